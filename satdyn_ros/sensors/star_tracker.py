"""
A star tracker: the attitude of its axes with a small random rotation, some ticks later.

Its boresight is its z axis.  A sample is q_is = q_ib q_bs d, where d is the rotation by the vector
(s_c w_x, s_c w_y, s_r w_z), s_c and s_r the standard deviations across and about the boresight.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..base.key import Key
from ..dynamics.motion import States
from ..kernel import rotation
from .measurements import Measurements, as_array, sampled
from .noise import normals
from .sensor import Sensor

_BORESIGHT = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class StarTrackerMemory:
    """The exposures that wait to be published: ticks (M,) int64 and attitudes (M, 4)."""

    exposed: np.ndarray
    q_is: np.ndarray

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> 'StarTrackerMemory':
        """Return the memory that to_plain gave."""
        exposed = np.array(plain['exposed'], np.int64)
        return cls(exposed, np.array(plain['q_is'], float).reshape(len(exposed), 4))

    def to_plain(self) -> dict[str, Any]:
        """Return the memory as plain data."""
        return {'exposed': self.exposed.tolist(), 'q_is': self.q_is.tolist()}

    def without_noise(self) -> 'StarTrackerMemory':
        """Return a memory without the waiting exposures: they contain noise."""
        return StarTrackerMemory(self.exposed[:0], self.q_is[:0])

    perfect = without_noise

    def restarted(self) -> 'StarTrackerMemory':
        """Return the memory after the motion has restarted: exposures are still published."""
        return self


@dataclass(frozen=True, eq=False)
class StarTracker(Sensor):
    """
    A star tracker.

    Parameters
    ----------
    seed : int
        of its noise
    divisor : ticks
        from sample to sample
    mounting : (4,), x, y, z, w
        quaternion from sensor to body axes
    cross_boresight, roll : rad
        standard deviations
    latency : ticks
        from exposure to message
    max_rate : rad/s
        a body that turns faster gives no sample; 0: no limit
    earth_exclusion, sun_exclusion : rad
        there is no sample with the attracting centre, or the Sun, this near the boresight; 0: no
        limit
    stream : int
        of its noise
    """

    kind = 'star_tracker'
    keys = (
        Key(
            'cross_boresight',
            'double',
            0.0,
            'rad',
            'standard deviation about each of the two axes across the boresight',
            low=0.0,
            high=1.0,
            trade='arcsec',
        ),
        Key(
            'roll',
            'double',
            0.0,
            'rad',
            'standard deviation about the boresight, the z axis of the sensor',
            low=0.0,
            high=1.0,
            trade='arcsec',
        ),
        Key(
            'latency',
            'integer',
            0,
            '',
            'ticks from exposure to publication; the message has the stamp of the exposure',
            low=0,
            high=100_000,
        ),
        Key(
            'max_rate',
            'double',
            0.0,
            'rad/s',
            'no sample while the body turns faster; 0: no limit',
            low=0.0,
        ),
        Key(
            'earth_exclusion',
            'double',
            0.0,
            'rad',
            'no sample with the attracting centre within this angle of the boresight; 0: no limit',
            low=0.0,
            high=3.141592653589793,
        ),
        Key(
            'sun_exclusion',
            'double',
            0.0,
            'rad',
            'no sample with the Sun within this angle of the boresight, in the shadow too; 0: no '
            'limit; with environment.sun',
            low=0.0,
            high=3.141592653589793,
            is_optional=True,
        ),
    )
    with_orbit, with_sun = ('earth_exclusion',), ('sun_exclusion',)
    message, measures = 'sensor_msgs/msg/Imu', 'orientation'
    columns = tuple(f'q_is_{part}' for part in 'xyzw')
    says = (
        'attitude, sensor to inertial, as the star tracker measures it, with its covariance in '
        'sensor axes, stamped by its exposure; everything else is marked absent'
    )
    unit, per_si = 'arcsec', float(np.degrees(3600.0))

    seed: int
    divisor: int = 1
    mounting: np.ndarray = field(default_factory=lambda: rotation.IDENTITY)
    cross_boresight: float = 0.0
    roll: float = 0.0
    latency: int = 0
    max_rate: float = 0.0
    earth_exclusion: float = 0.0
    sun_exclusion: float = 0.0
    stream: int = 1

    memory = StarTrackerMemory(np.empty(0, np.int64), np.empty((0, 4)))

    @property
    def cone(self) -> float:
        """The half-angle about its boresight in which the Earth or the Sun blinds it [rad]."""
        return max(self.earth_exclusion, self.sun_exclusion)

    @property
    def variances(self) -> tuple[float, float, float]:
        """Return the variances of the small rotation about the sensor's axes [rad^2]."""
        return self.cross_boresight**2, self.cross_boresight**2, self.roll**2

    def error(self, values: np.ndarray, true: np.ndarray) -> np.ndarray:
        """Return the rotation vectors from the true to the measured axes [rad], (M, 3)."""
        return rotation.to_vector(rotation.multiply(rotation.conjugate(true), values))

    def without_noise(self) -> 'StarTracker':
        """Return the star tracker without noise."""
        return replace(self, cross_boresight=0.0, roll=0.0)

    # Noise is its only error.
    perfect = without_noise

    def measure(
        self, ticks: range, states: States, memory: StarTrackerMemory
    ) -> tuple[Measurements, StarTrackerMemory]:
        """Return attitudes q_is (M, 4), sensor to inertial, and the exposures still waiting."""
        exposed, q_is = memory.exposed, memory.q_is
        samples = sampled(ticks, self.divisor)
        if samples:
            exposures, attitudes = self._expose(samples, samples.start - ticks.start, states)
            exposed = np.concatenate([exposed, exposures])
            q_is = np.concatenate([q_is, attitudes])
        done = int(np.searchsorted(exposed, ticks.stop - self.latency))
        published = Measurements(exposed[:done] + self.latency, exposed[:done], q_is[:done])
        return published, StarTrackerMemory(exposed[done:], q_is[done:])

    def _expose(self, samples, first_row, states):
        """Return those of the samples at which stars are seen, and the attitudes measured."""
        rows = slice(first_row, None, self.divisor)
        deviates = normals(self.seed, self.stream, samples, self.deviates)
        q_is, sees, _ = self.read(states, rows, deviates)
        return as_array(samples)[sees], q_is[sees]

    def read(
        self, states: States, rows: Any, deviates: np.ndarray, biases: Any = None
    ) -> tuple[np.ndarray, np.ndarray, Any]:
        """Return attitudes q_is (N, 4) as they are exposed, and whether stars are seen."""
        small = deviates * np.sqrt(self.variances)
        q_bs = rotation.multiply(self.mounting, rotation.from_vector(small))
        q_is = rotation.multiply(states.q_ib[rows], q_bs)
        return q_is, self._sees_stars(states, rows), biases

    def _sees_stars(self, states, rows):
        """Return whether the body is slow enough, the boresight off centre and Sun, (M,) bool."""
        sees = np.ones(len(states.omega_bi_b[rows]), bool)
        if self.max_rate:
            sees &= np.linalg.norm(states.omega_bi_b[rows], axis=-1) <= self.max_rate
        boresight_b = rotation.rotate(self.mounting, _BORESIGHT)
        if self.earth_exclusion:
            # c_b points from the centre to the body.
            cosine = -np.sum(states.c_b[rows] * boresight_b, axis=-1)
            sees &= cosine < np.cos(self.earth_exclusion)
        if self.sun_exclusion:
            cosine = np.sum(states.sun_direction_b[rows] * boresight_b, axis=-1)
            sees &= cosine < np.cos(self.sun_exclusion)
        return sees

"""
A sun sensor: the direction of the Sun in its axes, turned by a small random rotation.

A sample is the unit vector s, turned by the vector sigma (w - (w s) s), where w is white noise of
unit variance: by the standard deviation sigma about each of two axes perpendicular to s.  There is
no sample where the Sun is out of its view, or less than half of the disc is seen past the Earth.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..base.key import Key
from ..dynamics.motion import States
from ..kernel import rotation
from ..kernel.rows import dot
from .measurements import Measurements, as_array, sampled
from .noise import normals
from .sensor import NoMemory, Sensor

_LEAST_LIT = 0.5


@dataclass(frozen=True, eq=False)
class SunSensor(Sensor):
    """
    A sun sensor, which looks along its z axis.

    Parameters
    ----------
    seed, stream : int
        of its noise
    divisor : ticks
        from sample to sample
    mounting : (4,), x, y, z, w
        quaternion from sensor to body axes
    noise : rad
        standard deviation about each axis perpendicular to the direction
    field_of_view : rad
        half-angle about z in which it sees, 0: everywhere
    """

    kind = 'sun_sensor'
    keys = (
        Key(
            'noise',
            'double',
            0.0,
            'rad',
            'standard deviation about each of the two axes perpendicular to the direction of '
            'the Sun',
            low=0.0,
            high=1.0,
        ),
        Key(
            'field_of_view',
            'double',
            0.0,
            'rad',
            'no sample with the Sun further than this from the z axis of the sensor; 0: no limit',
            low=0.0,
            high=3.141592653589793,
        ),
    )
    needs = 'environment.sun'
    message, measures = 'geometry_msgs/msg/Vector3Stamped', 'vector'
    columns = ('x', 'y', 'z')
    says = (
        'unit vector to the Sun as the sun sensor measures it, in its axes; nothing out of its '
        'view or in the shadow; with environment.sun'
    )
    unit, per_si = 'deg', float(np.degrees(1.0))

    seed: int
    stream: int
    divisor: int = 1
    mounting: np.ndarray = field(default_factory=lambda: rotation.IDENTITY)
    noise: float = 0.0
    field_of_view: float = 0.0

    @property
    def cone(self) -> float:
        """The half-angle about its z axis in which it sees [rad]."""
        return self.field_of_view

    @property
    def variances(self) -> tuple[float, float, float]:
        """Return the variances of the small rotation about the sensor's axes, at most [rad^2]."""
        return self.noise**2, self.noise**2, self.noise**2

    def error(self, values: np.ndarray, true: np.ndarray) -> np.ndarray:
        """Return the small rotations from the true to the measured directions [rad], (M, 3)."""
        return np.cross(true, values)

    def without_noise(self) -> 'SunSensor':
        """Return the sun sensor without noise."""
        return replace(self, noise=0.0)

    # Noise is its only error.
    perfect = without_noise

    def truth(self, states: States, rows: slice = slice(None)) -> np.ndarray:
        """Return the unit vectors to the Sun in sensor axes, (M, 3)."""
        return rotation.rotate(rotation.conjugate(self.mounting), states.sun_direction_b[rows])

    def measure(
        self, ticks: range, states: States, memory: NoMemory
    ) -> tuple[Measurements, NoMemory]:
        """Return the unit vectors to the Sun (M, 3) measured in sensor axes."""
        samples = sampled(ticks, self.divisor)
        if not samples:
            return Measurements.prompt(as_array(samples), np.empty((0, 3))), memory
        rows = slice(samples.start - ticks.start, None, self.divisor)
        deviates = normals(self.seed, self.stream, samples, self.deviates)
        values, sees, _ = self.read(states, rows, deviates)
        return Measurements.prompt(as_array(samples)[sees], values[sees]), memory

    def read(
        self, states: States, rows: Any, deviates: np.ndarray, biases: Any = None
    ) -> tuple[np.ndarray, np.ndarray, Any]:
        """Return unit vectors (N, 3) in sensor axes, and whether the Sun is seen."""
        true = self.truth(states, rows)
        across = deviates - dot(deviates, true)[:, None] * true
        values = rotation.rotate(rotation.from_vector(self.noise * across), true)
        sees = states.lit_fraction[rows] >= _LEAST_LIT
        if self.field_of_view:
            sees &= true[:, 2] >= np.cos(self.field_of_view)
        return values, sees, biases

"""
A coarse sun sensor: a photocell, whose reading is the sunlight that falls on it.

With the part nu of the Sun's disc that the Earth leaves free, the distance d of the Sun and its
angle a to the cell's normal, which is the z axis of the sensor, a sample is

    E = nu 128000 lx (1 au / d)^2 max(0, cos a) + sigma w,   w white noise of unit variance

The light that the Earth scatters, its albedo, is not modelled.
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

_NORMAL = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class CoarseSunSensor(Sensor):
    """
    A coarse sun sensor.

    Parameters
    ----------
    seed, stream : int
        of its noise
    divisor : ticks
        from sample to sample
    mounting : (4,), x, y, z, w
        quaternion from sensor to body axes
    noise : lx
        standard deviation of a sample
    """

    kind = 'coarse_sun_sensor'
    keys = (Key('noise', 'double', 0.0, 'lx', 'standard deviation of a sample', low=0.0),)
    needs = 'environment.sun'
    message, measures = 'sensor_msgs/msg/Illuminance', 'illuminance'
    columns = ('lx',)
    says = (
        'sunlight on the coarse sun sensor along its z axis [lx] as it measures it, with its '
        'variance; with environment.sun'
    )
    unit = 'lx'
    deviates = 1

    seed: int
    stream: int
    divisor: int = 1
    mounting: np.ndarray = field(default_factory=lambda: rotation.IDENTITY)
    noise: float = 0.0

    @property
    def is_at_every_tick(self) -> bool:
        """Whether it has a message at every tick."""
        return self.divisor == 1

    @property
    def variances(self) -> tuple[float]:
        """Return the variance of a sample [lx^2]."""
        return (self.noise**2,)

    def error(self, values: np.ndarray, true: np.ndarray) -> np.ndarray:
        """Return measurements minus their truth [lx], (M, 1)."""
        return (values - true)[:, None]

    def without_noise(self) -> 'CoarseSunSensor':
        """Return the coarse sun sensor without noise."""
        return replace(self, noise=0.0)

    # Noise is its only error.
    perfect = without_noise

    def truth(self, states: States, rows: slice = slice(None)) -> np.ndarray:
        """Return the illuminance of the cell [lx], (M,)."""
        cosine = dot(states.sun_direction_b[rows], rotation.rotate(self.mounting, _NORMAL))
        return states.illuminance_lx[rows] * np.maximum(cosine, 0.0)

    def measure(
        self, ticks: range, states: States, memory: NoMemory
    ) -> tuple[Measurements, NoMemory]:
        """Return the illuminances [lx] (M,) measured along z."""
        samples = sampled(ticks, self.divisor)
        if not samples:
            return Measurements.prompt(as_array(samples), np.empty(0)), memory
        rows = slice(samples.start - ticks.start, None, self.divisor)
        deviates = normals(self.seed, self.stream, samples, self.deviates)
        values, _, _ = self.read(states, rows, deviates)
        return Measurements.prompt(as_array(samples), values), memory

    def read(
        self, states: States, rows: Any, deviates: np.ndarray, biases: Any = None
    ) -> tuple[np.ndarray, None, Any]:
        """Return illuminances [lx] (N,)."""
        return self.truth(states, rows) + self.noise * deviates[:, 0], None, biases

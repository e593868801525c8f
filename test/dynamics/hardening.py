"""A kind of modes in one file: a boom whose spring gets harder with the displacement."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from satdyn_ros.base.key import Key
from satdyn_ros.dynamics.inner_mode import InnerMode
from satdyn_ros.kernel.functions import sqrt


class HardeningConstants(NamedTuple):
    """stiffness [1/s^2]; growth [1/(kg m^2 s^2)]: of the stiffness with eta^2."""

    coupling: Any
    stiffness: float
    growth: float

    def spring(self, eta):
        return (self.stiffness + self.growth * eta * eta) * eta

    def friction(self, rate):
        return 0.0

    def frequency(self):
        return sqrt(self.stiffness)


@dataclass(frozen=True, eq=False)
class Hardening(InnerMode):
    """A mode with the spring W^2 eta + growth eta^3, without damping."""

    names = Key('hardening.names', 'string_array', (), '', 'names of booms that get harder')
    keys = (
        Key('frequency', 'double', 0.0, 'rad/s', 'of small swings', low=0.0),
        Key('growth', 'double', 0.0, '', 'of the stiffness', low=0.0),
    )
    says = 'booms that get harder'
    is_damped = False

    name: str
    frequency: float = 1.0
    growth: float = 0.0
    coupling: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @property
    def constants(self):
        return HardeningConstants(self.coupling, self.frequency**2, self.growth)

    def stretch(self, eta):
        return eta * np.sqrt(self.frequency**2 + 0.5 * self.growth * eta * eta)

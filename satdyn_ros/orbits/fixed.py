"""A body held at a fixed position in the field: the direction to the attracting centre stays."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.key import Key
from .orbit import Orbit, OrbitConstants
from .orbit_type import OrbitType

GRADIENT = Key(
    'orbit.gradient',
    'double',
    0.0,
    '1/s^2',
    '3 mu / r^3; negative: the gradient averaged over an orbit about Z; orbit.type fixed only',
)


@dataclass(frozen=True)
class FixedDirection(Orbit):
    """A body held at a fixed position: c_i = +Z and a constant gradient 3 mu / r^3 [1/s^2]."""

    gradient: float = 0.0

    has_lvlh = False
    is_eccentric = False
    mean_motion = 0.0
    mu = np.nan

    def __repr__(self) -> str:
        return f'<FixedDirection: gradient {self.gradient:g} 1/s^2>'

    @property
    def constants(self) -> OrbitConstants:
        """What the equations take of it."""
        zero = np.zeros(3)
        return OrbitConstants(0.0, self.gradient, self.direction(0.0), ahead=zero, normal=zero)

    def direction(self, t_s: ArrayLike) -> np.ndarray:
        """Return c_i, shape (..., 3)."""
        return np.broadcast_to([0.0, 0.0, 1.0], (*np.shape(t_s), 3))

    def gradient_at(self, t_s: ArrayLike) -> np.ndarray:
        """Return the gradient [1/s^2], shape (...)."""
        return np.zeros(np.shape(t_s)) + self.gradient

    def position_velocity(self, t_s: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return r_i [m] and v_i [m/s], zero: the body does not travel."""
        return np.zeros((*np.shape(t_s), 3)), np.zeros((*np.shape(t_s), 3))

    def lvlh(self, t_s: ArrayLike) -> np.ndarray:
        """Refuse: without an orbit there is no LVLH."""
        raise ValueError('orbit.type is fixed, which has no LVLH; use circular or kepler')

    def lvlh_rate(self, t_s: ArrayLike) -> np.ndarray:
        """Refuse: without an orbit there is no LVLH."""
        return self.lvlh(t_s)


class Fixed(OrbitType):
    """A fixed direction by its gradient."""

    name = 'fixed'
    keys, has_lvlh = (GRADIENT,), False

    @classmethod
    def orbit(cls, values: Mapping[str, Any], is_earlier: bool) -> Orbit:
        """Return the orbit."""
        return FixedDirection(values['orbit.gradient'])

    @classmethod
    def is_shared(cls, values: Mapping[str, Any]) -> bool:
        """Return False: each run may have a gradient of its own."""
        return False

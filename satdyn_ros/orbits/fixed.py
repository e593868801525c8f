"""A body held at a fixed place in the field: the direction to the attracting centre stays."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class FixedDirection:
    """A body held at a fixed place: c_i = +Z and a constant gradient 3 mu / r^3 [1/s^2]."""

    gradient: float = 0.0

    has_lvlh = False
    is_eccentric = False

    def __repr__(self) -> str:
        return f'<FixedDirection: gradient {self.gradient:g} 1/s^2>'

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

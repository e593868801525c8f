"""
The gyrostat's rotors: symmetric wheels that turn about axes fixed in the body.

With the axial inertia J, the axis a and the speed s relative to the body, a rotor's whole axial
momentum is p = J (s + a . omega).  A motor torque tau and the friction, viscous and
Coulomb's, give p' = tau - b s - C tanh(s / s_c), and a free rotor without friction conserves p.
The body then moves as one with the inertia I - sum J a a^T and the momentum sum p a.  A rotor of
constant relative momentum (Volterra's gyrostat) adds the constant h = p a to the whole inertia I.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..kernel.rows import dot

MODES = ('none', 'constant_momentum', 'free', 'motor')


@dataclass(frozen=True, eq=False)
class Rotor:
    """
    A rotor, described by its mode, one of MODES.

    Attributes
    ----------
    mode : str
        none, constant_momentum, free or motor
    axis : (3,), body axes
        unit vector
    momentum : N m s
        relative momentum; mode constant_momentum
    inertia : kg m^2
        axial inertia J; modes free and motor
    friction : N m s
        viscous friction between rotor and body; modes free and motor
    max_torque, max_speed : N m, rad/s
        limits of a motor, 0: none
    coulomb_friction, friction_speed : N m, rad/s
        dry friction, and the speed within which it changes its sign; modes free and motor
    speed_gain : 1/s
        of the loop in the drive that follows a commanded speed, 0: none
    static_imbalance, dynamic_imbalance : kg m, kg m^2
        modes free and motor
    position : (3,), m, body axes
        from the mass centre
    name : str
        empty for the one rotor of a scenario without names
    """

    mode: str = 'none'
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))
    momentum: float = 0.0
    inertia: float = 0.0
    friction: float = 0.0
    max_torque: float = 0.0
    max_speed: float = 0.0
    coulomb_friction: float = 0.0
    friction_speed: float = 0.1
    speed_gain: float = 0.0
    static_imbalance: float = 0.0
    dynamic_imbalance: float = 0.0
    position: np.ndarray = field(default_factory=lambda: np.zeros(3))
    name: str = ''

    @property
    def turns_freely(self) -> bool:
        """Whether the rotor has a speed of its own (modes free and motor)."""
        return self.mode in ('free', 'motor')

    @property
    def label(self) -> str:
        """Return the name by which messages and tables call the rotor."""
        return self.name or 'rotor'

    @property
    def is_damped(self) -> bool:
        """Whether friction acts between rotor and body."""
        return self.turns_freely and bool(
            np.count_nonzero(self.friction) or np.count_nonzero(self.coulomb_friction)
        )

    @property
    def is_unbalanced(self) -> bool:
        """Whether its turning shakes the body."""
        return self.turns_freely and bool(
            np.count_nonzero(self.static_imbalance) or np.count_nonzero(self.dynamic_imbalance)
        )

    @property
    def zero_direction(self) -> np.ndarray:
        """
        Return the direction (3,) of an imbalance at the angle zero, perpendicular to the axis.

        It is the body axis with the smallest component along the rotor's, the first of equals,
        less that component.
        """
        body_axis = np.eye(3)[np.argmin(np.abs(self.axis))]
        square = body_axis - (body_axis @ self.axis) * self.axis
        return square / np.linalg.norm(square)

    @property
    def switches(self) -> bool:
        """Whether it is a motor whose torque may depend on its speed."""
        return bool(np.count_nonzero(self.max_speed) or np.count_nonzero(self.speed_gain))

    def friction_torque(self, speed: Any) -> Any:
        """Return b s + C tanh(s / s_c) [N m] at the relative speed s [rad/s]."""
        viscous = self.friction * speed
        if not np.any(self.coulomb_friction):
            return viscous
        return viscous + self.coulomb_friction * np.tanh(speed / self.friction_speed)

    def axial_momentum(
        self, speed: float | np.ndarray, omega_bi_b: np.ndarray
    ) -> float | np.ndarray:
        """Return p [N m s] for the relative speed [rad/s] and body rate omega_bi_b (..., 3)."""
        if self.turns_freely:
            return self.inertia * (speed + self._rate_along_axis(omega_bi_b))
        return (np.zeros(np.shape(omega_bi_b)[:-1]) + self.momentum)[()]

    def speed(
        self, axial_momentum: float | np.ndarray, omega_bi_b: np.ndarray
    ) -> float | np.ndarray:
        """Return the relative speed s = p / J - a . omega [rad/s]; nan where it has none."""
        if self.turns_freely:
            return axial_momentum / self.inertia - self._rate_along_axis(omega_bi_b)
        return np.broadcast_to(np.nan, np.shape(omega_bi_b)[:-1])[()]

    def _rate_along_axis(self, omega_bi_b):
        return dot(np.asarray(omega_bi_b, float), self.axis)

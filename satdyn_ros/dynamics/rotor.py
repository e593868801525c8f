"""
The gyrostat's rotors: symmetric wheels that turn about axes fixed in the body.

With the axial inertia J, the axis a and the speed s relative to the body, a rotor's whole axial
momentum is p = J (s + a . omega).  A motor torque tau and the viscous friction b give
p' = tau - b s, and a free rotor without friction conserves p.  The body then moves as one with the
inertia I - sum J a a^T and the momentum sum p a.  A rotor of constant relative momentum
(Volterra's gyrostat) adds the constant h = p a to the whole inertia I.
"""

from dataclasses import dataclass, field

import numpy as np

MODES = ('none', 'constant_momentum', 'free', 'motor')


@dataclass(frozen=True, eq=False)
class Rotor:
    """
    A rotor by its mode, one of MODES.

    axis: unit vector, body axes.  momentum [N m s]: relative momentum, mode constant_momentum.
    inertia [kg m^2]: axial inertia J, friction [N m s]: viscous, between rotor and body, modes
    free and motor.  max_torque [N m], max_speed [rad/s]: limits of a motor, 0: none.  name: empty
    for the one rotor of a scenario without names.
    """

    mode: str = 'none'
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))
    momentum: float = 0.0
    inertia: float = 0.0
    friction: float = 0.0
    max_torque: float = 0.0
    max_speed: float = 0.0
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
        return self.turns_freely and bool(np.count_nonzero(self.friction))

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
        # Written out: the bits of a matrix product depend on how many rows there are.
        omega, a = np.asarray(omega_bi_b, float), self.axis
        return omega[..., 0] * a[..., 0] + omega[..., 1] * a[..., 1] + omega[..., 2] * a[..., 2]

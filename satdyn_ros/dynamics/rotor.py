"""
The gyrostat's rotor: a symmetric wheel that turns about an axis fixed in the body.

With the axial inertia J, the axis a and the speed s relative to the body, the rotor's whole
axial momentum is p = J (s + a . omega).  A free rotor conserves p and a motor torque tau gives
p' = tau, so the body moves as one with the inertia I - J a a^T and the momentum p a.  A rotor of
constant relative momentum (Volterra's gyrostat) adds the constant h = p a to the whole inertia I.
"""

from dataclasses import dataclass, field

import numpy as np

MODES = ('none', 'constant_momentum', 'free', 'motor')


@dataclass(frozen=True, eq=False)
class Rotor:
    """
    A rotor by its mode, one of MODES.

    axis: unit vector, body axes.  momentum [N m s]: relative momentum, mode constant_momentum.
    inertia [kg m^2]: axial inertia J, modes free and motor.
    """

    mode: str = 'none'
    axis: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.0, 0.0]))
    momentum: float = 0.0
    inertia: float = 0.0

    @property
    def turns_freely(self) -> bool:
        """Whether the rotor has a speed of its own (modes free and motor)."""
        return self.mode in ('free', 'motor')

    def axial_momentum(self, speed, omega_bi_b):
        """Return p [N m s] for the relative speed [rad/s] and body rate omega_bi_b (..., 3)."""
        if self.turns_freely:
            return self.inertia * (speed + self._rate_along_axis(omega_bi_b))
        return (np.zeros(np.shape(omega_bi_b)[:-1]) + self.momentum)[()]

    def speed(self, axial_momentum, omega_bi_b):
        """Return the relative speed s = p / J - a . omega [rad/s]; nan where it has none."""
        if self.turns_freely:
            return axial_momentum / self.inertia - self._rate_along_axis(omega_bi_b)
        return np.broadcast_to(np.nan, np.shape(omega_bi_b)[:-1])[()]

    def _rate_along_axis(self, omega_bi_b):
        # Written out: the bits of a matrix product depend on how many rows there are.
        x, y, z = np.moveaxis(np.asarray(omega_bi_b, float), -1, 0)
        return x * self.axis[..., 0] + y * self.axis[..., 1] + z * self.axis[..., 2]

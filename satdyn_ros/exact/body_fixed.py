"""
The relations of Balli and Grioli (1979) for a rotation about an axis gamma fixed in the body.

The body is symmetric, A = B, in axes in which gamma = (0, gamma_2, gamma_3); I is the rotor's
momentum, nu the orbital rate, c the direction from the attracting centre and eta = 3 mu / r^3.
Where gamma is the equatorial axis 2 and the rotor is across it along 3, (10) to (13) must hold
too, and have no common solution but uniform rotations: the theorem.  As printed, (11) to (13) have
an index 3 for 2 in nu_1^2 + nu_2^2, and (12) begins A (nu - nu_2^2).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class BodyFixed:
    """
    A symmetric gyrostat on a circular orbit and the relations that its rotations obey.

    All methods take omega [rad/s], signed, about gamma (3,), and nu (3,) [rad/s] and c (3,), all
    in body axes.

    Parameters
    ----------
    A, C : kg m^2
        principal moments
    rotor_momentum : (3,), N m s, body axes
        of the rotor
    eta : 1/s^2
        3 n^2

    Examples
    --------
    >>> body = BodyFixed(600.0, 900.0, [0.0, 5.0, 0.0], 3.6e-6)
    >>> body.along_axis(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0011, 0.0]))
    0.0011
    """

    A: float
    C: float
    rotor_momentum: Sequence[float] | np.ndarray
    eta: float

    def along_axis(self, gamma: np.ndarray, nu: np.ndarray) -> float:
        """Return l = nu . gamma [rad/s], constant in a rotation about a body-fixed axis (6)."""
        return float(np.dot(nu, gamma))

    def E0(self, omega: float, gamma: np.ndarray, nu: np.ndarray, c: np.ndarray) -> float:
        """Return the energy integral (5) [J]: twice Jacobi's, less 3 n^2 A."""
        moments = np.array([self.A, self.A, self.C])
        rate, nu = omega * np.asarray(gamma), np.asarray(nu)
        field = self.eta * (self.C - self.A) * np.asarray(c)[2] ** 2
        return float(rate @ (moments * rate) + field - 2.0 * nu @ (moments * rate + self._h))

    def transverse(self, omega: float, gamma: np.ndarray, c: np.ndarray) -> float:
        """Return what (1)_1 says is zero [N m]."""
        (_, g2, g3), (_, c2, c3), (_, I2, I3) = gamma, c, self._h
        turn = (self.C - self.A) * (omega**2 * g2 * g3 - self.eta * c2 * c3)
        return float(turn + omega * (I3 * g2 - I2 * g3))

    def off_the_equator(self, omega: float, gamma: np.ndarray, c: np.ndarray) -> float:
        """Return what (9) says is zero where gamma_3 is not."""
        (_, g2, g3), (c1, _, c3), I1 = gamma, c, self._h[0]
        inertias = self.C * g3**2 + self.A * g2**2
        return float(I1 * omega * inertias - self.eta * self.C * (self.A - self.C) * g3 * c1 * c3)

    def changing(self, omega: float, nu: np.ndarray, c: np.ndarray) -> float:
        """Return what (10), the derivative of (1)_1, says is zero about axis 2."""
        (n1, n2, n3), (c1, c2, c3), A = nu, c, self.A
        turn = c3 * (c1 * n3 - c3 * n1) + c2 * (c1 * (omega - n2) + c2 * n1)
        return float(self._h[2] * c1 * c3 + A * turn)

    def H(self, omega: float, nu: np.ndarray, E: float) -> float:
        """Return H = A omega^2 - 2 A nu_2 omega - 2 I_3 nu_3 - E; E = E0 + 2 I_2 nu_2 [J]."""
        _, n2, n3 = nu
        return float(self.A * omega * (omega - 2.0 * n2) - 2.0 * self._h[2] * n3 - E)

    def eliminants(self, omega: float, nu: np.ndarray, E: float) -> tuple[float, float, float]:
        """Return what (11), (12) and (13), corrected, say is zero: c eliminated, about axis 2."""
        (n1, n2, n3), A, I3, H = nu, self.A, self._h[2], self.H(omega, nu, E)
        across, along = n1**2 + n3**2, n1**2 + n2**2
        first = self.eta * (self.C - A) * n1**2 - 2.0 * I3 * n2 * omega * n3
        second = I3 * (2.0 * A * n2 * omega * n3 + 2.0 * I3 * n3**2 + E * n3 + I3 * n2 * omega)
        rest = along - n2 * omega
        return (
            float(across * H**2 + first * H + I3**2 * along * omega**2),
            float(A * across * H**2 - second * H - A * I3**2 * rest * omega**2),
            float(A * rest * (across * H + first) + along * (A * across * H - second)),
        )

    @property
    def _h(self):
        return np.asarray(self.rotor_momentum, float)

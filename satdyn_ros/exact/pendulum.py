"""The planar pendulum of the gravity gradient: theta'' = -(N^2 / 2) sin 2 theta."""

import numpy as np

from . import elliptic


class Pendulum:
    """
    The pendulum from its start.

    Parameters
    ----------
    N : rad/s
        of small swings, N >= 0
    theta0 : rad
        at the start
    rate0 : rad/s
        at the start

    Attributes
    ----------
    k : float
        the modulus, k^2 = (rate0 / N)^2 + sin^2 theta0
    regime : str
        libration for k < 1, tumbling for k > 1, separatrix for k = 1, and rest at an equilibrium
    period_s : s or None
        of the libration, or of a whole turn (gradient and rate repeat after half of it); else None
    limits : two of rad, or None
        the angles between which a libration stays; else None
    """

    def __init__(self, N: float, theta0: float, rate0: float):
        self._centre = np.pi * np.rint(theta0 / np.pi)
        self._from_centre = theta0 - self._centre
        sine, cosine = np.sin(self._from_centre), np.cos(self._from_centre)
        speed, self._sense = abs(rate0), np.copysign(1.0, rate0)
        self._fastest = float(np.hypot(rate0, N * sine))
        self.k = self._fastest / N if N > 0.0 else np.inf
        self.period_s: float | None = None
        self.limits: tuple[float, float] | None = None
        excess = speed - N * cosine
        if np.hypot(rate0, N * sine * cosine) <= elliptic.LAST_DIGITS * N:
            self.regime = 'rest'
        elif abs(excess) <= elliptic.LAST_DIGITS * speed:
            self.regime = 'separatrix'
            self._m1, self._rate = 0.0, self._fastest
        elif excess < 0.0:
            self.regime = 'libration'
            self._m1, self._rate = -excess * (speed + N * cosine) / N**2, N
        else:
            self.regime = 'tumbling'
            self._rate = self._fastest
            self._m1 = excess * (speed + N * cosine) / self._rate**2
        if self.regime == 'rest':
            return
        if self.regime == 'libration':
            self._u0 = elliptic.F(np.arctan2(N * sine, rate0), self._m1)
            swing = float(np.arctan2(self.k, np.sqrt(self._m1)))
            self.limits = float(self._centre) - swing, float(self._centre) + swing
        else:
            self._u0 = elliptic.F(self._sense * self._from_centre, self._m1)
        if self.regime != 'separatrix':
            self.period_s = float(4.0 * elliptic.K(self._m1) / self._rate)

    def at(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return theta [rad], continuous, and its rate [rad/s] at t_s (N,)."""
        if self.regime == 'rest':
            still = np.zeros(np.shape(t_s))
            return still + self._centre + self._from_centre, still
        u = self._u0 + self._rate * t_s
        sn, cn, dn = elliptic.sncndn(u, self._m1)
        if self.regime == 'libration':
            return self._centre + np.arctan2(self.k * sn, dn), self._fastest * cn
        turn = self._sense * elliptic.amplitude(u, self._m1)
        return self._centre + turn, self._sense * self._fastest * dn

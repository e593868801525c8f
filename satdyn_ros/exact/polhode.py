"""The path of the vertical in the body in a stationary motion (Agostinelli 1977, eqs 24-30)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from . import elliptic


class Polhode(NamedTuple):
    """
    The path of gamma in the body: gamma = (S sn u, D dn u, C cn u), u' = lam.

    m + m1 = 1 and C^2 + D^2 = 1; S has the sign that makes gamma' = gamma x omega.
    """

    lam: float
    m: float
    m1: float
    S: float
    D: float
    C: float

    @classmethod
    def of(
        cls, differences: Sequence[float] | np.ndarray, distances: Sequence[float] | np.ndarray
    ) -> 'Polhode':
        """
        Return the polhode, whose y axis has the largest or the least alpha and z the other.

        All differences and distances are times one rate [rad/s], and those from y or z of one
        sign, so that nothing cancels.

        Parameters
        ----------
        differences : (3,), rad/s
            y - z, y - x, x - z of the alphas
        distances : (3,), rad/s
            e - z, y - e, e - x
        """
        yz, yx, xz = differences
        ez, ye, ex = distances
        product = yx * ez
        if ez == 0.0 and yz != 0.0:
            # x and z have the alpha e: gamma stays anywhere in the plane across y
            return cls(0.0, 0.0, 1.0, 1.0, 0.0, 1.0)
        if product == 0.0 or ye == 0.0:
            return cls(0.0, 0.0, 1.0, 0.0, 1.0, 0.0)
        return cls(
            lam=np.sqrt(product),
            m=ye * xz / product,
            m1=min(ex * yz / product, 1.0),
            S=-np.copysign(np.sqrt(ye / yx), yx),
            D=np.sqrt(ez / yz),
            C=np.sqrt(ye / yz),
        )

    def at(self, u: float | np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the three cosines at the argument u."""
        sn, cn, dn = elliptic.sncndn(u, self.m1)
        return self.S * sn, self.D * dn, self.C * cn

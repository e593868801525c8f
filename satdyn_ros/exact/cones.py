"""Paladini's limiting cones: which of the roots of f bound the nutation of a symmetric body."""

from typing import Any, NamedTuple

import numpy as np

# A root this near a pole is at it: where two are, rounding parts them by the root of rounding.
AT_POLE = 1e-7
# The ends are so near each other that differences of Q say nothing of its slope.
_NARROW = 1e-4


class Cones(NamedTuple):
    """
    The circular cones about the field's direction between which the axis stays (sec. 1).

    Attributes
    ----------
    roots : (n,)
        all real roots a_1 <= a_2 ... of f(u), n from 2 to 4: one less for H1 = 0, two less for the
        free body, and two less where two are complex
    interval : two of int
        the numbers, from 1, of those between which u = cos theta moves
    case : str
        Paladini's alpha (a_1 to a_2) or beta (a_3 to a_4) of two wells, gamma (a_2 to a_3), or
        complex (sec. 7)
    k : float
        the modulus; 1 on a separatrix
    """

    roots: np.ndarray
    interval: tuple[int, int]
    case: str
    k: float

    @classmethod
    def of(cls, motion: Any) -> 'Cones':
        """Return the cones of an exact motion (symmetric.Symmetric)."""
        nutation = motion.flow.nutation
        turning, c2 = nutation.turning, 2.0 * motion.H1 / motion.A
        others = _others(nutation, c2, 2.0 * motion.H2 / motion.A, motion.roots)
        roots = np.sort([turning.b, turning.a, *others])
        below = int(np.sum(np.asarray(others) <= turning.b))
        interval = (below + 1, below + 2)
        if len(others) < 2 and (motion.H1 != 0.0 and not turning.steady):
            case = 'complex'
        else:
            case = ('alpha', 'gamma', 'beta')[below if motion.H1 or below else 0]
        return cls(roots, interval, case, float(np.sqrt(nutation.k2)))

    @property
    def thetas(self) -> np.ndarray:
        """Return theta_i [rad], cos theta_i = a_i; nan for a root beyond the poles."""
        outside = np.abs(self.roots) > 1.0 + AT_POLE
        return np.where(outside, np.nan, np.arccos(np.clip(self.roots, -1.0, 1.0)))


def _others(nutation, c2, c3, roots):
    """
    Return the real ones of the two roots other than the turning points.

    f = (a - u)(u - b) Q(u) with Q = Q(a) + Q'(a) (u - a) + c2 (u - a)^2; for c2 = 0 the slope c3
    of the cubic's Q.
    """
    turning = nutation.turning
    if turning.steady:
        # u is at a double root, of which np.roots leaves a pair that is complex by rounding
        apart = np.abs(roots - turning.b)
        rest = roots[np.argsort(apart)][2:]
        return [z.real for z in rest if abs(z.imag) <= 1e-7 * max(abs(z), 1.0)]
    if c2 == 0.0:
        return [turning.a - turning.Qa / c3] if c3 != 0.0 else []
    width = turning.da - turning.db
    if width < _NARROW:
        slope = c3 + c2 * (3.0 * turning.a + turning.b)
        discriminant = slope**2 - 4.0 * c2 * turning.Qa
        if discriminant < 0.0:
            return []
        split = np.sqrt(discriminant)
    elif nutation.lattice.share != 1.0:
        return []
    else:
        slope = (turning.Qa - turning.Qb) / width + c2 * width
        split = nutation.split / width
    q = -(slope + np.copysign(split, slope)) / 2.0
    return sorted([turning.a + q / c2, turning.a + turning.Qa / q] if q else [turning.a] * 2)

"""The turning points of u'^2 = f(u) to full relative precision from the start and the poles."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from .elliptic import LAST_DIGITS


class Turning(NamedTuple):
    """
    The range b <= u <= a of the motion that starts at u0, and f there.

    Attributes
    ----------
    da, db : float
        a - u0 >= 0 >= b - u0
    from_above : two of float
        1 - a and 1 - b
    from_below : two of float
        1 + b and 1 + a
    Qa, Qb : float
        with f = (a - u)(u - b) Q(u), the values of Q at the ends
    """

    da: float
    db: float
    from_above: tuple[float, float]
    from_below: tuple[float, float]
    Qa: float
    Qb: float

    @property
    def a(self) -> float:
        """The upper turning point."""
        return 1.0 - self.from_above[0]

    @property
    def b(self) -> float:
        """The lower turning point."""
        return self.from_below[0] - 1.0

    @property
    def theta_limits(self) -> tuple[float, float]:
        """The least and greatest theta [rad], u = cos theta, with the digits of the poles."""
        (above_a, above_b), (below_b, below_a) = self.from_above, self.from_below
        least = 2.0 * np.arctan2(np.sqrt(above_a), np.sqrt(below_a))
        return float(least), float(2.0 * np.arctan2(np.sqrt(above_b), np.sqrt(below_b)))

    @property
    def steady(self) -> bool:
        """Whether u is constant."""
        return self.da == self.db


def turning_points(
    f: ArrayLike,
    f_up: ArrayLike,
    f_down: ArrayLike,
    above: float,
    below: float,
) -> Turning:
    """
    Return the turning points beside u0, where f >= 0.

    Parameters
    ----------
    f : (5,)
        coefficients of f(u0 + d), lowest first, with f(1) <= 0 and f(-1) <= 0
    f_up, f_down : (5,)
        likewise of f(1 - s) and of f(-1 + s)
    above, below : float
        1 - u0 and 1 + u0
    """
    f = np.asarray(f)
    curvature = np.sum(np.abs(f[2:]))
    # Rates of 1e-50 rad/s, and a nutation of 1e-60, far below rounding, count as none.
    still = curvature < 1e-100
    if still or (abs(f[1]) <= 1e-60 * curvature and f[0] <= 1e-120 * curvature):
        return steady(above, below)
    da, to_upper_pole, slope_a = _turning_point(f, f_up, above)
    mirrored = f * np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    db, to_lower_pole, slope_b = _turning_point(mirrored, f_down, below)
    width = da + db
    if width == 0.0:
        return steady(above, below)
    return Turning(
        da,
        -db,
        (to_upper_pole, above + db),
        (to_lower_pole, below + da),
        slope_a / width,
        slope_b / width,
    )


def steady(above: float, below: float) -> Turning:
    """Return the range of a constant u0; above, below: 1 - u0 and 1 + u0."""
    return Turning(0.0, 0.0, (above, above), (below, below), 0.0, 0.0)


def _turning_point(here, pole, gap):
    """
    Return the distances of the first root towards a pole from here and from it, and |f'| there.

    here, pole: coefficients of f in the distance from here and from the pole; gap: between them.
    """
    f = Polynomial(here)
    x = _first_root(f, 0.0, gap)
    s = gap - x
    slope = -f.deriv()(x)
    if s < x:
        f = Polynomial(pole)
        # Here f may be next to nothing, of which this polynomial has no digits.
        start = min((z for z in _extrema(f, s, gap) if f(z) > 0.0), default=gap)
        s = _first_root(f, start, 0.0)
        x = gap - s
        slope = f.deriv()(s)
    return x, s, max(slope, 0.0)


def _first_root(f, start, stop):
    """Return the first root on the way from start, where f >= 0, to stop, where f <= 0."""
    extrema = _extrema(f, min(start, stop), max(start, stop))
    left = start
    for right in [*(extrema if stop > start else extrema[::-1]), stop]:
        if f(right) <= 0.0:
            break
        left = right
    else:
        return stop  # rounding hides that the pole itself is the root
    if f(left) <= 0.0:
        return left
    root = brentq(f, left, right, xtol=1e-300, rtol=LAST_DIGITS, maxiter=3000)
    return _polished(f, root)


def _extrema(f, low, high):
    """Return where f has its extrema between low and high, in ascending order."""
    slope = f.deriv()
    extrema = np.array([_polished(slope, z.real) for z in slope.roots() if z.imag == 0.0])
    return np.sort(extrema[(extrema > low) & (extrema < high)])


def _polished(f, root):
    """Return the root after one Newton step, if that is nearer to it."""
    slope = f.deriv()(root)
    newton = root - f(root) / slope if slope != 0.0 else root
    return newton if abs(f(newton)) < abs(f(root)) else root

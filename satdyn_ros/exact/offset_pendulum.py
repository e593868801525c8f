"""
Beletsky's pendulum with the mass centre off the fixed point, in the plane of motion.

    theta'^2 = f(theta) = l + G1 cos(theta + delta) + G2 cos 2 theta      (Beletsky 1957, eq. 4)

f, a trigonometric polynomial of degree two, has four roots e^(i theta) in the complex plane.  Two
turning points bound a libration, none leaves it tumbling, a double root is an equilibrium that the
separatrix approaches without end: one closed form for each.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from . import elliptic
from .elliptic import LAST_DIGITS


class Field(NamedTuple):
    """The constants G1, G2 [1/s^2] and delta [rad] of f, which starts at theta0 and rate0."""

    G1: float
    delta: float
    G2: float
    theta0: float
    rate0: float

    def f(self, d: float) -> float:
        """Return f at theta0 + d, without cancellation for small d."""
        return self.rate0**2 - sum(self._drops(d))

    def slope(self, d: float) -> float:
        """Return df/dtheta at theta0 + d."""
        phi = self.theta0 + self.delta + d
        return -self.G1 * np.sin(phi) - 2.0 * self.G2 * np.sin(2.0 * (self.theta0 + d))

    def second_derivative(self, d: float) -> float:
        """Return half the second derivative of f at theta0 + d."""
        theta = self.theta0 + d
        G1, G2 = self.G1, self.G2
        return -(G1 * np.cos(theta + self.delta) + 4.0 * G2 * np.cos(2.0 * theta)) / 2.0

    def is_separatrix(self, d: float) -> bool:
        """Whether f has a double root at the equilibrium theta0 + d, and is positive beside it."""
        size = self.rate0**2 + sum(abs(drop) for drop in self._drops(d))
        return abs(self.f(d)) <= LAST_DIGITS * size and self.second_derivative(d) >= 0.0

    def _drops(self, d):
        phi = self.theta0 + self.delta + d / 2.0
        yield 2.0 * self.G1 * np.sin(phi) * np.sin(d / 2.0)
        yield 2.0 * self.G2 * np.sin(2.0 * self.theta0 + d) * np.sin(d)

    def equilibria(self) -> np.ndarray:
        """Return the angles d, 0 <= d < 2 pi, at which theta0 + d is an equilibrium, ascending."""
        z = np.exp(1j * self.delta)
        roots = np.roots([2.0 * self.G2, self.G1 * z, 0.0, -self.G1 / z, -2.0 * self.G2])
        on_circle = np.angle(roots[np.abs(np.abs(roots) - 1.0) < 1e-4])
        return np.sort(np.mod(on_circle - self.theta0, 2.0 * np.pi))


class OffsetPendulum:
    """
    The pendulum of a field from its start.

    Parameters
    ----------
    field : Field
        with G1 and |G2| not both zero

    Attributes
    ----------
    regime : str
        libration, tumbling, separatrix or rest
    k : float
        the modulus of the elliptic functions
    period_s : s or None
        of the libration, or of a whole turn; else None
    limits : two of rad, or None
        the angles between which a libration stays; else None

    Examples
    --------
    >>> theta, rate = OffsetPendulum(Field(1.0, 0.0, 0.2, 0.5, 0.3)).at(np.array([10.0]))
    """

    def __init__(self, field: Field):
        self.regime, self._solution = _solution(field)
        self.limits: tuple[float, float] | None = self._solution.limits
        self.k, self.period_s = self._solution.k, self._solution.period_s

    def at(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return theta [rad], continuous, and its rate [rad/s] at t_s (N,)."""
        return self._solution.at(np.asarray(t_s, float))


def _solution(field):
    """Return the regime and the closed form of the motion in a field."""
    scale = field.G1 + 2.0 * abs(field.G2)
    resting = abs(field.rate0) <= LAST_DIGITS * np.sqrt(scale)
    if resting and abs(field.slope(0.0)) <= LAST_DIGITS * scale:
        return 'rest', Rest(field.theta0)
    ahead = field.equilibria()
    ways = {1: ahead, -1: ahead[::-1] - 2.0 * np.pi}
    sense = 1 if field.rate0 > 0.0 or (field.rate0 == 0.0 and field.slope(0.0) > 0.0) else -1
    ends = {}
    for side in (sense, -sense):
        end, is_double = _end(field, ways[side])
        if is_double:
            return 'separatrix', Separatrix(field, end)
        if end is None:
            return 'tumbling', Tumbling(field)
        ends[side] = end
    return 'libration', Libration(field, ends[-1], ends[1])


def _end(field, equilibria):
    """
    Return where, from theta0 on in the order of the equilibria, f falls to zero, None if nowhere.

    Between equilibria f is monotonic.  Second result: whether it is a double root.
    """
    before = 0.0
    for d in equilibria:
        if field.is_separatrix(d) and abs(d) > 0.0:
            return d, True
        if field.f(d) < 0.0:
            inside = before if field.f(before) > 0.0 else 0.0
            if field.f(inside) <= 0.0:
                return 0.0, False
            # a slow start next to its turning point takes bisections down to it
            return brentq(field.f, inside, d, xtol=1e-300, rtol=LAST_DIGITS, maxiter=3000), False
        before = d
    return None, False


class Rest:
    """An equilibrium."""

    k, period_s, limits = 0.0, None, None

    def __init__(self, theta0: float):
        self._theta0 = theta0

    def at(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the angle and no rate."""
        return np.full(np.shape(t_s), self._theta0), np.zeros(np.shape(t_s))


class Libration:
    """
    The swing between the turning points theta0 + down and theta0 + up.

    With x from the middle, X its largest value and v = tan(x/2) / tan(X/2), the motion is v'^2 =
    (1 - v^2)(p v^2 + q v + r); w^2 = (1 + v) / (1 - v) gives it by elliptic functions for all
    patterns of the other two roots.
    """

    def __init__(self, field: Field, down: float, up: float):
        X, self._middle = (up - down) / 2.0, field.theta0 + (up + down) / 2.0
        self.limits = float(self._middle - X), float(self._middle + X)
        phi = self._middle + field.delta
        g_cos = field.G2 * np.cos(2.0 * self._middle)
        g_sin = -field.G2 * np.sin(2.0 * self._middle)
        g = field.G1 / 2.0 * np.cos(phi) + g_cos * np.cos(X)
        self._sine, self._cosine = np.sin(X / 2.0), np.cos(X / 2.0)
        p, q, r = (g - g_cos) * self._sine**2, g_sin * np.sin(X), (g + g_cos) * self._cosine**2
        at_up = g + g_cos * np.cos(X) + q
        at_down = at_up - 2.0 * q
        M, G = 2.0 * (r - p), 2.0 * np.sqrt(at_up * at_down)
        self._wide = M > G
        if self._wide:
            self._m1, self._rate = 2.0 * G / (M + G), np.sqrt(M + G) / 2.0
        else:
            # (G^2 - M^2) / 4; at its rounding the start is within rounding of a separatrix
            product = max(4.0 * p * r - q * q, LAST_DIGITS * p * r)
            m1 = 2.0 * product / (G * (G - M)) if M < 0.0 else (1.0 + M / G) / 2.0
            self._m1, self._rate = m1, np.sqrt(G / 2.0)
        self.k = float(np.sqrt(1.0 - self._m1))
        self.period_s = float(4.0 * elliptic.K(self._m1) / self._rate)
        self._ratio = np.sqrt(at_down / at_up)
        root = np.sqrt(self._ratio)
        from_down, to_up = np.sin(-down / 2.0), np.sin(up / 2.0)
        both = 2.0 * root * np.sqrt(from_down * to_up)
        factor = np.sqrt(self._m1) if self._wide else 1.0
        am0 = np.arctan2(both, factor * (self._ratio * to_up - from_down))
        self._u0 = np.copysign(elliptic.F(am0, self._m1), field.rate0)

    def at(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the angle and its rate."""
        sn, cn, dn = elliptic.sncndn(self._u0 + self._rate * t_s, self._m1)
        top = dn if self._wide else 1.0
        factor = self._m1 if self._wide else 1.0
        # top -+ cn, without cancellation
        large = top + np.abs(cn)
        small = factor * sn * sn / large
        minus = self._ratio * np.where(cn < 0.0, large, small)
        plus = np.where(cn < 0.0, small, large)
        y, x = self._sine * (minus - plus), self._cosine * (minus + plus)
        slope = self._m1 * sn if self._wide else sn * dn
        rate = 8.0 * self._sine * self._cosine * self._rate * self._ratio * slope / (x * x + y * y)
        return self._middle + 2.0 * np.arctan2(y, x), rate


class Tumbling:
    """
    The turn without turning points: f = c |e^(i theta) - a|^2 |e^(i theta) - b|^2, |a|, |b| < 1.

    The map of the unit circle that takes a to 0 turns theta into eta with eta' a multiple of
    |e^(i eta) - b'|, b' the image of b: Legendre's form in half of eta - arg b'.
    """

    limits = None

    def __init__(self, field: Field):
        z = np.exp(1j * field.delta)
        G1, G2 = field.G1, field.G2
        l = field.rate0**2 - G1 * np.cos(field.theta0 + field.delta)
        l -= G2 * np.cos(2.0 * field.theta0)
        roots = np.roots([G2, G1 * z, 2.0 * l, G1 / z, G2])
        a, b = roots[np.argsort(np.abs(roots))][:2]
        fastest = max(field.equilibria(), key=field.f)
        z = np.exp(1j * (field.theta0 + fastest))
        c = field.f(fastest) / (abs(z - a) * abs(z - b)) ** 2
        across = abs(1.0 - np.conj(a) * b)
        image = (b - a) / (1.0 - np.conj(a) * b)
        radius = abs(image)
        short = (1.0 - abs(a) ** 2) * (1.0 - abs(b) ** 2) / across**2 / (1.0 + radius)
        self._m1 = (short / (1.0 + radius)) ** 2
        self._a, self._b, self._speed = a, b, np.copysign(np.sqrt(c), field.rate0)
        self._offset = np.angle(image) - np.pi
        self._rate = self._speed * across * (1.0 + radius) / 2.0
        self.k = float(np.sqrt(1.0 - self._m1))
        self.period_s = float(2.0 * elliptic.K(self._m1) / abs(self._rate))
        eta0 = field.theta0 + 2.0 * np.angle(1.0 - a * np.exp(-1j * field.theta0))
        self._u0 = elliptic.F((eta0 - self._offset) / 2.0, self._m1)

    def at(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the angle and its rate."""
        eta = self._offset + 2.0 * elliptic.amplitude(self._u0 + self._rate * t_s, self._m1)
        theta = eta + 2.0 * np.angle(1.0 + self._a * np.exp(-1j * eta))
        z = np.exp(1j * theta)
        return theta, self._speed * np.abs(z - self._a) * np.abs(z - self._b)


class Separatrix:
    """
    The motion to, from, or from and to the equilibrium theta0 + d, a double root of f.

    kappa = cot((theta - equilibrium) / 2) obeys the linear kappa'' = q2 kappa + q1 / 2.
    """

    k, period_s, limits = 1.0, None, None

    def __init__(self, field: Field, d: float):
        self._equilibrium = field.theta0 + d
        twice = 2.0 * self._equilibrium
        q2 = field.second_derivative(d)
        self._growth = np.sqrt(q2)
        sine = np.sin(-d / 2.0)
        self._kappa0 = np.cos(d / 2.0) / sine
        self._slope0 = -field.rate0 / (2.0 * sine**2)
        self._pull = q2 * self._kappa0 + field.G2 * np.sin(twice)
        # atan2 counts the angle from 0 to 2 pi; a start behind the equilibrium is at -d there
        self._turns = 2.0 * np.pi * np.floor(-d / (2.0 * np.pi))

    def at(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the angle and its rate."""
        # beyond exp(300) the angle is the equilibrium to the last bit
        x = np.minimum(self._growth * t_s, 300.0)
        t = x / self._growth if self._growth > 0.0 else t_s
        sinh, half = _sinhc(x) * t, _sinhc(x / 2.0) * t / 2.0
        kappa = self._kappa0 + self._slope0 * sinh + 2.0 * self._pull * half**2
        slope = self._slope0 * np.cosh(x) + self._pull * sinh
        theta = self._equilibrium + self._turns + 2.0 * np.arctan2(1.0, kappa)
        return theta, -2.0 * slope / (1.0 + kappa**2)


def _sinhc(x):
    """Return sinh(x) / x."""
    return np.sinh(x) / np.where(x == 0.0, 1.0, x) + (x == 0.0)

"""
The half-angle numbers of a flow as theta functions of time (flow.py says of what).

A theta function is the series sum over all j of (-1)^j Q^(j(j-1)/2) X^j.  With real period T,
imaginary period T' and a zero at i h, X turns with time, exp(-2 pi (h + i t) / T), and |Q| =
exp(-2 pi share T' / T) < 0.05 while T' >= T; else by Jacobi's imaginary transformation X decays
with time, exp(-2 pi (t - i h) / T'), and |Q| = exp(-2 pi share T / T').  On a rhombic lattice Q is
negative.
"""

from functools import partial
from typing import NamedTuple

import numpy as np

from ..kernel.compile import compiled, inlined

# Times evaluated at once: their sums stay in the processor's first-level cache.
ROWS = 64
# What _series keeps of a row: powers of X and 1 / X with their share of Q, last term and sums.
_X, _Y, _UP, _DOWN, _TERM, _TERM_SLOPE, _RATIO, _SLOPE = range(8)


class Lattice(NamedTuple):
    """
    The periods of u [s]: period, and i imaginary or, on a rhombic lattice, half the sum of both.

    share: 1, or 1/2 on a rhombic lattice; share * imaginary / period is Im tau.
    """

    period: float
    imaginary: float
    share: float


class Zero(NamedTuple):
    """
    The zero of a half-angle number, sign * i * height from an end of the range of u.

    Attributes
    ----------
    sign : float
        of its imaginary part
    height : s
        its distance from the end
    depth : s
        share * imaginary - height
    at_end : bool
        whether the end is not the one where the clock starts but the other, half a period later
    rate : rad/s
        the mean turn of the number squared
    """

    sign: float
    height: float
    depth: float
    at_end: bool
    rate: float


@compiled
def evaluate(
    t_s: np.ndarray, since_s: float, lattice: Lattice, plus: Zero, minus: Zero
) -> np.ndarray:
    """Return alpha, alpha', beta and beta' at t_s (N,), up to constant and common real factors."""
    numbers = np.empty((4, len(t_s)), np.complex128)
    r, decay = np.empty(ROWS), np.empty((3, ROWS))
    for begin in range(0, len(t_s), ROWS):
        count = min(ROWS, len(t_s) - begin)
        for i in range(count):
            r[i] = since_s + t_s[begin + i]
            if lattice.period < np.inf:
                r[i] -= lattice.period * np.rint(r[i] / lattice.period)
        if lattice.imaginary < lattice.period:
            _decay(r[:count], lattice, decay)
        for first, zero in ((0, plus), (2, minus)):
            rate, left_rate = zero.rate / 2.0, 0.0
            if lattice.imaginary >= lattice.period:
                number = _oscillating(r[:count], lattice, zero)
            else:
                number = _decaying(r[:count], decay, lattice, zero)
                left_rate = _left_rate(lattice, zero)
            for i in range(count):
                value, slope = number[0, i], number[1, i]
                turn = _turn(rate * t_s[begin + i] + left_rate * r[i])
                numbers[first, begin + i] = turn * value
                numbers[first + 1, begin + i] = turn * (slope + 1j * (rate + left_rate) * value)
    return numbers


@partial(inlined, makes_arrays=True)
def _oscillating(r, lattice, zero):
    """Return the periodic factor and its slope (2, N) at r, X = exp(-w (height + i sign r))."""
    w = 2.0 * np.pi / lattice.period
    Q, size_Y = np.exp(-w * (zero.height + zero.depth)), np.exp(-w * zero.depth)
    if lattice.share < 1.0:
        Q, size_Y = -Q, -size_Y
    size_X, growth = np.exp(-w * zero.height), np.expm1(-w * zero.height)
    X, Y, away = np.empty(ROWS, np.complex128), np.empty(ROWS, np.complex128), np.empty(ROWS)
    for i in range(len(r)):
        angle = -zero.sign * w * r[i]
        if zero.at_end:
            angle += np.pi
        half = _turn(angle / 2.0)
        X[i], Y[i], away[i] = _arguments(size_X, growth, half, size_Y)
    number = _series(X, Y, Q, len(r))
    for i in range(len(r)):
        number[0, i], slope = _theta(X[i], away[i], number[0, i], number[1, i])
        number[1, i] = -1j * zero.sign * w * slope
    return number


@inlined
def _decay(r, lattice, decay):
    """Write exp(-w |r|), the same less 1, and exp(-w (T / 2 - |r|)), which all zeros share."""
    w = 2.0 * np.pi / lattice.imaginary
    for i in range(len(r)):
        log_X = -w * abs(r[i])
        decay[0, i], decay[1, i] = np.exp(log_X), np.expm1(log_X)
        decay[2, i] = np.exp(-w * (lattice.period / 2.0 - abs(r[i])))


@partial(inlined, makes_arrays=True)
def _decaying(r, decay, lattice, zero):
    """
    Return the number beside its turn and the slope (2, N) at r, X = exp(-w (|r| - i sign height)).

    What the Gaussian factor of the transformation and the mean rate leave of the turn has the rate
    _left_rate.
    """
    w = 2.0 * np.pi / lattice.imaginary
    angle = zero.sign * w * zero.height
    Q = np.exp(-w * lattice.share * lattice.period)
    is_rhombic = lattice.share < 1.0
    if is_rhombic:
        Q = -Q
        if zero.at_end:
            angle -= zero.sign * np.pi
    half = _turn(angle / 2.0)
    X, Y, away = np.empty(ROWS, np.complex128), np.empty(ROWS, np.complex128), np.empty(ROWS)
    for i in range(len(r)):
        size_X, growth, size_Y = decay[0, i], decay[1, i], decay[2, i]
        if is_rhombic:
            size_Y = -size_Y
        elif zero.at_end:
            log_X = -w * abs(r[i]) - w * lattice.period / 2.0
            size_X, growth = np.exp(log_X), np.expm1(log_X)
        else:
            size_Y *= np.sqrt(Q)
        X[i], Y[i], away[i] = _arguments(size_X, growth, half, size_Y)
    number = _series(X, Y, Q, len(r))
    for i in range(len(r)):
        front, growth = 1j * np.conj(half), 0.0
        if zero.at_end and not is_rhombic:
            front, growth = np.exp(-w * abs(r[i]) / 2.0) + 0j, -w / 2.0
        value, slope = _theta(X[i], away[i], number[0, i], number[1, i])
        value, slope = front * value, front * (growth * value - w * slope)
        if r[i] < 0.0:
            value, slope = np.conj(value), -np.conj(slope)
        number[0, i], number[1, i] = value, slope
    return number


@inlined
def _left_rate(lattice, zero):
    whole = zero.height + zero.depth
    return zero.sign * np.pi / lattice.period * (zero.height - zero.depth) / whole


@inlined
def _turn(angle):
    """Return exp(i angle)."""
    return complex(np.cos(angle), np.sin(angle))


@inlined
def _arguments(size_X, growth, half, size_Y):
    """
    Return X, Y = Q / X and 1 - Re X, half: exp(i angle / 2); growth: |X| - 1.

    Near a zero the digits of 1 - X are in growth and the angle.
    """
    s, c = half.imag, half.real
    turn = complex((c - s) * (c + s), 2.0 * s * c)
    return size_X * turn, size_Y * np.conj(turn), 2.0 * s * s - growth * turn.real


@inlined
def _theta(X, away, ratio, slope):
    """Return theta and X dtheta/dX; away: 1 - Re X; ratio: theta / (1 - X), slope: its slope."""
    from_zero = complex(away, -X.imag)
    return from_zero * ratio, from_zero * slope - X * ratio


@partial(inlined, makes_arrays=True)
def _series(X, Y, Q, count):
    """
    Return theta / (1 - X) and its slope X d/dX (2, count) at X (ROWS,), where Y = Q / X.

    The sum over j >= 0 of (-1)^j Q^(j(j+1)/2) (X^-j + .. + X^j).  All rows add a term at a time:
    the compiler makes vector instructions of it.
    """
    # One array, whose parts the compiler knows to be disjoint.
    numbers = np.zeros(2 * 8 * ROWS)
    for i in range(count):
        _put(numbers, _X, i, X[i])
        _put(numbers, _Y, i, Y[i])
    for i in range(ROWS):
        for n in (_UP, _DOWN, _TERM, _RATIO):
            _put(numbers, n, i, 1.0 + 0j)
    power, j = 1.0, 1
    while abs(power) > 1e-18:
        next_power = power * Q
        for i in range(ROWS):
            X_i, Y_i = _get(numbers, _X, i), _get(numbers, _Y, i)
            x = _get(numbers, _UP, i) * (next_power * X_i)
            y = _get(numbers, _DOWN, i) * (power * Y_i)
            term = -(next_power * _get(numbers, _TERM, i) + x + y)
            term_slope = -(next_power * _get(numbers, _TERM_SLOPE, i) + j * (x - y))
            _put(numbers, _UP, i, -x)
            _put(numbers, _DOWN, i, -y)
            _put(numbers, _TERM, i, term)
            _put(numbers, _TERM_SLOPE, i, term_slope)
            _put(numbers, _RATIO, i, _get(numbers, _RATIO, i) + term)
            _put(numbers, _SLOPE, i, _get(numbers, _SLOPE, i) + term_slope)
        power = next_power
        j += 1
    found = np.empty((2, count), np.complex128)
    for i in range(count):
        found[0, i], found[1, i] = _get(numbers, _RATIO, i), _get(numbers, _SLOPE, i)
    return found


@inlined
def _get(numbers, n, i):
    at = np.uintp(2 * n * ROWS) + np.uintp(i)
    return complex(numbers[at], numbers[at + np.uintp(ROWS)])


@inlined
def _put(numbers, n, i, z):
    at = np.uintp(2 * n * ROWS) + np.uintp(i)
    numbers[at], numbers[at + np.uintp(ROWS)] = z.real, z.imag

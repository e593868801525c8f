"""
The half-angle numbers of a flow as theta functions of time (flow.py says of what).

A theta function is the series sum over all j of (-1)^j Q^(j(j-1)/2) X^j.  With real period T,
imaginary period T' and a zero at i h, X turns with time, exp(-2 pi (h + i t) / T), and |Q| =
exp(-2 pi share T' / T) < 0.05 while T' >= T; else by Jacobi's imaginary transformation X decays
with time, exp(-2 pi (t - i h) / T'), and |Q| = exp(-2 pi share T / T').  On a rhombic lattice Q is
negative.
"""

from typing import NamedTuple

import numpy as np

from ..compiled import compiled, inlined


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
    The zero of a half-angle number, sign * i * height [s] from an end of the range of u.

    depth [s]: share * imaginary - height.  at_end: the end is not the one where the clock starts
    but the other, half a period later.  rate [rad/s]: the mean turn of the number squared.
    """

    sign: float
    height: float
    depth: float
    at_end: bool
    rate: float


@compiled
def evaluate(t_s, since_s, lattice, plus, minus):
    """Return alpha, alpha', beta and beta' at t_s (N,), up to constant and common real factors."""
    numbers = np.empty((4, len(t_s)), np.complex128)
    for i in range(len(t_s)):
        r = since_s + t_s[i]
        if lattice.period < np.inf:
            r -= lattice.period * np.rint(r / lattice.period)
        numbers[0, i], numbers[1, i] = _number(t_s[i], r, lattice, plus)
        numbers[2, i], numbers[3, i] = _number(t_s[i], r, lattice, minus)
    return numbers


@inlined
def _number(t, r, lattice, zero):
    """Return exp(i rate t / 2) times the periodic factor at r, |r| <= period / 2; its slope."""
    if lattice.imaginary >= lattice.period:
        value, slope = _oscillating(r, lattice, zero)
    else:
        value, slope = _decaying(r, lattice, zero)
    rate = zero.rate / 2.0
    turn = np.exp(1j * rate * t)
    return turn * value, turn * (slope + 1j * rate * value)


@inlined
def _oscillating(r, lattice, zero):
    """Return the periodic factor and its slope, X = exp(-w (height + i sign r))."""
    w = 2.0 * np.pi / lattice.period
    angle = -zero.sign * w * r
    if zero.at_end:
        angle += np.pi
    Q, size_Y = np.exp(-w * (zero.height + zero.depth)), np.exp(-w * zero.depth)
    if lattice.share < 1.0:
        Q, size_Y = -Q, -size_Y
    value, slope = _theta(-w * zero.height, angle, size_Y, Q)
    return value, -1j * zero.sign * w * slope


@inlined
def _decaying(r, lattice, zero):
    """Return the periodic factor and its slope, X = exp(-w (|r| - i sign height))."""
    w = 2.0 * np.pi / lattice.imaginary
    angle = zero.sign * w * zero.height
    log_X, size_Y = -w * abs(r), np.exp(-w * (lattice.period / 2.0 - abs(r)))
    Q = np.exp(-w * lattice.share * lattice.period)
    growth = 0.0
    if lattice.share < 1.0:
        Q, size_Y = -Q, -size_Y
        if zero.at_end:
            angle -= zero.sign * np.pi
        front = 1j * np.exp(-0.5j * angle)
    elif zero.at_end:
        front, growth = np.exp(log_X / 2.0) + 0j, -w / 2.0
        log_X -= w * lattice.period / 2.0
    else:
        size_Y *= np.sqrt(Q)
        front = 1j * np.exp(-0.5j * angle)
    value, slope = _theta(log_X, angle, size_Y, Q)
    value, slope = front * value, front * (growth * value - w * slope)
    if r < 0.0:
        value, slope = np.conj(value), -np.conj(slope)
    # What the Gaussian factor of the transformation and the mean rate leave of the turn.
    whole = zero.height + zero.depth
    rest = zero.sign * np.pi / lattice.period * (zero.height - zero.depth) / whole
    turn = np.exp(1j * rest * r)
    return turn * value, turn * (slope + 1j * rest * value)


@inlined
def _theta(log_X, angle, size_Y, Q):
    """
    Return theta and X dtheta/dX at X = exp(log_X + i angle), where Q / X = size_Y exp(-i angle).

    theta / (1 - X) is the sum over j >= 0 of (-1)^j Q^(j(j+1)/2) (X^-j + .. + X^j): near a zero
    the digits are in 1 - X.
    """
    s, c = np.sin(angle / 2.0), np.cos(angle / 2.0)
    turn, growth = complex((c - s) * (c + s), 2.0 * s * c), np.expm1(log_X)
    X, Y = np.exp(log_X) * turn, size_Y * np.conj(turn)
    from_zero = complex(2.0 * s * s - growth * turn.real, -X.imag)
    ratio, slope = 1.0 + 0j, 0j
    term, term_slope = 1.0 + 0j, 0j
    x, y, power, j = 1.0 + 0j, 1.0 + 0j, 1.0, 1
    while abs(power) > 1e-18:
        y *= power * Y
        power *= Q
        x *= power * X
        term = -(power * term + x + y)
        term_slope = -(power * term_slope + j * (x - y))
        x, y = -x, -y
        ratio += term
        slope += term_slope
        j += 1
    return from_zero * ratio, from_zero * slope - X * ratio

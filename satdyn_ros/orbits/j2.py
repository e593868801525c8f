"""
The orbit about an oblate centre, integrated.

    r'' = -mu r / r^3 + (3/2) J2 mu R^2 / r^5 ((5 z^2 / r^2 - 1) (x, y), (5 z^2 / r^2 - 3) z)

z along inertial +Z (Montenbruck and Gill, Satellite Orbits, section 3.2, of the zonal term of
degree 2).  In each piece r is the polynomial whose second derivative is this acceleration at the
nodes (collocation), found by Picard's iteration; the next piece begins where it ends.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from .kepler import EARTH_RADIUS_M, KeplerOrbit
from .pieces import Piece, Stretch
from .tabled import OrbitSource

EARTH_J2 = 1.08262668e-3


def _matrices(count):
    """
    Return the nodes, and what takes the acceleration there to its integrals from x = -1 on.

    To the terms of the second; to its values at the nodes; to the first one at the end.  In more
    digits than double ones: an error of a last digit here is made in every piece alike.
    """
    angles = np.arccos(np.longdouble(-1.0)) * (np.arange(count)[::-1] + 0.5) / count
    to_terms = 2.0 / np.longdouble(count) * np.cos(np.outer(np.arange(count), angles))
    to_terms[0] /= 2.0
    once, twice = (chebyshev.chebint(to_terms, n, lbnd=-1.0) for n in (1, 2))
    values = np.cos(np.outer(angles, np.arange(count + 2))) @ twice
    found = np.cos(angles), twice, values, np.sum(once, axis=0)
    return [each.astype(float) for each in found]


_NODES, _TWICE, _AT_NODES, _AT_END = _matrices(18)
# Each gains a factor of 100 and more; what is left after ten is rounding.
_ITERATIONS = 12
# Of the distance: where the last one still changes more, deep in the body, there is no end to it.
_LEAST_LEFT = 1e-9
# Between the pieces whose starts are kept for good, half a day of a low orbit apart.
_MARK = 100


@dataclass(eq=False)
class OblateOrbit(OrbitSource):
    """
    An orbit with J2.

    Parameters
    ----------
    start : KeplerOrbit
        the ellipse whose elements are those of the orbit at tick 0
    j2 : float
        of the attracting body
    reference_radius : m
        that J2 refers to
    """

    start: KeplerOrbit
    j2: float = EARTH_J2
    reference_radius: float = EARTH_RADIUS_M

    def __post_init__(self) -> None:
        self._marks = {0: self.start.position_velocity(0.0)}
        # Most often the piece that follows the last one is asked for.
        self._recent = (0, self._marks[0])

    def __repr__(self) -> str:
        return f'{self.start}, J2 {self.j2:g}'

    @cached_property
    def stretches(self) -> tuple[Stretch, ...]:
        """Those of the ellipse at tick 0."""
        return self.start.stretches

    def acceleration(self, r_i: np.ndarray) -> np.ndarray:
        """Return r'' [m/s^2] at positions [m], both (N, 3)."""
        r_squared = np.sum(r_i * r_i, axis=1, keepdims=True)
        attraction = self.start.mu / (r_squared * np.sqrt(r_squared))
        oblate = 1.5 * self.j2 * self.reference_radius**2 / r_squared
        up = 5.0 * r_i[:, 2:] ** 2 / r_squared
        return attraction * r_i * (oblate * (up - [1.0, 1.0, 3.0]) - 1.0)

    def coefficients(self, piece: Piece) -> np.ndarray:
        """Return those of r_i over a piece, (3, terms)."""
        if piece.number >= 0:
            terms, end = self._solve(*self._start_of(piece.number))
            self._recent = piece.number + 1, end
            return terms
        # Before tick 0 lies what comes after it on the way back.
        mirrored = self._backward.coefficients(piece._replace(number=-1 - piece.number))
        return mirrored * (-1.0) ** np.arange(mirrored.shape[1])

    @cached_property
    def _backward(self) -> 'OblateOrbit':
        r_i, v_i = self.start.position_velocity(0.0)
        return replace(self, start=KeplerOrbit.from_state(r_i, -v_i, self.start.mu))

    def _start_of(self, number):
        """Return r_i and v_i where a piece begins."""
        k, state = self._recent
        if k > number:
            k = number - number % _MARK
            while k not in self._marks:
                k -= _MARK
            state = self._marks[k]
        while k < number:
            state = self._solve(*state)[1]
            k += 1
            if k % _MARK == 0:
                self._marks[k] = state
        return state

    def _solve(self, r_0, v_0):
        """Return the coefficients of a piece that begins with r_0 and v_0, and how it ends."""
        half_s = self.stretches[0].length_s / 2.0
        unforced = r_0 + half_s * v_0 * (_NODES[:, None] + 1.0)
        forced = half_s**2 * self.acceleration(unforced)
        before = forced
        for _ in range(_ITERATIONS):
            before = forced
            forced = half_s**2 * self.acceleration(unforced + _AT_NODES @ forced)
        left, r = np.max(np.abs(_AT_NODES @ (forced - before))), np.linalg.norm(r_0)
        if not left <= _LEAST_LEFT * r:
            raise ValueError(
                f'with orbit.j2 {self.j2:g} the orbit comes too near to the centre, to '
                f'{r / 1e3:.4g} km, to be integrated'
            )
        terms = _TWICE @ forced
        end = r_0 + 2.0 * half_s * v_0 + np.sum(terms, axis=0), v_0 + _AT_END @ forced / half_s
        terms[0] += r_0 + half_s * v_0
        terms[1] += half_s * v_0
        return terms.T, end

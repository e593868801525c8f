"""
What an ephemeris asks for between its rows: Lagrange's polynomials, or Hermite's.

And the pieces in which they are tabled.  The polynomials change at the rows: pieces end at rows,
and have as many between their ends as can be tabled together.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev

from .pieces import PIECE_TURN, Stretch

# How far the table may be from the interpolation, and its velocity.
_ENOUGH_M, _ENOUGH_M_S = 3e-4, 3e-5
# A piece has as many terms, and holds a polynomial of a degree below.
_TERMS = 16
# In how many points a piece is compared, at least, and two between rows.
_POINTS = 12
# How often a piece without a row inside may be halved.
_HALVED = 5
# How far pieces of one length may end from their rows [s].
_ALIKE_S = 1e-8
# How many polynomials are worked out together: some megabytes.
_TOGETHER = 4096


@dataclass(frozen=True, eq=False)
class Interpolation:
    """
    Polynomials between the rows of an ephemeris.

    By Lagrange's each column is one; by Hermite's the positions are, whose slopes at the rows are
    the velocities.

    Attributes
    ----------
    times_s : (N,), s
        ascending
    rows : (N, 6), m, m/s
        positions and velocities
    is_hermite : bool
        whether they are Hermite's
    window : int
        how many rows each goes through
    """

    times_s: np.ndarray
    rows: np.ndarray
    is_hermite: bool
    window: int

    @property
    def degree(self) -> int:
        """The degree of the polynomials."""
        return 2 * self.window - 1 if self.is_hermite else self.window - 1

    def of_every_other(self) -> 'Interpolation':
        """Return that of every other row, from the first on, of the same degree if it can be."""
        times_s, rows = self.times_s[::2], self.rows[::2]
        return Interpolation(times_s, rows, self.is_hermite, min(self.window, len(times_s)))

    def at(self, x_s: np.ndarray) -> np.ndarray:
        """Return r_i and v_i at times (N,), (N, 6)."""
        return self.with_slope(x_s)[0]

    def with_slope(self, x_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return r_i and v_i, (N, 6), and the slope of r_i, (N, 3), at times (N,)."""
        if len(x_s) > _TOGETHER:
            starts = range(0, len(x_s), _TOGETHER)
            parts = [self.with_slope(x_s[start : start + _TOGETHER]) for start in starts]
            values, slopes = zip(*parts, strict=True)
            return np.concatenate(values), np.concatenate(slopes)
        # The rows on both sides, as many before as after, at the ends those that there are.
        before = np.searchsorted(self.times_s, x_s, side='right') - 1
        first = np.clip(before - (self.window - 1) // 2, 0, len(self.times_s) - self.window)
        indices = first[:, None] + np.arange(self.window)
        # Times in a unit of their own keep the numbers near 1.
        unit_s = (self.times_s[-1] - self.times_s[0]) / (len(self.times_s) - 1)
        x = (x_s - self.times_s[first]) / unit_s
        nodes = (self.times_s[indices] - self.times_s[first][:, None]) / unit_s
        rows = self.rows[indices]
        if not self.is_hermite:
            found, slope = _newton(nodes, rows, x)
            return found, slope[:, :3] / unit_s
        r, slopes = rows[..., :3], rows[..., 3:] * unit_s
        r_i, slope = _newton(np.repeat(nodes, 2, axis=1), np.repeat(r, 2, axis=1), x, slopes)
        return np.hstack([r_i, slope / unit_s]), slope / unit_s


@dataclass(frozen=True, eq=False)
class Span:
    """
    A time that is interpolated from one set of rows.

    Attributes
    ----------
    interpolation : Interpolation
        between the rows
    begin_s, end_s : s
        from tick 0
    ahead_s : s
        by how much the times of the rows are ahead of those from tick 0
    fastest_rad_s : rad/s
        how fast the line from the centre to the body turns
    """

    interpolation: Interpolation
    begin_s: float
    end_s: float
    ahead_s: float
    fastest_rad_s: float

    def interpolated(self, t_s: np.ndarray) -> np.ndarray:
        """Return r_i [m] and v_i [m/s] at times (N,), (N, 6)."""
        return self.interpolation.at(t_s + self.ahead_s)

    @property
    def edges_s(self) -> np.ndarray:
        """Its begin, the rows inside and its end."""
        rows_s = self.interpolation.times_s - self.ahead_s
        inside = (rows_s > self.begin_s + _ALIKE_S) & (rows_s < self.end_s - _ALIKE_S)
        return np.array([self.begin_s, *rows_s[inside], self.end_s])

    def stretches(self) -> tuple[Stretch, ...]:
        """
        Return it in pieces in which a table reproduces the interpolation.

        Each begins as long as all may be; where its table would be off it is halved, at a row if
        there is one inside.
        """
        edges_s = self.edges_s
        turned, turns = self.fastest_rad_s * edges_s, self.fastest_rad_s * np.diff(edges_s)
        # Of a power of two: halves of pieces of one length are of one length.
        most = 2 ** max(0, math.floor(math.log2(PIECE_TURN / max(np.median(turns), 1e-9))))
        last = len(turns)
        waiting = [(i, min(i + most, last)) for i in range(0, last, most)]
        pieces_s: list[np.ndarray] = []
        while waiting:
            fit = [(i, j) for i, j in waiting if j - i == 1 or turned[j] - turned[i] <= PIECE_TURN]
            many = [(i, j) for i, j in fit if j - i > 1]
            off = set(self._off(many, edges_s))
            pieces_s += [edges_s[[i, j]] for i, j in many if (i, j) not in off]
            pieces_s += [self._within_rows(edges_s, i, turns[i]) for i, j in fit if j - i == 1]
            halved = off | ({*waiting} - {*fit})
            waiting = [half for i, j in halved for half in ((i, (i + j) // 2), ((i + j) // 2, j))]
        return _together(np.unique(np.concatenate(pieces_s)))

    def _within_rows(self, edges_s, i, turn):
        """Return the ends of the pieces from one edge to the next, which share one polynomial."""
        ends_s, count = edges_s[i : i + 2], max(1, math.ceil(turn / PIECE_TURN))
        if count > 1:
            ends_s = np.linspace(ends_s[0], ends_s[1], count + 1)
        if self.interpolation.degree < _TERMS:
            return ends_s
        for _ in range(_HALVED):
            if not self._off([(k, k + 1) for k in range(count)], ends_s):
                break
            count *= 2
            ends_s = np.linspace(ends_s[0], ends_s[-1], count + 1)
        return ends_s

    def _off(self, pieces, edges_s):
        """Return which pieces, each from one edge to another, a table would be off in."""
        if not pieces:
            return []
        first, last = np.array(pieces).T
        begin_s, length_s = edges_s[first], edges_s[last] - edges_s[first]
        nodes = chebyshev.chebpts1(_TERMS)
        at_nodes_s = begin_s[:, None] + length_s[:, None] * (nodes + 1.0) / 2.0
        values = self.interpolated(at_nodes_s.ravel()).reshape(*at_nodes_s.shape, 6)
        series = np.linalg.inv(chebyshev.chebvander(nodes, _TERMS - 1)) @ values
        # Some points between any two edges inside.
        points = max(2, math.ceil(_POINTS / np.min(last - first)))
        within = (np.arange(points) + 0.5) / points
        intervals = np.concatenate([np.arange(i, j) for i, j in pieces])
        steps_s = np.diff(edges_s)[intervals]
        t_s = (edges_s[intervals][:, None] + steps_s[:, None] * within).ravel()
        owner = np.repeat(np.repeat(np.arange(len(pieces)), last - first), points)
        x = 2.0 * (t_s - begin_s[owner]) / length_s[owner] - 1.0
        tabled = np.einsum('nk,nkc->nc', chebyshev.chebvander(x, _TERMS - 1), series[owner])
        off = np.abs(tabled - self.interpolated(t_s))
        wrong = (off[:, :3] > _ENOUGH_M).any(axis=1) | (off[:, 3:] > _ENOUGH_M_S).any(axis=1)
        return [pieces[k] for k in np.unique(owner[wrong])]


def _together(ends_s: np.ndarray) -> tuple[Stretch, ...]:
    """Return pieces between ascending times as stretches, those of one length together."""
    lengths_s = np.diff(ends_s)
    changes = np.flatnonzero(np.abs(np.diff(lengths_s)) > _ALIKE_S) + 1
    found = []
    for i, j in zip([0, *changes], [*changes, len(lengths_s)], strict=True):
        begin_s, end_s = float(ends_s[i]), float(ends_s[j])
        length_s = (end_s - begin_s) / int(j - i)
        evenly_s = begin_s + length_s * np.arange(j - i + 1)
        if np.allclose(ends_s[i : j + 1], evenly_s, rtol=0.0, atol=_ALIKE_S):
            found.append(Stretch(begin_s, length_s, begin_s, end_s))
        else:
            found += [
                Stretch(float(a), float(b - a), float(a), float(b))
                for a, b in zip(ends_s[i:j], ends_s[i + 1 : j + 1], strict=True)
            ]
    return tuple(found)


def _newton(nodes, values, x, slopes=None):
    """
    Return the polynomials through values (N, n, C) at nodes (N, n), and their slopes, at x (N,).

    slopes (N, n / 2, C): those at the nodes, each of which stands twice then.
    """
    # Divided differences, in place; each polynomial by Newton's form.
    terms = [values[:, 0]]
    table, count = values, nodes.shape[1]
    for order in range(1, count):
        steps = nodes[:, order:] - nodes[:, :-order]
        with np.errstate(divide='ignore', invalid='ignore'):
            table = (table[:, 1:] - table[:, :-1]) / steps[..., None]
        if order == 1 and slopes is not None:
            table[:, ::2] = slopes
        terms.append(table[:, 0])
    found, slope = terms[-1], np.zeros_like(terms[-1])
    for k in range(count - 2, -1, -1):
        beyond = (x - nodes[:, k])[:, None]
        found, slope = terms[k] + beyond * found, found + beyond * slope
    return found, slope

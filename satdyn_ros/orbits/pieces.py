"""
What depends on time alone, piece by piece: polynomials for the equations, and for whoever asks.

Any library may compute such a function at the nodes of a piece.  What a piece holds depends on the
function and on the piece alone, and each is made by one call of one shape, whatever was asked for
before: a library's last bit may change with the number of rows.
"""

import math
import sys
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from ..base.nanoseconds import DAY_NS, SECOND_NS
from ..kernel.time_table import Table, interpolate

# By how much the line from the centre to the body turns in a piece, where it turns fastest [rad].
# The nearest singularity of a parabola in complex time is 4/3 over the rate at its pericentre
# away, that of an ellipse no nearer: 16 terms of a Chebyshev series leave 1e-16.
PIECE_TURN = 0.5
_TERMS = 16
_DAY_S = 86_400.0
# How far the time of a tick may be beyond the end that it is at: its stamp is rounded, and both.
_STAMP_ROUNDING_S, _ROUNDING = 5e-10, 1e-15
# To what the end of a function is found, and in how many parts of a piece it is sought.
_INSTANT_S, _PARTS = 1e-11, 32
# The square of a momentum r x v of such numbers is still one.
_LARGEST = 1e70
# More than a day of a low orbit, 0.4 MB: runs that share the orbit share them.
_KEPT = 256
# One thread, whatever there is to make: each would take its turn before the one that ticks.
_AHEAD = ThreadPoolExecutor(1, 'tables')


class Stretch(NamedTuple):
    """
    A time that is cut into pieces of one length, where the function is smooth.

    Piece k begins at origin_s + k length_s.

    Attributes
    ----------
    origin_s : s
        from tick 0
    length_s : s
        of a piece
    begin_s, end_s : s
        from tick 0, the time for which there are pieces: each infinite or where a piece begins or
        ends
    """

    origin_s: float
    length_s: float
    begin_s: float = -math.inf
    end_s: float = math.inf

    def edge_s(self, k: int) -> float:
        """Return when piece k begins."""
        return self.origin_s + k * self.length_s

    @property
    def last(self) -> int:
        """The number of the last piece, where there is one; else one that no run comes to."""
        pieces = (self.end_s - self.origin_s) / self.length_s
        return round(pieces) - 1 if math.isfinite(pieces) else sys.maxsize

    def number(self, t_s: float) -> int:
        """Return which piece a time is in; the end of the stretch is in its last."""
        k = math.floor((t_s - self.origin_s) / self.length_s)
        # The quotient is rounded, and the edges are.
        if t_s >= self.edge_s(k + 1):
            k += 1
        elif t_s < self.edge_s(k):
            k -= 1
        return min(k, self.last)


class Piece(NamedTuple):
    """One piece: the number k in a stretch."""

    stretch: Stretch
    number: int

    @property
    def begin_s(self) -> float:
        """When it begins [s from tick 0]."""
        return self.stretch.edge_s(self.number)

    @property
    def end_s(self) -> float:
        """When it ends and the next begins [s from tick 0]."""
        is_last = self.number == self.stretch.last
        return self.stretch.end_s if is_last else self.stretch.edge_s(self.number + 1)


def fitted(
    function: Callable[[np.ndarray], np.ndarray], terms: int = _TERMS
) -> Callable[[Piece], np.ndarray]:
    """
    Return how to make pieces of functions by their values.

    Parameters
    ----------
    function : function of (terms,), s
        returns the values (terms, C) of C functions at times from tick 0
    terms : int
        of the polynomials, whose degree is one less
    """
    nodes, to_terms = _nodes(terms)

    def make(piece):
        t_s = piece.begin_s + piece.stretch.length_s * (nodes + 1.0) / 2.0
        return (to_terms @ function(t_s)).T

    return make


def whole_seconds(
    function: Callable[[np.ndarray], np.ndarray],
    epoch_ns: int,
    with_end: bool = False,
    most: int = 32,
) -> Callable[[Piece], np.ndarray]:
    """
    Return how to make pieces of a function that is known at whole seconds of UTC, and not exactly.

    By least squares on some of them, which takes out most of what it scatters.

    Parameters
    ----------
    function : function of (K,), s
        returns the values (K, C) of C functions at times from tick 0
    epoch_ns : ns
        Unix time of tick 0
    with_end : bool
        whether by that second too at which a piece ends, where the function may have jumped
    most : int
        the most seconds that a piece is made from
    """
    first_s = (-epoch_ns % SECOND_NS) / SECOND_NS
    nodes, _ = _nodes(most)

    def make(piece):
        begin_s, end_s = np.ceil(piece.begin_s - first_s), np.ceil(piece.end_s - first_s) - 1.0
        if with_end:
            end_s = max(begin_s, np.floor(piece.end_s - first_s))
        at_s = piece.begin_s + piece.stretch.length_s * (nodes + 1.0) / 2.0 - first_s
        # In less than a second there may be none: then it is the one before.
        t_s = np.unique(np.clip(np.rint(at_s), min(begin_s, end_s), end_s)) + first_s
        x = 2.0 * (t_s - piece.begin_s) / piece.stretch.length_s - 1.0
        terms = min(_TERMS, len(x))
        series, *_ = np.linalg.lstsq(chebyshev.chebvander(x, terms - 1), function(t_s))
        return np.pad(series.T, ((0, 0), (0, _TERMS - terms)))

    return make


def no_longer(stretches: Iterable[Stretch], longest_s: float) -> list[Stretch]:
    """
    Return stretches whose pieces are cut into equal ones where they are too long.

    Parameters
    ----------
    stretches : iterable of Stretch
        as they are
    longest_s : s
        the longest that a piece may be
    """
    return [
        each._replace(length_s=each.length_s / math.ceil(each.length_s / longest_s))
        for each in stretches
    ]


def ending_at(stretches: Iterable[Stretch], times_s: Iterable[float]) -> list[Stretch]:
    """
    Return stretches whose pieces, none longer than before, end at some times too.

    A time is shared out anew from the beginning of the piece before that which it is in to the end
    of the one after, so that no piece is much shorter either; all others are as they were.

    Parameters
    ----------
    stretches : iterable of Stretch
        as they are
    times_s : iterable of s
        from tick 0
    """
    found = list(stretches)
    for t_s in sorted(times_s):
        for i, stretch in enumerate(found):
            if stretch.begin_s < t_s < stretch.end_s:
                found[i : i + 1] = _parted(stretch, t_s)
                break
    return found


def _parted(stretch, t_s):
    k = stretch.number(t_s)
    first_s = max(stretch.begin_s, stretch.edge_s(k - 1))
    last_s = stretch.end_s if k + 1 >= stretch.last else stretch.edge_s(k + 2)
    edges_s = stretch.begin_s, first_s, t_s, last_s, stretch.end_s
    for n, (begin_s, end_s) in enumerate(pairwise(edges_s)):
        if n in (0, 3) and begin_s < end_s:
            yield stretch._replace(begin_s=begin_s, end_s=end_s)
        elif begin_s < end_s:
            length_s = (end_s - begin_s) / math.ceil((end_s - begin_s) / stretch.length_s)
            yield Stretch(begin_s, length_s, begin_s, end_s)


def within_days(stretches: Iterable[Stretch], epoch_ns: int) -> list[Stretch]:
    """
    Return stretches whose pieces, none longer than before, end where a day of UTC does.

    Parameters
    ----------
    stretches : iterable of Stretch
        as they are
    epoch_ns : ns
        Unix time of tick 0
    """
    midnight_s = -(epoch_ns % DAY_NS) / SECOND_NS
    found = []
    for stretch in stretches:
        if math.isinf(stretch.begin_s) and math.isinf(stretch.end_s):
            pieces = math.ceil(_DAY_S / stretch.length_s)
            found.append(Stretch(midnight_s, _DAY_S / pieces))
            continue
        ends_s = stretch.begin_s, stretch.end_s
        days = range(*(math.ceil((end_s - midnight_s) / _DAY_S) for end_s in ends_s))
        edges = sorted({*ends_s, *(midnight_s + _DAY_S * day for day in days)})
        for begin_s, end_s in pairwise(edges):
            length_s = (end_s - begin_s) / math.ceil((end_s - begin_s) / stretch.length_s)
            found.append(Stretch(begin_s, length_s, begin_s, end_s))
    return found


def roots(function: Callable[[np.ndarray], np.ndarray]) -> Callable[[Piece], np.ndarray]:
    """Return what finds the times in a piece at which one of function(t_s (N,)) -> (N, C) is 0."""
    series_in = fitted(function)

    def find(piece):
        found = [chebyshev.chebroots(series) for series in series_in(piece)]
        x = np.concatenate(found)
        x = np.sort(x[(x.imag == 0.0) & (abs(x) < 1.0)].real)
        return piece.begin_s + piece.stretch.length_s * (x + 1.0) / 2.0

    return find


@lru_cache
def _nodes(terms):
    """Return the nodes of a piece from -1 to 1, and what takes values there to coefficients."""
    nodes = chebyshev.chebpts1(terms)
    return nodes, np.linalg.inv(chebyshev.chebvander(nodes, terms - 1))


@lru_cache
def derivatives(terms: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices that take coefficients (C, terms) to those of d/dx and d^2/dx^2."""
    first = np.zeros((terms, terms))
    first[:, :-1] = chebyshev.chebder(np.eye(terms)).T
    return first, first @ first


class Pieces:
    """
    Functions of time in pieces, made when they are asked for and kept for a while.

    Where make refuses a piece by a ValueError, there is one up to where it knows the functions.

    Parameters
    ----------
    make : function of a Piece
        returns (C, terms), the Chebyshev coefficients of C functions over the piece, ascending
    stretches : sequence of Stretch
        in their order of time; where two meet, a function may jump
    outside : function of s
        returns the sentence of the refusal of a time from tick 0 that is in none
    corners : function of a Piece, or None
        returns (K,), the times [s] from tick 0 in the piece at which what is made of the functions
        is not smooth
    """

    def __init__(
        self,
        make: Callable[[Piece], np.ndarray],
        stretches: Sequence[Stretch],
        outside: Callable[[float], str] = '{:g} s from tick 0 is in no piece'.format,
        corners: Callable[[Piece], np.ndarray] | None = None,
    ):
        self._function, self._outside, self._corners = make, outside, corners
        self.stretches = tuple(stretches)
        self._begins_s = [stretch.begin_s for stretch in self.stretches]
        # Two threads that ask for the same piece may both make it: it is the same.
        self._kept = lru_cache(_KEPT)(self._made)
        self._shortened = lru_cache(_KEPT)(self._up_to_its_end)
        self._last_asked: Piece | None = None

    def _made(self, piece: Piece) -> tuple[Table, np.ndarray]:
        grid = np.array([piece.begin_s, piece.stretch.length_s], float)
        table = Table(grid, self._make(piece)[None])
        return table, np.zeros(0) if self._corners is None else self._corners(piece)

    def _make(self, piece):
        is_within = False
        with np.errstate(all='ignore'), suppress(OverflowError):
            coefficients = np.ascontiguousarray(self._function(piece), float)
            is_within = bool(np.all(np.abs(coefficients) < _LARGEST))
        if not is_within:
            raise ValueError(
                'the orbit, or what is along it, is beyond the range of numbers from '
                f'{piece.begin_s:g} to {piece.end_s:g} s after tick 0'
            )
        return coefficients

    def with_derivatives(self) -> 'Pieces':
        """Return the functions, and behind them their derivatives [1/s], in the same pieces."""

        def make(piece):
            values = self._table(piece).coefficients[0]
            slopes = np.zeros_like(values)
            slopes[:, :-1] = chebyshev.chebder(values, axis=1) * (2.0 / piece.stretch.length_s)
            return np.concatenate([values, slopes])

        return Pieces(make, self.stretches, self._outside)

    def _table(self, piece):
        return self._kept(piece)[0]

    def corners_in(self, piece: Piece) -> np.ndarray:
        """Return the times in a piece at which what is made of the functions is not smooth."""
        return self._kept(piece)[1]

    def __deepcopy__(self, memo: object) -> 'Pieces':
        """Return itself: what it gives never changes."""
        return self

    def piece_at(self, t_s: float) -> Piece:
        """Return the piece that a time is in, to rounding; ValueError: there is none."""
        return self._piece(t_s, lambda end_s: t_s <= latest_at(end_s))

    def piece_from(self, t_s: float) -> Piece:
        """Return the piece that is in force from a time on; ValueError: there is none."""
        return self._piece(t_s, lambda end_s: t_s < end_s)

    def _piece(self, t_s, is_before):
        why = ''
        # Where two meet it is in the later one.
        for i in range(bisect_right(self._begins_s, t_s) - 1, -1, -1):
            stretch = self.stretches[i]
            if is_before(stretch.end_s):
                piece = Piece(stretch, stretch.number(float(t_s)))
                try:
                    self._kept(piece)
                except ValueError as error:
                    why = why or str(error)
                    shorter = self._shortened(piece)
                    if shorter is None or not is_before(shorter.end_s):
                        continue
                    piece = shorter
                return piece
        raise ValueError(why or self._outside(t_s))

    def _up_to_its_end(self, piece):
        """Return the part of a piece up to where it is known; None: it is not where it begins."""
        known_s, unknown_s = None, math.inf
        for t_s in np.linspace(piece.begin_s, piece.end_s, _PARTS + 1).tolist():
            if not self._is_known(t_s):
                unknown_s = t_s
                break
            known_s = t_s
        if known_s is None or math.isinf(unknown_s):
            return None
        while known_s < (middle_s := 0.5 * (known_s + unknown_s)) < unknown_s - _INSTANT_S:
            if self._is_known(middle_s):
                known_s = middle_s
            else:
                unknown_s = middle_s
        if known_s == piece.begin_s:
            return None
        return Piece(Stretch(piece.begin_s, known_s - piece.begin_s, piece.begin_s, known_s), 0)

    def _is_known(self, t_s):
        try:
            self._make(Piece(Stretch(t_s, _INSTANT_S, t_s, t_s + _INSTANT_S), 0))
        except ValueError:
            return False
        return True

    def known_rows(self, t_s: np.ndarray) -> tuple[int, str]:
        """Return how many ascending times (N,), from the first, are in pieces, and why no more."""
        if not len(t_s) or self._is_covered(float(t_s[0]), float(t_s[-1])):
            return len(t_s), ''
        count = 0
        while count < len(t_s):
            try:
                piece = self.piece_at(float(t_s[count]))
            except ValueError as error:
                return count, str(error)
            count = max(count + 1, int(np.searchsorted(t_s, piece.end_s)))
        return count, ''

    def _is_covered(self, begin_s, end_s):
        """Whether there are pieces at two times, and no gap between the stretches."""
        try:
            self.piece_at(end_s)
            return end_s <= latest_at(self.covered_until(begin_s))
        except ValueError:
            return False

    def covered_until(self, t_s: float) -> float:
        """Return up to when [s] there are pieces without a gap from a time on."""
        end_s = self.piece_at(t_s).stretch.end_s
        for stretch in self.stretches:
            if stretch.begin_s <= end_s:
                end_s = max(end_s, stretch.end_s)
        return end_s

    def table_in(self, piece: Piece) -> Table:
        """
        Return the table of one piece, and let a thread make the next, unless it has been asked to.

        ValueError: it cannot be made.
        """
        table = self._table(piece)
        if piece != self._last_asked and piece.number < piece.stretch.last:
            self._last_asked = piece
            following = Piece(piece.stretch, piece.number + 1)
            # Where Python ends, a thread that still goes on makes its pieces when it needs them.
            with suppress(RuntimeError):
                _AHEAD.submit(self._make_ahead, following)
        return table

    def _make_ahead(self, piece):
        # Who comes to that piece meets the error again.
        with suppress(ValueError):
            self._kept(piece)

    def values(self, t_s: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """
        Return some of the functions at times, (N, C).

        By the very code of the equations.  Row i depends on t_s[i] alone.

        Parameters
        ----------
        t_s : (N,), s
            from tick 0
        columns : (C,) int
            the numbers of the functions
        """
        t_s = np.asarray(t_s, float)
        values = np.empty((len(t_s), len(columns)))
        for rows, current in by_piece((self,), t_s):
            table, some_s = self._table(current[self]), t_s[rows]
            values[rows] = interpolate(table, columns[:, None].astype(float), some_s).T
        return values


def latest_at(end_s: float) -> float:
    """Return the latest time [s from tick 0] of a tick that is at an end to rounding."""
    return end_s + _STAMP_ROUNDING_S + _ROUNDING * abs(end_s)


def by_piece(
    tables: Iterable[Pieces], t_s: np.ndarray
) -> Iterator[tuple[np.ndarray, dict[Pieces, Piece]]]:
    """
    Yield the rows of times that are in one piece of each table, and these pieces.

    Parameters
    ----------
    tables : iterable of Pieces
        the tables
    t_s : (N,), s
        from tick 0
    """
    order, begin = np.argsort(t_s, kind='stable'), 0
    ascending_s = t_s[order]
    while begin < len(t_s):
        current = {each: each.piece_at(ascending_s[begin]) for each in tables}
        end_s = min((piece.end_s for piece in current.values()), default=math.inf)
        end = max(begin + 1, int(np.searchsorted(ascending_s, end_s)))
        yield order[begin:end], current
        begin = end


def tables_of(current: Mapping[Pieces, Piece]) -> Callable[[Pieces], Table]:
    """Return what gives the table of each of these pieces, and makes the next ahead of time."""
    return lambda each: each.table_in(current[each])

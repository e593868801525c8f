"""
The orbit of a CCSDS Orbit Ephemeris Message, 502.0-B, in keyword = value notation.

Each segment is interpolated by itself, as it says: by Lagrange's polynomial of each column, or by
Hermite's of the positions, whose slopes at the rows are the velocities.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from ..base.kvn import kvn_rows
from ..base.nanoseconds import SECOND_NS, epoch, stamp_ns
from ..environment.earth import utc_from_tai_ns, utc_from_tt_ns
from .pieces import PIECE_TURN, Piece, Stretch, fitted
from .tabled import OrbitSource

_VERSIONS = ('1.0', '2.0', '3.0')
_FRAMES = ('EME2000', 'GCRF', 'ICRF')
_TO_UTC = {'UTC': lambda stamps_ns: stamps_ns, 'TT': utc_from_tt_ns, 'TAI': utc_from_tai_ns}
_METHODS = ('HERMITE', 'LAGRANGE', 'LINEAR')
_DEFAULT = ('HERMITE', '7')
_ROW_LENGTHS = (6, 9)
# How far the table may be from the interpolation, seen at a few places, and how often the longest
# pieces may be halved for it.
_ENOUGH_M, _HALVED = 1e-4, 5


@dataclass(frozen=True)
class EphemerisOrbit(OrbitSource):
    """
    The orbit of the text of an OEM from tick 0 on, which is at epoch_ns.

    ValueError: it is none, or of another centre, frame or time system, with what is wrong.
    """

    text: str
    epoch_ns: int

    def __post_init__(self) -> None:
        _ = self._segments

    def __repr__(self) -> str:
        begin, end = map(self._epoch, self._bounds_s)
        return f'ephemeris from {begin} to {end}'

    @cached_property
    def _segments(self) -> tuple['_Segment', ...]:
        segments: list[tuple[dict[str, str], list[list[str]]]] = []
        try:
            for row in kvn_rows(
                self.text.splitlines(), 'Orbit Ephemeris Message', 'CCSDS_OEM_VERS', _VERSIONS
            ):
                if not segments or row.metadata is not segments[-1][0]:
                    segments.append((row.metadata, []))
                segments[-1][1].append(row.words)
            if not segments:
                raise ValueError('it has no positions')
            made = [_Segment(metadata, rows, self.epoch_ns) for metadata, rows in segments]
            made.sort(key=lambda segment: segment.begin_s)
            # Where two have the same time, the later one counts.
            for segment, following in pairwise(made):
                segment.end_s = min(segment.end_s, following.begin_s)
            useable = tuple(segment for segment in made if segment.begin_s < segment.end_s)
            if not useable:
                raise ValueError('no time in it is useable')
        except ValueError as error:
            raise ValueError(f'orbit.file: {error}') from None
        return useable

    @property
    def _bounds_s(self):
        return self._segments[0].begin_s, self._segments[-1].end_s

    def _epoch(self, t_s):
        return epoch(self.epoch_ns + round(float(t_s) * SECOND_NS)).rstrip('0').rstrip('.')

    @cached_property
    def stretches(self) -> tuple[Stretch, ...]:
        """One for each segment, over its useable time."""
        return tuple(segment.stretch for segment in self._segments)

    def outside(self, t_s: float) -> str:
        """Return the sentence that refuses a time in no segment, or what follows on its end."""
        begin, end = map(self._epoch, self._bounds_s)
        is_gap = self._bounds_s[0] < t_s < self._bounds_s[1]
        gap = ', with a gap between two segments there' if is_gap else ''
        is_last = any(t_s == segment.end_s for segment in self._segments)
        where = f'{"after" if is_last else "at"} {self._epoch(t_s)}'
        return f'orbit.file has no position {where}: it goes from {begin} to {end}{gap}'

    def coefficients(self, piece: Piece) -> np.ndarray:
        """Return those of r_i and v_i over a piece, (6, terms)."""
        segment = self._segments[self.stretches.index(piece.stretch)]
        return fitted(segment.interpolated)(piece)

    def position_velocity(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return r_i [m] and v_i [m/s] at times (N,), each (N, 3); ValueError: one is outside."""
        found = np.full((len(t_s), 6), np.nan)
        for segment in self._segments:
            inside = (t_s >= segment.begin_s) & (t_s <= segment.end_s)
            found[inside] = segment.interpolated(t_s[inside])
        outside = np.isnan(found[:, 0])
        if np.any(outside):
            raise ValueError(self.outside(t_s[outside][0]))
        return found[:, :3], found[:, 3:]


class _Segment:
    """The rows of a segment, with times from tick 0, and how it says to interpolate them."""

    def __init__(self, metadata, rows, epoch_ns):
        def value(keyword, *default):
            if keyword not in metadata and not default:
                raise ValueError(f'a segment has no {keyword}')
            return metadata.get(keyword, *default).upper()

        for keyword, allowed in (
            ('CENTER_NAME', ('EARTH',)),
            ('REF_FRAME', _FRAMES),
            ('TIME_SYSTEM', tuple(_TO_UTC)),
        ):
            if value(keyword) not in allowed:
                raise ValueError(f'{keyword} is {value(keyword)}; supported: {", ".join(allowed)}')
        self._method, degree = value('INTERPOLATION', _DEFAULT[0]), _DEFAULT[1]
        if self._method not in _METHODS:
            raise ValueError(f'INTERPOLATION is {self._method}; supported: {", ".join(_METHODS)}')
        degree = '1' if self._method == 'LINEAR' else value('INTERPOLATION_DEGREE', degree)
        if not (degree.isdigit() and int(degree) > 0):
            raise ValueError(
                f'INTERPOLATION_DEGREE is {degree}; it must be a whole number above 0'
            )
        # Hermite's polynomial through n rows has the degree 2 n - 1.
        is_hermite = self._method == 'HERMITE'
        self._window = max(2, int(degree) // 2 + 1) if is_hermite else int(degree) + 1
        if len(rows) < self._window:
            raise ValueError(
                f'a segment has {len(rows)} rows; interpolation of degree {degree} needs '
                f'{self._window}'
            )

        def seconds(epochs):
            in_utc = _TO_UTC[value('TIME_SYSTEM')](np.array([stamp_ns(text) for text in epochs]))
            return (in_utc - epoch_ns) / SECOND_NS

        self._t_s = seconds([row[0] for row in rows])
        steps = np.diff(self._t_s)
        if not np.all(steps > 0.0):
            late = rows[int(np.argmin(steps > 0.0)) + 1][0]
            raise ValueError(f'the row at {late} is not later than the one before it')
        self._rows = 1e3 * np.array([_numbers(row) for row in rows])
        self.begin_s, self.end_s = (
            float(seconds([text])[0])
            for text in (
                metadata.get('USEABLE_START_TIME', rows[0][0]),
                metadata.get('USEABLE_STOP_TIME', rows[-1][0]),
            )
        )
        self.begin_s = max(self.begin_s, float(self._t_s[0]))
        self.end_s = min(self.end_s, float(self._t_s[-1]))

    @cached_property
    def stretch(self) -> Stretch:
        """
        The useable time in pieces of one length, as few as follow the interpolation.

        Its polynomials change at the rows, which is seen where they are far apart.
        """
        r, v = self._rows[:, :3], self._rows[:, 3:]
        rates = np.linalg.norm(np.cross(r, v), axis=1) / np.sum(r * r, axis=1)
        span_s = self.end_s - self.begin_s
        fewest = max(1, int(np.ceil(span_s * np.max(rates) / PIECE_TURN)))
        counts = {fewest * 2**n for n in range(_HALVED)}
        # Pieces that end at rows, the shortest of which are exact.
        inside = (self._t_s >= self.begin_s) & (self._t_s < self.end_s)
        steps = max(1, int(np.sum(inside)))
        rows_s = self.begin_s + span_s / steps * np.arange(steps)
        if np.allclose(self._t_s[self._t_s >= self.begin_s][:steps], rows_s, rtol=0.0, atol=1e-6):
            counts |= {count for count in range(fewest, steps + 1) if steps % count == 0}
        for count in sorted(counts):
            stretch = Stretch(self.begin_s, float(span_s / count), self.begin_s, self.end_s)
            if self._error_m(stretch) <= _ENOUGH_M:
                break
        return stretch

    def _error_m(self, stretch):
        """Return how far the polynomials of some pieces are from the interpolation."""
        x, worst_m = np.linspace(-1.0, 1.0, 50), 0.0
        for number in np.unique(np.linspace(0, stretch.last, 9).astype(int)):
            piece = Piece(stretch, int(number))
            t_s = piece.begin_s + stretch.length_s * (x[1:-1] + 1.0) / 2.0
            true = self.interpolated(t_s)[:, :3]
            found = chebyshev.chebval(x[1:-1], fitted(self.interpolated)(piece)[:3].T).T
            worst_m = max(worst_m, float(np.max(np.abs(found - true))))
        return worst_m

    def interpolated(self, t_s: np.ndarray) -> np.ndarray:
        """Return r_i [m] and v_i [m/s] at times (N,), (N, 6)."""
        # The rows on both sides, as many before as after, at the ends those that there are.
        before = np.searchsorted(self._t_s, t_s, side='right') - 1
        first = np.clip(before - (self._window - 1) // 2, 0, len(self._t_s) - self._window)
        places = first[:, None] + np.arange(self._window)
        # Times in a unit of their own keep the numbers near 1.
        unit_s = (self._t_s[-1] - self._t_s[0]) / (len(self._t_s) - 1)
        x = (t_s - self._t_s[first]) / unit_s
        nodes = (self._t_s[places] - self._t_s[first][:, None]) / unit_s
        rows = self._rows[places]
        if self._method != 'HERMITE':
            return _newton(nodes, rows, x)[0]
        r, slopes = rows[..., :3], rows[..., 3:] * unit_s
        r_i, slope = _newton(np.repeat(nodes, 2, axis=1), np.repeat(r, 2, axis=1), x, slopes)
        return np.hstack([r_i, slope / unit_s])


def _numbers(row):
    """Return position [km] and velocity [km/s] of a row split into its words."""
    try:
        numbers = [float(word) for word in row[1:]]
    except ValueError:
        numbers = []
    if len(numbers) not in _ROW_LENGTHS or not np.all(np.isfinite(numbers)):
        raise ValueError(f'the row at {row[0]} does not hold 6 numbers')
    return numbers[:6]


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

"""
The orbit of a CCSDS Orbit Ephemeris Message, 502.0-B, in either notation, or of STK's file.

Each segment is interpolated by itself, as it says, and in TAI, whatever its TIME_SYSTEM.  A stamp
is an instant of UTC: the orbit at a time from tick 0 is that at its stamp, so that across a leap
second, which has no stamp, it goes on by a second more.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from io import StringIO
from itertools import pairwise
from typing import Any

import numpy as np

from ..base.kvn import (
    INERTIAL_FRAMES,
    KvnMetadata,
    KvnRow,
    by_segment,
    is_inertial,
    kvn_rows,
    kvn_text,
)
from ..base.nanoseconds import SECOND_NS, epoch
from ..base.ndm_xml import is_xml, xml_rows
from ..environment.earth import TO_UTC
from ..environment.file_clock import Clock, Time
from ..kernel.rows import length
from .interpolation import Interpolation, Span
from .kepler import EARTH_RADIUS_M
from .pieces import Piece, Stretch, fitted
from .stk_ephemeris import is_stk, stk_rows
from .tabled import OrbitSource, TabledOrbit

_VERSION, VERSIONS = 'CCSDS_OEM_VERS', ('1.0', '2.0', '3.0')
_METHODS = ('HERMITE', 'LAGRANGE', 'LINEAR')
_DEFAULT_DEGREE, _HIGHEST_DEGREE = 7, 99
_TIMES = ('START_TIME', 'USEABLE_START_TIME', 'USEABLE_STOP_TIME', 'STOP_TIME')
_KEYWORDS = (
    *('OBJECT_NAME', 'OBJECT_ID', 'CENTER_NAME', 'REF_FRAME', 'REF_FRAME_EPOCH', 'TIME_SYSTEM'),
    *_TIMES,
    *('INTERPOLATION', 'INTERPOLATION_DEGREE'),
)
_ROW_LENGTHS = (6, 9)
_STATE = tuple(f'{axis}{dots}' for dots in ('', '_DOT', '_DDOT') for axis in 'XYZ')
_NUMBERS = re.compile(r'(?: [-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)*')
# What nothing about the Earth is beyond [m] and nothing as fast as [m/s].
_FURTHEST_M, _LIGHT_M_S = 1e13, 299_792_458.0
# A body slower than this across the line to the centre [m/s] has no LVLH.
_SLOWEST_M_S = 1e-3
# The ground is a spheroid about Z, of the radii of WGS 84 less a kilometre: the pole has moved
# since 2000, and neither sea nor land follows the spheroid.
_GROUND_M = np.array([EARTH_RADIUS_M, EARTH_RADIUS_M, 6_356_752.3]) - 1000.0
# By how much rows may be missed by the interpolation of every other one without a word.
_MISSED_M = 10.0
_WEEKS_S = 4e6
# How often a radian of an orbit is checked, and how often at least between two rows.
_CHECKS_A_RADIAN, _LEAST_CHECKS = 12, 2
# In how many times the heights over a turn are looked for: one in half a degree.
_TIMES_A_TURN = 721


@dataclass(frozen=True)
class EphemerisOrbit(OrbitSource):
    """
    The orbit of the text of an OEM, or of an STK ephemeris, from tick 0 on.

    Parameters
    ----------
    text : str
        the ephemeris
    epoch_ns : ns
        Unix time of tick 0

    Raises
    ------
    ValueError
        it is none, or of another centre, frame or time system, or no orbit goes through its rows;
        with the line and what is wrong
    """

    text: str
    epoch_ns: int

    key = 'orbit.file'

    def __post_init__(self) -> None:
        try:
            with np.errstate(all='ignore'):
                _ = self.spans
        except ValueError as error:
            raise ValueError(f'{self.key}: {error}') from error.__cause__

    def __repr__(self) -> str:
        begin, end = map(self._epoch, self._bounds_s)
        return f'ephemeris from {begin} to {end}'

    @cached_property
    def _segments(self) -> tuple['_Segment', ...]:
        given = self.text.strip()
        if given and '\n' not in given:
            raise ValueError(f'this is not an Orbit Ephemeris Message, but one line: {given!r}')
        # All are read first: what is damaged is said before what a segment asks for.
        read = list(by_segment(_rows(self.text)))
        if not read:
            raise ValueError('it has no positions')
        found = [_Segment(rows, self.epoch_ns) for rows in read]
        found.sort(key=lambda segment: segment.begin_ns)
        for segment, following in pairwise(found):
            if following.begin_ns < segment.end_ns:
                raise ValueError(
                    f'the segments of lines {segment.line} and {following.line} both hold '
                    f'{_shown(following.begin_ns)}; of their useable times only an end may be the '
                    'same'
                )
        return tuple(found)

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """The useable times, cut where another set of rows begins and at leap seconds."""
        return tuple(span for segment in self._segments for span in segment.spans)

    def described(self, orbit: TabledOrbit) -> dict[str, Any]:
        """Return the epochs of tick 0, begin and end, and heights, period and inclination."""

        def at(t_s):
            return epoch(self.epoch_ns + round(t_s * SECOND_NS))

        turn_s = min(orbit.period_s, orbit.known_until(0.0))
        height_m = orbit.radius(np.linspace(0.0, turn_s, _TIMES_A_TURN)) - EARTH_RADIUS_M
        return {
            'tick_0': at(0.0),
            'begin': at(min(stretch.begin_s for stretch in orbit.stretches)),
            'end': at(max(stretch.end_s for stretch in orbit.stretches)),
            'lowest_height_m': height_m.min(),
            'highest_height_m': height_m.max(),
            'period_s': orbit.period_s,
            'inclination_rad': orbit.osculating.inclination,
        }

    @property
    def warning(self) -> str | None:
        """What to say of rows that are too far apart for their interpolation."""
        missed_m, at, step_s = max(segment.missed for segment in self._segments)
        if missed_m <= _MISSED_M:
            return None
        return (
            f'{self.key} has rows {step_s:g} s apart at {at}, which may be too far for its '
            'interpolation: without every other row it misses the one there by '
            f'{missed_m:.3g} m'
        )

    @property
    def _bounds_s(self):
        return self.spans[0].begin_s, self.spans[-1].end_s

    def _epoch(self, t_s):
        # Beyond some weeks a double resolves no nanoseconds.
        unit_ns = 1 if abs(t_s) < _WEEKS_S else 1000
        return _shown(self.epoch_ns + round(float(t_s) * SECOND_NS / unit_ns) * unit_ns)

    @cached_property
    def _span_of(self) -> dict[Stretch, Span]:
        return {stretch: span for span in self.spans for stretch in span.stretches()}

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """Those of each segment, over its useable time."""
        return tuple(self._span_of)

    def outside(self, t_s: float) -> str:
        """Return the sentence that refuses a time in no segment, or what follows on its end."""
        begin, end = map(self._epoch, self._bounds_s)
        is_gap = self._bounds_s[0] < t_s < self._bounds_s[1]
        gap = ', with a gap between two segments there' if is_gap else ''
        is_last = any(t_s == span.end_s for span in self.spans)
        where = f'{"after" if is_last else "at"} {self._epoch(t_s)}'
        return f'{self.key} has no position {where}: it goes from {begin} to {end}{gap}'

    def coefficients(self, piece: Piece) -> np.ndarray:
        """Return those of r_i and v_i over a piece, (6, terms)."""
        return fitted(self._span_of[piece.stretch].interpolated)(piece)

    def position_velocity(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return r_i [m] and v_i [m/s] at times (N,), each (N, 3); ValueError: one is outside."""
        found = np.full((len(t_s), 6), np.nan)
        for span in self.spans:
            inside = (t_s >= span.begin_s) & (t_s <= span.end_s)
            found[inside] = span.interpolated(t_s[inside])
        outside = np.isnan(found[:, 0])
        if np.any(outside):
            raise ValueError(self.outside(t_s[outside][0]))
        return found[:, :3], found[:, 3:]


def oem_of_xml(text: str) -> str:
    """Return an OEM in XML in the notation of fewer characters; ValueError: it is none."""
    return kvn_text(_VERSION, xml_rows(text, 'oem', VERSIONS, 'stateVector', _STATE))


def _rows(text):
    """Return the rows of a message in either notation, or of a file of STK."""
    lines = StringIO(text.removeprefix('\ufeff'), newline=None)
    if is_xml(text):
        return xml_rows(text, 'oem', VERSIONS, 'stateVector', _STATE)
    if is_stk(text):
        return stk_rows(lines)
    return kvn_rows(lines, 'Orbit Ephemeris Message', _VERSION, VERSIONS)


class _Segment:
    """
    The rows of a segment, checked.

    line: where it begins.  begin_ns, end_ns: its useable time, by stamps.
    """

    def __init__(self, rows: Sequence[KvnRow], epoch_ns: int):
        metadata = rows[0].metadata
        self.line = metadata.lines['META_START']
        self._rows = rows
        system = _time_system(metadata)
        times = [Time(row.words[0], row.line) for row in rows]
        clock = Clock(system, times)
        tai_ns = [clock.tai_ns(time) for time in times]
        for i, (before_ns, after_ns) in enumerate(pairwise(tai_ns), 1):
            if after_ns <= before_ns:
                raise ValueError(f'{self._named(i)} is not later than the one before it')
        self._interpolation = interpolation_of(
            metadata,
            np.array([ns - tai_ns[0] for ns in tai_ns]) / SECOND_NS,
            1e3 * np.array([_numbers(row) for row in rows]),
        )
        said_ns = {
            keyword: clock.tai_ns(Time(metadata[keyword], metadata.lines[keyword]))
            for keyword in _TIMES
            if keyword in metadata
        }
        parts = clock.parts(
            max(tai_ns[0], said_ns.get('USEABLE_START_TIME', tai_ns[0])),
            min(tai_ns[-1], said_ns.get('USEABLE_STOP_TIME', tai_ns[-1])),
        )
        if not parts:
            raise ValueError(f'line {self.line}: no time in it is useable')
        self.begin_ns, self.end_ns = parts[0][0], parts[-1][1]
        self._check_rows()
        self.spans = [
            Span(
                self._interpolation,
                (begin_ns - epoch_ns) / SECOND_NS,
                (end_ns - epoch_ns) / SECOND_NS,
                (epoch_ns + ahead_ns - tai_ns[0]) / SECOND_NS,
                float(np.max(self._rates)),
            )
            for begin_ns, end_ns, ahead_ns in parts
        ]
        self._check_between(epoch_ns)

    def _named(self, i):
        return f'line {self._rows[i].line}: the row at {self._rows[i].words[0]}'

    def _check_rows(self):
        """ValueError: a row is not that of a satellite, or whole turns away from the next."""
        r, v = np.split(self._interpolation.rows, 2, axis=1)
        for is_wrong, why in (
            (length(r) > _FURTHEST_M, f'more than {_FURTHEST_M / 1e3:g} km from the Earth'),
            (length(v) >= _LIGHT_M_S, 'as fast as light'),
            (length(r / _GROUND_M) < 1.0, 'within the Earth'),
        ):
            if np.any(is_wrong):
                raise ValueError(f'{self._named(int(np.argmax(is_wrong)))} is {why}')
        self._rates = length(np.cross(r, v)) / length(r) ** 2
        steps_s = np.diff(self._interpolation.times_s)
        turns = np.minimum(self._rates[1:], self._rates[:-1]) * steps_s / math.tau
        if np.any(turns > 1.0):
            i = int(np.argmax(turns))
            raise ValueError(
                f'{self._named(i + 1)} is {steps_s[i]:g} s after the one before it, and the orbit '
                f'turns {turns[i]:.3g} times in between'
            )

    def _check_between(self, epoch_ns):
        """ValueError: the interpolation goes within the Earth, or is at rest."""
        for span in self.spans:
            t_s = _checked_times(span)
            values, slope = self._interpolation.with_slope(t_s + span.ahead_s)
            r = values[:, :3]
            height = length(r / _GROUND_M)
            across_m_s = length(np.cross(r, slope)) / length(r)
            lowest = int(np.argmin(height))
            if not height[lowest] >= 1.0:
                after = int(np.searchsorted(span.edges_s, t_s[lowest], side='right'))
                apart_s = np.diff(span.edges_s[max(0, after - 1) :][:2])[0]
                raise ValueError(
                    f'at {_shown(epoch_ns + round(float(t_s[lowest]) * SECOND_NS))}, between rows '
                    f'{apart_s:g} s apart, its interpolation of degree '
                    f'{self._interpolation.degree} is {length(r[lowest]) / 1e3:.5g} km from the '
                    "Earth's centre, within the Earth"
                )
            if np.any(across_m_s < _SLOWEST_M_S):
                at_s = float(t_s[np.argmax(across_m_s < _SLOWEST_M_S)])
                raise ValueError(
                    f'at {_shown(epoch_ns + round(at_s * SECOND_NS))} the body of the segment of '
                    f'line {self.line} rests, or moves straight up or down: it has no LVLH'
                )

    @cached_property
    def missed(self) -> tuple[float, str, float]:
        """
        By how much [m], at which row, and how far it is from the one before [s].

        The interpolation of every other row misses the rest of the useable ones by no more.
        """
        times_s, rows = self._interpolation.times_s, self._interpolation.rows
        useable = np.zeros(len(times_s), bool)
        for span in self.spans:
            t_s = times_s - span.ahead_s
            useable |= (t_s >= span.begin_s) & (t_s <= span.end_s)
        # The last row, if it is left out, is beyond those that are not.
        left_out = np.flatnonzero(useable[1:-1:2]) * 2 + 1
        if not len(left_out):
            return 0.0, '', 0.0
        with np.errstate(all='ignore'):
            found = self._interpolation.of_every_other().at(times_s[left_out])
            off_m = np.nan_to_num(length(found[:, :3] - rows[left_out, :3]), nan=np.inf)
        worst = int(np.argmax(off_m))
        i = left_out[worst]
        return float(off_m[worst]), self._rows[i].words[0], float(times_s[i] - times_s[i - 1])


def interpolation_of(
    metadata: KvnMetadata, times_s: np.ndarray, rows: np.ndarray
) -> Interpolation:
    """
    Return what INTERPOLATION and INTERPOLATION_DEGREE ask for, without them Hermite of degree 7.

    Where no degree is asked for, few rows are enough.

    Parameters
    ----------
    metadata : KvnMetadata
        the keywords of the rows' segment
    times_s : (N,), s
        ascending
    rows : (N, 6), m, m/s
        positions and velocities

    Raises
    ------
    ValueError
        we do not have it, or it needs more rows
    """
    method = metadata.get('INTERPOLATION', _METHODS[0]).upper()
    if method not in _METHODS:
        raise ValueError(
            f'line {metadata.lines["INTERPOLATION"]}: INTERPOLATION is {method}; supported: '
            f'{", ".join(_METHODS)}'
        )
    is_hermite, degree, is_asked_for = method == 'HERMITE', _DEFAULT_DEGREE, False
    if method == 'LINEAR':
        degree = 1
    elif (text := metadata.get('INTERPOLATION_DEGREE')) is not None:
        if not re.fullmatch('0*[1-9][0-9]?', text):
            raise ValueError(
                f'line {metadata.lines["INTERPOLATION_DEGREE"]}: INTERPOLATION_DEGREE is '
                f'{text.upper()}; '
                f'it must be a whole number from 1 to {_HIGHEST_DEGREE}'
            )
        degree, is_asked_for = int(text), True
    # Hermite's polynomial through n rows has the degree 2 n - 1.
    window = max(2, degree // 2 + 1 if is_hermite else degree + 1)
    if not is_asked_for:
        window = max(2, min(window, len(rows)))
    if len(rows) < window:
        raise ValueError(
            f'line {metadata.lines["META_START"]}: a segment has {len(rows)} rows; '
            f'interpolation of degree {degree} needs {window}'
        )
    return Interpolation(times_s, rows, is_hermite, window)


def _time_system(metadata):
    """Return TIME_SYSTEM; ValueError: the rows of a segment are not what we read."""
    for keyword in metadata:
        if keyword not in _KEYWORDS:
            raise ValueError(
                f'line {metadata.lines[keyword]}: {keyword} is no keyword of a segment; allowed: '
                f'{", ".join(_KEYWORDS)}'
            )
    for keyword, allowed, is_allowed in (
        ('CENTER_NAME', ('EARTH',), 'EARTH'.__eq__),
        ('REF_FRAME', INERTIAL_FRAMES, is_inertial),
        ('TIME_SYSTEM', tuple(TO_UTC), TO_UTC.__contains__),
    ):
        if keyword not in metadata:
            line = metadata.lines['META_START']
            raise ValueError(f'line {line}: a segment has no {keyword}')
        value = metadata[keyword].upper()
        if not is_allowed(value):
            raise ValueError(
                f'line {metadata.lines[keyword]}: {keyword} is {value}; supported: '
                f'{", ".join(allowed)}'
            )
    return value


def _numbers(row):
    """Return position [km] and velocity [km/s] of a row."""
    words = row.words[1:]
    joined = f' {" ".join(words)}'
    # In XML a word may hold a blank.
    is_row = len(words) in _ROW_LENGTHS and joined.count(' ') == len(words)
    if is_row and _NUMBERS.fullmatch(joined):
        numbers = [float(word) for word in words]
        if all(map(math.isfinite, numbers)):
            return numbers[:6]
    raise ValueError(f'line {row.line}: the row at {row.words[0]} does not hold 6 numbers')


def _checked_times(span):
    """Return times (N,) all along a span, those of the rows too."""
    edges_s = span.edges_s
    turns = np.diff(edges_s) * span.fastest_rad_s
    counts = np.maximum(_LEAST_CHECKS, np.ceil(turns * _CHECKS_A_RADIAN)).astype(int)
    within = np.concatenate([np.arange(count) / count for count in counts])
    t_s = np.repeat(edges_s[:-1], counts) + within * np.repeat(np.diff(edges_s), counts)
    return np.append(t_s, edges_s[-1])


def _shown(at_ns):
    return epoch(at_ns).rstrip('0').rstrip('.')

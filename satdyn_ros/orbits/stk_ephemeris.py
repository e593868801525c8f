"""The ephemeris file of STK (.e), with velocities, read as the rows of an OEM."""

import math
import re
from collections.abc import Iterable, Iterator
from decimal import Decimal
from typing import NamedTuple

from ..base.kvn import KvnMetadata, KvnRow
from ..base.nanoseconds import FURTHEST_NS, SECOND_NS, epoch, stamp_ns
from ..base.numbers import number
from ..environment.earth import leap_seconds_between

_MONTHS = ('Jan', 'Feb', 'Mar', 'Apr', 'May', 'Jun', 'Jul', 'Aug', 'Sep', 'Oct', 'Nov', 'Dec')
_EPOCH = re.compile(r'(\d{1,2}) ([A-Za-z]{3}) (\d{4}) (\d\d:\d\d:\d\d(?:\.\d*)?)', re.ASCII)
_FRAMES = {'J2000': 'EME2000', 'ICRF': 'ICRF'}
_UNITS_KM = {'meters': Decimal('0.001'), 'kilometers': Decimal(1)}
_METHODS = 'Lagrange', 'Hermite'
_KINDS = ('EphemerisTimePosVel', 'EphemerisTimePosVelAcc')
_COVARIANCES = ('covariancetimepos', 'covariancetimeposvel')
# What says nothing about the rows that is needed here.
_LEFT_OUT = (
    *('numberofephemerispoints', 'coordinatesystemepoch', 'timeformat', 'messagelevel'),
    *('blockingfactor', 'covarianceformat'),
)
# Beyond it [s] no stamp is.
_FURTHEST_S = 9_000_000_000


def is_stk(text: str) -> bool:
    """Whether a text is a file of STK, by its first line."""
    return re.match(r'\s*stk\.v\.', text.removeprefix('\ufeff'), re.IGNORECASE) is not None


def stk_rows(lines: Iterable[str]) -> Iterator[KvnRow]:
    """
    Yield the rows of an ephemeris file, in km and km/s and UTC, by segment.

    Times are seconds past ScenarioEpoch.  Without InterpolationMethod it is Lagrange's through six
    rows, as in STK; by either method it goes through InterpolationSamplesM1 + 1 rows, so that
    Hermite's polynomial has the degree 2 InterpolationSamplesM1 + 1.  At a segment boundary a
    segment ends, and another begins with the same row or with a second one of its time.
    ValueError: it is none, or has what is not read; with the line.
    """
    said: dict[str, tuple[str, int]] = {}
    boundaries: set[Decimal] = set()
    rows: list[tuple[Decimal, list[str], int]] = []
    section = ''
    for line_number, line in enumerate(lines, 1):
        words = line.partition('#')[0].split()
        if not words or words[0].lower().startswith('stk.v.'):
            continue
        keyword, value = words[0].lower(), ' '.join(words[1:])
        if keyword in ('begin', 'end'):
            section = value.lower() if keyword == 'begin' else ''
            if section not in ('', 'ephemeris', 'segmentboundarytimes', *_COVARIANCES):
                raise ValueError(f'line {line_number}: BEGIN {value} is not read')
        elif section == 'segmentboundarytimes':
            boundaries |= {_seconds(word, line_number) for word in words}
        elif section in _COVARIANCES:
            continue
        elif keyword in (kind.lower() for kind in _KINDS):
            section = 'rows'
        elif section == 'rows' or rows:
            rows.append((_seconds(words[0], line_number), words[1:], line_number))
        elif keyword.startswith('ephemeris'):
            raise ValueError(
                f'line {line_number}: it has {words[0]}; supported: {" and ".join(_KINDS)}'
            )
        else:
            said[keyword] = value, line_number
    return _in_km(said, boundaries, rows)


def _in_km(said, boundaries, rows):
    """Yield the rows of the file, those of a segment with the same metadata."""
    if not rows:
        raise ValueError(f'it has no rows of {" or ".join(_KINDS)}')
    header = _header(said)
    for at, _, line in rows:
        if abs(header.begin_ns + at * SECOND_NS) > FURTHEST_NS:
            raise ValueError(f'line {line}: {at} s after ScenarioEpoch is beyond all stamps')
    leaps = _leap_seconds(header.begin_ns, max(at for at, _, _ in rows))
    current = header.metadata(rows[0][2])
    # The first and the last may be among them, where nothing else begins.
    within = boundaries - {rows[0][0], rows[-1][0]}
    before: tuple[Decimal, list[str], int] | None = None
    for at, words, line in rows:
        if before is not None and before[0] in within:
            current = header.metadata(line)
            if at != before[0]:
                yield KvnRow('', current, header.words(*before[:2], leaps), before[2])
        yield KvnRow('', current, header.words(at, words, leaps), line)
        # The second row of a boundary begins what follows on it.
        before = None if before is not None and at == before[0] else (at, words, line)


class _Header(NamedTuple):
    """What the keywords say: the line of a method or a degree that none gives is 0."""

    begin_ns: int
    frame: str
    to_km: Decimal
    method: str
    degree: int
    method_line: int
    degree_line: int

    def metadata(self, line: int) -> KvnMetadata:
        """Return the keywords of a segment whose first row is in a line."""
        found = KvnMetadata(line)
        for keyword, each, at in (
            ('CENTER_NAME', 'EARTH', line),
            ('REF_FRAME', self.frame, line),
            ('TIME_SYSTEM', 'UTC', line),
            ('INTERPOLATION', self.method, self.method_line or line),
            ('INTERPOLATION_DEGREE', str(self.degree), self.degree_line or line),
        ):
            found[keyword], found.lines[keyword] = each, at
        return found

    def words(self, at: Decimal, words: list[str], leaps: dict[int, int]) -> list[str]:
        """Return the words of a row at a time [s past the epoch] as those of an OEM."""
        instant = _instant(self.begin_ns + int((at * SECOND_NS).to_integral_value()), leaps)
        values = [(word, _decimal(word)) for word in words]
        scaled = [word if value is None else str(value * self.to_km) for word, value in values]
        return [instant, *scaled]


def _instant(stamp: int, leaps: dict[int, int]) -> str:
    """Return the epoch of an instant, given the stamp that it would have without leap seconds."""
    for after, step in leaps.items():
        if stamp >= after + step:
            stamp -= step
        elif stamp >= after and step == SECOND_NS:
            return epoch(stamp - step).replace(':59.', ':60.')
    return epoch(stamp)


def _header(said: dict[str, tuple[str, int]]) -> _Header:
    """Return what the keywords of a file say, each with its line; no other may be among them."""
    _one_of(said, 'CentralBody', 'Earth', ('Earth',))
    frame, _ = _one_of(said, 'CoordinateSystem', 'Fixed', _FRAMES)
    unit, _ = _one_of(said, 'DistanceUnit', 'Meters', ('Meters', 'Kilometers'))
    method, method_line = _one_of(said, 'InterpolationMethod', 'Lagrange', _METHODS)
    samples, degree_line = said.pop('interpolationsamplesm1', ('5', method_line))
    if 'interpolationorder' in said:
        samples, degree_line = said.pop('interpolationorder')
    if not re.fullmatch('[0-9]{1,2}', samples):
        raise ValueError(
            f'line {degree_line}: InterpolationSamplesM1 is {samples}; it must be a whole number'
        )
    begin_ns = _epoch_ns(*said.pop('scenarioepoch', ('', 0)))
    for keyword, (_, line) in said.items():
        if keyword not in _LEFT_OUT:
            raise ValueError(f'line {line}: the keyword {keyword} is not read')
    return _Header(
        begin_ns,
        frame=_FRAMES[frame.upper()],
        to_km=_UNITS_KM[unit.lower()],
        method=method.upper(),
        degree=int(samples) if method.lower() == 'lagrange' else 2 * int(samples) + 1,
        method_line=method_line,
        degree_line=degree_line,
    )


def _one_of(said, keyword, default, allowed):
    """Return the value of a keyword, one of those allowed, and its line, 0: by default."""
    given, line = said.pop(keyword.lower(), (default, 0))
    if given.lower() not in (each.lower() for each in allowed):
        what = f'{keyword} is {given}' if line else f'{keyword} is not given, which is {given}'
        where = f'line {line}: ' if line else ''
        raise ValueError(f'{where}{what}; supported: {" and ".join(allowed)}')
    return given, line


def _leap_seconds(begin_ns: int, last_s: Decimal) -> dict[int, int]:
    """Return the leap seconds up to the last row [s past the epoch], by stamp."""
    end_ns = begin_ns + int(last_s * SECOND_NS)
    return leap_seconds_between(begin_ns, max(begin_ns, end_ns))


def _seconds(word: str, line: int) -> Decimal:
    value = _decimal(word)
    if value is None or not abs(value) < _FURTHEST_S:
        raise ValueError(f'line {line}: {word} is no time in seconds')
    return value


def _decimal(word: str) -> Decimal | None:
    """Return the number that a word is, None: it is none, or beyond the range of doubles."""
    value = number(word)
    if value is None or not math.isfinite(value):
        return None
    # A decimal may have no exponent as small as that of a double that is zero.
    return Decimal(word) if value else Decimal(repr(value))


def _epoch_ns(text: str, line: int) -> int:
    if not line:
        raise ValueError('it has no ScenarioEpoch')
    found = _EPOCH.fullmatch(text)
    if found is None or found[2].title() not in _MONTHS:
        raise ValueError(
            f'line {line}: ScenarioEpoch is {text}; it must be as 1 Mar 2026 12:00:00.000'
        )
    month = _MONTHS.index(found[2].title()) + 1
    try:
        return stamp_ns(f'{found[3]}-{month:02d}-{int(found[1]):02d}T{found[4].rstrip(".")}')
    except ValueError as error:
        raise ValueError(f'line {line}: {error}') from None

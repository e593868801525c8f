"""
The orbit of a two-line element set, or of a CCSDS Orbit Mean-Elements Message, by SGP4.

SGP4 with the constants of WGS 72 (Hoots and Roehrich 1980, as corrected by Vallado, Crawford,
Hujsak and Kelso 2006), by the package sgp4.  Its velocity is not quite the slope of its position.
"""

import re
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..base.imports import brought_by
from ..base.nanoseconds import DAY_NS, SECOND_NS, epoch, stamp_ns
from ..kernel.rows import components, times
from . import element_ranges, element_sets
from .axes_of_date import tabled_teme_to_gcrs
from .element_sets import ELEMENTS, SGP4_MEANS, ElementSet, is_message
from .pieces import PIECE_TURN, Piece, Stretch, fitted
from .tabled import OrbitSource, TabledOrbit

# How far from its epoch an element set is taken without a warning.
GOOD_FOR_DAYS = 14
_DAY_S = 86_400
# The Julian date of 1 January 1970, 00:00.
_UNIX_EPOCH_JD = 2_440_587.5
# Of a deep-space orbit SGP4 sums up the resonances in steps of 720 min from the epoch; the slope
# of the position jumps by 1e-4 m/s where one ends.  Pieces end there too.
_SGP4_STEP_S = 43_200.0
# Elements whose perigee is this much nearer to the centre than the ground [Earth radii] are no
# orbit; those of a satellite that decays have one 50 km below it.
_DEEPEST = 0.1
# How one of many is chosen.
_CHOOSE = "; orbit.tle: [FILE, 'NUMBER OR NAME'] chooses one"
_LENGTH = 69
_LAYOUT = (
    # Number, class, designator, epoch, half of n', a sixth of n'', drag, type, set.
    r'1 [ \dA-Z][ \d]{4}. .{8} \d\d[ \d]{3}\.\d{8} [-+ ]\.\d{8} [-+ ]\d{5}[-+ ]\d '
    r'[-+ ]\d{5}[-+ ]\d [\d ] [\d ]{4}\d',
    # Number, inclination, node, eccentricity, argument, anomaly, mean motion, revolutions.
    r'2 [ \dA-Z][ \d]{4} [ \d]{3}\.[ \d]{4} [ \d]{3}\.[ \d]{4} [ \d]{7} [ \d]{3}\.[ \d]{4} '
    r'[ \d]{3}\.[ \d]{4} [ \d]{2}\.\d{8}[ \d]{5}\d',
)
# What the package wants besides, and SGP4 does not use; it knows satellite numbers of five digits
# and a letter alone.
_WITHOUT_EFFECT = {
    'MEAN_MOTION_DOT': '0',
    'MEAN_MOTION_DDOT': '0',
    'CLASSIFICATION_TYPE': 'U',
    'OBJECT_ID': '',
    'EPHEMERIS_TYPE': '0',
    'ELEMENT_SET_NO': '0',
    'REV_AT_EPOCH': '0',
    'NORAD_CAT_ID': '0',
}


class MeanOrbit(NamedTuple):
    """
    The orbit of mean elements.

    Attributes
    ----------
    perigee_height_m, apogee_height_m : m
        above the equator's radius, of the mean ellipse
    period_s : s
        by the mean motion, without drag
    inclination_rad : rad
        to the equator of date
    """

    perigee_height_m: float
    apogee_height_m: float
    period_s: float
    inclination_rad: float


@dataclass(frozen=True)
class TwoLineOrbit(OrbitSource):
    """
    The orbit of an element set from tick 0 on.

    Parameters
    ----------
    text : str
        a two-line element set, with or without a line of the satellite's name above, or an OMM in
        keyword = value notation, XML, JSON or CSV
    epoch_ns : ns
        Unix time of tick 0

    Raises
    ------
    ValueError
        it is neither, with what is wrong; see check too
    """

    text: str
    epoch_ns: int

    key = 'orbit.tle'

    def __post_init__(self) -> None:
        _satellite(self.text)

    def __repr__(self) -> str:
        return f'elements of {self.elements_epoch} by SGP4'

    @cached_property
    def elements_ns(self) -> int:
        """The epoch of the elements, as a stamp."""
        satellite = _satellite(self.text)
        days = round((satellite.jdsatepoch - _UNIX_EPOCH_JD) * DAY_NS)
        return days + round(satellite.jdsatepochF * DAY_NS)

    @property
    def elements_epoch(self) -> str:
        """That epoch in UTC, to a microsecond: its days are a double, and OMMs resolve no less."""
        return epoch(round(self.elements_ns, -3))

    @property
    def mean_orbit(self) -> MeanOrbit:
        """The orbit in a few numbers, as catalogues have them."""
        satellite = _satellite(self.text)
        radius_m = 1e3 * satellite.radiusearthkm
        return MeanOrbit(
            perigee_height_m=satellite.altp * radius_m,
            apogee_height_m=satellite.alta * radius_m,
            period_s=60.0 * 2.0 * np.pi / satellite.no_kozai,
            inclination_rad=satellite.inclo,
        )

    def described(self, orbit: TabledOrbit) -> dict[str, Any]:
        """Return the epochs of tick 0 and of the elements, their age, and the mean orbit."""
        return {
            'tick_0': epoch(self.epoch_ns),
            'elements_epoch': self.elements_epoch,
            'age_days': (self.epoch_ns - self.elements_ns) / DAY_NS,
            **self.mean_orbit._asdict(),
        }

    @property
    def warning(self) -> str | None:
        """What to say of elements that are far from tick 0."""
        days = abs(self.epoch_ns - self.elements_ns) / DAY_NS
        if days <= GOOD_FOR_DAYS:
            return None
        return (
            f'the epoch of orbit.tle, {self.elements_epoch[:19]}, is {days:.0f} days from '
            f'tick 0: an element set is good for days, and beyond {GOOD_FOR_DAYS} it may be off '
            'by hundreds of kilometres'
        )

    @cached_property
    def stretches(self) -> tuple[Stretch, ...]:
        """One, from the epoch of the elements in both directions."""
        satellite = _satellite(self.text)
        e = satellite.ecco
        fastest = satellite.no_kozai / 60.0 * np.sqrt(1.0 + e) / (1.0 - e) ** 1.5
        pieces = max(1.0, np.ceil(_SGP4_STEP_S * fastest / PIECE_TURN))
        return (Stretch(self._elements_s, float(_SGP4_STEP_S / pieces)),)

    @property
    def _elements_s(self):
        return (self.elements_ns - self.epoch_ns) / SECOND_NS

    def coefficients(self, piece: Piece) -> np.ndarray:
        """Return those of r_i and v_i over a piece, (6, terms)."""
        return fitted(lambda t_s: np.hstack(self.position_velocity(t_s)))(piece)

    def position_velocity(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return r_i [m] and v_i [m/s] at times (N,), each (N, 3), as SGP4 gives them.

        ValueError: the satellite has decayed, or what else SGP4 says.
        """
        with brought_by('environment', 'sgp4'):
            from sgp4.api import SGP4_ERRORS
        # It keeps what it summed up, and several threads may ask: each has its own.
        satellite = _satellite(self.text)
        since_days = (t_s - self._elements_s) / _DAY_S
        day = np.full(len(t_s), satellite.jdsatepoch)
        errors, r_km, v_km_s = satellite.sgp4_array(day, satellite.jdsatepochF + since_days)
        if np.any(errors):
            first = np.flatnonzero(errors)[0]
            at = epoch(self.epoch_ns + round(t_s[first] * SECOND_NS))[:19]
            raise ValueError(
                f'SGP4 has no position for orbit.tle at {at}: {SGP4_ERRORS[errors[first]]}'
            )
        to_gcrs = tabled_teme_to_gcrs(self.epoch_ns / SECOND_NS + t_s)
        r_i, v_i = (1e3 * np.stack(times(to_gcrs, components(v)), axis=-1) for v in (r_km, v_km_s))
        return r_i, v_i


def check(text: str) -> None:
    """
    Check that the elements of a text are such as SGP4 flies.

    Bags of earlier rules may hold others, which flew.  ValueError, one sentence: a number is out
    of its range, the elements are those of another theory, or SGP4 has no position at their epoch.
    """
    with brought_by('environment', 'sgp4'):
        from sgp4.api import SGP4_ERRORS
    if is_message(text):
        with _of_message():
            pairs = _pairs(text)
            _check_once(pairs)
            element_ranges.check_message(_known(pairs))
    else:
        element_ranges.check_lines(_lines(text))
    satellite = _satellite(text)
    if satellite.altp < -_DEEPEST:
        below_km = -satellite.altp * satellite.radiusearthkm
        raise ValueError(
            f'the perigee of orbit.tle is {below_km:.0f} km below the ground; mean motion and '
            'eccentricity do not belong together'
        )
    error, _, _ = satellite.sgp4(satellite.jdsatepoch, satellite.jdsatepochF)
    if error:
        raise ValueError(
            'SGP4 has no position for orbit.tle at the epoch of its elements: '
            f'{SGP4_ERRORS[error]}'
        )


def checked(given: ElementSet) -> TwoLineOrbit:
    """Return the orbit of one of many sets, at stamp 0; ValueError: as of check, with its line."""
    try:
        check(given.text)
        return TwoLineOrbit(given.text, 0)
    except ValueError as error:
        raise ValueError(f'the set of line {given.line}: {error}') from error.__cause__


def _satellite(text: str) -> Any:
    """Return the satellite of the package sgp4; ValueError: what is wrong with the text."""
    with brought_by('environment', 'sgp4'):
        from sgp4 import omm
        from sgp4.api import WGS72, Satrec
    if is_message(text):
        satellite = Satrec()
        with _of_message():
            omm.initialize(satellite, _mean_elements(_known(_pairs(text))), WGS72)
        return satellite
    return Satrec.twoline2rv(*_lines(text), WGS72)


@contextmanager
def _of_message():
    try:
        yield
    except ValueError as error:
        raise ValueError(f'orbit.tle holds an OMM that cannot be read: {error}') from None


def _lines(text):
    """Return the two lines of an element set; ValueError: the text is none."""
    lines = [line.rstrip() for line in text.splitlines() if line.strip()]
    if len(lines) == 3 and not lines[0].startswith('1 '):
        lines = lines[1:]
    if len(lines) != 2:
        raise ValueError(
            f'orbit.tle has {len(lines)} lines; it must be two, or a file of one element set'
            f'{_CHOOSE if len(lines) > 3 else ""}'
        )
    if lines[0].startswith('2 ') and lines[1].startswith('1 '):
        raise ValueError('orbit.tle has its second line first')
    for number, (line, layout) in enumerate(zip(lines, _LAYOUT, strict=True), 1):
        if not line.startswith(f'{number} '):
            raise ValueError(
                f'line {number} of orbit.tle begins with {line[:2]!r}; it must begin with '
                f"'{number} '"
            )
        if len(line) != _LENGTH:
            raise ValueError(
                f'line {number} of orbit.tle has {len(line)} characters; it must have {_LENGTH}'
            )
        for column, character in enumerate(line, 1):
            if not character.isascii():
                raise ValueError(
                    f'line {number} of orbit.tle has {character!r} in column {column}; its '
                    'characters must be those of ASCII'
                )
        tally = sum(int(c) if c.isdigit() else c == '-' for c in line[:-1]) % 10
        if line[-1] != str(tally):
            raise ValueError(
                f'line {number} of orbit.tle ends with the checksum {line[-1]}, and its '
                f'characters make {tally}: it is not as it was issued'
            )
        if not re.fullmatch(layout, line):
            raise ValueError(f'line {number} of orbit.tle has its numbers in other columns')
    if lines[0][2:7] != lines[1][2:7]:
        raise ValueError(
            f'the lines of orbit.tle are of two satellites, {lines[0][2:7]} and {lines[1][2:7]}'
        )
    return lines


def _pairs(text):
    """Return keywords and values of an OMM, a unit in brackets behind its value."""
    found = element_sets.messages(text)
    if len(found) != 1:
        raise ValueError(f'it holds {len(found)} element sets{_CHOOSE if found else ""}')
    return found[0].pairs


def _known(pairs):
    """Return the values by their keywords; ValueError: they are not one element set of SGP4."""
    count = sum(keyword == 'EPOCH' for keyword, _ in pairs)
    if count > 1:
        raise ValueError(f'it holds {count} element sets')
    elements = dict(pairs)
    for keyword, allowed in SGP4_MEANS.items():
        value = elements.get(keyword, allowed[0]).upper()
        if value not in allowed:
            raise ValueError(f'{keyword} is {value}; it must be {" or ".join(allowed)}')
    missing = [keyword for keyword in ELEMENTS if not elements.get(keyword)]
    if missing:
        raise ValueError(f'it has no {missing[0]}')
    return elements


def _check_once(pairs):
    """ValueError: a keyword stands twice, so that it is not known which value is meant."""
    keywords = [keyword for keyword, _ in pairs]
    for keyword in (*SGP4_MEANS, *ELEMENTS[1:], 'EPHEMERIS_TYPE'):
        if keywords.count(keyword) > 1:
            raise ValueError(f'it has {keyword} {keywords.count(keyword)} times')


def _mean_elements(elements):
    """Return what the package sgp4 wants of the values of an OMM."""
    numbers = {keyword: elements[keyword].partition('[')[0].strip() for keyword in ELEMENTS}
    # It wants a point in the epoch.
    return numbers | _WITHOUT_EFFECT | {'EPOCH': epoch(stamp_ns(numbers['EPOCH']))[:26]}

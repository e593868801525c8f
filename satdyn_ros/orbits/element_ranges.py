"""
What the fields of an element set may be, two lines or an OMM, so that SGP4 flies what was meant.

Only what plays a part in SGP4 is looked at: not the classification, the number of the set, that of
the revolution, nor the derivatives of the mean motion.
"""

from calendar import isleap
from collections.abc import Mapping
from typing import NamedTuple

from ..base.numbers import number

# The ephemeris types of SGP4, the first of which most sets have, and what others are called in
# 502.0-B-3.
_SGP4_TYPES = ('', '0', '2')
_OTHER_TYPES = {'3': ', PPT3', '4': ', SGP4-XP', '6': ', special perturbations'}
# The years of two digits, and of an OMM up to where stamps end.
_FIRST_YEAR, _LAST_YEAR = 1957, 2261
# Angles that lines give from 0 on, and some programs write into a message with a sign.
_SIGNED = ('RA_OF_ASC_NODE', 'ARG_OF_PERICENTER', 'MEAN_ANOMALY')


class _Field(NamedTuple):
    """
    A number of an element set.

    name: in a sentence about lines.  line, columns: where it stands there.  unit: that of an OMM.
    low, high: the least and the most, in that unit.
    """

    name: str
    line: int
    columns: slice
    unit: str
    low: float
    high: float


# Of the mean motion: an orbit at the surface has 17 turns a day, one at the edge of the Earth's
# sphere of influence 0.005.  Of the drag: it would be that of a foil of 50 m^2/kg.
FIELDS = {
    'INCLINATION': _Field('inclination', 2, slice(8, 16), 'deg', 0.0, 180.0),
    'RA_OF_ASC_NODE': _Field('node', 2, slice(17, 25), 'deg', 0.0, 360.0),
    'ECCENTRICITY': _Field('eccentricity', 2, slice(26, 33), '', 0.0, 1.0),
    'ARG_OF_PERICENTER': _Field('argument of perigee', 2, slice(34, 42), 'deg', 0.0, 360.0),
    'MEAN_ANOMALY': _Field('mean anomaly', 2, slice(43, 51), 'deg', 0.0, 360.0),
    'MEAN_MOTION': _Field('mean motion', 2, slice(52, 63), 'rev/day', 1e-3, 18.0),
    'BSTAR': _Field('drag term', 1, slice(53, 61), '1/ER', -10.0, 10.0),
}


def check_lines(lines: list[str]) -> None:
    """ValueError: a field of two lines is not a number, or out of its range."""
    first = lines[0]
    if (kind := first[62].strip()) not in _SGP4_TYPES:
        raise ValueError(
            f'line 1 of orbit.tle is of ephemeris type {kind}{_OTHER_TYPES.get(kind, "")}; it '
            'must be 0 or 2, of SGP4'
        )
    year = int(first[18:20])
    year += 1900 if year >= _FIRST_YEAR % 100 else 2000
    day, days = number(first[20:32].lstrip()), 366 if isleap(year) else 365
    if day is None or not 1.0 <= day < days + 1:
        raise ValueError(
            f'line 1 of orbit.tle has day {first[20:32].strip()} of the year {year}; it must be '
            f'from 1 to less than {days + 1}'
        )
    for keyword, field in FIELDS.items():
        text = lines[field.line - 1][field.columns]
        where = f'line {field.line} of orbit.tle has the {field.name} {text.strip()}'
        _check_range(where, number(_with_point(keyword, text)), field)


def check_message(elements: Mapping[str, str]) -> None:
    """ValueError: a value of an OMM, by its keyword, is not a number or out of its range."""
    kind = elements.get('EPHEMERIS_TYPE', '')
    if kind not in _SGP4_TYPES:
        raise ValueError(
            f'EPHEMERIS_TYPE is {kind}{_OTHER_TYPES.get(kind, "")}; it must be 0 or 2, of SGP4'
        )
    epoch, year = elements['EPOCH'], elements['EPOCH'][:4]
    if not epoch.isascii() or (year.isdigit() and not _FIRST_YEAR <= int(year) <= _LAST_YEAR):
        raise ValueError(
            f'EPOCH is {epoch}; it must be of the years {_FIRST_YEAR} to {_LAST_YEAR}'
        )
    for keyword, field in FIELDS.items():
        text, _, unit = elements[keyword].partition('[')
        unit = unit.rstrip(' ]')
        if unit and unit.lower() != field.unit.lower():
            wanted = f'in {field.unit}' if field.unit else 'without a unit'
            raise ValueError(f'{keyword} is in {unit}; it must be {wanted}')
        if keyword in _SIGNED:
            field = field._replace(low=-field.high)
        _check_range(f'{keyword} is {text.strip()}', number(text.strip()), field)


def _check_range(what, value, field):
    if value is None:
        raise ValueError(f'{what}, which is not a number')
    # An ellipse has an eccentricity below 1.
    if field.low <= value <= field.high and not value == field.high == 1.0:
        return
    to = 'less than ' if field.high == 1.0 else ''
    unit = f' {field.unit}' if field.unit else ''
    raise ValueError(f'{what}; it must be from {field.low:g} to {to}{field.high:g}{unit}')


def _with_point(keyword, text):
    """Return a field of the lines with the point and the exponent that it leaves out."""
    if keyword == 'ECCENTRICITY':
        return f'.{text.replace(" ", "0")}'
    if keyword == 'BSTAR':
        sign, digits, exponent = text[0].strip(), text[1:6], text[6:8].replace(' ', '+')
        return f'{sign}.{digits}e{exponent}'
    return text.strip()

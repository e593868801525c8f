"""
Units by dimension, and texts such as '51.6 deg', '0.15 deg/sqrt(h)' and '[5, 3, 2] mA m^2'.

An angle is a dimension of its own, so that a frequency [Hz] is no rate of turn [rad/s].  Factors:
the SI Brochure (9th edition, tables 2 to 8), the international foot and pound of 1959, the gauss
of 1e-4 T, the oersted of 1000 A/m / (4 pi), the solar flux unit of 1e-22 W/m^2/Hz.
"""

import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from functools import lru_cache
from typing import NoReturn

from . import numbers
from .sentences import nearest

_BASE = ('m', 'kg', 's', 'A', 'rad', 'lx', 'byte')
_DEFINITIONS = """
    g = 1e-3 kg
    min = 60 s
    h hr = 60 min
    d day = 24 h
    sec = s
    au = 149597870700 m
    ft = 0.3048 m
    lb = 0.45359237 kg
    rev turn = 2 pi rad
    deg degree degrees = pi rad/180
    arcmin = deg/60
    arcsec = deg/3600
    mas = arcsec/1000
    rpm RPM = rev/min
    dps = deg/s
    Hz = 1/s
    N = kg m/s^2
    Nm J = N m
    Nms = N m s
    W = J/s
    Pa = N/m^2
    T tesla = kg/(A s^2)
    G gauss = 1e-4 T
    lux = lx
    B = byte
    KiB = 1024 byte
    MiB = 1024 KiB
    GiB = 1024 MiB
    sfu = 1e-22 W/m^2/Hz
    Oe = 250 A/m/pi
    ppm = 1e-6
    % = 1e-2
"""
_PREFIXES = {
    **{'T': '1e12', 'G': '1e9', 'M': '1e6', 'k': '1e3', 'c': '1e-2', 'm': '1e-3'},
    **{'u': '1e-6', 'n': '1e-9', 'p': '1e-12', 'f': '1e-15'},
}
_WITH_PREFIXES = frozenset(
    {'m', 'g', 's', 'A', 'rad', 'lx', 'lux', 'byte', 'B', 'N', 'Nm', 'Nms', 'J', 'W', 'Pa'}
    | {'T', 'G', 'gauss', 'Hz', 'arcsec', 'deg', 'dps'}
)
# What a sentence names of those that fit, the ways in which people have them first.
_IN_USE = (
    *('rev/s', 'rpm', 'deg/s', 'deg/h', 'rad/s', 'deg', 'arcmin', 'arcsec', 'mrad', 'rad'),
    *('km', 'm', 'cm', 'au', 'km/s', 'm/s', 's', 'min', 'h', 'd', 'Hz', 'kHz', '1/s', '1/s^2'),
    *('kg', 'g', 'kg m', 'g cm', 'kg m^2', 'g cm^2', 'm^2', 'cm^2', 'kg/m^3', 'g/cm^3'),
    *('m^3', 'cm^3', 'A/m', 'Oe', 'T/(A m^2)', 'uT/(A m^2)', 'sqrt(kg) m', 'sqrt(kg) m/s'),
    *('N', 'mN', 'N m', 'mN m', 'N m s', 'mN m s', 'N m s/rad', 'mN m/rpm', 'A m^2', 'mA m^2'),
    *('T', 'uT', 'nT', 'gauss', 'nT/sqrt(s)', 'T/sqrt(s)', 'km^3/s^2', 'm^3/s^2', 'lx', 'klx'),
    *('deg/sqrt(h)', 'deg/s/sqrt(Hz)', 'rad/s/sqrt(Hz)', 'deg/h/sqrt(h)', 'deg/s^2/sqrt(Hz)'),
    *('rad/s^2/sqrt(Hz)', 'sfu', 'byte', 'MB', 'MiB', 'ppm', '%'),
)
# Those in which people have what is in a unit, from the largest to the smallest.
_TRADE = {
    'm': ('km', 'm', 'cm'),
    'm^2': ('m^2', 'cm^2'),
    'm^3': ('m^3', 'cm^3'),
    'm/s': ('km/s', 'm/s'),
    'm^3/s^2': ('km^3/s^2',),
    'kg m^2': ('kg m^2', 'g m^2', 'g cm^2'),
    's': ('s', 'ms'),
    'N': ('N', 'mN'),
    'N m': ('N m', 'mN m', 'uN m', 'nN m'),
    'N m s': ('N m s', 'mN m s', 'uN m s', 'nN m s'),
    'A m^2': ('A m^2', 'mA m^2'),
    'rad': ('deg', 'arcsec'),
    'rad/s': ('deg/s', 'deg/h'),
    'rad/s/sqrt(Hz)': ('deg/sqrt(h)',),
    'rad/s^2/sqrt(Hz)': ('deg/h/sqrt(h)',),
    'T': ('uT', 'nT'),
    'T/sqrt(s)': ('nT/sqrt(s)',),
}
_SMALL = 0.1
# What datasheets write in other characters.
_SPELLINGS = str.maketrans(
    {**dict.fromkeys('·⋅×*', ' '), **dict.fromkeys('µμ', 'u'), '°': 'deg ', '√': ' sqrt '}
    | {'²': '^2 ', '³': '^3 ', '−': '-', '′': 'arcmin ', '″': 'arcsec '}
)
# Of a text, and of its unit.
_LONGEST, _LONGEST_UNIT = 300, 60
# Wide enough that a double is rounded once; what is beyond it is infinite, and then refused.
_DECIMALS = Context(prec=50, traps=[])
_ONE = Decimal(1)
_PI = Decimal('3.14159265358979323846264338327950288419716939937510582')


class Unfit(ValueError):  # noqa: N818
    """Why a text is in no unit of a dimension, as the end of a sentence."""


@dataclass(frozen=True)
class Unit:
    """A factor times powers of the base units m, kg, s, A, rad, lx, byte: their dimension."""

    factor: Decimal = _ONE
    powers: tuple[Fraction, ...] = (Fraction(0),) * len(_BASE)

    def times(self, other: 'Unit', power: Fraction = Fraction(1)) -> 'Unit':
        """Return this unit times a power of another."""
        exponent = _DECIMALS.divide(Decimal(power.numerator), Decimal(power.denominator))
        factor = _DECIMALS.multiply(self.factor, _DECIMALS.power(other.factor, exponent))
        pairs = zip(self.powers, other.powers, strict=True)
        return Unit(factor, tuple(mine + power * its for mine, its in pairs))


@lru_cache(maxsize=1000)
def unit_of(text: str) -> Unit:
    """
    Return the unit of a text such as 'kg m^2', 'deg/sqrt(h)' or '1/s'; Unfit: it is not a unit.

    >>> unit_of('km').factor
    Decimal('1000')
    """
    return _Reader(text).unit()


def in_unit(text: str, unit: str, others: Iterable[str] = ()) -> Decimal | list[Decimal]:
    """
    Return the number, or the list of numbers, of a text with its unit, as so many of a unit.

    others: units of further dimensions that will do.  Unfit: the text is not a number or a list of
    numbers and a unit of this dimension.

    >>> in_unit('420 km', 'm'), in_unit('[5, 3] mA m^2', 'A m^2')
    (Decimal('420000'), [Decimal('0.005'), Decimal('0.003')])
    """
    given = text.translate(_SPELLINGS).replace('**', '^').strip()
    match = _QUANTITY.fullmatch(given) if len(given) <= _LONGEST else None
    if match is None:
        raise Unfit('a text must be a number and its unit')
    name = match['unit'] or match['scaled']
    if len(name) > _LONGEST_UNIT:
        raise Unfit(f'a unit has at most {_LONGEST_UNIT} characters')
    scale = _ONE
    if name != unit:
        found = unit_of(name)
        if found.powers not in _powers(unit, others):
            raise Unfit(f'{name} is of another dimension than {unit or "a plain number"}')
        scale = _DECIMALS.divide(found.factor, unit_of(unit).factor)
    sizes = [_DECIMALS.multiply(Decimal(x), scale) for x in _NUMBER.findall(match['numbers'])]
    return sizes if match['numbers'].startswith('[') else sizes[0]


def is_quantity(text: str) -> bool:
    """Return whether a text has the form of a number or a list of numbers and a unit."""
    return len(text) <= _LONGEST and bool(_QUANTITY.fullmatch(text.translate(_SPELLINGS).strip()))


def fitting(unit: str, others: Iterable[str] = ()) -> str:
    """Return the units in use that fit one, as the end of a sentence."""
    powers = _powers(unit, others)
    *most, last = [each for each in _IN_USE if unit_of(each).powers in powers] or [unit]
    return f'{", ".join(most)} and {last}' if most else last


def in_trade(values: float | Iterable[float], unit: str, trade: str = '') -> str:
    """
    Return what a number or numbers in a unit are in that of datasheets, '' where it is the same.

    trade: that of datasheets, where it is not that of the unit; of several the largest is used in
    which the largest number is not below a tenth.

    >>> in_trade(0.9005898940290741, 'rad'), in_trade([5e-5, 3.5e-4], 'rad')
    ('51.6 deg', '[10.3132, 72.1927] arcsec')
    """
    numbers = list(values) if isinstance(values, Iterable) else [values]
    largest = max(map(abs, numbers), default=0.0)
    units = (trade,) if trade else _TRADE.get(unit, ())
    for each in units:
        per_one = float(_DECIMALS.divide(unit_of(unit).factor, unit_of(each).factor))
        if not largest or largest * per_one >= _SMALL or each == units[-1]:
            if each == unit:
                break
            texts = [f'{x * per_one:.6g}' for x in numbers]
            size = f'[{", ".join(texts)}]' if isinstance(values, Iterable) else texts[0]
            return f'{size} {each}'
    return ''


def _powers(unit: str, others: Iterable[str]) -> list[tuple[Fraction, ...]]:
    """Return the dimensions of units; a key of one's own may have one that is not known."""
    with suppress(Unfit):
        return [unit_of(each).powers for each in (unit, *others)]
    return []


_NUMBER = re.compile(r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,4}(?!\d))?', re.ASCII)
_QUANTITY = re.compile(
    rf'(?P<numbers>{_NUMBER.pattern}|\[\s*{_NUMBER.pattern}(?:\s*,\s*{_NUMBER.pattern})*\s*,?\s*\])'
    # A unit may begin with a number of its own: '5 1/s', '150 1e-22 W/m^2/Hz'.
    r'(?:\s*(?P<unit>[A-Za-z%(].*)|\s+(?P<scaled>1(?:e[-+]?\d\d?)?(?:\s*/|\s).*))',
    re.ASCII,
)


class _Reader:
    """Reads the text of a unit, whole names before those with a prefix."""

    _WORDS = re.compile(r'[A-Za-z]+|[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|\S', re.ASCII)

    def __init__(self, text: str):
        self._text, self._words = text, self._WORDS.findall(text)

    def unit(self) -> Unit:
        """Return the unit of the whole text; Unfit: it is not a unit."""
        if not self._text:
            return Unit()
        found = self._product()
        return self._refuse() if self._words else found

    @property
    def _next(self) -> str:
        return self._words[0] if self._words else ''

    def _takes(self, word: str) -> bool:
        if self._next != word:
            return False
        del self._words[0]
        return True

    def _product(self) -> Unit:
        found, divided = self._power(), False
        while self._words and self._next != ')':
            power = Fraction(1)
            if self._takes('/'):
                power, divided = Fraction(-1), True
            elif divided:
                raise Unfit(
                    f'the unit {self._text} can be read in two ways; put the denominator in '
                    'parentheses, as in A/(B C)'
                )
            found = found.times(self._power(), power)
        return found

    def _power(self) -> Unit:
        found = self._atom()
        # m2 and s-1 are m^2 and s^-1.
        if not (self._takes('^') or re.fullmatch(r'[-+]?\d', self._next)):
            return found
        if not re.fullmatch(r'[-+]?\d(\.5)?', self._next):
            self._refuse()
        return Unit().times(found, Fraction(self._words.pop(0)))

    def _atom(self) -> Unit:
        if self._takes('('):
            found = self._product()
            return found if self._takes(')') else self._refuse()
        if self._takes('sqrt'):
            return Unit().times(self._atom(), Fraction(1, 2))
        word = self._next
        self._words = self._words[1:]
        if word.isalpha() or word == '%':
            return _unit_of_name(word)
        return Unit(Decimal(word)) if numbers.number(word) else self._refuse()

    def _refuse(self) -> NoReturn:
        raise Unfit(f'{self._text} is no unit')


def _unit_of_name(name: str) -> Unit:
    if name in _KNOWN:
        return _KNOWN[name]
    prefix, rest = name[0], name[1:]
    if prefix in _PREFIXES and rest in _WITH_PREFIXES:
        return Unit(Decimal(_PREFIXES[prefix])).times(_KNOWN[rest])
    in_use = {word for unit in _IN_USE for word in re.findall('[A-Za-z]+', unit)} - {'sqrt'}
    raise Unfit(f'there is no unit {name}, the nearest is {nearest(name, sorted(in_use))}')


_ZEROS = [Fraction(0)] * len(_BASE)
_KNOWN = {
    name: Unit(_ONE, (*_ZEROS[:i], Fraction(1), *_ZEROS[i + 1 :])) for i, name in enumerate(_BASE)
}
_KNOWN['pi'] = Unit(_PI)
for _line in _DEFINITIONS.strip().splitlines():
    _names, _, _what = _line.partition('=')
    _KNOWN |= dict.fromkeys(_names.split(), unit_of(_what.strip()))

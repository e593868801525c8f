"""What one key of a scenario is: type, unit, range, default, and the check of a value."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite
from numbers import Real
from typing import Any

from . import units
from .nanoseconds import stamp_ns
from .sentences import nearest, written

# The longest part of a given value that a sentence repeats.
_LONGEST_GIVEN = 100
_QUOTE = "; a text that ROS takes for a truth or a number must be quoted, as 'y' or '1'"
_OF_TEXTS = 'string', 'string_array', 'text', 'texts'
_OF_NUMBERS = 'double', 'double_array', 'integer'


@dataclass(frozen=True)
class Key:
    """
    One key of a scenario.

    Parameters
    ----------
    name : str
        dotted
    kind : str
        'double', 'double_array', 'string', 'string_array', 'epoch', 'text', 'texts' (strings of
        any content, empty: not given), 'bool' or 'integer'
    default : value
        its value if none is given
    unit : str
        empty: none
    meaning : str
        one sentence
    low, high : numbers
        bounds, inclusive
    above, below : numbers
        bounds, exclusive
    lengths : tuple
        allowed lengths of an array
    choices : tuple
        allowed strings
    changes : str
        'never', 'running' (a parameter set) or 'service' (~/set_initial_conditions)
    also : tuple
        units of another dimension in which people have it, with the factor 1 between them
    is_optional : bool
        whether a text leaves it out where it has its default, as most scenarios do
    trade : str
        the unit in which datasheets have it, where its own does not say
    is_direction : bool
        whether only the direction of the array counts, which must have one
    """

    name: str
    kind: str
    default: Any
    unit: str
    meaning: str
    low: float = -inf
    high: float = inf
    above: float = -inf
    below: float = inf
    lengths: tuple[int, ...] = ()
    choices: tuple[str, ...] = ()
    changes: str = 'never'
    also: tuple[str, ...] = ()
    is_optional: bool = False
    trade: str = ''
    is_direction: bool = False

    @property
    def allowed(self) -> str:
        """What is allowed, as the end of a sentence."""
        return self._allowed(())

    def _allowed(self, given):
        """Return what is allowed, its bounds in digits that set them off from given numbers."""
        if self.kind == 'bool':
            return 'true or false'
        if self.kind == 'epoch':
            return 'empty or an epoch in UTC, such as 2026-03-01T00:00:00Z'
        if self.kind in ('text', 'texts'):
            return 'a text' if self.kind == 'text' else 'a list of texts'
        if self.kind == 'string_array':
            return f'a list of {", ".join(self.choices) or "different names"}'
        if self.choices:
            empty = 'empty or ' if '' in self.choices else ''
            return f'{empty}one of {", ".join(filter(None, self.choices))}'
        if self.kind == 'string':
            return 'a non-empty string'
        what = {'double': 'a number', 'integer': 'an integer'}.get(self.kind)
        if what is None:
            lengths = ' or '.join(str(n) for n in self.lengths if n)
            empty = 'empty or ' if 0 in self.lengths else ''
            what = f'{empty}a list of {lengths} numbers'
        elif self.unit == 'rad':
            what = 'an angle in radians,'
        bounds = [
            f'above {_bound(self.above, given)}' if self.above > -inf else '',
            f'at least {_bound(self.low, given)}' if self.low > -inf else '',
            f'at most {_bound(self.high, given)}' if self.high < inf else '',
            f'below {_bound(self.below, given)}' if self.below < inf else '',
        ]
        unit = '' if 'radians' in what else self.unit
        parts = [what, ' and '.join(bound for bound in bounds if bound), unit]
        # Without bounds there is nothing behind the comma.
        return ' '.join(part for part in parts if part).rstrip(',')

    def is_within(self, number: Any) -> Any:
        """Return whether a number is finite and within the bounds; of arrays, whether each is."""
        # The exclusive bounds are infinite where there are none: they let nothing infinite pass.
        within = (number > self.above) & (number < self.below)
        return within & (number >= self.low) & (number <= self.high)

    def checked(self, value: Any) -> Any:
        """
        Return value as the key's kind; ValueError, in one sentence: it is not allowed.

        A text such as '51.6 deg', or a list of such, is its number in the key's unit.
        """
        number = value
        try:
            number = self._in_unit(value)
            return _READERS[self.kind](self, number)
        except _DoubledError as doubled:
            raise ValueError(f'{self.name} has {doubled} twice; each may be given once') from None
        except units.Unfit as unfit:
            fit = f'; units that fit: {units.fitting(self.unit, self.also)}' if self.unit else ''
            raise ValueError(f'{self.name} is {_shown(value)}; {unfit}{fit}') from None
        except (TypeError, ValueError, OverflowError):
            given = _shown(value)
            if number is not value:
                given += f', {_shown(number)} {self.unit}'.rstrip()
            items = number if isinstance(number, list | tuple) else [number]
            numbers = [x for x in items if isinstance(x, Real)]
            hint = _QUOTE if numbers and self.kind in _OF_TEXTS else ''
            if number is value:
                hint = hint or self._meant(number)
            other = [x for x in items if isinstance(x, str) and x not in self.choices]
            if other and self.choices and self.kind == 'string_array':
                given_name = other[0][:_LONGEST_GIVEN]
                hint = f'; the nearest to {given_name} is {nearest(given_name, self.choices)}'
            raise ValueError(
                f'{self.name} is {given}; it must be {self._allowed(numbers)}{hint}'
            ) from None

    def in_trade(self, value: Any) -> str:
        """Return a checked value in the unit of datasheets, '' where that is its own."""
        if self.kind not in _OF_NUMBERS:
            return ''
        return units.in_trade(value, self.unit, self.trade)

    def _meant(self, number):
        """Return the text that a number may have been meant as, as the end of a sentence."""
        trade = self.trade or {'rad': 'deg'}.get(self.unit, '')
        is_number = isinstance(number, float | int) and not isinstance(number, bool)
        if not trade or self.kind != 'double' or not is_number or not isfinite(number):
            return ''
        text = f'{written(number)} {trade}'
        is_within = self.is_within(self._number_of(text))
        return f"; where {trade} is meant, '{text}'" if is_within else ''

    def has_unit(self, value: Any) -> bool:
        """Return whether a value of numbers is a text with a unit, or a list with one in it."""
        items = value if isinstance(value, list | tuple) else [value]
        is_text = (isinstance(x, str) and units.is_quantity(x) for x in items)
        return self.kind in _OF_NUMBERS and any(is_text)

    def plain(self, value: Any) -> Any:
        """Return a value that has a unit as checked, another as it is; ValueError: as checked."""
        return listed(self.checked(value)) if self.has_unit(value) else value

    def _in_unit(self, value):
        """Return a value with texts such as '51.6 deg' as numbers; Unfit: one is in no unit."""
        if not self.has_unit(value):
            return value
        if isinstance(value, str):
            return self._number_of(value)
        if bare := [x for x in value if not isinstance(x, str) and x != 0]:
            raise units.Unfit(f'where one entry has a unit, {bare[0]} must have one too')
        # Of nothing the unit is no matter; as a text it may stand beside texts in a file.
        return [self._number_of(x) if x not in (0, '0') else 0.0 for x in value]

    def _number_of(self, text):
        number = units.in_unit(text, self.unit, self.also)
        if isinstance(number, list):
            return [float(x) for x in number]
        is_whole = self.kind == 'integer' and number == number.to_integral_value()
        return int(number) if is_whole else float(number)


def part_key(owner: str) -> Key:
    """Return the key that names a part of the catalogue, as `owner.part`."""
    return Key(
        f'{owner}.part',
        'text',
        '',
        '',
        'the name of a part, whose values are taken where none is given here; empty: no part',
    )


def _shown(value: Any) -> str:
    """Return a value as a sentence repeats it."""
    given = ascii(value) if isinstance(value, str) else str(value)
    return given if len(given) <= _LONGEST_GIVEN else f'{given[:_LONGEST_GIVEN]}...'


def _bound(bound: float, given: list[Any]) -> str:
    """Return a bound in six digits, or in all where those would lie beyond a given number."""
    short = f'{bound:g}'
    seen = float(short)
    beyond = any((x > bound) != (x > seen) or (x < bound) != (x < seen) for x in given)
    return repr(bound) if beyond else short


class _DoubledError(ValueError):
    """The name that a list has twice."""


def listed(value: Any) -> Any:
    """Return a value of a key as YAML and ROS know it, a tuple as a list."""
    return list(value) if isinstance(value, tuple) else value


def _real(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError
    return value


def _number(key: Key, value: Any) -> float:
    number = float(_real(value))
    if not key.is_within(number):
        raise ValueError
    return number


def _numbers(key: Key, value: Any) -> tuple[float, ...]:
    if 0 in key.lengths and (value is None or value == b''):
        # As ROS carries an empty list.
        return ()
    if isinstance(value, str | bytes):
        raise TypeError
    numbers = tuple(_number(key, x) for x in value)
    if len(numbers) not in key.lengths:
        raise ValueError
    return numbers


def _integer(key: Key, value: Any) -> int:
    if int(_real(value)) != value:
        raise TypeError
    if not key.is_within(value):
        raise ValueError
    return int(value)


def _text(key: Key, value: Any) -> str:
    if not _any_text(key, value) and '' not in key.choices:
        raise TypeError
    if key.choices and value not in key.choices:
        raise ValueError
    return value


def _epoch(key: Key, value: Any) -> str:
    if _any_text(key, value):
        stamp_ns(value)
    return value


def _texts(key: Key, value: Any) -> tuple[str, ...]:
    # ROS cannot carry an empty list: it arrives as not set.
    items = () if value is None else value
    if isinstance(items, str) or not all(isinstance(x, str) for x in items):
        raise TypeError
    texts = tuple(_text(key, x.removeprefix('/')) for x in items)
    for text, count in Counter(texts).most_common(1):
        if count > 1:
            raise _DoubledError(text)
    return texts


def _any_text(key: Key, value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError
    # Half of a surrogate pair is no text: UnicodeEncodeError, a ValueError.
    value.encode()
    return value


def _any_texts(key: Key, value: Any) -> tuple[str, ...]:
    # ROS cannot carry an empty list: it arrives as not set.
    items = () if value is None else value
    if isinstance(items, str):
        raise TypeError
    return tuple(_any_text(key, x) for x in items)


def _truth(key: Key, value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError
    return value


_READERS: dict[str, Callable[[Key, Any], Any]] = {
    'double': _number,
    'double_array': _numbers,
    'integer': _integer,
    'string': _text,
    'string_array': _texts,
    'epoch': _epoch,
    'text': _any_text,
    'texts': _any_texts,
    'bool': _truth,
}

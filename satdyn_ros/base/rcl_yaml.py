"""
Parameter files as rcl reads them: the kinds of their words, their sections, what is given twice.

Beyond rcl a list may mix integers and floats, a number may be closer to zero than 2.2e-308, a
group of keys may be empty, and an alias stands for what its anchor marks.  What else rcl does not
read is refused, as is what it reads without sense: a list in a list, and a parameter that is given
twice as values of two kinds, of which it keeps one by their kinds.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator
from typing import Any, ClassVar, NoReturn

import yaml

from . import ros_yaml

PARAMETERS = 'ros__parameters'

_TRUE = 'Y', 'y', 'yes', 'Yes', 'YES', 'true', 'True', 'TRUE', 'on', 'On', 'ON'
_FALSE = 'N', 'n', 'no', 'No', 'NO', 'false', 'False', 'FALSE', 'off', 'Off', 'OFF'
# What strtol reads to the base 0, and strtod.
_INTEGER = re.compile(r'([+-]?)(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9][0-9]*)')
_DECIMAL = re.compile(r'[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?')
_HEXADECIMAL = re.compile(
    r'[+-]?0[xX]([0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)([pP][+-]?[0-9]+)?'
)
_NOT_FINITE = re.compile(
    r'([+-]?)(inf|infinity|nan(?:\([0-9a-z_]*\))?)|([+-]?)\.(inf|Inf|INF)|\.(nan|NaN|NAN)'
)
_SECTION = re.compile(r'/?((\*\*?|[A-Za-z_][A-Za-z0-9_]*)/)*(\*\*?|[A-Za-z_][A-Za-z0-9_]*)')
_KINDS = {bool: 'a truth', int: 'an integer', float: 'a float', str: 'a text'}
_TEXT_TAG = 'tag:yaml.org,2002:str'


def word(text: str) -> bool | int | float | str:
    """
    Return what an unquoted word is.

    >>> [word(text) for text in ('y', '010', '-.5', '1_000')]
    [True, 8, -0.5, '1_000']
    """
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    if match := _INTEGER.fullmatch(text):
        sign, digits = match.groups()
        base = 16 if digits[:2] in ('0x', '0X') else 8 if digits[0] == '0' else 10
        number = int(sign + digits, base)
        return number if -(2**63) <= number < 2**63 else float(number)
    if _DECIMAL.fullmatch(text):
        return _number(text)
    if _HEXADECIMAL.fullmatch(text):
        try:
            return float.fromhex(text)
        except OverflowError:
            return text
    if _NOT_FINITE.fullmatch(text if '.' in text else text.lower()):
        return float('nan' if 'nan' in text.lower() else text.replace('.', ''))
    return text


def matches(section: str, full_name: str) -> bool:
    """
    Return whether a section is for a node: * stands for one name, ** for any number of them.

    >>> matches('/**/satdyn', '/sat1/satdyn'), matches('/*', '/sat1/satdyn')
    (True, False)
    """
    names = full_name.removeprefix('/').split('/')
    reached = {0}
    for token in section.removeprefix('/').split('/'):
        if token == '**':
            reached = set(range(min(reached), len(names) + 1))
        else:
            reached = {k + 1 for k in reached if k < len(names) and token in ('*', names[k])}
        if not reached:
            return False
    return len(names) in reached


def sections(
    files: Iterable[tuple[str, str]],
    value_of: Callable[[str, Any, str], Any] = lambda key, value, origin: value,
) -> dict[str, dict[str, Any]]:
    """
    Return the parameters, dotted, of each section of files, merged.

    Sections are in the order in which their names first stand, and of a parameter the last value
    counts.

    Parameters
    ----------
    files : iterable of pairs of str
        text and name, for the errors, of each
    value_of : function of key, value and origin
        returns what a parameter of a file comes to

    Raises
    ------
    ValueError
        rcl does not read it
    """
    found: dict[str, dict[str, Any]] = {}
    for text, origin in files:
        _Reader(origin, value_of).read(ros_yaml.compose(text, origin, _Loader), found)
    return found


class _Loader(ros_yaml.SafeLoader):  # type: ignore[misc, valid-type]
    """YAML in which a word differs from a text by the tag that it has in the file, if any."""

    DEFAULT_SCALAR_TAG = ''
    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}


class _Reader:
    """Reads one file; origin: its name in the errors."""

    def __init__(self, origin: str, value_of: Callable[[str, Any, str], Any]):
        self._origin, self._value_of = origin, value_of

    def read(self, node: yaml.Node | None, found: dict[str, dict[str, Any]]) -> None:
        """Add the sections of a file to those found."""
        if not isinstance(node, yaml.MappingNode):
            raise ValueError(
                f'{self._origin} is not a parameter file: it must have sections such as /**'
            )
        for name, value in self._sections(node, ''):
            section = found.setdefault(name, {})
            for key, parameter in self._parameters(value, ''):
                new = self._value_of(key, self._value(key, parameter), self._origin)
                kinds = sorted({_kind(new), _kind(section.get(key, new))})
                if len(kinds) > 1:
                    self._refuse(
                        parameter,
                        f'{key}, given as {kinds[0]} and as {kinds[1]} under {name}; ROS then '
                        'keeps one of them whatever their order, so it must be given once, or '
                        'twice in the same way, as 5.0 or [5.0]',
                    )
                section[key] = new

    def _sections(self, node, prefix) -> Iterator[tuple[str, yaml.MappingNode]]:
        """Yield the name of each section and its parameters."""
        for key, value in node.value:
            name = prefix + self._key(key)
            keys = value.value if isinstance(value, yaml.MappingNode) else None
            own = [each for each, _ in keys or [] if each.value == PARAMETERS]
            if keys is None or (own and len(keys) > 1) or (prefix and not keys):
                self._refuse(key, f'a section with more than {PARAMETERS} in it, or none: {name}')
            elif keys and not own:
                yield from self._sections(value, f'{name}/')
            elif not _SECTION.fullmatch(name):
                raise ValueError(
                    f'{self._origin} has the section {name}; it must be named /** or '
                    '/namespace/node'
                )
            else:
                parameters = keys[0][1] if keys else value
                if not isinstance(parameters, yaml.MappingNode):
                    raise ValueError(
                        f'{PARAMETERS} of {self._origin} must be keys and values, also in {name}'
                    )
                yield name, parameters

    def _parameters(self, node, prefix) -> Iterator[tuple[str, yaml.Node]]:
        """Yield the dotted name and the value of each parameter."""
        for key, value in node.value:
            name = prefix + self._key(key)
            if isinstance(value, yaml.MappingNode):
                yield from self._parameters(value, f'{name}.')
            else:
                yield name, value

    def _key(self, node):
        if not isinstance(node, yaml.ScalarNode) or not node.value:
            self._refuse(node, 'a key that is not a word')
        return node.value

    def _value(self, name, node):
        if not isinstance(node, yaml.SequenceNode):
            return self._scalar(node)
        values = [self._scalar(item) for item in node.value]
        words = {_kind(value): item.value for value, item in zip(values, node.value, strict=True)}
        if len(words) > 1 and set(words) != {_KINDS[int], _KINDS[float]}:
            mixed = ' and '.join(f'{kind} ({words[kind]})' for kind in sorted(words))
            self._refuse(
                node,
                f'{name} with {mixed} in one list; a text that ROS takes for true, false or a '
                "number must be quoted, as 'y', 'on', 'nan' or '1'",
            )
        return values

    def _scalar(self, node):
        if not isinstance(node, yaml.ScalarNode):
            self._refuse(node, 'a list or keys in a list, which no parameter can be')
        if node.style in ('"', "'") or node.tag == _TEXT_TAG:
            return node.value
        if not node.value:
            self._refuse(node, "a key without a value; an empty text is ''")
        return word(node.value)

    def _refuse(self, node, what) -> NoReturn:
        raise ValueError(f'{self._origin} has at line {node.start_mark.line + 1} {what}')


def _number(text: str) -> float | str:
    """Return what a decimal number is: a text where it is beyond those of a double."""
    number = float(text)
    is_zero = not re.search('[1-9]', text.lower().partition('e')[0])
    return text if math.isinf(number) or (number == 0.0) != is_zero else number


def _kind(value: Any) -> str:
    """Return in words of which type rcl takes a value for."""
    if isinstance(value, list):
        kinds = sorted({_kind(item) for item in value}) or ['nothing']
        return f'a list of {kinds[0].removeprefix("a ").removeprefix("an ")}s'
    return _KINDS[type(value)]

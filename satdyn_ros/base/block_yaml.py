"""Maps and lists as texts in YAML, as yaml-cpp lays them out for rosbag2."""

import re
from collections.abc import Iterator
from typing import Any

from .ros_yaml import quoted

# A text that is no other YAML for want of quotes.
_PLAIN = re.compile(
    r'(?!(y|n|yes|no|on|off|true|false|null)$)[a-z_/][\w./-]{0,254}', re.ASCII | re.IGNORECASE
)
# YAML reads no longer one ahead of its colon.
_LONGEST_KEY = 1000


def block_yaml(held: dict[str, Any]) -> str:
    """
    Return a map as a YAML text in block style; a text has quotes only if it needs them.

    >>> print(block_yaml({'a': [{'b': 1, 'c': 'yes'}], 'd': None}))
    a:
      - b: 1
        c: "yes"
    d: ~
    """
    return '\n'.join(_lines(held, ''))


def _lines(held: Any, indent: str) -> Iterator[str]:
    """Yield the lines of a map or a list as rosbag2 has them laid out: lists are indented."""
    is_map = isinstance(held, dict)
    for key, item in held.items() if is_map else enumerate(held):
        begin = f'{indent}{_key(key, indent)}:' if is_map else f'{indent}-'
        if not (item and isinstance(item, dict | list)):
            yield f'{begin} {_scalar(item)}'
            continue
        lines = _lines(item, f'{indent}  ')
        yield begin if is_map else begin + next(lines)[len(begin) :]
        yield from lines


def _key(key: Any, indent: str) -> str:
    text = _scalar(key)
    return text if len(text) <= _LONGEST_KEY else f'? {text}\n{indent}'


def _scalar(value: Any) -> str:
    match value:
        case None:
            return '~'
        case bool():
            return str(value).lower()
        case int() | dict() | list():
            # Maps and lists come here if they are empty.
            return str(value)
    text = str(value)
    return text if _PLAIN.fullmatch(text) else quoted(text)

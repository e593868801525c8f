"""
What ROS 2 knows about the message types used here: definitions, type hashes and fields.

The definitions are data of the package, so that bags are the same with and without ROS:
definitions.json holds the .msg texts word for word and the hashes as ROS 2 Jazzy installs them.
scripts/collect_definitions.py writes it from an installed ROS 2.
"""

import json
import re
from functools import cache
from importlib import resources
from typing import NamedTuple

SEQUENCE = -1


class MessageField(NamedTuple):
    """
    A field of a message.

    Attributes
    ----------
    type : str
        float64, string, std_msgs/msg/Header and so on
    name : str
        of the field
    length : int or None
        None for one value, n for an array of n, SEQUENCE for one of any length
    default : float or None
        its default
    """

    type: str
    name: str
    length: int | None = None
    default: float | None = None


def schema_text(type_name: str) -> str:
    """
    Return the schema of a type as rosbag2 writes it into a bag.

    The definition, then that of every type it contains, each once, depth first, the types within
    one definition in alphabetical order.  KeyError: the package has no such type.

    >>> schema_text('std_msgs/msg/Float64').splitlines()[-1]
    'float64 data'
    """
    text = ''
    for name in closure(type_name):
        if text:
            text += f'\n{"=" * 80}\nMSG: {name.replace("/msg/", "/")}\n'
        text += _definitions()[name]['definition']
    return text


def type_hash(type_name: str) -> str:
    """Return the type hash of REP-2011, 'RIHS01_' and 64 hexadecimal digits."""
    return _definitions()[type_name]['hash']


def closure(type_name: str) -> list[str]:
    """Return the type and all types it contains, in the order of schema_text."""
    found: list[str] = []
    _visit(type_name, found)
    return found


def _visit(type_name, found):
    found.append(type_name)
    for part in sorted({field.type for field in fields(type_name) if '/' in field.type}):
        if part not in found:
            _visit(part, found)


@cache
def fields(type_name: str) -> tuple[MessageField, ...]:
    """
    Return the fields of a type in the order of its definition; constants are left out.

    >>> fields('std_msgs/msg/Float64')
    (MessageField(type='float64', name='data', length=None, default=None),)
    """
    return parse(type_name, _definitions()[type_name]['definition'])


def parse(type_name: str, definition: str) -> tuple[MessageField, ...]:
    """Return the fields in the definition (.msg text) of a type."""
    package = type_name.split('/')[0]
    lines = (line.split('#')[0].split() for line in definition.splitlines())
    is_constant = re.compile(r'\S+ \S+ ?=').match
    return tuple(
        _field(package, *words) for words in lines if words and not is_constant(' '.join(words))
    )


def _field(package, declared, name, default=None):
    found = re.fullmatch(r'([\w/]+)(\[(\d*)\])?', declared)
    assert found is not None, declared
    base, brackets, length = found.groups()
    if base[0].isupper():
        base = f'{package}/{base}'
    count = None if brackets is None else int(length) if length else SEQUENCE
    value = None if default is None else float(default)
    return MessageField(base.replace('/', '/msg/'), name, count, value)


@cache
def _definitions() -> dict[str, dict[str, str]]:
    data = resources.files(__package__).joinpath('definitions.json')
    return json.loads(data.read_text(encoding='utf-8'))

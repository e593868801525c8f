"""The messages and requests of msg_examples/, made as ros2 topic pub and ros2 service call do."""

import array
import importlib
import re
import shlex
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

ROOT = Path(__file__).parents[2] / 'msg_examples'
TOPICS = sorted((ROOT / 'topics').glob('*.yaml'))
SERVICES = sorted((ROOT / 'services').glob('*.yaml'))


class Example(NamedTuple):
    """What a file says: its command in words, the topic or service, its type, and the values."""

    first_line: str
    command: list[str]
    name: str
    type: str
    values: dict[str, Any]


def load(path):
    """Return what an example file says."""
    text = path.read_text()
    (line,) = re.findall(r'^# (ros2 .*)$', text, re.MULTILINE)
    command = shlex.split(line)
    first_line, _ = text.split('\n', 1)
    return Example(first_line, command, command[-3], command[-2], yaml.safe_load(text))


def interface(type_name):
    """Return the class of a message or service, 'std_srvs/srv/Trigger'."""
    package, kind, name = type_name.split('/')
    return getattr(importlib.import_module(f'{package}.{kind}'), name)


def filled(message, values):
    """
    Return a message with the values of an example in it.

    As ros2 topic pub fills one, but nothing is converted: a whole number for a double, which the
    message class refuses, is a mistake of the example.
    """
    for name, value in values.items():
        field = getattr(message, name)
        if isinstance(value, dict):
            filled(field, value)
        elif isinstance(field, array.array):
            setattr(message, name, array.array(field.typecode, value))
        elif isinstance(field, np.ndarray):
            setattr(message, name, np.array(value, dtype=field.dtype))
        elif isinstance(field, list) and value and isinstance(value[0], dict):
            declared = message.get_fields_and_field_types()[name]
            (of,) = re.findall(r'<(.*)>', declared)
            element = interface(of.replace('/', '/msg/'))
            setattr(message, name, [filled(element(), item) for item in value])
        else:
            setattr(message, name, value)
    return message

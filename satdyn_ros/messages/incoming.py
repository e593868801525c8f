"""The messages of commands, one by one."""

from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..actuators import Command, kind_of
from ..run.samples import Stamped
from ..run.scenario import Frames
from . import cdr, contents, schemas


@dataclass(frozen=True, eq=False)
class Numbers(Stamped):
    """
    What changes from message to message.

    Attributes
    ----------
    stamps_ns : (N,), ns
        of the messages
    numbers : (N, K)
        their numbers
    """

    stamps_ns: np.ndarray
    numbers: np.ndarray


def pack_command(stamp_ns: int, command: Command, frames: Frames, topic: str = '') -> bytes:
    """Return the message of a command; topic: one of earlier versions in place of its own."""
    kind = kind_of(command.topic)
    fields = kind.fields(topic or command.topic, command.value)
    numbers: list[float] = []
    layout = tuple((path, _laid_out(given, numbers)) for path, given in fields.items())
    packer = _packer(kind.earlier.get(topic, kind.message), frames.body, layout)
    return packer.pack(Numbers(np.array([stamp_ns]), np.array([numbers], float))).tobytes()


class _Vector(NamedTuple):
    """The index of the first of three numbers, and the one after them."""

    begin: int
    end: int


class _Part(NamedTuple):
    """The fields of a message within a message: their names and indices."""

    fields: tuple[tuple[str, Any], ...]


class _Sequence(NamedTuple):
    """The indices of the elements of a sequence, or its texts."""

    items: tuple[Any, ...]


def _laid_out(given: Any, numbers: list[float]) -> Any:
    """Add the numbers of a field to others; return their indices, and texts as they are."""
    match given:
        case str():
            return given
        case dict():
            return _Part(tuple((name, _laid_out(x, numbers)) for name, x in given.items()))
        case list():
            return _Sequence(tuple(_laid_out(item, numbers) for item in given))
        case tuple():
            numbers += given
            return _Vector(len(numbers) - len(given), len(numbers))
    numbers.append(given)
    return len(numbers) - 1


@cache
def _packer(type_name: str, frame_id: str, layout: tuple[tuple[str, Any], ...]) -> cdr.Message:
    content: dict[str, Any] = {}
    if any(field.name == 'header' for field in schemas.fields(type_name)):
        content['header'] = contents.header(frame_id)
    for path, indices in layout:
        contents.fill(content, path, _columns(indices))
    return cdr.Message(type_name, content)


def _columns(indices):
    match indices:
        case str():
            return indices
        case _Part(fields):
            return {name: _columns(each) for name, each in fields}
        case _Sequence(items):
            return [_columns(each) for each in items]
        case _Vector(begin, end):
            return lambda source: source.numbers[:, begin:end]
    return lambda source: source.numbers[:, indices]

"""
The CDR bytes of ROS messages as rows of a NumPy table.

ROS 2 serialises in XCDR1, little endian: four bytes of encapsulation; then numbers, each aligned
to its size, counted from the end of the encapsulation; strings as a count, bytes and a NUL;
sequences as a count and the elements.  Where strings and counts are constant, so are the offsets
of all numbers: a message is a row of a structured array, and packing copies a template row and
writes the columns that change.  Padding is zero.
"""

from collections.abc import Callable, Mapping, Sized
from types import SimpleNamespace
from typing import Any

import numpy as np

from . import schemas

ENCAPSULATION = b'\x00\x01\x00\x00'

_NUMBERS = {
    'bool': '|b1',
    'byte': '|u1',
    'char': '|u1',
    'int8': '|i1',
    'uint8': '|u1',
    'int16': '<i2',
    'uint16': '<u2',
    'int32': '<i4',
    'uint32': '<u4',
    'int64': '<i8',
    'uint64': '<u8',
    'float32': '<f4',
    'float64': '<f8',
}


class Message:
    """
    A message type with the strings, counts and constants of one topic.

    content has the keys of the message; keys left out hold the message's defaults.  A value is a
    constant or a column: a function from what is packed (anything with a length N) to (N, ...).
    Fields that are vectors, such as geometry_msgs/Quaternion, are given as arrays in the order of
    their parts.

    dtype: one field for each number, array of numbers or vector, named by its path
    ('header.stamp.sec', 'wrench.torque', 'points[1]'); its itemsize is the length of the message.

    >>> Message('std_msgs/msg/Float64', {'data': 2.0}).rows(1).tobytes().hex()
    '000100000000000000000040'
    """

    def __init__(self, type_name: str, content: Mapping[str, Any]):
        self.type = type_name
        self._template = bytearray(ENCAPSULATION)
        self._formats: dict[str, tuple[Any, int]] = {}
        self._constants: dict[str, Any] = {}
        self._columns: dict[Callable, list[str]] = {}
        self._add_struct('', type_name, content)
        formats, offsets = zip(*self._formats.values(), strict=True)
        self.dtype = np.dtype(
            {
                'names': list(self._formats),
                'formats': list(formats),
                'offsets': list(offsets),
                'itemsize': len(self._template),
            }
        )
        row = np.frombuffer(self._template, self.dtype)
        for path, value in self._constants.items():
            row[path] = value

    def rows(self, count: int) -> np.ndarray:
        """Return `count` messages (count,) that hold the constants, the columns zero."""
        return np.ndarray(count, self.dtype, self._template * count)

    def pack(self, source: Sized, rows: np.ndarray | None = None) -> np.ndarray:
        """
        Return the messages of a source, shape (N,): the bytes of row i are message i.

        The strings stand between the fields, so rows are copied as bytes, rows.view(np.uint8).

        Parameters
        ----------
        source : object
            what is packed, of length N
        rows : (N or more,), or None
            those of an earlier call that are no longer needed, to be overwritten
        """
        count = len(source)
        rows = self.rows(count) if rows is None or len(rows) < count else rows[:count]
        for column, paths in self._columns.items():
            values = column(source)
            for path in paths:
                _write(rows[path], values)
        return rows

    def _add_struct(self, path, type_name, content):
        declared = schemas.fields(type_name)
        unknown = set(content) - {field.name for field in declared}
        if unknown:
            raise ValueError(f'{type_name} has no field {", ".join(sorted(unknown))}')
        for field in declared:
            inner_path = f'{path}.{field.name}' if path else field.name
            value = content.get(field.name)
            if field.length is None:
                self._add_value(inner_path, field.type, field.default if value is None else value)
            else:
                self._add_array(inner_path, field, value)

    def _add_array(self, path, field, items):
        if items is None:
            items = np.zeros(max(field.length, 0))
        if field.length == schemas.SEQUENCE:
            self._add_count(len(items))
        elif len(items) != field.length:
            raise ValueError(f'{path} has {len(items)} elements; it must have {field.length}')
        if field.type in _NUMBERS and not any(callable(item) for item in items):
            self._add_numbers(path, field.type, (len(items),), items)
        else:
            for i, item in enumerate(items):
                self._add_value(f'{path}[{i}]', field.type, item)

    def _add_value(self, path, type_name, value):
        if type_name == 'string':
            data = ('' if value is None else value).encode() + b'\0'
            self._add_count(len(data))
            self._template += data
        elif type_name in _NUMBERS:
            self._add_numbers(path, type_name, (), value)
        elif is_vector(type_name):
            parts = schemas.fields(type_name)
            defaults = [part.default or 0.0 for part in parts]
            values = defaults if value is None else value
            self._add_numbers(path, parts[0].type, (len(parts),), values)
        else:
            self._add_struct(path, type_name, {} if value is None else value)

    def _add_count(self, count):
        self._align(4)
        self._template += count.to_bytes(4, 'little')

    def _add_numbers(self, path, number, shape, value):
        dtype = np.dtype((_NUMBERS[number], shape))
        if dtype.itemsize == 0:
            return
        self._align(dtype.base.itemsize)
        self._formats[path] = (dtype, len(self._template))
        self._template += bytes(dtype.itemsize)
        if callable(value):
            self._columns.setdefault(value, []).append(path)
        elif value is not None:
            self._constants[path] = value

    def _align(self, size):
        self._template += bytes((len(ENCAPSULATION) - len(self._template)) % size)


def _write(field, values):
    """Write the values of all rows into a field."""
    if field.ndim == 1 or len(field) < field.shape[1]:
        field[:] = values
    else:
        # Part by part: NumPy's inner loop would be over the few parts of a row.
        for i in range(field.shape[1]):
            field[:, i] = values[:, i]


def is_vector(type_name: str) -> bool:
    """Whether a message is made of numbers of one type alone, such as Vector3 and Quaternion."""
    parts = schemas.fields(type_name)
    one_type = {(part.type, part.length) for part in parts} == {(parts[0].type, None)}
    return one_type and parts[0].type in _NUMBERS


def read(type_name: str, data: bytes) -> SimpleNamespace:
    """
    Return a message of its bytes, with the fields of its type; ValueError: it is not one.

    >>> read('std_msgs/msg/Float64', bytes.fromhex('000100000000000000000040')).data
    2.0
    """
    return _Reader(data).value(type_name)


class _Reader:
    """The values of a message's bytes one after the other; ValueError: no bytes are left."""

    def __init__(self, data: bytes):
        self._data, self._at = data, len(ENCAPSULATION)

    def value(self, type_name: str) -> Any:
        """Return a number, a string, or the fields of a message."""
        if type_name == 'string':
            return bytes(self._numbers('uint8', self._count())[:-1]).decode()
        if type_name in _NUMBERS:
            return self._numbers(type_name, 1)[0]
        declared = schemas.fields(type_name)
        return SimpleNamespace(**{field.name: self._field(field) for field in declared})

    def _field(self, field):
        if field.length is None:
            return self.value(field.type)
        count = self._count() if field.length == schemas.SEQUENCE else field.length
        # Nothing is aligned for nothing.
        if field.type in _NUMBERS and count:
            return self._numbers(field.type, count)
        return [self.value(field.type) for _ in range(count)]

    def _count(self):
        return self._numbers('uint32', 1)[0]

    def _numbers(self, type_name, count):
        dtype = np.dtype(_NUMBERS[type_name])
        self._at += (len(ENCAPSULATION) - self._at) % dtype.itemsize
        values = np.frombuffer(self._data, dtype, count, self._at)
        self._at += values.nbytes
        return values.tolist()

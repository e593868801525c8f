"""The records of MCAP as the mcap package has them, read strictly; message indexes as arrays."""

import io
import struct
from collections.abc import Iterable
from typing import Any, NamedTuple

import mcap.records
import numpy as np
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import McapRecord

from .chunk import Contents
from .errors import Damaged

# Opcode and length of the content.
PREFIX = struct.Struct('<BQ')
_INDEX = struct.Struct('<HI')
_ENTRIES = np.dtype([('log_time', '<u8'), ('offset', '<u8')])


class IndexRecord(NamedTuple):
    """A channel's messages in the previous chunk: entries (n,) of log_time, offset."""

    channel_id: int
    entries: np.ndarray

    @classmethod
    def read(cls, content: bytes) -> 'IndexRecord':
        """Return the index of a record's content; Damaged: it is not an index."""
        if len(content) < _INDEX.size:
            raise Damaged('it cannot be read')
        channel_id, size = _INDEX.unpack_from(content)
        if size != len(content) - _INDEX.size or size % _ENTRIES.itemsize:
            raise Damaged('its length is wrong')
        return cls(channel_id, np.frombuffer(content, _ENTRIES, offset=_INDEX.size))

    def agrees_with(self, contents: Contents) -> bool:
        """Whether this is the index of a chunk's contents, in any order."""
        if self.channel_id not in contents.counts:
            return len(self.entries) == 0
        expected = contents.index_of(self.channel_id)
        in_order = self.entries[np.argsort(self.entries['offset'], kind='stable')]
        return in_order.tobytes() == expected.tobytes()


def message_indexes(contents: Contents, start: int) -> tuple[bytes, dict[int, int]]:
    """Return the index records of a chunk's messages and where in the file each channel's is."""
    parts: list[bytes | memoryview] = []
    offsets, end = {}, start
    for channel_id in contents.counts:
        # This machine is little endian, as the file is.
        entries = contents.index_of(channel_id)
        size = entries.nbytes
        prefix = PREFIX.pack(Opcode.MESSAGE_INDEX, _INDEX.size + size)
        parts += [prefix, _INDEX.pack(channel_id, size), entries.data]
        offsets[channel_id] = end
        end += len(prefix) + _INDEX.size + size
    return b''.join(parts), offsets


def read(opcode: int, content: bytes) -> McapRecord | IndexRecord | None:
    """
    Return the record of a content; None: a message, or a kind that MCAP does not define.

    Damaged: it is not what a writer writes.
    """
    if opcode == Opcode.MESSAGE_INDEX:
        return IndexRecord.read(content)
    if opcode not in _KINDS:
        return None
    try:
        record = _KINDS[opcode].read(ReadDataStream(io.BytesIO(content)))
        again = written([record])
    except (McapError, struct.error, UnicodeError, MemoryError, OverflowError):
        raise Damaged('it cannot be read') from None
    if again[PREFIX.size :] != content:
        raise Damaged('it is not what a writer writes')
    return record


def written(records: Iterable[McapRecord]) -> bytes:
    """Return the bytes of records in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()


def name_of(opcode: int) -> str:
    """
    Return the name of a kind of record.

    >>> name_of(7)
    'MessageIndex'
    """
    try:
        return Opcode(opcode).name.title().replace('_', '')
    except ValueError:
        return f'unknown (opcode {opcode})'


# A message's content has no length of its own to be read by.
_KINDS: dict[int, Any] = {
    opcode: getattr(mcap.records, name_of(opcode)) for opcode in Opcode if opcode != Opcode.MESSAGE
}

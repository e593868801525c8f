"""The records of MCAP one by one: parsed strictly, and distinguished from other bytes."""

import io
import struct
import zlib
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from .chunk import Contents, Indexed
from .compression import CEILING, ResourceBudget, decompress
from .errors import Damaged

# Opcode and length of the content.
PREFIX = struct.Struct('<BQ')
_CHUNK = struct.Struct('<QQQII')
_INDEX = struct.Struct('<HI')
_KINDS: dict[int, Any] = {
    Opcode.HEADER: Header,
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT: Attachment,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.STATISTICS: Statistics,
    Opcode.METADATA: Metadata,
    Opcode.METADATA_INDEX: MetadataIndex,
    Opcode.SUMMARY_OFFSET: SummaryOffset,
    Opcode.DATA_END: DataEnd,
}
_ENTRIES = np.dtype([('log_time', '<u8'), ('offset', '<u8')])


class ChunkRecord(NamedTuple):
    """A chunk as it is in a file; data: the messages, compressed."""

    first_ns: int
    last_ns: int
    size: int
    crc: int
    compression: str
    data: bytes

    @classmethod
    def read(cls, content: bytes) -> 'ChunkRecord':
        """Return the chunk of a record's content, which may be cut off; Damaged: it is not one."""
        try:
            first_ns, last_ns, size, crc, length = _CHUNK.unpack_from(content)
            compression = content[_CHUNK.size : _CHUNK.size + length].decode()
            begin = _CHUNK.size + length + 8
            (data_size,) = struct.unpack_from('<Q', content, begin - 8)
        except (struct.error, UnicodeDecodeError):
            raise Damaged('it cannot be read') from None
        data = content[begin : begin + data_size]
        return cls(first_ns, last_ns, size, crc, compression, data)

    def prefix(self) -> bytes:
        """Return the part of the record that precedes data."""
        name = self.compression.encode()
        fields = _CHUNK.pack(self.first_ns, self.last_ns, self.size, self.crc, len(name))
        length = len(fields) + len(name) + 8 + len(self.data)
        return b''.join(
            [
                PREFIX.pack(Opcode.CHUNK, length),
                fields,
                name,
                struct.pack('<Q', len(self.data)),
            ]
        )

    def contents(self, budget: ResourceBudget, ceiling: int = CEILING) -> Contents:
        """Return the messages; Damaged: they are not what was written, or too large."""
        if self.size <= ceiling:
            budget.spend(self.size)
        data = decompress(self.compression, self.data, self.size, ceiling)
        if self.crc not in (0, zlib.crc32(data)):
            raise Damaged('its checksum is wrong')
        contents = Contents(np.frombuffer(data, np.uint8))
        contents.check(budget)
        return contents


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


def message_indexes(contents: Indexed, start: int) -> tuple[bytes, dict[int, int]]:
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


def read(opcode: int, content: bytes) -> McapRecord | ChunkRecord | IndexRecord | None:
    """
    Return the record of a content; None: a kind that this version of MCAP does not define.

    Damaged: it is not what a writer writes.
    """
    if opcode == Opcode.CHUNK:
        return ChunkRecord.read(content)
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

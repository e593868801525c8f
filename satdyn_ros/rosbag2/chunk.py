"""
What is inside a chunk: the records of schemas, channels and messages, as one array of bytes.

A message is a record of a 31-byte head and its data.  Heads and data are extracted from the bytes
as tables, so that a message costs no more than copying it.
"""

import zlib
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema

from ..kernel.looped import looped
from ..trace.memory import integers, octets
from .budget import MESSAGE, objects
from .compression import decompress
from .errors import Damaged
from .records import read

CHUNK_SIZE = 786432
HEAD = np.dtype(
    [
        ('opcode', 'u1'),
        ('length', '<u8'),
        ('channel_id', '<u2'),
        ('sequence', '<u4'),
        ('log_time', '<u8'),
        ('publish_time', '<u8'),
    ]
)

# Opcode and length come before the content of every record.
_PREFIX = 9
_MESSAGE = int(Opcode.MESSAGE)
_HEAD_SIZE = HEAD.itemsize


class Contents:
    """
    The complete records of a chunk.

    data (N,) uint8; for its M messages offsets (M,), where they begin, heads (M,), as HEAD,
    channel_ids (M,), and log_times (M,) [ns]; span_ns: the first and the last log time, zeros if
    there is no message.  Bytes after the last complete record are left out.
    """

    def __init__(self, data: np.ndarray):
        size, self.offsets, self._others = _record_offsets(data)
        self.data = data[:size]
        self.heads = _gathered(self.data, self.offsets, _HEAD_SIZE).view(HEAD)[:, 0]
        self.channel_ids = self.heads['channel_id'].copy()
        self.log_times = self.heads['log_time'].copy()
        times = self.log_times if len(self) else np.zeros(1, np.uint64)
        self.span_ns = int(np.min(times)), int(np.max(times))

    def __len__(self) -> int:
        return len(self.offsets)

    @classmethod
    def of(cls, chunk: Chunk) -> 'Contents':
        """Return what a chunk holds; Damaged: it is not what was written, or too much."""
        data = decompress(chunk.compression, chunk.data, chunk.uncompressed_size)
        if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
            raise Damaged('its checksum is wrong')
        contents = cls(np.frombuffer(data, np.uint8))
        if len(contents.data) != len(data):
            raise Damaged(f'its messages are broken off at byte {len(contents.data)}')
        return contents

    @classmethod
    def of_messages(cls, data: bytes) -> 'Contents':
        """Return the whole messages with which data begin."""
        contents = cls(np.frombuffer(data, np.uint8))
        return cls(contents.data[: contents._others[0]]) if len(contents._others) else contents

    @property
    def cost(self) -> int:
        """What a reader pays of its Budget for what is in here, beside its bytes."""
        lengths = _gathered(self.data, self._others, _PREFIX)[:, 1:].copy().view('<u8')
        return MESSAGE * len(self) + objects(len(lengths), int(np.sum(lengths)))

    @cached_property
    def counts(self) -> dict[int, int]:
        """The number of messages of each channel that has any."""
        return {i: len(indices) for i, indices in self.indices.items()}

    @cached_property
    def indices(self) -> dict[int, np.ndarray]:
        """The indices of each channel's messages among all, for channels that have any."""
        indices = np.argsort(self.channel_ids, kind='stable')
        channel_ids = self.channel_ids[indices]
        begins = (channel_ids[1:] != channel_ids[:-1]).nonzero()[0] + 1
        spans = pairwise([0, *begins.tolist(), len(indices)]) if len(indices) else ()
        return {int(channel_ids[begin]): indices[begin:end] for begin, end in spans}

    def index_of(self, channel_id: int) -> np.ndarray:
        """Return log time [ns] and offset of each message of a channel, (n, 2) uint64."""
        indices = self.indices[channel_id]
        index = np.empty((len(indices), 2), np.uint64)
        index[:, 0], index[:, 1] = self.log_times[indices], self.offsets[indices]
        return index

    @cached_property
    def declarations(self) -> tuple[dict[int, Schema], dict[int, Channel]]:
        """The schemas and the channels by their ids; Damaged: one cannot be read."""
        declared: dict[Any, dict[int, Any]] = {Schema: {}, Channel: {}}
        for start in self._others.tolist():
            content = self.data[start + _PREFIX : start + self._length(start)].tobytes()
            record: Any = read(int(self.data[start]), content)
            kind = type(record)
            if kind not in declared:
                raise Damaged('it holds a record that does not belong in a chunk')
            if declared[kind].setdefault(record.id, record) != record:
                raise Damaged(f'it declares {kind.__name__} {record.id} in two ways')
        return declared[Schema], declared[Channel]

    def message_records(self) -> np.ndarray:
        """Return the records of the messages alone, (n,) uint8."""
        ends = [start + self._length(start) for start in self._others.tolist()]
        spans = zip([0, *ends], [*self._others.tolist(), len(self.data)], strict=True)
        return np.concatenate([self.data[begin:end] for begin, end in spans])

    def data_at(self, indices: np.ndarray) -> np.ndarray | list[bytes]:
        """
        Return the data of messages by their indices (n,) among all.

        It is an array (n, length) of uint8, or a list of bytes where lengths differ.
        """
        begins = self.offsets[indices] + HEAD.itemsize
        lengths = self.heads['length'][indices].astype(np.int64) + _PREFIX - HEAD.itemsize
        if len(indices) and np.all(lengths == lengths[0]):
            return _gathered(self.data, begins, int(lengths[0]))
        ends = begins + lengths
        return [self.data[i:j].tobytes() for i, j in zip(begins, ends, strict=True)]

    def _length(self, start):
        """Return the length of a record, its opcode and length included."""
        return _PREFIX + int(self.data[start + 1 : start + _PREFIX].copy().view('<u8')[0])


def _record_offsets(data):
    """Return where the last complete record ends, and where messages and other records begin."""
    offsets = np.empty(len(data) // _HEAD_SIZE + 1, np.int64)
    others = np.empty(len(data) // _PREFIX + 1, np.int64)
    counts = np.zeros(2, np.int64)
    arrays = (array.ctypes.data for array in (data, offsets, others, counts))
    end = _scan(len(data), *arrays)
    messages, other = counts.tolist()
    return end, offsets[:messages].copy(), others[:other].copy()


@looped
def _scan(size: int, data_at: int, offsets_at: int, others_at: int, counts_at: int) -> int:
    """Fill in where messages and other records begin, and how many; return where the last ends."""
    data, offsets, others = octets(data_at), integers(offsets_at), integers(others_at)
    start, messages, other = 0, 0, 0
    while start + _PREFIX <= size:
        length = 0
        for i in range(8):
            length = 256 * length + data[start + 8 - i]
        # One beyond what an integer holds has come out negative.
        if length < 0 or length > size - start - _PREFIX:
            break
        end = start + _PREFIX + length
        if data[start] == _MESSAGE and end - start >= _HEAD_SIZE:
            offsets[messages] = start
            messages += 1
        else:
            others[other] = start
            other += 1
        start = end
    counts = integers(counts_at)
    counts[0], counts[1] = messages, other
    return start


def _gathered(data, begins, length):
    """Return the rows data[begin : begin + length], shape (N, length)."""
    if length == 0 or len(begins) == 0:
        return np.empty((len(begins), length), np.uint8)
    # A row is copied as one item: in half the time that its bytes take.
    rows = np.ndarray(len(data) - length + 1, f'V{length}', data, strides=(1,))
    return rows[begins].view(np.uint8).reshape(-1, length)

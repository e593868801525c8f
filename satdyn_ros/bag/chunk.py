"""
What is inside a chunk: the records of schemas, channels and messages, as one array of bytes.

A message is a record of 31 bytes of head and its data.  Heads and data are taken out of the bytes
as tables, so that the cost of a message is that of copying it.
"""

import io

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from numba import njit

COMPRESSIONS = ('none', 'lz4', 'zstd')
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
# Level 1 takes the same bytes to within a few per cent of the default and less time.
_ZSTD_LEVEL = 1


class Contents:
    """
    The complete records of a chunk.

    data (N,) uint8; offsets (M,): where its messages begin; heads (M,): their heads, as HEAD.
    Bytes after the last complete record are left out.
    """

    def __init__(self, data: np.ndarray):
        starts = _record_starts(data)
        self.data = data[: starts[-1]]
        self._starts = starts[:-1]
        self._opcodes = data[self._starts]
        has_head = np.diff(starts) >= HEAD.itemsize
        self.offsets = self._starts[(self._opcodes == Opcode.MESSAGE) & has_head]
        self.heads = _gather(data, self.offsets, HEAD.itemsize).view(HEAD)[:, 0]

    @property
    def span_ns(self) -> tuple[int, int]:
        """Return the first and the last log time; zeros where there is no message."""
        log_times = self.heads['log_time']
        if len(log_times) == 0:
            return 0, 0
        return int(np.min(log_times)), int(np.max(log_times))

    def declarations(self) -> tuple[dict[int, Schema], dict[int, Channel]]:
        """Return the schemas and the channels by their ids."""
        schemas, channels = self._declared(Schema), self._declared(Channel)
        return {schema.id: schema for schema in schemas}, {c.id: c for c in channels}

    def message_records(self) -> np.ndarray:
        """Return the records of the messages alone, (n,) uint8."""
        kept = np.ones(len(self.data), bool)
        ends = np.append(self._starts[1:], len(self.data))
        for i in np.flatnonzero(self._opcodes != Opcode.MESSAGE):
            kept[self._starts[i] : ends[i]] = False
        return self.data if np.all(kept) else self.data[kept]

    def channel_ids(self) -> np.ndarray:
        """Return the channels that have messages, in ascending order."""
        return np.unique(self.heads['channel_id'])

    def messages(self, channel_id: int) -> tuple[np.ndarray, np.ndarray | list[bytes]]:
        """Return log times [ns] (n,) and data_at of the messages on a channel, in order."""
        places = np.flatnonzero(self.heads['channel_id'] == channel_id)
        return self.heads['log_time'][places], self.data_at(places)

    def data_at(self, places: np.ndarray) -> np.ndarray | list[bytes]:
        """
        Return the data of messages by their places (n,) in the chunk.

        It is an array (n, length) of uint8, or a list of bytes where lengths differ.
        """
        begins = self.offsets[places] + HEAD.itemsize
        lengths = self.heads['length'][places].astype(np.int64) + _PREFIX - HEAD.itemsize
        if len(places) and np.all(lengths == lengths[0]):
            return _gather(self.data, begins, lengths[0])
        ends = begins + lengths
        return [self.data[i:j].tobytes() for i, j in zip(begins, ends, strict=True)]

    def _declared(self, kind):
        opcode = Opcode.SCHEMA if kind is Schema else Opcode.CHANNEL
        for start in self._starts[self._opcodes == opcode]:
            yield kind.read(ReadDataStream(io.BytesIO(self.data[start + _PREFIX :].data)))


def compress(compression: str, data) -> bytes:
    """Return data compressed by one of COMPRESSIONS ('' is none)."""
    if compression == 'zstd':
        return zstandard.ZstdCompressor(level=_ZSTD_LEVEL).compress(data)
    if compression == 'lz4':
        return lz4.frame.compress(data)
    return bytes(data)


def decompress(compression: str, data: bytes, size: int) -> np.ndarray:
    """
    Return the contents (size,) uint8 of a chunk.

    ValueError: data is damaged, or the compression is none that we know.
    """
    try:
        if compression == 'zstd':
            data = zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
        elif compression == 'lz4':
            data = lz4.frame.decompress(data)
        elif compression:
            raise ValueError(f'the compression of a chunk is {compression}; we read lz4 and zstd')
    except (zstandard.ZstdError, RuntimeError) as error:
        raise ValueError(f'a chunk cannot be read: {error}') from error
    return np.frombuffer(data, np.uint8)


def decompress_begin(compression: str, data: bytes) -> np.ndarray:
    """Return as much of a chunk's contents (N,) uint8 as can be had where data is cut off."""
    try:
        if compression == 'zstd':
            data = zstandard.ZstdDecompressor().decompressobj().decompress(data)
        elif compression == 'lz4':
            data = lz4.frame.LZ4FrameDecompressor().decompress(data)
        elif compression:
            data = b''
    except (zstandard.ZstdError, RuntimeError):
        data = b''
    return np.frombuffer(data, np.uint8)


@njit('int64[::1](Array(uint8, 1, "C", readonly=True))', cache=True)
def _record_starts(data):
    """Return where each complete record begins, and at last where the last one ends."""
    starts = np.empty(len(data) // 9 + 1, np.int64)
    count, start = 0, 0
    starts[0] = 0
    while start + 9 <= len(data):
        length = np.uint64(0)
        for i in range(8):
            length |= np.uint64(data[start + 1 + i]) << np.uint64(8 * i)
        if length > np.uint64(len(data) - start - 9):
            break
        start += 9 + np.int64(length)
        count += 1
        starts[count] = start
    return starts[: count + 1].copy()


@njit('uint8[:, ::1](Array(uint8, 1, "C", readonly=True), int64[::1], int64)', cache=True)
def _gather(data, begins, length):
    """Return the rows data[begin : begin + length], shape (N, length)."""
    rows = np.empty((len(begins), length), np.uint8)
    for i in range(len(begins)):
        rows[i] = data[begins[i] : begins[i] + length]
    return rows

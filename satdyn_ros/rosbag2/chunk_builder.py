"""
Builds chunks with NumPy, with the messages of many ticks at once.

All messages of a topic have one length, so a tick is a row of one layout, and a block of ticks is
a table whose columns are heads and data.  Messages of topics that do not have one at every tick go
between the rows.
"""

from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Message, Schema

from ..messages.rows import Rows, SomeRows
from .chunk import CHUNK_SIZE, HEAD, scatter


class BuiltContents:
    """
    What is Indexed, known from its making.

    entries: of each channel, log time [ns] and offset of its messages, parts of (n, 2) uint64.
    """

    def __init__(
        self,
        data: np.ndarray,
        entries: Mapping[int, list[np.ndarray]],
        declarations: tuple[dict[int, Schema], dict[int, Channel]],
    ):
        self.data, self.declarations = data, declarations
        self._entries = {i: np.concatenate(entries[i]) for i in sorted(entries)}
        self.counts = {i: len(some) for i, some in self._entries.items()}
        # Messages of a channel come in the order of their log times.
        first = [int(some[0, 0]) for some in self._entries.values()]
        last = [int(some[-1, 0]) for some in self._entries.values()]
        self.span_ns = min(first, default=0), max(last, default=0)

    def __len__(self) -> int:
        return sum(self.counts.values())

    def index_of(self, channel_id: int) -> np.ndarray:
        """Return log time [ns] and offset of each message of a channel, (n, 2) uint64."""
        return self._entries[channel_id]


class ChunkBuilder:
    """The contents of the current chunk; full once they reach the size of a chunk."""

    def __init__(self):
        self._buffer = np.empty(2 * CHUNK_SIZE, np.uint8)
        self._begin()

    def _begin(self):
        self._size = 0
        self._entries: defaultdict[int, list[np.ndarray]] = defaultdict(list)
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}

    @property
    def is_empty(self) -> bool:
        """Whether nothing was added since the last chunk."""
        return self._size == 0

    @property
    def is_full(self) -> bool:
        """Whether the contents have reached the size of a chunk."""
        return self._size >= CHUNK_SIZE

    def add_declaration(self, record: Schema | Channel) -> None:
        """Append a schema or a channel."""
        declared: dict[int, Any] = self._schemas if isinstance(record, Schema) else self._channels
        declared[record.id] = record
        self._add_record(record)

    def add_message(self, channel_id: int, stamp_ns: int, data: bytes) -> None:
        """Append one message."""
        self._note(channel_id, np.array([stamp_ns]), np.array([self._size]))
        self._add_record(Message(channel_id, stamp_ns, data, publish_time=stamp_ns, sequence=0))

    def add_ticks(self, stamps_ns: np.ndarray, rows: Mapping[int, Rows]) -> int:
        """
        Append the messages of ticks until the chunk is full; return how many ticks were added.

        stamps_ns (N,); rows: for each channel the messages (N,), each row the bytes of one, or
        SomeRows, which follow those of all ticks.
        """
        full = {i: row for i, row in rows.items() if not isinstance(row, SomeRows)}
        layout, _ = _tick_layout(tuple((i, row.itemsize) for i, row in full.items()))
        free = max(CHUNK_SIZE - self._size, 0)
        # No more fit, whatever else comes between them.
        stamps_ns = stamps_ns[: max(1, -(-free // max(layout.itemsize, 1)))]
        some = {i: row[: len(stamps_ns)] for i, row in rows.items() if isinstance(row, SomeRows)}
        some = {i: row for i, row in some.items() if len(row.rows)}
        first = self._size
        if not some:
            count = len(stamps_ns)
            block = self._take(count * layout.itemsize).reshape(count, layout.itemsize)
            fits = {i: row[:count] for i, row in full.items()}
            _write_ticks(block, stamps_ns, fits)
            self._note_ticks(fits, stamps_ns, first + np.arange(count) * layout.itemsize)
            return count
        sizes = np.full(len(stamps_ns), layout.itemsize)
        for row in some.values():
            sizes[row.places] += HEAD.itemsize + row.rows.itemsize
        ends = np.cumsum(sizes)
        count = min(len(stamps_ns), 1 + int(np.searchsorted(ends, free)))
        block = self._take(int(ends[count - 1]))
        fits = {i: row[:count] for i, row in full.items()}
        table = np.empty((count, layout.itemsize), np.uint8)
        _write_ticks(table, stamps_ns[:count], fits)
        begins = ends[:count] - sizes[:count]
        self._note_ticks(fits, stamps_ns[:count], first + begins)
        scatter(block, begins, table)
        begins += layout.itemsize
        for channel_id, row in some.items():
            places, messages = row[:count].places, row[:count].rows
            table = np.empty((len(places), HEAD.itemsize + messages.itemsize), np.uint8)
            _write_ticks(table, stamps_ns[places], {channel_id: messages})
            self._note(channel_id, stamps_ns[places], first + begins[places])
            scatter(block, begins[places], table)
            begins[places] += table.shape[1]
        return count

    def take(self) -> BuiltContents:
        """Return the contents, valid until the next record is added, and start a new chunk."""
        data, declarations = self._buffer[: self._size], (self._schemas, self._channels)
        contents = BuiltContents(data, self._entries, declarations)
        self._begin()
        return contents

    def _add_record(self, record):
        builder = RecordBuilder()
        record.write(builder)
        data = builder.end()
        self._take(len(data))[:] = np.frombuffer(data, np.uint8)

    def _note_ticks(self, rows, stamps_ns, begins):
        """Note where the messages of ticks are that begin at `begins`."""
        layout, _ = _tick_layout(tuple((i, row.itemsize) for i, row in rows.items()))
        for channel_id in rows:
            self._note(channel_id, stamps_ns, begins + layout.fields[f'head {channel_id}'][1])

    def _note(self, channel_id, stamps_ns, begins):
        """Note log times and offsets of messages of a channel."""
        entries = np.empty((len(begins), 2), np.uint64)
        entries[:, 0], entries[:, 1] = stamps_ns, begins
        self._entries[channel_id].append(entries)

    def _take(self, size):
        end = self._size + size
        if end > len(self._buffer):
            self._buffer = np.concatenate([self._buffer[: self._size], np.empty(end, np.uint8)])
        place = self._buffer[self._size : end]
        self._size = end
        return place


def _write_ticks(table: np.ndarray, stamps_ns: np.ndarray, rows: Mapping[int, np.ndarray]):
    """Write the messages of N ticks, heads and data, as the rows of a table of bytes (N, size)."""
    layout, heads = _tick_layout(tuple((i, row.itemsize) for i, row in rows.items()))
    for channel_id, messages in rows.items():
        begin = layout.fields[f'head {channel_id}'][1]
        end = begin + HEAD.itemsize
        table[:, begin:end] = heads[channel_id]
        table[:, end : end + messages.itemsize] = _bytes(messages)
        head = table.view(layout)[:, 0][f'head {channel_id}']
        head['log_time'] = head['publish_time'] = stamps_ns


def _bytes(messages):
    return messages.view(np.uint8).reshape(len(messages), messages.itemsize)


@cache
def _tick_layout(lengths):
    """Return the dtype of a tick with messages (channel, length), and each one's constant head."""
    fields, heads = [], {}
    for channel_id, length in lengths:
        fields += [(f'head {channel_id}', HEAD), (f'data {channel_id}', np.void, length)]
        head = np.zeros((), HEAD)
        head['opcode'] = Opcode.MESSAGE
        head['length'] = HEAD.itemsize - 9 + length
        head['channel_id'] = channel_id
        heads[channel_id] = np.frombuffer(head.tobytes(), np.uint8)
    return np.dtype(fields), heads

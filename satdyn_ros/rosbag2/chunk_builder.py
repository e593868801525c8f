"""
Builds chunks with NumPy, with the messages of many ticks at once.

All messages of a topic have one length, so ticks are the rows of a table.  Messages of topics that
do not have one at every tick go between the rows.
"""

from collections import defaultdict
from collections.abc import Mapping
from typing import Any

import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Message, Schema

from ..messages.sparse import SparseMessages
from .chunk import CHUNK_SIZE, HEAD, scatter
from .tick_table import TickTable


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
        self._entries = {i: _joined(entries[i]) for i in sorted(entries)}
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
        self._data, self._size = self._buffer, 0
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

    @property
    def _free(self):
        return max(CHUNK_SIZE - self._size, 0)

    def add_declaration(self, record: Schema | Channel) -> None:
        """Append a schema or a channel."""
        declared: dict[int, Any] = self._schemas if isinstance(record, Schema) else self._channels
        declared[record.id] = record
        self._add_record(record)

    def add_message(self, channel_id: int, stamp_ns: int, data: bytes) -> None:
        """Append one message."""
        self._note(channel_id, np.array([stamp_ns]), np.array([self._size]))
        self._add_record(Message(channel_id, stamp_ns, data, publish_time=stamp_ns, sequence=0))

    def add_ticks(
        self,
        stamps_ns: np.ndarray,
        table: TickTable,
        some: Mapping[int, SparseMessages] | None = None,
    ) -> int:
        """
        Append the messages of ticks until the chunk is full; return how many ticks were added.

        stamps_ns (N,); table: of N ticks, stamped so, and which must not change until the chunk is
        taken.  some: by channel messages at some of the ticks, which follow.
        """
        size = table.records.shape[1]
        # No more fit, whatever else comes between them.
        stamps_ns = stamps_ns[: max(1, -(-self._free // max(size, 1)))]
        between = {i: row[: len(stamps_ns)] for i, row in (some or {}).items()}
        between = {i: row for i, row in between.items() if len(row.rows)}
        if between:
            return self._add_with_others(stamps_ns, table, between)
        count, first = len(stamps_ns), self._size
        table = table[:count]
        records = table.records.reshape(-1)
        if self.is_empty and len(records) >= CHUNK_SIZE:
            # The chunk is rows of the table: nothing needs to be copied.
            self._data, self._size = records, len(records)
        else:
            self._take(len(records))[:] = records
        self._note_ticks(table, stamps_ns, first + np.arange(count) * size)
        return count

    def _add_with_others(self, stamps_ns, table, some):
        sizes = np.full(len(stamps_ns), table.records.shape[1])
        for row in some.values():
            sizes[row.places] += HEAD.itemsize + row.rows.itemsize
        ends = np.cumsum(sizes)
        count = min(len(stamps_ns), 1 + int(np.searchsorted(ends, self._free)))
        first = self._size
        block = self._take(int(ends[count - 1]))
        begins = ends[:count] - sizes[:count]
        parts = [(np.arange(count), table[:count])]
        for channel_id, row in some.items():
            fits = row[:count]
            part = TickTable.of(len(fits.places), {channel_id: fits.rows})
            part.stamp(stamps_ns[fits.places])
            parts.append((fits.places, part))
        for places, part in parts:
            self._note_ticks(part, stamps_ns[places], first + begins[places])
            scatter(block, begins[places], part.records)
            begins[places] += part.records.shape[1]
        return count

    def whole(self, table: TickTable) -> int:
        """
        Return how many ticks of a table that was added to end with a full chunk, at most all.

        They are laid out without a copy of a part of a chunk.  All, if they do not fill the chunk.
        """
        size = max(table.records.shape[1], 1)
        first, each = -(-self._free // size), -(-CHUNK_SIZE // size)
        most = len(table)
        return most if most < first else first + (most - first) // each * each

    def take(self) -> BuiltContents:
        """Return the contents, valid until the next record is added, and start a new chunk."""
        data, declarations = self._data[: self._size], (self._schemas, self._channels)
        contents = BuiltContents(data, self._entries, declarations)
        self._begin()
        return contents

    def _add_record(self, record):
        builder = RecordBuilder()
        record.write(builder)
        data = builder.end()
        self._take(len(data))[:] = np.frombuffer(data, np.uint8)

    def _note_ticks(self, table, stamps_ns, begins):
        """Note where the messages of ticks are that begin at `begins`."""
        for channel_id, (place, _) in table.places.items():
            self._note(channel_id, stamps_ns, begins + (place - HEAD.itemsize))

    def _note(self, channel_id, stamps_ns, begins):
        """Note log times and offsets of messages of a channel."""
        entries = np.empty((len(begins), 2), np.uint64)
        entries[:, 0], entries[:, 1] = stamps_ns, begins
        self._entries[channel_id].append(entries)

    def _take(self, size):
        end = self._size + size
        if end > len(self._data):
            self._buffer = np.concatenate([self._data[: self._size], np.empty(end, np.uint8)])
            self._data = self._buffer
        place = self._data[self._size : end]
        self._size = end
        return place


def _joined(parts):
    return parts[0] if len(parts) == 1 else np.concatenate(parts)

"""
Builds chunks with NumPy, with the messages of many ticks at once.

All messages of a topic have one length, so ticks are the rows of a table.  Messages of topics that
do not have one at every tick go between the rows.
"""

from collections.abc import Mapping

import numpy as np
from mcap.records import Channel, Message, Schema
from numpy.lib.stride_tricks import sliding_window_view

from ..base.sparse import SparseMessages
from .chunk import CHUNK_SIZE, HEAD
from .records import written
from .tick_table import TickTable


class ChunkBuilder:
    """The contents of the current chunk; full once they reach the size of a chunk."""

    def __init__(self):
        self._buffer = np.empty(2 * CHUNK_SIZE, np.uint8)
        self._data, self._size = self._buffer, 0

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

    def add(self, record: Schema | Channel | Message) -> None:
        """Append a record."""
        data = written([record])
        self._take(len(data))[:] = np.frombuffer(data, np.uint8)

    def add_message(self, channel_id: int, stamp_ns: int, data: bytes) -> None:
        """Append one message."""
        self.add(Message(channel_id, stamp_ns, data, publish_time=stamp_ns, sequence=0))

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
        count = len(stamps_ns)
        records = table[:count].records.reshape(-1)
        if self.is_empty and len(records) >= CHUNK_SIZE:
            # The chunk is rows of the table: nothing needs to be copied.
            self._data, self._size = records, len(records)
        else:
            self._take(len(records))[:] = records
        return count

    def _add_with_others(self, stamps_ns, table, some):
        sizes = np.full(len(stamps_ns), table.records.shape[1])
        for row in some.values():
            sizes[row.indices] += HEAD.itemsize + row.rows.itemsize
        ends = np.cumsum(sizes)
        count = min(len(stamps_ns), 1 + int(np.searchsorted(ends, self._free)))
        block = self._take(int(ends[count - 1]))
        begins = ends[:count] - sizes[:count]
        parts = [(np.arange(count), table[:count])]
        for channel_id, row in some.items():
            fits = row[:count]
            part = TickTable.of(len(fits.indices), {channel_id: fits.rows})
            part.stamp(stamps_ns[fits.indices])
            parts.append((fits.indices, part))
        for indices, part in parts:
            size = part.records.shape[1]
            if len(indices):
                rows = sliding_window_view(block, size, writeable=True)
                rows[begins[indices]] = part.records
            begins[indices] += size
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

    def take(self) -> np.ndarray:
        """Return the contents, valid until the next record is added, and start a new chunk."""
        data = self._data[: self._size]
        self._data, self._size = self._buffer, 0
        return data

    def _take(self, size):
        end = self._size + size
        if end > len(self._data):
            self._buffer = np.concatenate([self._data[: self._size], np.empty(end, np.uint8)])
            self._data = self._buffer
        piece = self._data[self._size : end]
        self._size = end
        return piece

"""The messages of ticks as a chunk holds them: for each tick a row of heads and messages."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from mcap.opcode import Opcode

from .chunk import HEAD
from .records import PREFIX


@dataclass(frozen=True, eq=False)
class TickTable:
    """
    N ticks with a message on each of some channels, in one piece.

    records (N, size) uint8: the bytes in a chunk.  fields: by channel, in order, where in a row
    its message begins, and the dtype of the message.  A slice is by ticks, of the same bytes.
    """

    records: np.ndarray
    fields: Mapping[int, tuple[int, np.dtype]]

    @classmethod
    def of(cls, count: int, messages: Mapping[int, np.ndarray]) -> 'TickTable':
        """
        Return a table of count ticks, without stamps.

        messages: by channel those of all ticks, (count,), or one that each tick begins with, (1,).
        """
        fields, size = {}, 0
        for channel_id, some in messages.items():
            fields[channel_id] = size + HEAD.itemsize, some.dtype
            size += HEAD.itemsize + some.itemsize
        table = cls(np.empty((count, size), np.uint8), fields)
        for channel_id, some in messages.items():
            length = HEAD.itemsize - PREFIX.size + some.itemsize
            table.heads(channel_id)[:] = Opcode.MESSAGE, length, channel_id, 0, 0, 0
            begin, _ = fields[channel_id]
            table.records[:, begin : begin + some.itemsize] = some.view(np.uint8).reshape(
                len(some), some.itemsize
            )
        return table

    def __len__(self) -> int:
        return len(self.records)

    def __getitem__(self, ticks: slice) -> 'TickTable':
        return TickTable(self.records[ticks], self.fields)

    def heads(self, channel_id: int) -> np.ndarray:
        """Return the heads of a channel's messages (N,), to be read or written."""
        return self._view(self.fields[channel_id][0] - HEAD.itemsize, HEAD)

    def messages(self, channel_id: int) -> np.ndarray:
        """Return a channel's messages (N,), to be read or written."""
        return self._view(*self.fields[channel_id])

    def stamp(self, stamps_ns: np.ndarray) -> None:
        """Write the times (N,) of the ticks into all heads."""
        times = stamps_ns.astype(HEAD['log_time'])
        for channel_id in self.fields:
            heads = self.heads(channel_id)
            heads['log_time'] = heads['publish_time'] = times

    def _view(self, begin, dtype):
        return self.records[:, begin : begin + dtype.itemsize].view(dtype)[:, 0]

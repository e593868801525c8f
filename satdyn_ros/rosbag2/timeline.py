"""The messages of a complete file in the order of their log times, chunk by chunk."""

import heapq
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.summary import Summary

from .budget import Budget
from .chunk import Contents
from .compression import CEILING
from .errors import Damaged
from .records import PREFIX, read
from .scan import Block, scan

# If this much of a file covers the same log times, its chunks do not give an order to play in.
_MOST_AT_ONCE = 2**30
# Messages of a chunk that are Python objects at a time: a chunk may hold millions of small ones.
_MOST_LISTED = 8192
# A channel has a number of two bytes.
_CHANNEL_IDS = 2**16


class LoggedMessage(NamedTuple):
    """A message: its log time, its topic and its bytes."""

    log_time_ns: int
    topic: str
    data: bytes


class _Place(NamedTuple):
    """Where messages are in a file, and the range of their log times."""

    first_ns: int
    last_ns: int
    start: int
    end: int
    is_chunk: bool


class Timeline:
    """
    A complete file to play; summary: that at its end.

    Damaged, here and while reading: the file is not as it was written.
    """

    def __init__(self, path: Path, summary: Summary):
        self._path = path
        self._topics = {i: channel.topic for i, channel in summary.channels.items()}
        self._places = [
            _Place(
                index.message_start_time,
                index.message_end_time,
                index.chunk_start_offset,
                index.chunk_start_offset + index.chunk_length,
                is_chunk=True,
            )
            for index in summary.chunk_indexes
        ]
        if not self._places:
            self._places = list(self._loose_places())
        self._places.sort(key=lambda place: place.start)
        for before, place in pairwise(self._places):
            if place.start < before.end:
                raise Damaged(
                    f'{path} is damaged: its summary has two chunks at byte {place.start}'
                )

    def messages(self, topics: list[str], from_ns: int) -> Iterator[LoggedMessage]:
        """Yield the messages of topics whose log time is not before from_ns."""
        is_wanted = np.zeros(_CHANNEL_IDS, bool)
        is_wanted[[i for i, topic in self._topics.items() if topic in topics]] = True
        self._budget = Budget(self._path.stat().st_size)
        self._at_once = 0
        # Places by the log time of their next message, which those that were not read yet have not
        # before their first; of equal ones the first in the file.
        waiting: list[tuple[int, int, Iterator[LoggedMessage], LoggedMessage | None]] = [
            (place.first_ns, place.start, self._in_order(place, is_wanted, from_ns), None)
            for place in self._places
            if place.last_ns >= from_ns
        ]
        heapq.heapify(waiting)
        while waiting:
            _, start, following, message = waiting[0]
            if message is not None:
                yield message
            after = next(following, None)
            if after is None:
                heapq.heappop(waiting)
            else:
                heapq.heapreplace(waiting, (after.log_time_ns, start, following, after))

    def _in_order(
        self, place: _Place, is_wanted: np.ndarray, from_ns: int
    ) -> Iterator[LoggedMessage]:
        """Yield the messages at a place of the channels that are wanted."""
        contents = self._contents(place)
        self._at_once += len(contents.data)
        if self._at_once > _MOST_AT_ONCE:
            raise Damaged(
                f'{self._path} has more than {_MOST_AT_ONCE} bytes of messages at the same log '
                'times'
            )
        wanted = is_wanted[contents.channel_ids] & (contents.log_times >= from_ns)
        places = np.flatnonzero(wanted)
        places = places[np.argsort(contents.log_times[places], kind='stable')]
        for begin in range(0, len(places), _MOST_LISTED):
            some = places[begin : begin + _MOST_LISTED]
            log_times, ids = contents.log_times[some].tolist(), contents.channel_ids[some].tolist()
            for log_time_ns, channel_id, data in zip(
                log_times, ids, contents.data_at(some), strict=True
            ):
                yield LoggedMessage(log_time_ns, self._topics[channel_id], bytes(data))
        self._at_once -= len(contents.data)

    def _loose_places(self) -> Iterator[_Place]:
        """Yield the places of messages in a file without chunks."""
        for found in scan(self._path):
            item = found.sound(self._path).item
            if isinstance(item, Block) and len(item.contents):
                is_chunk = item.chunk is not None
                yield _Place(*item.contents.span_ns, found.start, found.end, is_chunk)

    def _contents(self, place: _Place) -> Contents:
        """Return the messages at a place."""
        length = place.end - place.start - PREFIX.size
        with open(self._path, 'rb') as file:
            file.seek(min(place.start, self._path.stat().st_size))
            data = file.read(PREFIX.size + max(0, min(length, CEILING)))
        if not place.is_chunk:
            return Contents(np.frombuffer(data, np.uint8))
        what = f'{self._path} is damaged: the Chunk record at byte {place.start}'
        if PREFIX.unpack(data[: PREFIX.size].ljust(PREFIX.size)) != (Opcode.CHUNK, length):
            raise Damaged(f'{what} is not where the summary places it')
        try:
            chunk = read(Opcode.CHUNK, data[PREFIX.size :])
            assert isinstance(chunk, Chunk)  # by its opcode
            return Contents.of(chunk, self._budget)
        except Damaged as error:
            raise Damaged(f'{what}: {error}') from None

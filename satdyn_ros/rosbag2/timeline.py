"""The messages of a complete file in the order of their log times, chunk by chunk."""

import heapq
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode

from .chunk import Contents
from .compression import CEILING, ResourceBudget
from .errors import Damaged
from .frames import FrameReader
from .records import PREFIX, ChunkRecord
from .scan import Block, Flaw, scan
from .summary import Summary

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

    ceiling [bytes]: no chunk is read that holds more.  Damaged, here and while reading: the file
    is not as it was written.
    """

    def __init__(self, path: Path, summary: Summary, ceiling: int = CEILING):
        self._path = path
        self._ceiling = ceiling
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
        self._places.sort()

    def messages(self, topics: list[str], from_ns: int) -> Iterator[LoggedMessage]:
        """Yield the messages of topics whose log time is not before from_ns."""
        is_wanted = np.zeros(_CHANNEL_IDS, bool)
        is_wanted[[i for i, topic in self._topics.items() if topic in topics]] = True
        coming = [place for place in reversed(self._places) if place.last_ns >= from_ns]
        budget = ResourceBudget(self._path.stat().st_size)
        at_once = 0
        # Open places by the log time of their next message; of equal ones the first in the file.
        is_open: list[tuple[int, int, int, Iterator[LoggedMessage], LoggedMessage]] = []
        while coming or is_open:
            while coming and (not is_open or coming[-1].first_ns <= is_open[0][0]):
                place = coming.pop()
                contents = self._contents(place, budget)
                at_once += len(contents.data)
                if at_once > _MOST_AT_ONCE:
                    raise Damaged(
                        f'{self._path} has more than {_MOST_AT_ONCE} bytes of messages at the '
                        'same log times'
                    )
                following = self._in_order(contents, is_wanted, from_ns)
                size = len(contents.data)
                first = next(following, None)
                if first is None:
                    at_once -= size
                else:
                    entry = (first.log_time_ns, place.start, size, following, first)
                    heapq.heappush(is_open, entry)
            if not is_open:
                continue
            _, start, size, following, message = is_open[0]
            yield message
            after = next(following, None)
            if after is None:
                heapq.heappop(is_open)
                at_once -= size
            else:
                heapq.heapreplace(is_open, (after.log_time_ns, start, size, following, after))

    def _in_order(
        self, contents: Contents, is_wanted: np.ndarray, from_ns: int
    ) -> Iterator[LoggedMessage]:
        """Yield the messages in a chunk of the channels that are wanted."""
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

    def _loose_places(self) -> Iterator[_Place]:
        """Yield the places of messages in a file without chunks."""
        for found in scan(self._path, self._ceiling):
            if isinstance(found.item, Flaw):
                raise Damaged(f'{self._path} {found.item.what}')
            if isinstance(found.item, Block) and len(found.item.contents):
                span_ns = found.item.contents.span_ns
                is_chunk = found.item.chunk is not None
                yield _Place(*span_ns, found.start, found.end, is_chunk)

    def _contents(self, place: _Place, budget: ResourceBudget) -> Contents:
        with open(self._path, 'rb') as file:
            reader = FrameReader(file, self._ceiling)
            if not place.is_chunk:
                return Contents(np.frombuffer(reader.read(*_range(place)), np.uint8))
            opcode, length = PREFIX.unpack(reader.read(place.start, PREFIX.size).ljust(9, b'\0'))
            what = f'{self._path} is damaged: the Chunk record at byte {place.start}'
            if opcode != Opcode.CHUNK or place.start + PREFIX.size + length != place.end:
                raise Damaged(f'{what} is not where the summary places it')
            if length > self._ceiling:
                raise Damaged(f'{what} has {length} bytes; the limit is {self._ceiling}')
            try:
                content = reader.read(place.start + PREFIX.size, length)
                return ChunkRecord.read(content).contents(budget, self._ceiling)
            except Damaged as error:
                raise Damaged(f'{what}: {error}') from None


def _range(place: _Place) -> tuple[int, int]:
    return place.start, place.end - place.start

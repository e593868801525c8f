"""The messages of a complete file in the order of their log times, chunk by chunk."""

import heapq
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.summary import Summary

from .errors import Damaged
from .scan import Block, Flaw, Scanner, scan


class LoggedMessage(NamedTuple):
    """A message: its log time, its topic and its bytes."""

    log_time_ns: int
    topic: str
    data: bytes


class _Span(NamedTuple):
    """The span of a file that messages are in, and the range of their log times."""

    first_ns: int
    last_ns: int
    start: int
    end: int


class Timeline:
    """
    A complete file to play; summary: that at its end.

    Damaged, here and while reading: the file is not as it was written.
    """

    def __init__(self, path: Path, summary: Summary):
        self._path = path
        self._topics = {i: channel.topic for i, channel in summary.channels.items()}
        spans = {
            _Span(
                index.message_start_time,
                index.message_end_time,
                index.chunk_start_offset,
                index.chunk_start_offset + index.chunk_length,
            )
            for index in summary.chunk_indexes
        }
        self._spans = sorted(spans or self._loose_spans(), key=lambda span: span.start)

    def messages(self, topics: list[str], from_ns: int) -> Iterator[LoggedMessage]:
        """Yield the messages of topics whose log time is not before from_ns."""
        channel_ids = [i for i, topic in self._topics.items() if topic in topics]
        with open(self._path, 'rb') as file:
            scanner = Scanner(self._path, file)
            spans = [span for span in self._spans if span.last_ns >= from_ns]
            in_order = [self._in_order(span, scanner, channel_ids, from_ns) for span in spans]
            # Of equal log times the first in the file.
            for _, message in heapq.merge(*in_order, key=itemgetter(0)):
                if message is not None:
                    yield message

    def _in_order(
        self, span: _Span, scanner: Scanner, channel_ids: list[int], from_ns: int
    ) -> Iterator[tuple[int, LoggedMessage | None]]:
        """Yield the messages of a span that are wanted, with their log times, after None."""
        # Nothing is read before its time has come.
        yield span.first_ns, None
        found = scanner.at(span.start)
        if found.end != span.end or not isinstance(found.item, Block | Flaw):
            raise Damaged(
                f'{self._path} is damaged: the Chunk record at byte {span.start} is not where '
                'the summary places it'
            )
        contents = found.sound().item.contents
        wanted = np.isin(contents.channel_ids, channel_ids) & (contents.log_times >= from_ns)
        indices = np.flatnonzero(wanted)
        indices = indices[np.argsort(contents.log_times[indices], kind='stable')]
        log_times = contents.log_times[indices].tolist()
        ids = contents.channel_ids[indices].tolist()
        rows = zip(log_times, ids, contents.data_at(indices), strict=True)
        for log_time_ns, channel_id, data in rows:
            topic = self._topics[channel_id]
            yield log_time_ns, LoggedMessage(log_time_ns, topic, bytes(data))

    def _loose_spans(self) -> Iterator[_Span]:
        """Yield the spans of messages in a file without chunks."""
        for found in scan(self._path):
            item = found.sound().item
            if isinstance(item, Block) and len(item.contents):
                yield _Span(*item.contents.span_ns, found.start, found.end)

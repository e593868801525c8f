"""Writes a rosbag2 bag during a run: never half a record, never more than one flush behind."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import mcap
import numpy as np
from mcap.records import Channel, Header, Metadata, Schema

from .. import __version__
from ..base.sparse import Rows, SparseMessages, dense_and_sparse
from . import metadata
from .chunk import Contents
from .chunk_builder import ChunkBuilder
from .compression import COMPRESSIONS, compressor
from .mcap_file import McapFile
from .metadata import BagMetadata, TopicMetadata
from .summary import SummaryBuilder
from .tick_table import TickTable

_HEADER = Header('ros2', f'satdyn_ros {__version__}; mcap-python {mcap.__version__}')
_NEVER = 2**62


class BagWriter:
    """
    Write a bag into a new directory: <name>_0.mcap, <name>_1.mcap ... and metadata.yaml.

    topics: what is recorded; those without messages are listed too.  max_size_bytes,
    max_duration_s: a new file begins when the current one has reached this size, or would span
    more than this time; 0: never.  preamble: metadata records, by name, with which every
    file begins; metadata.yaml carries their content too.  latched: messages, by topic, that each
    file has ahead of its first tick.

    file_count: how many files were begun.

    For use by one thread.  Writes reach the system at flush(), and the bag is complete after
    close().  OSError: the directory exists or cannot be written; nothing more is then written to
    the bag, and what was written can be recovered.
    """

    def __init__(
        self,
        directory: str | Path,
        topics: Sequence[TopicMetadata],
        *,
        compression: str = 'zstd',
        max_size_bytes: int = 0,
        max_duration_s: float = 0,
        preamble: Mapping[str, Mapping[str, str]] | None = None,
        latched: Mapping[str, bytes] | None = None,
    ):
        if compression not in COMPRESSIONS:
            known = ', '.join(COMPRESSIONS)
            raise ValueError(f'record.compression is {compression!r}; allowed: {known}')
        self.directory = Path(directory)
        self._schemas: dict[str, Schema] = {}
        self._channels: dict[str, Channel] = {}
        self._compression = '' if compression == 'none' else compression
        self._compress = compressor(self._compression)
        self._max_size_bytes = max_size_bytes or _NEVER
        self._max_duration_ns = round(max_duration_s * 1e9) or _NEVER
        self._preamble = dict(preamble or {})
        self._latched = dict(latched or {})
        custom_data = {k: v for record in self._preamble.values() for k, v in record.items()}
        self._metadata = BagMetadata(custom_data)
        self._first_ns = _NEVER
        self._chunk = ChunkBuilder()
        self._wants_snapshot = True
        self._why_ended: str | None = None
        self.file_count = self._finished_bytes = 0
        self._make_directory()
        with self._in_one_sentence():
            self._begin_file()
        for topic in topics:
            self.add_topic(topic)

    @property
    def size_bytes(self) -> int:
        """The size of the bag's files, as far as they are written."""
        return self._finished_bytes + self._file.size

    def add_topic(self, topic: TopicMetadata) -> None:
        """Add a topic; one already added stays as it is."""
        if topic.name in self._channels:
            return
        schema_id = len(self._schemas) + 1
        schema = self._schemas.setdefault(topic.type, topic.schema_record(schema_id))
        channel = topic.channel_record(len(self._channels) + 1, schema.id)
        self._channels[topic.name] = channel
        self._file.summary.schemas[schema.id] = schema
        self._file.summary.channels[channel.id] = channel

    def write(
        self,
        stamps_ns: np.ndarray,
        rows: Mapping[str, Rows],
        snapshot: Callable[[int], tuple[str, Mapping[str, str]]] | None = None,
    ) -> None:
        """
        Write the messages of ticks.

        stamps_ns (N,); rows: by topic N rows of one message's bytes each, or SparseMessages.  The
        topics of a tick follow each other as in rows, SparseMessages after the others.
        snapshot(i): name and content of a metadata record for a file that begins with tick i of
        these.
        """
        full, some = dense_and_sparse(rows)
        self.write_ticks(stamps_ns, self.table(len(stamps_ns), full), some, snapshot)

    def table(self, count: int, rows: Mapping[str, np.ndarray]) -> TickTable:
        """Return the table for write_ticks of count ticks; rows: by topic, as in TickTable.of."""
        by_channel = {self._channels[topic].id: row for topic, row in rows.items()}
        return TickTable.of(count, by_channel)

    def write_ticks(
        self,
        stamps_ns: np.ndarray,
        table: TickTable,
        some: Mapping[str, SparseMessages],
        snapshot: Callable[[int], tuple[str, Mapping[str, str]]] | None = None,
    ) -> int:
        """
        As write(), with messages that were packed in place, those of every tick in a table.

        table: of N ticks or more, which may be packed into again afterwards.  Return how many
        ticks of it are best written next, at most all: as many as end with a full chunk.
        """
        with self._in_one_sentence():
            if not (table.fields or some):
                if len(stamps_ns):
                    self._write_snapshot(snapshot, 0, int(stamps_ns[0]))
                return len(table)
            table[: len(stamps_ns)].stamp(stamps_ns)
            done = 0
            while done < len(stamps_ns):
                if self._file_is_full(int(stamps_ns[done])):
                    self._end_file()
                    self._finished_bytes += self._file.size
                    self._begin_file()
                self._write_snapshot(snapshot, done, int(stamps_ns[done]))
                last_ns = min(self._first_ns, int(stamps_ns[done])) + self._max_duration_ns
                fits = slice(done, np.searchsorted(stamps_ns, last_ns, side='right'))
                between = {topic: row[fits] for topic, row in some.items()}
                done += self._add_ticks(stamps_ns[fits], table[fits], between)
            return self._chunk.whole(table)

    def write_message(self, topic: str, stamp_ns: int, data: bytes) -> None:
        """Write one message, such as an input ahead of the messages of its tick."""
        with self._in_one_sentence():
            self._chunk.add_message(self._declared(topic), stamp_ns, data)
            self._first_ns = min(self._first_ns, stamp_ns)
            if self._chunk.is_full:
                self._end_chunk()

    def write_metadata(
        self, name: str, mapping: Mapping[str, str], ends_chunk: bool = True
    ) -> None:
        """
        Write a metadata record, after everything written so far.

        ends_chunk: False for one that may stand before the messages of the current chunk, which
        then goes on.
        """
        with self._in_one_sentence():
            if ends_chunk:
                self._end_chunk()
            self._file.write_metadata(name, mapping)

    def flush(self) -> None:
        """Hand everything written to the system, so that it survives the process."""
        with self._in_one_sentence():
            self._end_chunk()

    def close(self) -> None:
        """Complete the bag; after a write error, do nothing."""
        if self._why_ended:
            return
        with self._in_one_sentence():
            self._end_file()
            self._metadata.write(self.directory)
        self._why_ended = f'the bag {self.directory} is closed'

    def _make_directory(self):
        try:
            self.directory.resolve().name.encode()
            self.directory.mkdir(parents=True)
        except UnicodeEncodeError:
            raise OSError(
                f'the bag {self.directory} cannot be created: its name is not UTF-8'
            ) from None
        except FileExistsError as error:
            raise FileExistsError(
                f'{self.directory} already exists; a bag needs a new directory'
            ) from error
        except OSError as error:
            raise type(error)(
                f'the bag {self.directory} cannot be created: {error.strerror}'
            ) from error

    @contextmanager
    def _in_one_sentence(self):
        """Turn an error of the system into one sentence; nothing more is written after it."""
        if self._why_ended:
            raise OSError(self._why_ended)
        try:
            yield
        except OSError as error:
            self._why_ended = (
                f'the bag {self.directory} can no longer be written: {error.strerror}; '
                'satdyn recover completes it'
            )
            raise OSError(self._why_ended) from error

    def _write_snapshot(self, snapshot, row, stamp_ns):
        """Write the snapshot of the first tick of a file, and what is latched."""
        if self._wants_snapshot and snapshot is not None:
            self._end_chunk()
            self._file.write_metadata(*snapshot(row))
            self._wants_snapshot = False
            for topic, data in self._latched.items():
                self.write_message(topic, stamp_ns, data)

    def _begin_file(self) -> None:
        name = f'{self.directory.resolve().name}_{self.file_count}.mcap'
        self.file_count += 1
        opening = {metadata.NAME: self._metadata.record(name, SummaryBuilder()), **self._preamble}
        records = [Metadata(name, dict(mapping)) for name, mapping in opening.items()]
        self._file = McapFile(self.directory / name, _HEADER, records)
        self._file.summary.schemas |= {schema.id: schema for schema in self._schemas.values()}
        self._file.summary.channels |= {channel.id: channel for channel in self._channels.values()}
        self._in_file: set[str] = set()
        self._first_ns = _NEVER
        self._wants_snapshot = True

    def _end_file(self):
        self._end_chunk()
        name, summary = self._file.path.name, self._file.summary
        self._metadata.add(name, summary)
        self._file.write_metadata(metadata.NAME, self._metadata.record(name, summary))
        self._file.finish()

    def _file_is_full(self, stamp_ns):
        has_messages = self._first_ns != _NEVER
        spans_ns = stamp_ns - self._first_ns
        return has_messages and (self._file_is_too_large or spans_ns > self._max_duration_ns)

    @property
    def _file_is_too_large(self):
        return self._file.size >= self._max_size_bytes

    def _add_ticks(self, stamps_ns, table, some):
        """Write the ticks until the file is too large; return how many."""
        channels = self._file.summary.channels
        topics = [channels[channel_id].topic for channel_id in table.fields]
        for topic in topics:
            self._declared(topic)
        between = {self._declared(topic): rows for topic, rows in some.items()}
        done = 0
        while done == 0 or (done < len(stamps_ns) and not self._file_is_too_large):
            rest = {channel_id: rows[done:] for channel_id, rows in between.items()}
            done += self._chunk.add_ticks(stamps_ns[done:], table[done:], rest)
            if self._chunk.is_full:
                self._end_chunk()
        firsts = [*stamps_ns[: 1 if topics else 0]]
        firsts += [stamps_ns[i] for rows in some.values() for i in rows[:done].indices[:1]]
        self._first_ns = min([self._first_ns, *map(int, firsts)])
        return done

    def _declared(self, topic):
        """Return a topic's channel; a file declares it before its first message."""
        channel = self._channels[topic]
        schema = self._file.summary.schemas[channel.schema_id]
        for key, record in ((schema.name, schema), (topic, channel)):
            if key not in self._in_file:
                self._chunk.add(record)
                self._in_file.add(key)
        return channel.id

    def _end_chunk(self):
        if not self._chunk.is_empty:
            contents = Contents(self._chunk.take())
            self._file.write_chunk(contents, self._compression, self._compress(contents.data))

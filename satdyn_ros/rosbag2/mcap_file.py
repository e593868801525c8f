"""One MCAP file, written record by record in the order of rosbag2."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

from .chunk import Contents


class McapFile:
    """
    A file that is complete after finish(); what was written before is with the system at once.

    schemas, channels: what the summary lists, by id.  statistics, metadata_names, size [bytes]: of
    what was written so far.  OSError: the file exists, or cannot be written.
    """

    def __init__(self, path: Path, header: Header):
        self.path = path
        self.size = 0
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.statistics = Statistics(0, 0, {}, 0, 0, 0, 0, 0, 0)
        self.metadata_names: list[str] = []
        self._chunk_indexes = RecordBuilder()
        self._metadata_indexes = RecordBuilder()
        self._file = open(path, 'xb', buffering=0)  # noqa: SIM115
        self._write(MCAP0_MAGIC)
        self._write_record(header)

    def write_metadata(self, name: str, mapping: dict[str, str]) -> None:
        """Write a metadata record."""
        start = self.size
        self._write_record(Metadata(name, mapping))
        MetadataIndex(start, self.size - start, name).write(self._metadata_indexes)
        self.metadata_names.append(name)
        self.statistics.metadata_count += 1

    def write_chunk(self, contents: np.ndarray, compression: str, compressed: bytes) -> None:
        """
        Write a chunk of contents (N,) uint8 and the index of its messages.

        compressed: the same by compression, 'zstd', 'lz4' or '' for none.
        """
        parsed = Contents(contents)
        first_ns, last_ns = parsed.span_ns
        name = compression.encode()
        fields = struct.pack(
            f'<QQQII{len(name)}sQ',
            first_ns,
            last_ns,
            len(contents),
            zlib.crc32(contents.data),
            len(name),
            name,
            len(compressed),
        )
        start = self.size
        # A record builder of mcap would copy the compressed bytes twice.
        self._write(struct.pack('<BQ', Opcode.CHUNK, len(fields) + len(compressed)) + fields)
        self._write(compressed)
        index_start = self.size
        indexes, index_offsets = _message_indexes(parsed, index_start)
        self._write(indexes)
        ChunkIndex(
            message_start_time=first_ns,
            message_end_time=last_ns,
            chunk_start_offset=start,
            chunk_length=index_start - start,
            message_index_offsets=index_offsets,
            message_index_length=len(indexes),
            compression=compression,
            compressed_size=len(compressed),
            uncompressed_size=len(contents),
        ).write(self._chunk_indexes)
        self._count(parsed)

    def finish(self) -> None:
        """Write the summary and close the file, its bytes on the disk."""
        self._write_record(DataEnd(0))
        summary_start = self.size
        summary = RecordBuilder()
        offsets = RecordBuilder()
        self.statistics.schema_count = len(self.schemas)
        self.statistics.channel_count = len(self.channels)
        for opcode, records in (
            (Opcode.SCHEMA, _written(self.schemas.values())),
            (Opcode.CHANNEL, _written(self.channels.values())),
            (Opcode.STATISTICS, _written([self.statistics])),
            (Opcode.CHUNK_INDEX, self._chunk_indexes.end()),
            (Opcode.METADATA_INDEX, self._metadata_indexes.end()),
        ):
            if records:
                group_start = summary_start + summary.count
                SummaryOffset(opcode, group_start, len(records)).write(offsets)
                summary.write(records)
        offset_start = summary_start + summary.count
        summary.write(offsets.end())
        # The checksum takes in the footer up to the place where it is written itself.
        footer = struct.pack('<BQQQ', Opcode.FOOTER, 8 + 8 + 4, summary_start, offset_start)
        records = summary.end()
        crc = zlib.crc32(footer, zlib.crc32(records))
        self._write(records)
        self._write_record(Footer(summary_start, offset_start, crc))
        self._write(MCAP0_MAGIC)
        os.fsync(self._file.fileno())
        self.close()

    @property
    def is_closed(self) -> bool:
        """Whether the file takes no more."""
        return self._file.closed

    def close(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def _count(self, contents):
        """Take what a chunk declares and holds into the summary."""
        schemas, channels = contents.declarations()
        self.schemas |= schemas
        self.channels |= channels
        statistics, (first_ns, last_ns) = self.statistics, contents.span_ns
        statistics.chunk_count += 1
        if len(contents) == 0:
            return
        if statistics.message_count == 0:
            statistics.message_start_time = first_ns
        statistics.message_start_time = min(statistics.message_start_time, first_ns)
        statistics.message_end_time = max(statistics.message_end_time, last_ns)
        statistics.message_count += len(contents)
        counts = statistics.channel_message_counts
        for channel_id, count in contents.counts.items():
            counts[channel_id] = counts.get(channel_id, 0) + count

    def _write_record(self, record: McapRecord):
        self._write(_written([record]))

    def _write(self, data):
        rest = memoryview(data)
        while rest:
            written = self._file.write(rest)
            self.size += written
            rest = rest[written:]


def _written(records) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()


def _message_indexes(contents: Contents, start: int) -> tuple[bytearray, dict[int, int]]:
    """Return the index records of a chunk's messages and where in the file each channel's is."""
    records, offsets = bytearray(), {}
    for channel_id in contents.counts:
        # Numbers of this machine are those of the file, little endian.
        entries = contents.index_of(channel_id)
        offsets[channel_id] = start + len(records)
        size = entries.nbytes
        records += struct.pack('<BQHI', Opcode.MESSAGE_INDEX, 2 + 4 + size, channel_id, size)
        records += entries.data
    return records, offsets

"""
The summary at the end of a file, built up while the data are written or read.

Writing a file, and checking one against its data, use the same summary.
"""

import io
import os
import struct
import zlib
from collections.abc import Iterable
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import StreamReader
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC

from ..base.regular_file import regular_file
from .chunk import Contents
from .errors import Damaged, Incomplete
from .records import PREFIX, UNREADABLE, written

# A MessageIndex: opcode, length, channel and size of the entries, each a log time and an offset.
INDEX_HEAD = struct.Struct('<BQHI')
INDEX_ENTRY_SIZE = 16
# How a file ends, without a summary.
_END = written([Footer(0, 0, 0)]) + MCAP0_MAGIC


class SummaryBuilder(Summary):
    """What the summary of a file must say, given the records so far."""

    statistics: Statistics

    def __init__(self) -> None:
        super().__init__()
        self.statistics = Statistics(0, 0, {}, 0, 0, 0, 0, 0, 0)

    def add_metadata(self, start: int, length: int, name: str) -> None:
        """Add a metadata record, its offset and its whole length."""
        self.metadata_indexes.append(MetadataIndex(start, length, name))
        self.statistics.metadata_count += 1

    def add_chunk(self, start: int, end: int, chunk: Chunk, contents: Contents) -> None:
        """Add a chunk, from its start to its end, which its message indexes follow."""
        index_offsets, index_end = {}, end
        for channel_id, count in contents.counts.items():
            index_offsets[channel_id] = index_end
            index_end += INDEX_HEAD.size + INDEX_ENTRY_SIZE * count
        index = ChunkIndex(
            message_start_time=contents.span_ns[0],
            message_end_time=contents.span_ns[1],
            chunk_start_offset=start,
            chunk_length=end - start,
            message_index_offsets=index_offsets,
            message_index_length=index_end - end,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            uncompressed_size=chunk.uncompressed_size,
        )
        self.chunk_indexes.append(index)
        self.statistics.chunk_count += 1
        self.add_messages(contents)

    def add_messages(self, contents: Contents) -> None:
        """Add what messages declare, and count them."""
        schemas, channels = contents.declarations
        self.schemas |= schemas
        self.channels |= channels
        if len(contents) == 0:
            return
        statistics, (first_ns, last_ns) = self.statistics, contents.span_ns
        before_ns = statistics.message_start_time if statistics.message_count else first_ns
        statistics.message_start_time = min(before_ns, first_ns)
        statistics.message_end_time = max(statistics.message_end_time, last_ns)
        statistics.message_count += len(contents)
        counts = statistics.channel_message_counts
        for channel_id, count in contents.counts.items():
            counts[channel_id] = counts.get(channel_id, 0) + count

    def end_of_file(self, start: int) -> bytes:
        """Return what follows the data, from `start` to the end of the file."""
        self.statistics.schema_count = len(self.schemas)
        self.statistics.channel_count = len(self.channels)
        groups: dict[int, Iterable[McapRecord]] = {
            Opcode.SCHEMA: [schema for _, schema in sorted(self.schemas.items())],
            Opcode.CHANNEL: [channel for _, channel in sorted(self.channels.items())],
            Opcode.STATISTICS: [self.statistics],
            Opcode.CHUNK_INDEX: self.chunk_indexes,
            Opcode.METADATA_INDEX: self.metadata_indexes,
        }
        summary, offsets = b'', []
        for opcode, records in groups.items():
            if group := written(records):
                offsets.append(SummaryOffset(opcode, start + len(summary), len(group)))
                summary += group
        end = start + len(summary)
        summary += written(offsets)
        crc = checksum(summary, start, end)
        return summary + written([Footer(start, end, crc)]) + MCAP0_MAGIC


def checksum(summary: bytes, start: int, offset_start: int) -> int:
    """Return the checksum of a summary and of the footer up to the checksum itself."""
    footer = written([Footer(start, offset_start, 0)])
    return zlib.crc32(footer[:-4], zlib.crc32(summary))


def read_summary(path: Path) -> Summary:
    """
    Return the summary of a file, read from its end: schemas, channels, statistics and chunks.

    Incomplete: the file has none because its writer did not finish.  Damaged: its checksum is
    wrong, or it cannot be read.
    """
    with open(regular_file(path), 'rb') as file:
        end = file.seek(0, os.SEEK_END) - len(_END)
        file.seek(max(0, end))
        tail = file.read()
        has_footer, has_magic = tail.startswith(_END[: PREFIX.size]), tail.endswith(MCAP0_MAGIC)
        if end < len(MCAP0_MAGIC) or not (has_footer or has_magic):
            raise Incomplete(path)
        if not (has_footer and has_magic):
            raise Damaged(f'{path} is damaged: it does not end with a footer and the magic')
        footer = Footer.read(ReadDataStream(io.BytesIO(tail[PREFIX.size :])))
        file.seek(min(footer.summary_start or end, end))
        section = file.read()
    wanted = checksum(section[: -len(_END)], footer.summary_start, footer.summary_offset_start)
    if footer.summary_crc not in (0, wanted):
        raise Damaged(f'{path} is damaged: in its summary, its checksum is wrong')
    summary = Summary()
    try:
        for record in StreamReader(io.BytesIO(section), skip_magic=True, emit_chunks=True).records:
            match record:
                case Schema():
                    summary.schemas[record.id] = record
                case Channel():
                    summary.channels[record.id] = record
                case ChunkIndex():
                    summary.chunk_indexes.append(record)
                case Statistics():
                    summary.statistics = record
    except UNREADABLE:
        raise Damaged(f'{path} is damaged: its summary cannot be read') from None
    return summary

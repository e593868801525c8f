"""
The summary at the end of a file, built up while the data are written or read.

Writing a file, and checking one against its data, use the same summary.
"""

import os
import zlib
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
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
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC

from ..base.regular_file import regular_file
from .chunk import Contents
from .errors import Damaged, Incomplete
from .records import PREFIX, name_of, read, written

# How a file ends, without a summary.
_END = written([Footer(0, 0, 0)]) + MCAP0_MAGIC


class SummaryBuilder(Summary):
    """What the summary of a file must say, given the records so far."""

    statistics: Statistics

    def __init__(self) -> None:
        super().__init__()
        self.statistics = Statistics(0, 0, {}, 0, 0, 0, 0, 0, 0)

    def add_metadata(self, start: int, length: int, name: str) -> None:
        """Add a metadata record, its place and its whole length."""
        self.metadata_indexes.append(MetadataIndex(start, length, name))
        self.statistics.metadata_count += 1

    def add_attachment(self, start: int, length: int, attachment: Attachment) -> None:
        """Add an attachment, its place and its whole length."""
        index = AttachmentIndex(
            offset=start,
            length=length,
            create_time=attachment.create_time,
            log_time=attachment.log_time,
            data_size=len(attachment.data),
            name=attachment.name,
            media_type=attachment.media_type,
        )
        self.attachment_indexes.append(index)
        self.statistics.attachment_count += 1

    def add_chunk(
        self,
        start: int,
        end: int,
        chunk: Chunk,
        contents: Contents,
        index_offsets: dict[int, int],
        index_length: int,
    ) -> None:
        """Add a chunk, from its start to its end, and the message indexes that follow it."""
        index = ChunkIndex(
            message_start_time=chunk.message_start_time,
            message_end_time=chunk.message_end_time,
            chunk_start_offset=start,
            chunk_length=end - start,
            message_index_offsets=index_offsets,
            message_index_length=index_length,
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
        if statistics.message_count == 0:
            statistics.message_start_time = first_ns
        statistics.message_start_time = min(statistics.message_start_time, first_ns)
        statistics.message_end_time = max(statistics.message_end_time, last_ns)
        statistics.message_count += len(contents)
        counts = statistics.channel_message_counts
        for channel_id, count in contents.counts.items():
            counts[channel_id] = counts.get(channel_id, 0) + count

    def counted(self) -> Statistics:
        """Return the statistics, with the schemas and channels that are known by now."""
        return replace(
            self.statistics,
            schema_count=len(self.schemas),
            channel_count=len(self.channels),
        )

    def end_of_file(self, start: int) -> bytes:
        """Return what follows the data, from `start` to the end of the file."""
        groups: dict[int, Iterable[McapRecord]] = {
            Opcode.SCHEMA: [schema for _, schema in sorted(self.schemas.items())],
            Opcode.CHANNEL: [channel for _, channel in sorted(self.channels.items())],
            Opcode.STATISTICS: [self.counted()],
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
    Return the summary of a file, read from its end.

    Incomplete: the file has none because its writer did not finish.  Damaged: it is not what a
    writer writes.
    """
    summary = Summary()
    by_id: dict[type, dict[int, Any]] = {Schema: summary.schemas, Channel: summary.channels}
    listed: dict[type, list[Any]] = {
        ChunkIndex: summary.chunk_indexes,
        MetadataIndex: summary.metadata_indexes,
        AttachmentIndex: summary.attachment_indexes,
    }
    _, section = summary_section(path)
    place, end = 0, len(section) - len(_END)
    while place < end:
        opcode, length = PREFIX.unpack_from(section, place)
        begin = place + PREFIX.size
        place = begin + length
        if place > end:
            raise _damaged(path, 'it is cut off')
        try:
            record: Any = read(opcode, section[begin:place])
        except Damaged as error:
            raise _damaged(path, f'its {name_of(opcode)} record: {error}') from None
        kind = type(record)
        if kind in by_id:
            if by_id[kind].setdefault(record.id, record) != record:
                raise _damaged(path, f'it lists {kind.__name__} {record.id} in two ways')
        elif kind in listed:
            listed[kind].append(record)
        elif kind is Statistics:
            summary.statistics = record
        # Readers skip records that MCAP does not define.
        elif record is not None and kind is not SummaryOffset:
            raise _damaged(path, 'it holds a record that does not belong there')
    return summary


def summary_section(path: Path) -> tuple[int, bytes]:
    """
    Return where the data of a file end and what follows them, its checksum being right.

    Errors: as of read_summary.
    """
    with open(regular_file(path), 'rb') as file:
        size = file.seek(0, os.SEEK_END)
        end = size - len(_END)
        file.seek(max(0, end))
        tail = file.read()
        if end < len(MCAP0_MAGIC) or not tail.endswith(MCAP0_MAGIC):
            raise Incomplete(f'{path} ends in mid-write; satdyn recover completes it')
        if tail[: PREFIX.size] != _END[: PREFIX.size]:
            raise Damaged(f'{path} is damaged: there is no footer before its end')
        footer: Any = read(Opcode.FOOTER, tail[PREFIX.size : -len(MCAP0_MAGIC)])
        start = footer.summary_start or end
        if not len(MCAP0_MAGIC) <= start <= end:
            raise _damaged(path, f'the footer places it at byte {start}')
        file.seek(start)
        section = file.read()
    wanted = checksum(section[: end - start], footer.summary_start, footer.summary_offset_start)
    if footer.summary_crc not in (0, wanted):
        raise _damaged(path, 'its checksum is wrong')
    return start, section


def _damaged(path: Path, why: str) -> Damaged:
    return Damaged(f'{path} is damaged: in its summary, {why}')

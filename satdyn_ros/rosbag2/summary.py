"""
The summary at the end of a file, built up while the data are written or read.

Writing a file, and checking one against its data, use the same summary.
"""

import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

from ..base.regular_file import regular_file
from .chunk import Indexed
from .compression import CEILING
from .errors import Damaged, Incomplete
from .frames import FrameReader
from .records import PREFIX, ChunkRecord, name_of, read, written

FOOTER_SIZE = PREFIX.size + 8 + 8 + 4
_GROUPS = (
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.METADATA_INDEX,
)


class SummaryBuilder:
    """
    What the summary of a file must say, given the records so far.

    schemas, channels: by id.  chunk_indexes, metadata_indexes, attachment_indexes: by the place of
    what they index.
    """

    def __init__(self) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.statistics = Statistics(0, 0, {}, 0, 0, 0, 0, 0, 0)
        self.chunk_indexes: dict[int, ChunkIndex] = {}
        self.metadata_indexes: dict[int, MetadataIndex] = {}
        self.attachment_indexes: dict[int, AttachmentIndex] = {}
        self.metadata_names: list[str] = []

    def add_metadata(self, start: int, length: int, name: str) -> None:
        """Add a metadata record, its place and its whole length."""
        self.metadata_indexes[start] = MetadataIndex(start, length, name)
        self.metadata_names.append(name)
        self.statistics.metadata_count += 1

    def add_attachment(self, start: int, length: int, attachment: Attachment) -> None:
        """Add an attachment, its place and its whole length."""
        self.attachment_indexes[start] = AttachmentIndex(
            offset=start,
            length=length,
            create_time=attachment.create_time,
            log_time=attachment.log_time,
            data_size=len(attachment.data),
            name=attachment.name,
            media_type=attachment.media_type,
        )
        self.statistics.attachment_count += 1

    def add_chunk(
        self,
        start: int,
        end: int,
        chunk: ChunkRecord,
        contents: Indexed,
        index_offsets: dict[int, int],
        index_length: int,
    ) -> None:
        """Add a chunk, from its start to its end, and the message indexes that follow it."""
        self.chunk_indexes[start] = ChunkIndex(
            message_start_time=chunk.first_ns,
            message_end_time=chunk.last_ns,
            chunk_start_offset=start,
            chunk_length=end - start,
            message_index_offsets=index_offsets,
            message_index_length=index_length,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            uncompressed_size=chunk.size,
        )
        self.statistics.chunk_count += 1
        self.add_messages(contents)

    def add_messages(self, contents: Indexed) -> None:
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

    def close(self) -> None:
        """Count the schemas and channels, of which the summary may have more than the data."""
        self.statistics.schema_count = len(self.schemas)
        self.statistics.channel_count = len(self.channels)

    def end_of_file(self, start: int) -> bytes:
        """Return what follows the data, from `start` to the end of the file."""
        self.close()
        groups = (
            written(schema for _, schema in sorted(self.schemas.items())),
            written(channel for _, channel in sorted(self.channels.items())),
            written([self.statistics]),
            written(self.chunk_indexes.values()),
            written(self.metadata_indexes.values()),
        )
        offsets, end = [], start
        for opcode, group in zip(_GROUPS, groups, strict=True):
            if group:
                offsets.append(SummaryOffset(opcode, end, len(group)))
                end += len(group)
        summary = b''.join([*groups, written(offsets)])
        crc = checksum(summary, start, end)
        return summary + written([Footer(start, end, crc)]) + MCAP0_MAGIC


def checksum(summary: bytes, start: int, offset_start: int) -> int:
    """Return the checksum of a summary and of the footer up to the checksum itself."""
    footer = struct.pack('<BQQQ', Opcode.FOOTER, 8 + 8 + 4, start, offset_start)
    return zlib.crc32(footer, zlib.crc32(summary))


@dataclass
class Summary:
    """The summary read from a file."""

    footer: Footer
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    statistics: Statistics | None = None
    chunk_indexes: list[ChunkIndex] = field(default_factory=list)


def read_summary(path: Path, with_chunks: bool = True) -> Summary:
    """
    Return the summary of a file, read from its end.

    with_chunks: with the indexes of chunks, of which there are as many as the file is long.
    Incomplete: the file has none because its writer did not finish.  Damaged: it is not what a
    writer writes.
    """
    footer, data = summary_bytes(path)
    summary = Summary(footer)
    for record in _each_record(path, footer.summary_start, data, with_chunks):
        match record:
            case Schema():
                summary.schemas[record.id] = record
            case Channel():
                summary.channels[record.id] = record
            case Statistics():
                summary.statistics = record
            case ChunkIndex():
                summary.chunk_indexes.append(record)
    return summary


def summary_bytes(path: Path) -> tuple[Footer, bytes]:
    """Return the footer of a file and its summary, whose checksum is right; errors: as above."""
    with open(regular_file(path), 'rb') as file:
        size = file.seek(0, os.SEEK_END)
        end = size - len(MCAP0_MAGIC) - FOOTER_SIZE
        file.seek(max(0, end))
        tail = file.read()
        if end < len(MCAP0_MAGIC) or not tail.endswith(MCAP0_MAGIC):
            raise Incomplete(f'{path} ends in mid-write; satdyn recover completes it')
        if tail[: PREFIX.size] != PREFIX.pack(Opcode.FOOTER, FOOTER_SIZE - PREFIX.size):
            raise Damaged(f'{path} is damaged: there is no footer before its end')
        footer = Footer(*struct.unpack_from('<QQI', tail, PREFIX.size))
        if footer.summary_start == 0:
            return footer, b''
        if not len(MCAP0_MAGIC) <= footer.summary_start <= end:
            raise Damaged(
                f'{path} is damaged: its footer places the summary at byte {footer.summary_start}'
            )
        file.seek(footer.summary_start)
        data = file.read(end - footer.summary_start)
        wanted = checksum(data, footer.summary_start, footer.summary_offset_start)
        if footer.summary_crc not in (0, wanted):
            what = _changed(file, footer, end, wanted ^ footer.summary_crc)
            raise Damaged(f'{path} is damaged: {what}')
    return footer, data


def _changed(file: BinaryIO, footer: Footer, footer_start: int, difference: int) -> str:
    """Return in words what was changed in a summary whose checksum is wrong."""
    summed = footer_start + FOOTER_SIZE - 4 - footer.summary_start
    reader = FrameReader(file, CEILING)
    if changed := reader.changed_record(footer.summary_start, summed, difference):
        return f'{changed}, as the checksum of the summary shows'
    return 'the checksum of its summary is wrong'


def _each_record(path: Path, start: int, data: bytes, with_chunks: bool) -> Iterator[McapRecord]:
    end = 0
    while end < len(data):
        place = end
        rest = len(data) - place - PREFIX.size
        opcode, length = PREFIX.unpack_from(data, place) if rest >= 0 else (0, 0)
        if length > rest:
            raise Damaged(f'{path} is damaged: its summary is cut off at byte {start + place}')
        end = place + PREFIX.size + length
        if opcode == Opcode.CHUNK_INDEX and not with_chunks:
            continue
        try:
            record = read(opcode, data[place + PREFIX.size : end])
        except Damaged as error:
            raise Damaged(
                f'{path} is damaged: the {name_of(opcode)} record at byte {start + place}: {error}'
            ) from None
        if isinstance(record, McapRecord):
            yield record

"""One MCAP file, written record by record in the order of rosbag2."""

import os
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Chunk, DataEnd, Header, McapRecord, Metadata
from mcap.writer import MCAP0_MAGIC

from .chunk import Contents
from .records import PREFIX, written
from .summary import INDEX_HEAD, SummaryBuilder


class McapFile:
    """
    A file that is complete after finish(); each write is handed to the system at once.

    opening: metadata records with which it begins.  summary: what the summary will say; schemas
    and channels that are added to it are listed there.  size [bytes], crc: of what was written so
    far.  OSError: the file exists, or cannot be written.
    """

    def __init__(self, path: Path, header: Header, opening: Sequence[Metadata] = ()):
        self.path = path
        self.size = 0
        self.summary = SummaryBuilder()
        self.crc = 0
        begin = MCAP0_MAGIC + written([header])
        for record in opening:
            data = written([record])
            self.summary.add_metadata(len(begin), len(data), record.name)
            begin += data
        self._file = open(path, 'xb', buffering=0)  # noqa: SIM115
        # At once: a killed writer leaves a file that says what it is, but for an instant.
        self._write(begin)

    def write_metadata(self, name: str, mapping: Mapping[str, str]) -> None:
        """Write a metadata record."""
        start = self.size
        self._write_record(Metadata(name, dict(mapping)))
        self.summary.add_metadata(start, self.size - start, name)

    def write_chunk(self, contents: Contents, compression: str, compressed: bytes) -> None:
        """
        Write a chunk and the index of its messages.

        compressed: the contents by compression, 'zstd', 'lz4' or '' for none.
        """
        chunk = Chunk(
            compression=compression,
            data=compressed,
            message_start_time=contents.span_ns[0],
            message_end_time=contents.span_ns[1],
            uncompressed_crc=zlib.crc32(contents.data.data),
            uncompressed_size=len(contents.data),
        )
        start = self.size
        self._write_record(chunk)
        self.summary.add_chunk(start, self.size, chunk, contents)
        self._write(message_indexes(contents))

    def finish(self) -> None:
        """Write the summary, sync the file to disk and close it."""
        self._write_record(DataEnd(self.crc))
        self._write(self.summary.end_of_file(self.size))
        os.fsync(self._file.fileno())
        self.close()

    def close(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def _write_record(self, record: McapRecord) -> None:
        self._write(written([record]))

    def _write(self, data) -> None:
        self.crc = zlib.crc32(data, self.crc)
        rest = memoryview(data)
        while rest:
            count = self._file.write(rest)
            self.size += count
            rest = rest[count:]


def message_indexes(contents: Contents) -> bytes:
    """Return the records that index a chunk; mcap would make an object of each message."""
    parts: list[bytes | memoryview] = []
    for channel_id in contents.counts:
        # This machine is little endian, as the file is.
        entries = contents.index_of(channel_id).data
        length = INDEX_HEAD.size - PREFIX.size + entries.nbytes
        head = INDEX_HEAD.pack(Opcode.MESSAGE_INDEX, length, channel_id, entries.nbytes)
        parts += [head, entries]
    return b''.join(parts)

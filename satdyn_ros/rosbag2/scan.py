"""The records of an MCAP file from its begin on, as far as they go."""

import io
import os
import struct
import zlib
from collections.abc import Iterable, Iterator
from itertools import groupby, takewhile
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import (
    Attachment,
    Channel,
    Chunk,
    Footer,
    Header,
    McapRecord,
    Metadata,
    Schema,
)
from mcap.summary import Summary
from mcap.writer import MCAP0_MAGIC

from .chunk import CHUNK_SIZE, Contents
from .compression import decompress, decompress_begin

_PREFIX = struct.Struct('<BQ')
_IN_CHUNKS = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
_BESIDE_CHUNKS: dict[int, Any] = {
    Opcode.HEADER: Header,
    Opcode.ATTACHMENT: Attachment,
    Opcode.METADATA: Metadata,
}
_IN_SUMMARY: dict[int, Any] = {
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.FOOTER: Footer,
}


class Incomplete(ValueError):  # noqa: N818
    """A file that ends before its footer, or is damaged there."""


class Block(NamedTuple):
    """Messages that follow each other; compressed: as they stand in the file, if a whole chunk."""

    contents: Contents
    compression: str = ''
    compressed: bytes | None = None


class _Raw(NamedTuple):
    """A record as bytes: its opcode, the length it says, and the bytes there are."""

    opcode: int
    length: int
    body: bytes

    @property
    def is_whole(self):
        return len(self.body) == self.length

    @property
    def stream(self):
        return ReadDataStream(io.BytesIO(self.body))


def scan(path: Path) -> Iterator[McapRecord | Block]:
    """
    Yield what a file holds, in its order.

    These are header, metadata and blocks of messages; from the summary schemas and channels, and
    the footer at last.

    ValueError: it is no MCAP file.  Incomplete (a ValueError): after all that could be had, the
    footer is missing; of a chunk that is cut off, its first messages were yielded as a block.
    """
    with open(path, 'rb') as file:
        magic = file.read(len(MCAP0_MAGIC))
        if magic != MCAP0_MAGIC[: len(magic)]:
            raise ValueError(f'{path} is no MCAP file')
        records = _raw_records(file)
        data = takewhile(lambda raw: raw.opcode != Opcode.DATA_END, records)
        try:
            for are_loose, group in groupby(data, lambda raw: raw.opcode in _IN_CHUNKS):
                read = _loose_blocks if are_loose else _records
                yield from read(group)
        except (ValueError, EndOfFile, struct.error) as error:
            raise Incomplete(f'{path} is damaged: {error}') from error
        for raw in records:
            if raw.is_whole and raw.opcode in _IN_SUMMARY:
                yield _IN_SUMMARY[raw.opcode].read(raw.stream)
        if file.read() != MCAP0_MAGIC:
            raise Incomplete(f'{path} ends in mid-write; satdyn recover completes it')


def read_summary(path: Path) -> Summary | None:
    """Return the summary of a complete file; None: it has none."""
    with open(path, 'rb') as file:
        try:
            return SeekingReader(file).get_summary()
        except (McapError, OSError, ValueError, struct.error):
            return None


def _raw_records(file: BinaryIO) -> Iterator[_Raw]:
    """Yield the records up to the footer, or to the end, where the last one may be cut off."""
    size = os.fstat(file.fileno()).st_size
    while len(prefix := file.read(_PREFIX.size)) == _PREFIX.size:
        opcode, length = _PREFIX.unpack(prefix)
        if opcode == Opcode.MESSAGE_INDEX:
            file.seek(length, os.SEEK_CUR)
            continue
        if opcode == 0:  # not a record: blocks of a file that the system never filled
            return
        yield _Raw(opcode, length, file.read(min(length, size - file.tell())))
        if opcode == Opcode.FOOTER:
            return


def _records(group: Iterable[_Raw]) -> Iterator[McapRecord | Block]:
    for raw in group:
        if raw.opcode == Opcode.CHUNK:
            yield from _chunk_block(raw)
        elif raw.is_whole and raw.opcode in _BESIDE_CHUNKS:
            yield _BESIDE_CHUNKS[raw.opcode].read(raw.stream)


def _chunk_block(raw: _Raw) -> Iterator[Block]:
    """Yield the messages of a chunk; of one that is cut off, those that are there."""
    try:
        chunk = Chunk.read(raw.stream)
    except (EndOfFile, struct.error):
        return
    if not raw.is_whole:
        yield Block(Contents(decompress_begin(chunk.compression, chunk.data)), chunk.compression)
        return
    data = decompress(chunk.compression, chunk.data, chunk.uncompressed_size)
    if chunk.uncompressed_crc not in (0, zlib.crc32(data.data)):
        raise ValueError('the checksum of a chunk is wrong')
    yield Block(Contents(data), chunk.compression, chunk.data)


def _loose_blocks(group: Iterable[_Raw]) -> Iterator[Block]:
    """Yield records that stand outside of chunks in blocks of a chunk's size."""
    records = bytearray()
    for raw in group:
        records += _PREFIX.pack(raw.opcode, raw.length) + raw.body
        if len(records) >= CHUNK_SIZE:
            yield Block(Contents(np.frombuffer(bytes(records), np.uint8)))
            records.clear()
    if records:
        yield Block(Contents(np.frombuffer(bytes(records), np.uint8)))

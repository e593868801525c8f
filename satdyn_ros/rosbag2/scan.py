"""
The records of an MCAP file from start to end, past any damage.

What cannot be read is reported as a flaw, and the scan continues at the next bytes that are a
record.  Each byte is read a bounded number of times, however hostile the file.
"""

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import DataEnd
from mcap.writer import MCAP0_MAGIC

from ..base.regular_file import regular_file
from .chunk import CHUNK_SIZE, Contents
from .compression import CEILING, decompress_begin
from .errors import BagError, Damaged, Incomplete
from .frames import Frame, FrameReader
from .records import PREFIX, ChunkRecord, IndexRecord, read

_KNOWN = frozenset(Opcode)
_IN_CHUNKS = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
# What says where the rest is, and how much of it there is.
_INDEXES = frozenset(
    {
        Opcode.MESSAGE_INDEX,
        Opcode.CHUNK_INDEX,
        Opcode.METADATA_INDEX,
        Opcode.ATTACHMENT_INDEX,
        Opcode.STATISTICS,
        Opcode.SUMMARY_OFFSET,
    }
)


class Block(NamedTuple):
    """Consecutive messages; chunk: the one they are in, None: they are not in a whole chunk."""

    contents: Contents
    chunk: ChunkRecord | None = None


class Flaw(NamedTuple):
    """
    A defect of the file; what: its description, the predicate of a sentence about the file.

    opcode: of the record whose length is right but whose content is wrong or cut off; 0: there is
    no record.  is_end: the file ends here, in mid-write.
    """

    what: str
    opcode: int = 0
    is_end: bool = False


_CUT_OFF = Flaw('ends in mid-write; satdyn recover completes it', is_end=True)
_WRONG_END = Flaw('is damaged: the magic at its end is wrong')


class Found(NamedTuple):
    """
    What a file holds from byte `start` to `end`.

    item: a McapRecord, IndexRecord, Block or Flaw; None: a kind of record that is not known.
    """

    start: int
    end: int
    item: Any

    def sound(self, path: Path) -> 'Found':
        """Return this of the file at path; Damaged or Incomplete: it is a flaw."""
        if isinstance(self.item, Flaw):
            raise (Incomplete if self.item.is_end else Damaged)(f'{path} {self.item.what}')
        return self

    def damaged(self, path: Path, why: str) -> Damaged:
        """Return the error for a record of the file at path that contradicts others."""
        kind = type(self.item)
        names = {Block: 'Chunk', IndexRecord: 'MessageIndex', type(None): 'unknown'}
        name = names.get(kind, kind.__name__)
        return Damaged(f'{path} is damaged: the {name} record at byte {self.start}: {why}')


def scan(path: Path, ceiling: int = CEILING, with_indexes: bool = True) -> Iterator[Found]:
    """
    Yield what a file holds, in order.

    Messages come in blocks: a whole chunk, the beginning of one that is cut off, or a chunk's size
    of those outside chunks.  ceiling [bytes]: no larger record or chunk contents is read, and all
    chunks together are no more than a ResourceBudget.  with_indexes: with the records that say
    where the others are; without them, only their places are checked.  BagError: it is not an MCAP
    file.
    """
    skipped = frozenset() if with_indexes else _INDEXES
    with open(regular_file(path), 'rb') as file:
        reader = FrameReader(file, ceiling)
        yield from _magic_at_begin(path, reader)
        yield from _data(reader, skipped)
        yield from _summary(reader, skipped)
        yield from _magic_at_end(reader)


def _data(reader: FrameReader, skipped: frozenset[int]) -> Iterator[Found]:
    """Yield the data section; the record that ends it has the checksum of all before it."""
    crc: int | None = zlib.crc32(MCAP0_MAGIC)
    loose: list[Frame] = []
    before: Frame | None = None
    for frame in reader.frames():
        is_loose = frame.is_whole and frame.opcode in _IN_CHUNKS and _is_readable(frame)
        if loose and not (is_loose and frame.end - loose[0].start < CHUNK_SIZE):
            yield _loose_block(loose)
            loose = []
        if is_loose:
            loose.append(frame)
        elif not frame.is_whole:
            yield from _broken(reader, frame, before.name if before else 'the magic at its start')
            crc = None
        elif frame.opcode not in skipped:
            found = _found(frame, reader)
            yield found
            if isinstance(found.item, DataEnd):
                if crc is not None and found.item.data_section_crc not in (0, crc):
                    yield _changed(reader, frame, crc ^ found.item.data_section_crc)
                return
        if crc is not None:
            crc = zlib.crc32(frame.content, zlib.crc32(frame.prefix, crc))
        before = frame
    if loose:
        yield _loose_block(loose)


def _changed(reader: FrameReader, end: Frame, difference: int) -> Found:
    """
    Return the flaw of data in which something was changed.

    end: the record with their checksum, from which the right one differs by difference.
    """
    what = (
        f'{end.name}: the checksum of all data before it is wrong; a record without one of its '
        'own was changed, such as the Header or a Metadata record'
    )
    if changed := reader.changed_record(0, end.start, difference):
        what = f'{changed}, as the checksum of the data shows'
    return Found(end.end, end.end, Flaw(f'is damaged: {what}', end.opcode))


def _summary(reader: FrameReader, skipped: frozenset[int]) -> Iterator[Found]:
    """Yield what follows the data."""
    before: Frame | None = None
    for frame in reader.frames():
        if not frame.is_whole:
            yield from _broken(reader, frame, before.name if before else 'the end of the data')
        elif frame.opcode not in skipped:
            yield _found(frame, reader)
        before = frame


def _magic_at_begin(path: Path, reader: FrameReader) -> Iterator[Found]:
    magic = reader.read(0, len(MCAP0_MAGIC))
    if MCAP0_MAGIC.startswith(magic):
        return
    if not (reader.is_finished or reader.is_record(len(MCAP0_MAGIC))):
        raise BagError(f'{path} is not an MCAP file')
    yield Found(0, len(MCAP0_MAGIC), Flaw('is damaged: the magic at its start is wrong'))


def _magic_at_end(reader: FrameReader) -> Iterator[Found]:
    if reader.is_broken_off:
        return
    magic = reader.read(reader.place, reader.size)
    if magic == MCAP0_MAGIC:
        return
    flaw = _CUT_OFF if MCAP0_MAGIC.startswith(magic) else _WRONG_END
    yield Found(reader.place, reader.size, flaw)


def _found(frame: Frame, reader: FrameReader) -> Found:
    """Return what a record holds, or why it cannot be read."""
    try:
        record = read(frame.opcode, frame.content)
        if isinstance(record, ChunkRecord):
            contents = record.contents(reader.budget, reader.ceiling)
            return Found(frame.start, frame.end, Block(contents, record))
    except Damaged as error:
        return _flaw(frame, str(error))
    return Found(frame.start, frame.end, record)


def _is_readable(frame: Frame) -> bool:
    try:
        read(frame.opcode, frame.content)
    except Damaged:
        return False
    return True


def _flaw(frame: Frame, why: str) -> Found:
    flaw = Flaw(f'is damaged: {frame.name}: {why}', frame.opcode)
    return Found(frame.start, frame.end, flaw)


def _broken(reader: FrameReader, frame: Frame, before: str) -> Iterator[Found]:
    """Yield what is readable where no whole record is; before: what precedes it."""
    if frame.end < reader.size or reader.is_finished:
        what = f'there is no record at byte {frame.start}, after {before}'
        if frame.opcode in _KNOWN:
            what = f'{frame.name}: it cannot be read'
        yield Found(frame.start, frame.end, Flaw(f'is damaged: {what}'))
        return
    if frame.opcode == Opcode.CHUNK and reader.is_cut_off(frame.start):
        chunk = ChunkRecord.read(reader.read(frame.start + PREFIX.size, reader.size))
        data = decompress_begin(chunk.compression, chunk.data, reader.ceiling)
        contents = Contents(np.frombuffer(data, np.uint8))
        if len(contents):
            kept = 0 if chunk.compression else len(chunk.prefix()) + len(contents.data)
            yield Found(frame.start, frame.start + kept, Block(contents))
            yield Found(frame.start + kept, frame.end, _CUT_OFF)
            return
    yield Found(frame.start, frame.end, _CUT_OFF._replace(opcode=frame.opcode))


def _loose_block(frames: list[Frame]) -> Found:
    """Return records outside chunks as a block."""
    data = b''.join(part for frame in frames for part in (frame.prefix, frame.content))
    return Found(frames[0].start, frames[-1].end, Block(Contents(np.frombuffer(data, np.uint8))))

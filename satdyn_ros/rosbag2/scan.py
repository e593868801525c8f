"""
The records of an MCAP file from start to end, past any damage.

What cannot be read is reported as a flaw, and the scan continues at the next bytes that are a
record.  What it costs is bounded by the file's Budget, however hostile the file.
"""

import os
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Chunk, DataEnd, Footer
from mcap.writer import MCAP0_MAGIC
from numpy.lib.stride_tricks import sliding_window_view

from ..base.regular_file import regular_file
from .budget import CHUNK, DAMAGE, RECORD, Budget, objects
from .chunk import CHUNK_SIZE, HEAD, Contents
from .compression import CEILING
from .errors import BagError, Damaged, Incomplete
from .records import PREFIX, read

# A search reads so much at a time, as the next record is mostly near.
_WINDOW = 2**14
# This many messages do not follow each other by chance.
_CHAIN = 3
# Where bytes are damaged, reading goes on at a record of these kinds.  For each of their inner
# lengths the bytes before it and its own, which what it counts follows; 0: there is none.
_INNER: dict[int, tuple[tuple[int, int], ...]] = {
    Opcode.HEADER: ((0, 4), (0, 4)),
    Opcode.FOOTER: ((20, 0),),
    Opcode.SCHEMA: ((2, 4), (0, 4), (0, 4)),
    Opcode.CHANNEL: ((4, 4), (0, 4), (0, 4)),
    Opcode.MESSAGE: ((HEAD.itemsize - PREFIX.size, 0),),
    Opcode.CHUNK: ((28, 4), (0, 8)),
    Opcode.MESSAGE_INDEX: ((2, 4),),
    Opcode.METADATA: ((0, 4), (0, 4)),
    Opcode.DATA_END: ((4, 0),),
}
# The least length of each; of other kinds more than any record has.
_LEAST = np.full(256, 2**32, np.uint64)
_LEAST[list(_INNER)] = [sum(map(sum, inner)) for inner in _INNER.values()]


class Block(NamedTuple):
    """Consecutive messages; chunk: the one they are in, None: they are outside chunks."""

    contents: Contents
    chunk: Chunk | None = None


class Flaw(NamedTuple):
    """
    A defect of the file; error: Incomplete if the file ends here, in mid-write.

    opcode: of the record whose length is right but whose content is wrong or cut off; 0: there is
    no record.
    """

    error: Damaged
    opcode: int = 0


class Found(NamedTuple):
    """
    What a file holds from byte `start` to `end`.

    item: a McapRecord, Block or Flaw; None: a kind of record that is not known.
    """

    start: int
    end: int
    item: Any

    def sound(self) -> 'Found':
        """Return this; Damaged or Incomplete: it is a flaw."""
        if isinstance(self.item, Flaw):
            raise self.item.error
        return self

    def damaged(self, path: Path, why: str) -> Damaged:
        """Return the error for what contradicts the rest of the file at path."""
        return Damaged(f'{path} is damaged: the record at byte {self.start}: {why}')


def scan(path: Path) -> Iterator[Found]:
    """
    Yield what a file holds, in order.

    Messages come in blocks: a chunk, or at most a chunk's size of those outside chunks; so do
    schemas and channels outside chunks.  BagError: it is not an MCAP file.  Damaged: to read it
    takes more than its Budget.
    """
    with open(regular_file(path), 'rb') as file:
        yield from Scanner(path, file).found()


class Scanner:
    """What a file holds, read at any offset; all that is read is paid from one Budget."""

    def __init__(self, path: Path, file: BinaryIO):
        self._path = path
        self._file = file
        self._size = os.fstat(file.fileno()).st_size
        self._budget = Budget(self._size)
        # Until their end is found.
        self._is_data = True

    def found(self) -> Iterator[Found]:
        """Yield what the file holds."""
        offset, crc = len(MCAP0_MAGIC), zlib.crc32(MCAP0_MAGIC)
        if not MCAP0_MAGIC.startswith(self._read(0, offset)):
            if not (self._is_finished or self._is_record(offset)):
                raise BagError(f'{self._path} is not an MCAP file')
            yield self._flaw(0, offset, 'the magic at its start is wrong')
        item: Any = None
        while offset < self._size and not isinstance(item, Footer):
            found = self.at(offset)
            item, offset = found.item, found.end
            if isinstance(item, DataEnd):
                self._is_data = False
                if item.data_section_crc not in (0, crc):
                    what = 'the checksum of its data section is wrong'
                    yield self._flaw(found.start, found.start, what, Opcode.DATA_END)
            elif self._is_data:
                crc = zlib.crc32(self._read(found.start, offset - found.start), crc)
            yield found
        magic = self._read(offset, self._size)
        if magic != MCAP0_MAGIC and MCAP0_MAGIC.startswith(magic):
            yield Found(offset, self._size, Flaw(Incomplete(self._path)))
        elif magic != MCAP0_MAGIC:
            yield self._flaw(offset, self._size, 'the magic at its end is wrong')

    def _flaw(self, start: int, end: int, what: str, opcode: int = 0) -> Found:
        return Found(start, end, Flaw(Damaged(f'{self._path} is damaged: {what}'), opcode))

    @property
    def _is_finished(self) -> bool:
        """Whether the file ends as a writer ends it."""
        return self._read(self._size - len(MCAP0_MAGIC), self._size) == MCAP0_MAGIC

    def at(self, start: int) -> Found:
        """Return what is at an offset: a record, messages, or damage up to the next record."""
        self._spend(RECORD)
        opcode, end = self._head(start)
        if opcode == Opcode.MESSAGE and len(contents := self._messages(start)):
            return Found(start, start + len(contents.data), Block(contents))
        record, why = self._record(start)
        # The length of one that cannot be read is right where a record follows it.
        is_there = record is not None or (self._is_record(end) if why else self._may_begin(end))
        if opcode == 0 or not is_there:
            return self._broken(start)
        if why:
            return self._flaw(start, end, f'the record at byte {start}: {why}', opcode)
        if isinstance(record, Chunk):
            return self._block(start, end, record)
        if self._is_data and opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            record = Block(Contents(np.frombuffer(self._read(start, end - start), np.uint8)))
        return Found(start, end, record)

    def _record(self, start: int) -> tuple[Any, str]:
        """Return the record at an offset, or None, as read does; and why, '': it can be read."""
        opcode, end = self._head(start)
        begin = start + PREFIX.size
        if opcode == 0 or end > self._size or end - begin > CEILING:
            return None, 'it cannot be read'
        try:
            return read(opcode, self._read(begin, end - begin)), ''
        except Damaged as error:
            return None, str(error)

    def _block(self, start: int, end: int, chunk: Chunk) -> Found:
        """Return what the chunk at an offset holds, or the flaw that it has."""
        try:
            self._budget.spend(max(CHUNK, chunk.uncompressed_size))
            contents = Contents.of(chunk)
            self._budget.spend(contents.cost)
            _ = contents.declarations
        except Damaged as error:
            what = f'the Chunk record at byte {start}: {error}'
            return self._flaw(start, end, what, Opcode.CHUNK)
        return Found(start, end, Block(contents, chunk))

    def _messages(self, start: int) -> Contents:
        """Return the messages outside chunks that begin at an offset, as many as a chunk."""
        _, end = self._head(start)
        data = self._read(start, min(max(CHUNK_SIZE, end - start), CEILING))
        self._spend(len(data))
        return Contents.of_messages(data)

    def _broken(self, start: int) -> Found:
        """Return the bytes up to the next record where no whole one is."""
        self._spend(DAMAGE)
        opcode, end = self._head(start)
        # The records in a chunk that is cut off are not those of the file.
        is_cut_off = opcode == Opcode.CHUNK and end > self._size and self._adds_up(start)
        end = self._size if is_cut_off else self._next_record(start + 1)
        if end == self._size and not self._is_finished:
            return Found(start, end, Flaw(Incomplete(self._path), opcode))
        return self._flaw(start, end, f'there is no whole record at byte {start}')

    def _adds_up(self, start: int) -> bool:
        """Whether the inner lengths of the record at an offset fill its length."""
        opcode, end = self._head(start)
        offset = start + PREFIX.size
        for gap, size in _INNER[opcode]:
            number = self._read(offset + gap, size)
            if len(number) < size or offset > end:
                return False
            offset += gap + size + int.from_bytes(number, 'little')
        return offset == end

    def _next_record(self, start: int) -> int:
        """Return where the next whole record begins, or the end of the file if there is none."""
        for begin in range(start, self._size, _WINDOW):
            for offset in self._likely(begin):
                if self._is_record(offset):
                    return offset
                self._spend(DAMAGE)
        return self._size

    def _likely(self, start: int) -> list[int]:
        """Return the offsets in a window where opcode and length are those of some record."""
        window = np.frombuffer(self._read(start, _WINDOW + PREFIX.size - 1), np.uint8)
        if len(window) < PREFIX.size:
            return []
        heads = sliding_window_view(window, PREFIX.size)
        lengths = heads[:, 1:].copy().view('<u8')[:, 0]
        rest = self._size - PREFIX.size - start - np.arange(len(heads))
        most = np.minimum(CEILING, rest).astype(np.uint64)
        offsets = np.flatnonzero((lengths >= _LEAST[heads[:, 0]]) & (lengths <= most))
        return (start + offsets).tolist()

    def _is_record(self, start: int, chain: int = _CHAIN) -> bool:
        """Whether bytes are a record to go on at, and not by chance: several messages in a row."""
        opcode, end = self._head(start)
        length = end - start - PREFIX.size
        if end > self._size or not int(_LEAST[opcode]) <= length <= CEILING:
            return False
        if opcode == Opcode.MESSAGE:
            return chain <= 1 or end == self._size or self._is_record(end, chain - 1)
        if not self._adds_up(start):
            return False
        if opcode == Opcode.FOOTER:
            return MCAP0_MAGIC.startswith(self._read(end, len(MCAP0_MAGIC)))
        if opcode == Opcode.DATA_END:
            return self._may_begin(end)
        is_bulk = opcode in (Opcode.CHUNK, Opcode.MESSAGE_INDEX)
        self._spend(length if is_bulk else objects(1, length))
        return self._record(start)[0] is not None

    def _may_begin(self, start: int) -> bool:
        """Whether the opcode here is one of MCAP, or the file ends."""
        return start == self._size or 0 < self._head(start)[0] <= max(Opcode)

    def _head(self, start: int) -> tuple[int, int]:
        """Return the opcode of the record at an offset, and where it ends; 0: there is none."""
        prefix = self._read(start, PREFIX.size)
        opcode, length = PREFIX.unpack(prefix) if len(prefix) == PREFIX.size else (0, 0)
        return opcode, start + PREFIX.size + length

    def _read(self, start: int, length: int) -> bytes:
        """Return bytes, fewer where the file ends."""
        start = min(max(0, start), self._size)
        self._file.seek(start)
        return self._file.read(min(length, self._size - start))

    def _spend(self, cost: int) -> None:
        try:
            self._budget.spend(cost)
        except Damaged as error:
            raise Damaged(f'{self._path} is damaged: {error}') from None

"""Where the records of an MCAP file are, and where the next one begins after damaged bytes."""

import os
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from .compression import Allowance
from .errors import Damaged
from .records import PREFIX, name_of, read

_MESSAGE_HEAD = 2 + 4 + 8 + 8
_LAST_OPCODE = max(Opcode)
_WINDOW = 2**20
# This many messages do not follow each other by chance.
_CHAIN = 3
# By kind of record: the size of what precedes the first inner length, and the sizes of the inner
# lengths; each is followed by that many bytes.
_SIZED: dict[int, tuple[int, ...]] = {
    Opcode.HEADER: (0, 4, 4),
    Opcode.SCHEMA: (2, 4, 4, 4),
    Opcode.CHANNEL: (4, 4, 4, 4),
    Opcode.CHUNK: (28, 4, 8),
    Opcode.MESSAGE_INDEX: (2, 4),
    Opcode.METADATA: (0, 4, 4),
}


class Frame(NamedTuple):
    """
    The bytes of a record; is_whole: false for other bytes in the place of a record.

    content: what follows opcode and length; empty where it is not whole.
    """

    opcode: int
    start: int
    end: int
    content: bytes
    is_whole: bool = True

    @property
    def prefix(self) -> bytes:
        """Return opcode and length as they are in the file."""
        return PREFIX.pack(self.opcode, len(self.content))

    @property
    def name(self) -> str:
        """Return its name in an error message."""
        return f'the {name_of(self.opcode)} record at byte {self.start}'


class FrameReader:
    """
    Reads a file record by record.

    place: where the next one is.  is_broken_off: the last one was cut off.  ceiling [bytes]: no
    larger record is read.  allowance: what its chunks may hold in total.
    """

    def __init__(self, file: BinaryIO, ceiling: int):
        self.size = os.fstat(file.fileno()).st_size
        self.place = len(MCAP0_MAGIC)
        self.is_broken_off = False
        self.ceiling = ceiling
        self.allowance = Allowance(self.size)
        self._file = file

    @property
    def is_finished(self) -> bool:
        """Whether the file ends as a writer ends it."""
        return self.read(self.size - len(MCAP0_MAGIC), self.size) == MCAP0_MAGIC

    def read(self, start: int, length: int) -> bytes:
        """Return bytes, fewer where the file ends."""
        start = min(max(0, start), self.size)
        self._file.seek(start)
        return self._file.read(max(0, min(length, self.size - start)))

    def frames(self) -> Iterator[Frame]:
        """Yield records, and the bytes in place of damaged ones, up to the footer or the end."""
        while self.place < self.size:
            frame = self._frame()
            self.place = frame.end
            self.is_broken_off = frame.end == self.size and not frame.is_whole
            yield frame
            if frame.opcode == Opcode.FOOTER and frame.is_whole:
                return

    def is_record(self, start: int, chain: int = _CHAIN) -> bool:
        """
        Whether bytes are a whole record, and not by chance.

        The inner lengths must add up to the length; of messages, which have none, several must
        follow each other.
        """
        opcode, length = self._head(start)
        begin, end = start + PREFIX.size, start + PREFIX.size + length
        if end > self.size or length > self.ceiling:
            return False
        if opcode == Opcode.FOOTER:
            return length == 20 and MCAP0_MAGIC.startswith(self.read(end, len(MCAP0_MAGIC)))
        if opcode == Opcode.DATA_END:
            return length == 4 and (end == self.size or self._may_begin(end))
        if opcode == Opcode.MESSAGE:
            if length < _MESSAGE_HEAD:
                return False
            return chain <= 1 or end == self.size or self.is_record(end, chain - 1)
        return opcode in _SIZED and self._adds_up(opcode, begin, length)

    def is_cut_off(self, start: int) -> bool:
        """Whether a record begins here whose inner lengths are right, and the file ends in it."""
        opcode, length = self._head(start)
        begin = start + PREFIX.size
        return begin + length > self.size and self._adds_up(opcode, begin, length)

    def _frame(self) -> Frame:
        start = self.place
        opcode, length = self._head(start)
        end = start + PREFIX.size + length
        if opcode and end <= self.size and length <= self.ceiling:
            frame = Frame(opcode, start, end, self.read(start + PREFIX.size, length))
            if self._is_valid(frame) or self.is_record(end):
                return frame
        if self.is_cut_off(start):
            return Frame(opcode, start, self.size, b'', is_whole=False)
        return Frame(opcode, start, self._next_record(start + 1), b'', is_whole=False)

    def _is_valid(self, frame: Frame) -> bool:
        """Whether a frame is a record, by its own bytes or by what follows it."""
        if frame.opcode in _SIZED:
            return self._adds_up(frame.opcode, frame.start + PREFIX.size, len(frame.content))
        if frame.opcode == Opcode.MESSAGE or frame.opcode > _LAST_OPCODE:
            return frame.end == self.size or self._may_begin(frame.end)
        try:
            return read(frame.opcode, frame.content) is not None
        except Damaged:
            return False

    def _head(self, start: int) -> tuple[int, int]:
        """Return opcode and length of what begins here; 0, 0 at the end of the file."""
        prefix = self.read(start, PREFIX.size)
        return PREFIX.unpack(prefix) if len(prefix) == PREFIX.size else (0, 0)

    def _may_begin(self, start: int) -> bool:
        opcode, length = self._head(start)
        return 0 < opcode <= _LAST_OPCODE and length <= self.ceiling

    def _adds_up(self, opcode: int, begin: int, length: int) -> bool:
        """Whether the inner lengths of a record, whose content begins here, fill its length."""
        if opcode not in _SIZED:
            return False
        offset, *sizes = _SIZED[opcode]
        for size in sizes:
            number = self.read(begin + offset, size)
            if len(number) < size or offset > length:
                return False
            offset += size + int.from_bytes(number, 'little')
        return offset == length

    def _next_record(self, start: int) -> int:
        """Return where the next whole record begins, or the end of the file if there is none."""
        for first in range(start, self.size, _WINDOW):
            window = np.frombuffer(self.read(first, _WINDOW + PREFIX.size), np.uint8)
            count = max(0, len(window) - PREFIX.size + 1)
            # No record has 4 GiB; opcode 0 wraps around and is not a record.
            likely = (window[:count] - np.uint8(1) < _LAST_OPCODE) & (window[5 : 5 + count] == 0)
            for place in np.flatnonzero(likely).tolist():
                if self.is_record(first + place):
                    return first + place
        return self.size

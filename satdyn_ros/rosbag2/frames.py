"""Where the records of an MCAP file are, and where the next one begins after damaged bytes."""

import os
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from .chunk import messages_end
from .compression import ResourceBudget
from .crc32 import flipped_byte
from .errors import BagError
from .records import PREFIX, name_of

_MESSAGE_HEAD = 2 + 4 + 8 + 8
_LAST_OPCODE = max(Opcode)
_BUFFER = 2**14
# A search begins with little, as the next record is mostly near.
_FIRST_WINDOW, _LAST_WINDOW = 2**11, 2**20
# This many messages do not follow each other by chance.
_CHAIN = 3
# By kind of record: the inner lengths, each as the bytes before it and its own size, and the bytes
# at the end; each inner length is followed by as many bytes as it says.
_LAYOUTS: dict[int, tuple[tuple[tuple[int, int], ...], int]] = {
    Opcode.HEADER: (((0, 4), (0, 4)), 0),
    Opcode.FOOTER: ((), 20),
    Opcode.SCHEMA: (((2, 4), (0, 4), (0, 4)), 0),
    Opcode.CHANNEL: (((4, 4), (0, 4), (0, 4)), 0),
    Opcode.CHUNK: (((28, 4), (0, 8)), 0),
    Opcode.MESSAGE_INDEX: (((2, 4),), 0),
    Opcode.CHUNK_INDEX: (((32, 4), (8, 4)), 16),
    Opcode.ATTACHMENT: (((16, 4), (0, 4), (0, 8)), 4),
    Opcode.ATTACHMENT_INDEX: (((40, 4), (0, 4)), 0),
    Opcode.STATISTICS: (((42, 4),), 0),
    Opcode.METADATA: (((0, 4), (0, 4)), 0),
    Opcode.METADATA_INDEX: (((16, 4),), 0),
    Opcode.SUMMARY_OFFSET: ((), 17),
    Opcode.DATA_END: ((), 4),
}
# Where bytes are damaged, reading goes on at a record of these kinds; the least length of each.
_RESUMED = (
    Opcode.HEADER,
    Opcode.FOOTER,
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.CHUNK,
    Opcode.MESSAGE_INDEX,
    Opcode.METADATA,
    Opcode.DATA_END,
)
_LEAST = np.full(_LAST_OPCODE + 1, 2**32)
_LEAST[Opcode.MESSAGE] = _MESSAGE_HEAD
for _opcode in _RESUMED:
    _inner, _last = _LAYOUTS[_opcode]
    _LEAST[_opcode] = sum(_gap + _size for _gap, _size in _inner) + _last


class Frame(NamedTuple):
    """
    The bytes of a record, or of consecutive messages.

    prefix: opcode and length.  content: what follows.  is_whole: false for other bytes in the
    place of a record, of which there are neither.
    """

    opcode: int
    start: int
    end: int
    prefix: bytes = b''
    content: bytes = b''
    is_whole: bool = True

    @property
    def name(self) -> str:
        """Return its name in an error message."""
        return f'the {name_of(self.opcode)} record at byte {self.start}'


class FrameReader:
    """
    Reads a file record by record.

    place: where the next one is.  is_broken_off: the last one was cut off.  ceiling [bytes]: no
    larger record is read.  budget: what its chunks may hold in total.

    BagError, while reading: there are more records or more damaged places than any writer or disk
    leaves in a file of its size.  This bounds the work, however hostile the file.
    """

    def __init__(self, file: BinaryIO, ceiling: int):
        self.size = os.fstat(file.fileno()).st_size
        self.place = len(MCAP0_MAGIC)
        self.is_broken_off = False
        self.ceiling = ceiling
        self.budget = ResourceBudget(self.size)
        self._misses = 0
        self._file = file
        self._begin, self._buffer = 0, b''
        self._records = 0
        # A message in a chunk of its own, with the indexes of both, has over 50 bytes a record.
        self._most_records = 20_000 + self.size // 50
        self._most_misses = 5_000 + self.size // 5_000
        # rosbag2 writes none; each costs as much as a chunk.
        self._attachments, self._most_attachments = 0, 1_000 + self.size // 1_000

    @property
    def is_finished(self) -> bool:
        """Whether the file ends as a writer ends it."""
        return self.read(self.size - len(MCAP0_MAGIC), self.size) == MCAP0_MAGIC

    def read(self, start: int, length: int) -> bytes:
        """Return bytes, fewer where the file ends."""
        offset = start - self._begin
        if 0 <= offset <= offset + length <= len(self._buffer):
            return self._buffer[offset : offset + length]
        start = min(max(0, start), self.size)
        length = max(0, min(length, self.size - start))
        offset = start - self._begin
        if offset < 0 or offset + length > len(self._buffer):
            self._file.seek(start)
            if length > _BUFFER:
                return self._file.read(length)
            ahead = min(_BUFFER, self.size - start)
            self._begin, self._buffer, offset = start, self._file.read(ahead), 0
        return self._buffer[offset : offset + length]

    def frames(self) -> Iterator[Frame]:
        """Yield records, and the bytes in place of damaged ones, up to the footer or the end."""
        while self.place < self.size:
            frame = self._frame()
            self._records += 1
            if self._records > self._most_records:
                raise BagError(
                    f'{self._file.name} has more than {self._most_records} records, the limit '
                    'for a file of its size'
                )
            self._attachments += frame.opcode == Opcode.ATTACHMENT
            if self._attachments > self._most_attachments:
                raise BagError(
                    f'{self._file.name} has more than {self._most_attachments} attachments, the '
                    'limit for a file of its size'
                )
            self.place = frame.end
            self.is_broken_off = frame.end == self.size and not frame.is_whole
            yield frame
            if frame.opcode == Opcode.FOOTER and frame.is_whole:
                return

    def changed_record(self, begin: int, size: int, difference: int) -> str | None:
        """
        Return in words which record a flipped bit changed, of `size` bytes from begin on.

        difference: as of flipped_byte; None: as there.
        """
        offset = flipped_byte(difference, size)
        if offset is None:
            return None
        byte = begin + offset
        again = FrameReader(self._file, self.ceiling)
        again.place = max(begin, again.place)
        for frame in again.frames():
            if frame.start <= byte < frame.end:
                return f'{frame.name}: byte {byte} was changed'
        return None

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
        return opcode in _RESUMED and self._adds_up(opcode, begin, length)

    def is_cut_off(self, start: int) -> bool:
        """Whether a record begins here whose inner lengths are right, and the file ends in it."""
        opcode, length = self._head(start)
        begin = start + PREFIX.size
        return begin + length > self.size and self._adds_up(opcode, begin, length)

    def _frame(self) -> Frame:
        start = self.place
        opcode, length = self._head(start)
        begin, end = start + PREFIX.size, start + PREFIX.size + length
        if opcode == Opcode.MESSAGE:
            # Those at hand that a record follows are taken at once.
            at_hand = np.frombuffer(self._buffer, np.uint8, offset=start - self._begin)
            if size := messages_end(at_hand, _LAST_OPCODE):
                return self._whole(opcode, start, start + size)
        fits = opcode != 0 and end <= self.size and length <= self.ceiling
        if fits and (self._is_valid(opcode, begin, length) or self.is_record(end)):
            return self._whole(opcode, start, end)
        self._miss()
        if self.is_cut_off(start):
            return Frame(opcode, start, self.size, is_whole=False)
        return Frame(opcode, start, self._next_record(start + 1), is_whole=False)

    def _whole(self, opcode: int, start: int, end: int) -> Frame:
        begin = start + PREFIX.size
        return Frame(
            opcode, start, end, self.read(start, PREFIX.size), self.read(begin, end - begin)
        )

    def _is_valid(self, opcode: int, begin: int, length: int) -> bool:
        """Whether a frame is a record, by its inner lengths or by what follows it."""
        if opcode in _LAYOUTS:
            return self._adds_up(opcode, begin, length)
        return begin + length == self.size or self._may_begin(begin + length)

    def _head(self, start: int) -> tuple[int, int]:
        """Return opcode and length of what begins here; 0, 0 at the end of the file."""
        prefix = self.read(start, PREFIX.size)
        return PREFIX.unpack(prefix) if len(prefix) == PREFIX.size else (0, 0)

    def _may_begin(self, start: int) -> bool:
        opcode, length = self._head(start)
        return 0 < opcode <= _LAST_OPCODE and length <= self.ceiling

    def _adds_up(self, opcode: int, begin: int, length: int) -> bool:
        """Whether the inner lengths of a record, whose content begins here, fill its length."""
        if opcode not in _LAYOUTS:
            return False
        inner, last = _LAYOUTS[opcode]
        offset = 0
        for gap, size in inner:
            number = self.read(begin + offset + gap, size)
            if len(number) < size or offset > length:
                return False
            offset += gap + size + int.from_bytes(number, 'little')
        return offset + last == length

    def _next_record(self, start: int) -> int:
        """Return where the next whole record begins, or the end of the file if there is none."""
        size = _FIRST_WINDOW
        while start < self.size:
            for place in self._likely(start, size):
                if self.is_record(place):
                    return place
                self._miss()
            start, size = start + size, min(2 * size, _LAST_WINDOW)
        return self.size

    def _likely(self, start: int, size: int) -> list[int]:
        """Return the places, of so many, where opcode and length are those of some record."""
        window = np.frombuffer(self.read(start, size + PREFIX.size - 1), np.uint8)
        if len(window) < PREFIX.size:
            return []
        opcodes = window[: len(window) - PREFIX.size + 1]
        # No record has 4 GiB: the upper bytes of a length are 0.
        upper = window[5:-3] | window[6:-2] | window[7:-1] | window[8:]
        # Opcode 0 wraps around and is not a record.
        places = np.flatnonzero((opcodes - np.uint8(1) < _LAST_OPCODE) & (upper == 0))
        lengths = sum(window[places + 1 + i].astype(np.int64) << 8 * i for i in range(4))
        most = np.minimum(self.ceiling, self.size - PREFIX.size - start - places)
        fits = (lengths >= _LEAST[opcodes[places]]) & (lengths <= most)
        return (start + places[fits]).tolist()

    def _miss(self) -> None:
        """Count a place that is no record."""
        self._misses += 1
        if self._misses > self._most_misses:
            raise BagError(
                f'{self._file.name} is damaged at more than {self._most_misses} places, the limit '
                'for a file of its size'
            )

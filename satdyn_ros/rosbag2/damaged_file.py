"""What a damaged file still holds, and what of it is lost."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, DataEnd, Header, Schema, Statistics

from .chunk import Contents
from .errors import BagError
from .records import IndexRecord, message_indexes
from .scan import Block, Flaw, Found, scan
from .summary import SummaryBuilder

_MADE_ANEW = (Opcode.HEADER, Opcode.MESSAGE_INDEX, Opcode.DATA_END)


@dataclass(frozen=True)
class Loss:
    """
    What can no longer be recovered from a file.

    byte_count: bytes that are lost, None: the whole file; 0: a Header or Metadata record is not as
    it was written, but it is unknown which.  span_ns: log times between which messages may be
    missing; None: there are no messages around.  begin_ns: the file's first log time.
    message_count: None: not known.  is_empty: the file is there, but holds nothing.
    """

    file: str
    byte_count: int | None
    span_ns: tuple[int, int] | None = None
    begin_ns: int = 0
    message_count: int | None = None
    is_empty: bool = False

    def __str__(self) -> str:
        if self.byte_count is None:
            return f'{self.file}: the file {"holds nothing" if self.is_empty else "is missing"}'
        if self.byte_count == 0:
            return (
                f'{self.file}: a Header or Metadata record is not as it was written; '
                'all are kept as they are'
            )
        said = f'{self.file}: {self.byte_count} bytes lost'
        if self.message_count is not None:
            said += f', {self.message_count} messages'
        if self.span_ns is not None:
            first_s, last_s = ((time - self.begin_ns) * 1e-9 for time in self.span_ns)
            said += f', from {first_s:.9g} s to {last_s:.9g} s after its first message'
        return said


class DamagedFile:
    """
    A damaged file, read once from start to end.

    header: None: it is lost.  summary: what its data hold; its schemas and channels are those that
    data or summary declare.  lost_bytes: how many cannot be read.  BagError: it cannot be kept
    whole.
    """

    def __init__(self, path: Path):
        self.header: Header | None = None
        self.summary = SummaryBuilder()
        self._name = path.name
        self._statistics: Statistics | None = None
        self.lost_bytes = 0
        self._crc = 0
        self._is_data = True
        self._is_doubtful = False
        self._lost_counts: list[int | None] = []
        self._times_ns: list[int] = []
        self._begin_ns = self._last_ns = 0
        self._behind_gap = False
        self._indexes = 0, 0
        for found in scan(path):
            self._take(found)
        for id_ in (
            self.summary.statistics.channel_message_counts.keys() - self.summary.channels.keys()
        ):
            # Its messages are all that is left of the channel.
            self.summary.channels[id_] = Channel(id_, f'/channel_{id_}', 'cdr', {}, 0)

    def loss(self, crc: int) -> Loss | None:
        """
        Return what is lost; None: all that the file held is still there.

        crc: the checksum of the data written again.
        """
        if self.lost_bytes == 0 and (not self._is_doubtful or crc == self._crc):
            return None
        count = None
        if self._statistics is not None:
            count = self._statistics.message_count - self.summary.statistics.message_count
        elif None not in self._lost_counts:
            count = sum(n for n in self._lost_counts if n is not None)
        times_ns = self._times_ns
        return Loss(
            file=self._name,
            byte_count=self.lost_bytes,
            span_ns=(min(times_ns), max(times_ns)) if times_ns else None,
            begin_ns=self._begin_ns,
            message_count=count,
        )

    def _take(self, found: Found) -> None:
        match found.item:
            case Header():
                self.header = found.item
            case Block(contents):
                self._take_block(found, contents)
            case IndexRecord(_, entries):
                if self._behind_gap and len(entries):
                    self._lost_counts[-1] = (self._lost_counts[-1] or 0) + len(entries)
                    times = entries['log_time']
                    self._times_ns += [int(np.min(times)), int(np.max(times))]
            case DataEnd(data_section_crc=crc):
                self._crc, self._is_data = crc, False
            case Schema():
                self.summary.schemas.setdefault(found.item.id, found.item)
            case Channel():
                self.summary.channels.setdefault(found.item.id, found.item)
            case Statistics():
                self._statistics = found.item
            case Attachment():
                raise BagError(f'{self._name} has attachments, which rosbag2 does not support')
            case Flaw():
                self._take_flaw(found, found.item)

    def _take_block(self, found: Found, contents: Contents) -> None:
        if self.summary.statistics.message_count == 0:
            self._begin_ns = contents.span_ns[0]
        if self._behind_gap and len(contents):
            self._times_ns.append(contents.span_ns[0])
        self._behind_gap = False
        self._last_ns = max(self._last_ns, contents.span_ns[1])
        self._indexes = found.end, found.end + len(message_indexes(contents, found.end)[0])
        self.summary.add_messages(contents)

    def _take_flaw(self, found: Found, flaw: Flaw) -> None:
        if flaw.opcode == Opcode.DATA_END and not flaw.is_end:
            self._is_doubtful = True
        first, last = self._indexes
        is_index = first <= found.start and found.end <= last and flaw.opcode != Opcode.CHUNK
        if not self._is_data or is_index or flaw.opcode in _MADE_ANEW or found.start == 0:
            return
        self.lost_bytes += found.end - found.start
        self._lost_counts.append(0 if flaw.opcode == Opcode.METADATA else None)
        if self._last_ns:
            self._times_ns.append(self._last_ns)
        self._behind_gap = True

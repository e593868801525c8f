"""
The data of a file checked as they are read: chunks, their indexes, what is declared and counted.

Bags written by satdyn_ros have every checksum and index of the format.  Other writers leave some
out; so did version 0.1, which wrote no checksum of the data.
"""

import re
from collections.abc import Callable
from pathlib import Path

from mcap.records import Attachment, Channel, DataEnd, Header, McapRecord, Metadata, Schema

from . import metadata
from .chunk import Contents
from .reader import TopicBlock
from .records import IndexRecord
from .scan import Block, Found
from .summary import SummaryBuilder

_OURS = re.compile(r'satdyn_ros (\d+)\.(\d+)')
_SUMS_DATA_SINCE = (0, 2)


class DataSection:
    """
    The data of a file, record by record, each checked against those before it.

    pass_on: called with messages and metadata in order, once they are checked.  summary: what the
    data hold.  crc: their checksum, 0: none.  end: where they end.  closing: rosbag2's metadata at
    the end of the file, '': none.  is_ours: satdyn_ros wrote the file; has_every_checksum: a
    version of it that leaves none out did.
    """

    def __init__(self, path: Path, pass_on: Callable[[TopicBlock | Metadata], None]):
        self.path = path
        self._pass_on = pass_on
        self._topics: dict[int, str] = {}
        self.summary = SummaryBuilder()
        self.is_ours = self.has_every_checksum = False
        self.crc = 0
        self.end = 0
        self.closing = ''
        self._has_begun = False
        self._chunk: Found | None = None
        self._indexes: dict[int, int] = {}
        self._chunk_end = 0

    def take(self, found: Found) -> bool:
        """Process the next item; return whether it ends the data.  Errors: as integrity.check."""
        item = found.sound(self.path).item
        if isinstance(item, IndexRecord):
            self._take_index(found, item)
            return False
        if item is None and self.is_ours:
            raise found.damaged(self.path, 'satdyn_ros writes none of its kind')
        self._end_chunk()
        if isinstance(item, Header) == self._has_begun:
            raise found.damaged(self.path, 'the data must have one Header, at their start')
        match item:
            case Header():
                self._has_begun = True
                if version := _OURS.match(item.library):
                    self.is_ours = True
                    self.has_every_checksum = (*map(int, version.groups()),) >= _SUMS_DATA_SINCE
            case Block(contents, chunk):
                self._check_declarations(found, contents)
                if chunk is None:
                    self.summary.add_messages(contents)
                    self._pass_messages_on(found, contents)
                else:
                    self._chunk, self._indexes, self._chunk_end = found, {}, found.end
            case Metadata():
                self.summary.add_metadata(found.start, found.end - found.start, item.name)
                if item.name == metadata.NAME:
                    self.closing = item.metadata.get('serialized_metadata', '')
                self._pass_on(item)
            case DataEnd():
                self.crc, self.end = item.data_section_crc, found.end
                if self.crc == 0 and self.has_every_checksum:
                    raise found.damaged(self.path, 'the checksum of the data is missing')
                return True
            case Attachment():
                self.summary.add_attachment(found.start, found.end - found.start, item)
            case McapRecord():
                raise found.damaged(self.path, 'it stands among the data')
        return False

    def _take_index(self, found: Found, index: IndexRecord) -> None:
        if self._chunk is None:
            raise found.damaged(self.path, 'there is no chunk before it')
        if index.channel_id in self._indexes or not index.agrees_with(self._chunk.item.contents):
            raise found.damaged(self.path, 'it is not the index of the chunk before it')
        self._indexes[index.channel_id] = found.start
        self._chunk_end = found.end

    def _end_chunk(self) -> None:
        """Process the chunk whose indexes are complete."""
        if self._chunk is None:
            return
        found, (contents, chunk) = self._chunk, self._chunk.item
        span_ns = chunk.message_start_time, chunk.message_end_time
        if len(contents) and span_ns != contents.span_ns:
            raise found.damaged(self.path, 'its times are not those of its messages')
        missing = [i for i in contents.counts if i not in self._indexes]
        if missing and (self._indexes or self.is_ours):
            raise found.damaged(self.path, f'the index of channel {min(missing)} is missing')
        size = self._chunk_end - found.end
        self.summary.add_chunk(found.start, found.end, chunk, contents, self._indexes, size)
        self._pass_messages_on(found, contents)
        self._chunk = None

    def _check_declarations(self, found: Found, contents: Contents) -> None:
        schemas, channels = contents.declarations
        declared: list[Schema | Channel] = [*schemas.values(), *channels.values()]
        for record in declared:
            is_schema = isinstance(record, Schema)
            before = self.summary.schemas if is_schema else self.summary.channels
            if before.get(record.id, record) != record:
                what = f'{type(record).__name__} {record.id} was declared before, in another way'
                raise found.damaged(self.path, what)

    def _pass_messages_on(self, found: Found, contents: Contents) -> None:
        """Pass on messages whose channels are all declared."""
        # Not as a difference of sets, which takes as long as there are channels.
        if unknown := [i for i in contents.counts if i not in self.summary.channels]:
            raise found.damaged(self.path, f'channel {min(unknown)} in it is not declared')
        _, channels = contents.declarations
        self._topics |= {id_: channel.topic for id_, channel in channels.items()}
        self._pass_on(TopicBlock(contents, self._topics))

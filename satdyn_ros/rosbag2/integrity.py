"""
Whether all parts of a bag agree: its data, their indexes, the summaries, metadata.yaml.

Bags written by satdyn_ros have every checksum and index of the format.  Other writers leave some
out; so did version 0.1, which wrote no checksum of the data.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from . import metadata
from .errors import Damaged, Incomplete
from .metadata import BagContents
from .reader import Bag
from .records import IndexRecord, written
from .scan import Block, Flaw, Found, scan
from .summary import Tally, in_order, summary_bytes

_OURS = re.compile(r'satdyn_ros (\d+)\.(\d+)')
_SUMS_DATA_SINCE = (0, 2)
# What metadata.yaml counts in the files of any bag, the last two if there are messages.
_COUNTED = ('message_count', 'relative_file_paths', 'starting_time', 'duration')
_ONLY_IN_CLOSING = ('custom_data', 'ros_distro')
_OPCODES = {
    Schema: Opcode.SCHEMA,
    Channel: Opcode.CHANNEL,
    Statistics: Opcode.STATISTICS,
    ChunkIndex: Opcode.CHUNK_INDEX,
    MetadataIndex: Opcode.METADATA_INDEX,
    AttachmentIndex: Opcode.ATTACHMENT_INDEX,
}


@dataclass(frozen=True)
class CheckedFile:
    """
    A file whose parts agree.

    tally: what its data hold; its schemas and channels are those of the summary.  is_ours:
    satdyn_ros wrote it.  has_checksum: its data have one.  closing: rosbag2's metadata at its end,
    '': none.
    """

    path: Path
    tally: Tally
    is_ours: bool
    has_checksum: bool
    closing: str


def check(bag: Bag) -> list[str]:
    """
    Check everything in a bag against everything else; return in words what cannot be checked.

    Damaged: the first contradiction, by file and record.  Incomplete: a file is cut off.
    """
    files = [check_file(path) for path in bag.files]
    if bag.information is not None:
        check_metadata(bag.path / metadata.FILE_NAME, bag.information, files)
    return [
        f'{file.path.name} has no checksum of its data' for file in files if not file.has_checksum
    ]


def check_file(path: Path) -> CheckedFile:
    """Check the records of a file against each other; errors: as check."""
    data = _Data(path)
    found = scan(path)
    for item in found:
        if data.take(item):
            break
    else:
        raise Damaged(f'{path} is damaged: its data section has no end')
    _Summary(path, data, [_sound(path, item) for item in found]).check()
    return CheckedFile(path, data.tally, data.is_ours, data.crc != 0, data.closing)


class _Data:
    """The data section of a file, record by record."""

    def __init__(self, path: Path):
        self.path = path
        self.tally = Tally()
        self.header: Header | None = None
        self.crc = 0
        self.end = 0
        self.closing = ''
        self._chunk: Found | None = None
        self._indexes: dict[int, int] = {}
        self._chunk_end = 0

    @property
    def is_ours(self) -> bool:
        return self._version is not None

    @property
    def _version(self) -> tuple[int, ...] | None:
        found = _OURS.match(self.header.library) if self.header else None
        return tuple(map(int, found.groups())) if found else None

    def take(self, found: Found) -> bool:
        """Process the next item and return whether it ends the data."""
        item = _sound(self.path, found).item
        if isinstance(item, IndexRecord):
            self._take_index(found, item)
            return False
        if item is None and self.is_ours:
            raise _damaged(self.path, found, 'satdyn_ros writes none of its kind')
        self._end_chunk()
        if isinstance(item, Header) != (self.header is None):
            raise _damaged(self.path, found, 'the data must have one Header, at their start')
        match item:
            case Header():
                self.header = item
            case Block(contents, chunk):
                if chunk is None:
                    self.tally.add_messages(contents)
                    self._check_channels(found, contents)
                else:
                    self._chunk, self._indexes, self._chunk_end = found, {}, found.end
            case Metadata():
                self.tally.add_metadata(found.start, found.end - found.start, item.name)
                if item.name == metadata.NAME:
                    self.closing = item.metadata.get('serialized_metadata', '')
            case DataEnd():
                self.crc, self.end = item.data_section_crc, found.end
                if self.crc == 0 and (self._version or (0, 0)) >= _SUMS_DATA_SINCE:
                    raise _damaged(self.path, found, 'the checksum of the data is missing')
                return True
            case Attachment():
                self.tally.statistics.attachment_count += 1
            case Statistics() | ChunkIndex() | MetadataIndex() | SummaryOffset() | Footer():
                raise _damaged(self.path, found, 'it stands among the data')
        return False

    def _take_index(self, found: Found, index: IndexRecord) -> None:
        if self._chunk is None:
            raise _damaged(self.path, found, 'there is no chunk before it')
        if index.channel_id in self._indexes or not index.agrees_with(self._chunk.item.contents):
            raise _damaged(self.path, found, 'it is not the index of the chunk before it')
        self._indexes[index.channel_id] = found.start
        self._chunk_end = found.end

    def _end_chunk(self) -> None:
        """Process the chunk whose indexes are complete."""
        if self._chunk is None:
            return
        found, (contents, chunk) = self._chunk, self._chunk.item
        if len(contents) and (chunk.first_ns, chunk.last_ns) != contents.span_ns:
            raise _damaged(self.path, found, 'its times are not those of its messages')
        missing = contents.counts.keys() - self._indexes.keys()
        if missing and (self._indexes or self.is_ours):
            raise _damaged(self.path, found, f'the index of channel {min(missing)} is missing')
        size = self._chunk_end - found.end
        self.tally.add_chunk(found.start, chunk, contents, self._indexes, size)
        self._check_channels(found, contents)
        self._chunk = None

    def _check_channels(self, found: Found, contents) -> None:
        unknown = contents.counts.keys() - self.tally.channels.keys()
        if unknown:
            raise _damaged(self.path, found, f'channel {min(unknown)} in it is not declared')


class _Summary:
    """What follows the data of a file."""

    def __init__(self, path: Path, data: _Data, found: list[Found]):
        self._path = path
        self._data = data
        self._found = found
        if not found or not isinstance(found[-1].item, Footer):
            raise Damaged(f'{path} is damaged: there is no Footer record at its end')

    def check(self) -> None:
        """Check the summary against the data, and add to the tally what only the summary says."""
        footer_found = self._found[-1]
        footer = footer_found.item
        summary_bytes(self._path)
        if self._data.is_ours and footer.summary_crc == 0:
            raise self._damaged(footer_found, 'the checksum of the summary is missing')
        starts = {type(found.item): found.start for found in reversed(self._found)}
        begin = self._data.end if len(self._found) > 1 else 0
        if (footer.summary_start, footer.summary_offset_start) != (
            begin if footer.summary_start else 0,
            starts.get(SummaryOffset, 0) if footer.summary_offset_start else 0,
        ):
            raise self._damaged(footer_found, 'it does not point at the summary')
        self._check_declarations()
        self._check_indexes(ChunkIndex, self._data.tally.chunk_indexes)
        self._check_indexes(MetadataIndex, self._data.tally.metadata_indexes)
        self._check_statistics()
        self._check_offsets()

    def _of(self, kind: type) -> list[Found]:
        return [found for found in self._found if isinstance(found.item, kind)]

    def _check_declarations(self) -> None:
        tally = self._data.tally
        for kind, declared in ((Schema, tally.schemas), (Channel, tally.channels)):
            listed = {found.item.id: found for found in self._of(kind)}
            for id_, record in declared.items():
                if id_ in listed and listed[id_].item != record:
                    raise self._damaged(listed[id_], 'the data declare another of this id')
                if id_ not in listed and (listed or self._data.is_ours):
                    raise self._missing(f'{kind.__name__} {id_}')
            declared |= {id_: found.item for id_, found in listed.items()}

    def _check_indexes(self, kind: type, expected: dict[int, bytes]) -> None:
        listed = self._of(kind)
        places = set()
        for found in listed:
            index = found.item
            is_chunk = isinstance(index, ChunkIndex)
            place = index.chunk_start_offset if is_chunk else index.offset
            if expected.get(place) != (in_order(index) if is_chunk else written([index])):
                raise self._damaged(found, f'it does not match what is at byte {place}')
            places.add(place)
        if expected.keys() - places and (listed or self._data.is_ours):
            raise self._missing(f'{kind.__name__} of byte {min(expected.keys() - places)}')

    def _check_statistics(self) -> None:
        tally, listed = self._data.tally, self._of(Statistics)
        tally.close()
        for found in listed:
            if found.item != tally.statistics:
                raise self._damaged(found, 'it does not count what the data hold')
        if not listed and self._data.is_ours:
            raise self._missing('Statistics')

    def _check_offsets(self) -> None:
        groups: dict[int, tuple[int, int]] = {}
        for found in self._found[:-1]:
            if not isinstance(found.item, SummaryOffset):
                opcode = _OPCODES[type(found.item)]
                start = groups.get(opcode, (found.start, 0))[0]
                groups[opcode] = start, found.end - start
        for found in self._of(SummaryOffset):
            offset = found.item
            group = groups.get(offset.group_opcode, (offset.group_start, 0))
            if group != (offset.group_start, offset.group_length):
                raise self._damaged(found, 'it does not point at its group')

    def _missing(self, what: str) -> Damaged:
        return Damaged(f'{self._path} is damaged: its summary has no {what}')

    def _damaged(self, found: Found, why: str) -> Damaged:
        return _damaged(self._path, found, why)


def check_metadata(path: Path, said: dict[str, Any], files: list[CheckedFile]) -> None:
    """
    Check metadata.yaml against the files; for satdyn_ros also against their closing records.

    Damaged: the first contradiction, by its key.
    """
    contents = BagContents()
    for file in files:
        contents.add(file.path.name, file.tally)
    held = metadata.parse(contents.to_yaml(), str(path))
    last = files[-1]
    if last.is_ours:
        closing = metadata.parse(last.closing, f'the last Metadata record of {last.path}')
        held = closing | {key: held[key] for key in held if key not in _ONLY_IN_CLOSING}
    else:
        keys = _COUNTED if held['message_count'] else _COUNTED[:2]
        held = {key: held[key] for key in keys}
    for key in [*held, *said]:
        if (key in held or last.is_ours) and said.get(key) != held.get(key):
            raise Damaged(f'{path} is damaged: its {key} is not what the files say')


def _sound(path: Path, found: Found) -> Found:
    """Return what was found, unless it is a flaw."""
    if isinstance(found.item, Flaw):
        raise (Incomplete if found.item.is_end else Damaged)(f'{path} {found.item.what}')
    return found


def _damaged(path: Path, found: Found, why: str) -> Damaged:
    """Return the error for a record that contradicts others."""
    kind = type(found.item)
    names = {Block: 'Chunk', IndexRecord: 'MessageIndex', type(None): 'unknown'}
    name = names.get(kind, kind.__name__)
    return Damaged(f'{path} is damaged: the {name} record at byte {found.start}: {why}')

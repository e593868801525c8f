"""
Whether all parts of a bag agree: its data, the summaries of its files, metadata.yaml.

Bags written by satdyn_ros have every checksum of the format, and summaries that follow from their
data.  Other writers leave some out; so did version 0.1, which wrote no checksum of the data.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.records import DataEnd, Header, Metadata

from . import metadata
from .errors import Damaged
from .metadata import BagMetadata
from .reader import Bag, TopicBlock
from .scan import Block, Found, scan
from .summary import SummaryBuilder, read_summary

_OURS = re.compile(r'satdyn_ros (\d+)\.(\d+)')
_SUMS_DATA_SINCE = (0, 2)
_ONLY_IN_CLOSING = ('custom_data', 'ros_distro')


def check(
    bag: Bag, pass_on: Callable[[TopicBlock | Metadata], None] = lambda _: None
) -> list[str]:
    """
    Check everything in a bag against everything else; return in words what cannot be checked.

    pass_on: called with each item of the bag, as Bag.items yields them, once it is checked.
    Damaged: the first contradiction, by file and record.  Incomplete: a file is cut off.
    """
    contents, notes = BagMetadata(), []
    for path in bag.files:
        file = CheckedFile(path, pass_on)
        contents.add(path.name, file.summary)
        if not file.crc:
            notes.append(f'{path.name} has no checksum of its data')
    if bag.information is not None:
        check_metadata(bag.path / metadata.FILE_NAME, bag.information, contents, file)
    return notes


class CheckedFile:
    """
    A file whose parts agree; pass_on and errors: as of check.

    summary: what its data hold, with what the file's own summary declares besides.  crc: the
    checksum of the data, 0: none.  closing: rosbag2's metadata at the end of the file, '': none.
    is_ours: satdyn_ros wrote it.
    """

    def __init__(
        self, path: Path, pass_on: Callable[[TopicBlock | Metadata], None] = lambda _: None
    ):
        self.path = path
        self.summary = SummaryBuilder()
        self.crc = 0
        self.closing = ''
        self.is_ours = False
        self._has_every_checksum = False
        self._pass_on = pass_on
        self._topics: dict[int, str] = {}
        self._check_summary(self._check_data())

    def _check_data(self) -> int:
        """Check the records of the data; return where they end."""
        for found in scan(self.path):
            item, length = found.sound().item, found.end - found.start
            match item:
                case Header(library=library) if version := _OURS.match(library):
                    self.is_ours = True
                    self._has_every_checksum = (*map(int, version.groups()),) >= _SUMS_DATA_SINCE
                case Block():
                    self._check_block(found)
                case Metadata(name=name):
                    self.summary.add_metadata(found.start, length, name)
                    if name == metadata.NAME:
                        self.closing = item.metadata.get('serialized_metadata', '')
                    self._pass_on(item)
                case DataEnd(data_section_crc=crc):
                    if crc == 0 and self._has_every_checksum:
                        raise found.damaged(self.path, 'the checksum of the data is missing')
                    self.crc = crc
                    return found.end
                case None if self.is_ours:
                    raise found.damaged(self.path, 'satdyn_ros writes none of its kind')
        raise Damaged(f'{self.path} is damaged: its data section has no end')

    def _check_block(self, found: Found) -> None:
        """Check what messages declare, count them, and pass them on."""
        contents, chunk = found.item
        known: tuple[dict[int, Any], ...] = self.summary.schemas, self.summary.channels
        for before, declared in zip(known, contents.declarations, strict=True):
            if any(before.get(i, record) != record for i, record in declared.items()):
                raise found.damaged(self.path, 'what it declares was declared in another way')
        if chunk is None:
            self.summary.add_messages(contents)
        else:
            self.summary.add_chunk(found.start, found.end, chunk, contents)
        # Not as a difference of sets, which takes as long as there are channels.
        if unknown := [i for i in contents.counts if i not in self.summary.channels]:
            raise found.damaged(self.path, f'channel {min(unknown)} in it is not declared')
        _, channels = contents.declarations
        self._topics |= {id_: channel.topic for id_, channel in channels.items()}
        self._pass_on(TopicBlock(contents, self._topics))

    def _check_summary(self, start: int) -> None:
        """Check the summary that begins at `start`, as far as it follows from the data."""
        said, held = read_summary(self.path), self.summary
        held.schemas = said.schemas | held.schemas
        held.channels = said.channels | held.channels
        with open(self.path, 'rb') as file:
            file.seek(start)
            if self._has_every_checksum and file.read() != held.end_of_file(start):
                what = 'its summary does not say what its data hold'
                raise Damaged(f'{self.path} is damaged: {what}')


def check_metadata(
    path: Path, said: dict[str, Any], contents: BagMetadata, last: CheckedFile
) -> None:
    """
    Check metadata.yaml of a bag of satdyn_ros against its files and what the last closes with.

    Each key may say what its writer wrote, or what `ros2 bag reindex` does.  Damaged: the first
    contradiction, by its key.
    """
    if not last.is_ours:
        return
    held = contents.said()
    reindexed = metadata.as_reindexed(held, contents.files)
    origin = f'the last Metadata record of {last.path}'
    closing = metadata.parse(last.closing, origin, len(last.closing))
    held = closing | {key: held[key] for key in held if key not in _ONLY_IN_CLOSING}
    for key in [*held, *said]:
        allowed = held.get(key), reindexed.get(key, held.get(key))
        if said.get(key) not in allowed:
            raise Damaged(f'{path} is damaged: its {key} is not what the files say')

"""Complete a bag whose writer was killed: index, statistics, summary and metadata.yaml."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from mcap.records import Attachment, Channel, Header, McapRecord, Metadata, Schema, Statistics

from . import metadata
from .compression import compressor
from .mcap_file import McapFile
from .metadata import BagMetadata, FileInformation, TopicMetadata
from .reader import Bag
from .scan import Block, Incomplete, read_summary, scan

_LOST_HEADER = Header('ros2', 'satdyn_ros')


@dataclass(frozen=True)
class Recovered:
    """What recover did: the files that it completed, and the messages that the bag has."""

    files: tuple[str, ...]
    message_count: int


def recover(path: str | Path) -> Recovered:
    """
    Complete a bag that was not closed: a directory, or a bare .mcap file.

    Everything that reached its files is kept, of a chunk that is cut off its whole messages.  A
    file is replaced when the new one is complete; what is complete is left as it is.

    ValueError: path is no bag, or one that cannot be kept whole.  OSError: the new file cannot be
    written.
    """
    bag = Bag(path)
    known = _Known(_first_metadata(bag))
    completed = []
    for file in bag.files:
        summary = read_summary(file)
        if summary is None or summary.statistics is None:
            _complete(file, known)
            completed.append(file.name)
        else:
            known.add(file.name, summary.statistics, summary.schemas, summary.channels)
    is_listed = (bag.path / metadata.FILE_NAME).exists()
    if bag.path.is_dir() and (completed or not is_listed):
        known.bag.write(bag.path, tuple(known.topics.values()), known.counts)
    return Recovered(tuple(completed), sum(known.counts.values()))


class _Known:
    """What is known of a bag after its first files; first: what it said of itself at its begin."""

    def __init__(self, first: dict[str, Any]):
        self.bag = BagMetadata([], first.get('custom_data') or {}, first.get('ros_distro', ''))
        self.topics: dict[str, TopicMetadata] = {}
        self.counts: dict[str, int] = {}

    def add(
        self,
        name: str,
        statistics: Statistics,
        schemas: dict[int, Schema],
        channels: dict[int, Channel],
    ) -> None:
        """Take in a file."""
        information = FileInformation(name)
        if statistics.message_count:
            span_ns = statistics.message_start_time, statistics.message_end_time
            information.add(statistics.message_count, *span_ns)
        self.bag.files.append(information)
        for channel in channels.values():
            topic = TopicMetadata.from_records(channel, schemas.get(channel.schema_id))
            count = statistics.channel_message_counts.get(channel.id, 0)
            self.topics[topic.name] = topic
            self.counts[topic.name] = self.counts.get(topic.name, 0) + count

    def record(self) -> dict[str, str]:
        """Return the content of the metadata record that closes a file."""
        return self.bag.record(tuple(self.topics.values()), self.counts)


def _complete(path: Path, known: _Known) -> None:
    """Write a file again with all that can be had of it, then put it in its place."""
    unfinished = path.with_suffix('.recovering')
    unfinished.unlink(missing_ok=True)
    records = _records(path)
    first = next(records, None)
    header = first if isinstance(first, Header) else _LOST_HEADER
    try:
        with closing(McapFile(unfinished, header)) as file:
            _copy(records, file, path)
            known.add(path.name, file.statistics, file.schemas, file.channels)
            # Two in a file: the first at its begin, the second with what is known at its end.
            for _ in range(file.metadata_names.count(metadata.NAME), 2):
                file.write_metadata(metadata.NAME, known.record())
            file.finish()
        unfinished.replace(path)
    except OSError as error:
        raise OSError(f'{unfinished} cannot be written: {error.strerror}') from error
    finally:
        unfinished.unlink(missing_ok=True)


def _copy(records: Iterator[McapRecord | Block], file: McapFile, path: Path) -> None:
    for record in records:
        match record:
            case Block(contents, compression, compressed):
                data = compressed or compressor(compression)(contents.data)
                file.write_chunk(contents.data, compression, data)
            case Metadata():
                file.write_metadata(record.name, record.metadata)
            case Channel():
                file.channels.setdefault(record.id, record)
            case Schema():
                file.schemas.setdefault(record.id, record)
            case Attachment():
                raise ValueError(f'{path} has attachments, which a rosbag2 bag has not')


def _records(path: Path) -> Iterator[McapRecord | Block]:
    """Yield what can be had of a file, but no chunk that is cut off before its first message."""
    try:
        for record in scan(path):
            match record:
                case Block(contents, _, None) if len(contents) == 0:
                    pass
                case _:
                    yield record
    except Incomplete:
        pass


def _first_metadata(bag: Bag) -> dict[str, Any]:
    """Return what rosbag2's first metadata record in a bag says."""
    for item in bag.items():
        if isinstance(item, Metadata) and item.name == metadata.NAME:
            return yaml.safe_load(item.metadata['serialized_metadata'])
    return {}

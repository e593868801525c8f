"""What rosbag2 says: of a bag in metadata.yaml, version 9, and of each file in its own records."""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, Schema

from ..base import ros_yaml
from ..base.block_yaml import block_yaml
from ..base.regular_file import regular_file
from .errors import BagError, Damaged
from .summary import SummaryBuilder

NAME = 'rosbag2'
FILE_NAME = 'metadata.yaml'
_KEY = 'rosbag2_bagfile_information'
# What rosbag2 says of a bag without messages: the latest of its times.
_NO_TIME = 2**63 - 1


@dataclass(frozen=True)
class TopicMetadata:
    """
    A recorded topic.

    name: fully resolved ('/attitude').  type: 'geometry_msgs/msg/QuaternionStamped'.  schema: its
    definition as rosbag2 writes it.  type_hash: 'RIHS01_...'.  qos: the offered profiles, a YAML
    list; '' for none.
    """

    name: str
    type: str
    schema: str
    type_hash: str
    qos: str

    def schema_record(self, schema_id: int) -> Schema:
        """Return the MCAP schema."""
        return Schema(schema_id, self.schema.encode(), 'ros2msg', self.type)

    def channel_record(self, channel_id: int, schema_id: int) -> Channel:
        """Return the MCAP channel."""
        metadata = {'offered_qos_profiles': self.qos, 'topic_type_hash': self.type_hash}
        return Channel(channel_id, self.name, 'cdr', metadata, schema_id)

    def said(self, count: int) -> dict[str, Any]:
        """Return what metadata.yaml says of the topic, which has so many messages."""
        return {
            'topic_metadata': {
                'name': self.name,
                'type': self.type,
                'serialization_format': 'cdr',
                'offered_qos_profiles': _profiles(self.qos),
                'type_description_hash': self.type_hash,
            },
            'message_count': count,
        }

    @classmethod
    def from_records(cls, channel: Channel, schema: Schema | None) -> 'TopicMetadata':
        """Return the topic that a channel and its schema, if it has one, describe."""
        return cls(
            channel.topic,
            schema.name if schema else '',
            schema.data.decode(errors='replace') if schema else '',
            channel.metadata.get('topic_type_hash', ''),
            channel.metadata.get('offered_qos_profiles', ''),
        )


class FileSpan(NamedTuple):
    """A file of a bag: the first and the last log time of its messages, and how many it has."""

    name: str
    first_ns: int
    last_ns: int
    message_count: int


class BagMetadata:
    """
    What metadata.yaml says of a bag, gathered file by file.

    files: of each what is said of it.  counts: messages by topic.
    """

    def __init__(self, custom_data: Mapping[str, str] | None = None, ros_distro: str = 'jazzy'):
        self.files: list[FileSpan] = []
        self.topics: dict[str, TopicMetadata] = {}
        self.counts: Counter[str] = Counter()
        self._custom_data, self._ros_distro = custom_data or {}, ros_distro

    def add(self, name: str, summary: SummaryBuilder) -> None:
        """Add a file by its summary."""
        held = summary.statistics
        span = held.message_start_time, held.message_end_time, held.message_count
        self.files.append(FileSpan(name, *span))
        for _, channel in sorted(summary.channels.items()):
            topic = TopicMetadata.from_records(channel, summary.schemas.get(channel.schema_id))
            self.topics[topic.name] = topic
            self.counts[topic.name] += held.channel_message_counts.get(channel.id, 0)

    def said(self) -> dict[str, Any]:
        """Return the map without its outer key."""
        return {
            'version': 9,
            'storage_identifier': 'mcap',
            **_span(self.files),
            'topics_with_message_count': [
                topic.said(self.counts[name]) for name, topic in self.topics.items()
            ],
            'compression_format': '',
            'compression_mode': '',
            'relative_file_paths': [file.name for file in self.files],
            'files': [_file(file) for file in self.files],
            'custom_data': self._custom_data or None,
            'ros_distro': self._ros_distro,
        }

    def record(self, name: str, summary: SummaryBuilder) -> dict[str, str]:
        """
        Return the metadata record NAME of one file: at its start of an empty summary.

        It says nothing of the other files, so that each costs the same, however many there are.
        """
        alone = BagMetadata(self._custom_data, self._ros_distro)
        alone.add(name, summary)
        return {'serialized_metadata': block_yaml(alone.said())}

    def write(self, directory: Path) -> None:
        """Write metadata.yaml atomically and sync it to disk, which completes the bag."""
        unfinished = directory / f'.{FILE_NAME}'
        with open(unfinished, 'w', encoding='utf-8') as file:
            file.write(block_yaml({_KEY: self.said()}))
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, directory / FILE_NAME)


def read(path: Path) -> dict[str, Any]:
    """
    Return what a metadata.yaml says, without its outer key.

    relative_file_paths are names of files in the bag, custom_data are texts.  Damaged: it is not
    what rosbag2 writes.  BagError: the storage of the bag is not supported.
    """
    try:
        text = regular_file(path).read_text(encoding='utf-8')
    except UnicodeDecodeError:
        raise Damaged(f'{path} is damaged: it is not text') from None
    files = (file for file in path.parent.glob('*.mcap') if file.is_file())
    # Of a file there are more bytes in its own records than here.
    outer = parse(text, str(path), sum(file.stat().st_size for file in files))
    said = outer.get(_KEY)
    if not isinstance(said, dict):
        raise Damaged(f'{path} is damaged: it has no {_KEY}')
    storage = said.get('storage_identifier')
    if storage != 'mcap':
        raise BagError(f'{path.parent} is stored as {storage}; only mcap is supported')
    names: Any = said.get('relative_file_paths')
    are_names = isinstance(names, list) and all(isinstance(name, str) for name in names)
    if not are_names or len(set(names)) < len(names):
        raise Damaged(f'{path} is damaged: its relative_file_paths are not a list of files')
    outside = [name for name in names if Path(name).name != name or name == '..' or '\0' in name]
    if outside:
        raise BagError(f'{path} lists {outside[0]!r}, which is not a file of the bag')
    if isinstance(custom := said.get('custom_data'), dict):
        # To rosbag2 they are texts, which it writes without quotes: rules: 2
        said['custom_data'] = {key: str(value) for key, value in custom.items()}
    return said


def parse(text: str, origin: str, size: int) -> dict[str, Any]:
    """
    Return the map in a YAML text; size: as of ros_yaml.load.

    Damaged, naming the origin: it is not a map.
    """
    try:
        said = ros_yaml.load(text, origin, size)
    except ValueError as error:
        raise Damaged(f'{origin} is damaged: {error}') from None
    if not isinstance(said, dict):
        raise Damaged(f'{origin} is damaged: it has no keys and values')
    return said


def as_reindexed(held: dict[str, Any], files: Sequence[FileSpan]) -> dict[str, Any]:
    """
    Return what `ros2 bag reindex` writes in another way than the writer of a bag.

    held: what metadata.yaml says of the files.
    """
    return {
        # The sum of those of the files, without the time between them.
        'duration': {'nanoseconds': sum(file.last_ns - file.first_ns for file in files)},
        'starting_time': {'nanoseconds_since_epoch': min(file.first_ns for file in files)},
        'topics_with_message_count': sorted(
            held['topics_with_message_count'], key=lambda topic: topic['topic_metadata']['name']
        ),
        'files': [],
    }


def _span(files: Sequence[FileSpan]) -> dict[str, Any]:
    """Return from when to when files have messages, and how many."""
    some = [file for file in files if file.message_count]
    first_ns = min((file.first_ns for file in some), default=_NO_TIME)
    last_ns = max((file.last_ns for file in some), default=first_ns)
    return {
        'duration': {'nanoseconds': last_ns - first_ns},
        'starting_time': {'nanoseconds_since_epoch': first_ns},
        'message_count': sum(file.message_count for file in some),
    }


def _file(file: FileSpan) -> dict[str, Any]:
    """Return what is said of one file, which begins with its starting time."""
    span = _span([file])
    keys = 'starting_time', 'duration', 'message_count'
    return {'path': file.name, **{key: span[key] for key in keys}}


# Every file has the same few.
@lru_cache(maxsize=64)
def _profiles(qos: str) -> Any:
    """Return a list of profiles; as rosbag2 before version 9, the text itself if it is none."""
    try:
        return ros_yaml.load(qos, 'offered_qos_profiles') or []
    except ValueError:
        return qos

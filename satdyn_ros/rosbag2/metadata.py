"""What rosbag2 says of a bag: metadata.yaml, version 9, and the same in each file's records."""

import json
import os
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.records import Channel, Schema, Statistics

from ..base import ros_yaml
from ..base.regular_file import regular_file
from .errors import BagError, Damaged
from .summary import SummaryBuilder

NAME = 'rosbag2'
FILE_NAME = 'metadata.yaml'
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


@dataclass
class FileInformation:
    """A file of a bag: its name, its message count and the log times [ns] it spans."""

    path: str
    message_count: int = 0
    first_ns: int = _NO_TIME
    last_ns: int = -1

    @classmethod
    def of(cls, name: str, statistics: Statistics) -> 'FileInformation':
        """Return what the statistics of a file say."""
        if statistics.message_count == 0:
            return cls(name)
        span_ns = statistics.message_start_time, statistics.message_end_time
        return cls(name, statistics.message_count, *span_ns)

    def add(self, count: int, first_ns: int, last_ns: int) -> None:
        """Count messages that lie between two log times."""
        self.message_count += count
        self.first_ns = min(self.first_ns, first_ns)
        self.last_ns = max(self.last_ns, last_ns)

    @property
    def duration_ns(self) -> int:
        """Return the time between first and last message."""
        return max(0, self.last_ns - self.first_ns)


@dataclass
class BagMetadata:
    """What metadata.yaml says of a bag besides its topics."""

    files: list[FileInformation]
    custom_data: Mapping[str, str] = field(default_factory=dict)
    ros_distro: str = 'jazzy'

    def to_yaml(self, topics: Sequence[TopicMetadata], counts: Mapping[str, int]) -> str:
        """Return the map without its outer key; counts: messages by the topic's name."""
        first_ns = min(file.first_ns for file in self.files)
        last_ns = max(file.last_ns for file in self.files)
        return '\n'.join(
            [
                'version: 9',
                'storage_identifier: mcap',
                'duration:',
                f'  nanoseconds: {max(0, last_ns - first_ns)}',
                'starting_time:',
                f'  nanoseconds_since_epoch: {first_ns}',
                f'message_count: {sum(file.message_count for file in self.files)}',
                _list('topics_with_message_count', [_topic(t, counts) for t in topics]),
                'compression_format: ""',
                'compression_mode: ""',
                _list('relative_file_paths', [_scalar(file.path) for file in self.files]),
                _list('files', [_file(file) for file in self.files]),
                _map('custom_data', self.custom_data),
                f'ros_distro: {_scalar(self.ros_distro)}',
            ]
        )

    def record(
        self, topics: Sequence[TopicMetadata] = (), counts: Mapping[str, int] | None = None
    ) -> dict[str, str]:
        """Return the content of the metadata record NAME; at the start, topics are unknown."""
        return {'serialized_metadata': self.to_yaml(topics, counts or {})}

    def write(
        self, directory: Path, topics: Sequence[TopicMetadata], counts: Mapping[str, int]
    ) -> None:
        """Write metadata.yaml atomically and sync it to disk, which completes the bag."""
        text = f'rosbag2_bagfile_information:\n{_indent(self.to_yaml(topics, counts), 2)}'
        unfinished = directory / f'.{FILE_NAME}'
        with open(unfinished, 'w', encoding='utf-8') as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, directory / FILE_NAME)


class BagContents:
    """What metadata.yaml says of a bag, gathered file by file."""

    def __init__(self, custom_data: Mapping[str, str] | None = None, ros_distro: str = ''):
        self.bag = BagMetadata([], custom_data or {}, ros_distro)
        self.topics: dict[str, TopicMetadata] = {}
        self.counts: dict[str, int] = {}

    def add(self, name: str, summary: SummaryBuilder) -> None:
        """Add a file by its summary."""
        self.bag.files.append(FileInformation.of(name, summary.statistics))
        counts = summary.statistics.channel_message_counts
        for _, channel in sorted(summary.channels.items()):
            topic = TopicMetadata.from_records(channel, summary.schemas.get(channel.schema_id))
            self.topics[topic.name] = topic
            self.counts[topic.name] = self.counts.get(topic.name, 0) + counts.get(channel.id, 0)

    def to_yaml(self) -> str:
        """Return the map without its outer key."""
        return self.bag.to_yaml(tuple(self.topics.values()), self.counts)

    def record(self) -> dict[str, str]:
        """Return the content of the metadata record that closes a file."""
        return self.bag.record(tuple(self.topics.values()), self.counts)

    def write(self, directory: Path) -> None:
        """Write metadata.yaml."""
        self.bag.write(directory, tuple(self.topics.values()), self.counts)


def read(path: Path) -> dict[str, Any]:
    """
    Return what a metadata.yaml says, without its outer key.

    relative_file_paths are names of files in the bag, custom_data are texts.  Damaged: it is not
    what rosbag2 writes.
    BagError: the storage or compression of the bag is not supported.
    """
    try:
        text = regular_file(path).read_text(encoding='utf-8')
    except UnicodeDecodeError:
        raise Damaged(f'{path} is damaged: it is not text') from None
    outer = parse(text, str(path))
    said = outer.get('rosbag2_bagfile_information')
    if not isinstance(said, dict):
        raise Damaged(f'{path} is damaged: it has no rosbag2_bagfile_information')
    storage = said.get('storage_identifier')
    if storage != 'mcap':
        raise BagError(f'{path.parent} is stored as {storage}; only mcap is supported')
    names = said.get('relative_file_paths')
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise Damaged(f'{path} is damaged: its relative_file_paths are not a list of names')
    outside = [name for name in names if Path(name).name != name or name == '..' or '\0' in name]
    if outside:
        raise BagError(f'{path} lists {outside[0]!r}, which is not a file of the bag')
    if len(set(names)) < len(names):
        raise Damaged(f'{path} is damaged: its relative_file_paths list a file twice')
    if isinstance(custom := said.get('custom_data'), dict):
        # To rosbag2 they are texts, which it writes without quotes: rules: 2
        said['custom_data'] = {key: str(value) for key, value in custom.items()}
    return said


def parse(text: str, origin: str) -> dict[str, Any]:
    """Return the map in a YAML text; Damaged, naming the origin: it is not a map."""
    try:
        said = ros_yaml.load(text, origin)
    except ValueError as error:
        raise Damaged(f'{origin} is damaged: {error}') from None
    if not isinstance(said, dict):
        raise Damaged(f'{origin} is damaged: it has no keys and values')
    return said


def as_reindexed(held: dict[str, Any], files: Sequence[Statistics]) -> dict[str, Any]:
    """
    Return what `ros2 bag reindex` writes in another way than the writer of a bag.

    held: what metadata.yaml says of the files.  files: their statistics.
    """
    return {
        # The sum of those of the files, without the time between them.
        'duration': {
            'nanoseconds': sum(file.message_end_time - file.message_start_time for file in files)
        },
        'starting_time': {
            'nanoseconds_since_epoch': min(file.message_start_time for file in files)
        },
        'topics_with_message_count': sorted(
            held['topics_with_message_count'], key=lambda topic: topic['topic_metadata']['name']
        ),
        'files': [],
    }


def _topic(topic, counts):
    profiles = f'offered_qos_profiles:\n{_indent(topic.qos, 2)}'
    return '\n'.join(
        [
            'topic_metadata:',
            f'  name: {_scalar(topic.name)}',
            f'  type: {_scalar(topic.type)}',
            '  serialization_format: cdr',
            _indent(profiles if topic.qos else 'offered_qos_profiles: []', 2),
            f'  type_description_hash: {_scalar(topic.type_hash)}',
            f'message_count: {counts.get(topic.name, 0)}',
        ]
    )


def _file(file):
    return '\n'.join(
        [
            f'path: {_scalar(file.path)}',
            'starting_time:',
            f'  nanoseconds_since_epoch: {file.first_ns}',
            'duration:',
            f'  nanoseconds: {file.duration_ns}',
            f'message_count: {file.message_count}',
        ]
    )


def _list(key, items):
    """Return a YAML list of texts; the lines after an item's first one are indented."""
    if not items:
        return f'{key}: []'
    return '\n'.join([f'{key}:', *('  - ' + _indent(item, 4).lstrip() for item in items)])


def _map(key, mapping):
    if not mapping:
        return f'{key}: ~'
    return '\n'.join(
        [f'{key}:', *(f'  {_scalar(name)}: {_quoted(mapping[name])}' for name in mapping)]
    )


def _scalar(text):
    """Return a string as a YAML scalar, plain where it cannot be misread."""
    return text if re.fullmatch(r'[A-Za-z_/][\w./-]*', text, re.ASCII) else _quoted(text)


def _quoted(text):
    """Return a double-quoted scalar of YAML, which a JSON string is."""
    return json.dumps(text, ensure_ascii=False)


def _indent(text, columns):
    return textwrap.indent(text, ' ' * columns)

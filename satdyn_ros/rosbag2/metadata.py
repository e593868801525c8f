"""What rosbag2 says of a bag: metadata.yaml, version 9, and the same in each file's records."""

import json
import os
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mcap.records import Channel, Schema

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
            schema.data.decode() if schema else '',
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
    """What metadata.yaml says of a bag beside its topics."""

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
        """Return the content of the metadata record NAME; at the begin, topics are unknown."""
        return {'serialized_metadata': self.to_yaml(topics, counts or {})}

    def write(
        self, directory: Path, topics: Sequence[TopicMetadata], counts: Mapping[str, int]
    ) -> None:
        """Write metadata.yaml, which makes the bag complete: all at once, and on the disk."""
        text = f'rosbag2_bagfile_information:\n{_indent(self.to_yaml(topics, counts), 2)}'
        unfinished = directory / f'.{FILE_NAME}'
        with open(unfinished, 'w', encoding='utf-8') as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, directory / FILE_NAME)


def _topic(topic, counts):
    profiles = f'offered_qos_profiles:\n{_indent(topic.qos, 2)}'
    return '\n'.join(
        [
            'topic_metadata:',
            f'  name: {topic.name}',
            f'  type: {topic.type}',
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
    """Return a YAML list of texts; what follows an item's first line keeps its column."""
    if not items:
        return f'{key}: []'
    return '\n'.join([f'{key}:', *('  - ' + _indent(item, 4).lstrip() for item in items)])


def _map(key, mapping):
    if not mapping:
        return f'{key}: ~'
    return '\n'.join([f'{key}:', *(f'  {name}: {_quoted(mapping[name])}' for name in mapping)])


def _scalar(text):
    """Return a string as YAML writes it, plain where nothing can be misread."""
    return text if re.fullmatch(r'[A-Za-z_][\w.-]*', text, re.ASCII) else _quoted(text)


def _quoted(text):
    """Return a double-quoted scalar of YAML, which a JSON string is."""
    return json.dumps(text, ensure_ascii=False)


def _indent(text, columns):
    return textwrap.indent(text, ' ' * columns)

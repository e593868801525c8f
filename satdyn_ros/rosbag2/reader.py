"""A bag as it can be had: ours or another's, complete or cut off by the end of its writer."""

import re
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from mcap.records import Channel, Metadata, Schema

from .chunk import Contents
from .metadata import FILE_NAME, TopicMetadata
from .scan import Block, Incomplete, read_summary, scan


class Messages(NamedTuple):
    """
    Messages of one topic.

    log_times_ns (N,) uint64; data: (N, length) uint8, or a list of bytes where lengths differ.
    """

    log_times_ns: np.ndarray
    data: np.ndarray | list[bytes]

    @classmethod
    def joined(cls, parts: Sequence['Messages']) -> 'Messages':
        """Return messages that follow each other as one."""
        log_times_ns = np.concatenate([np.empty(0, np.uint64), *(m.log_times_ns for m in parts)])
        if len({np.shape(part.data)[1:] for part in parts}) == 1:
            return cls(log_times_ns, np.concatenate([part.data for part in parts]))
        return cls(log_times_ns, [bytes(row) for part in parts for row in part.data])


class TopicBlock(NamedTuple):
    """Messages of several topics that follow each other; topics: names by channel."""

    contents: Contents
    topics: dict[int, str]

    def by_topic(self) -> dict[str, Messages]:
        """Return the messages of each topic that has any."""
        contents = self.contents
        return {self.topics[i]: Messages(*contents.messages(i)) for i in contents.places}


class Bag:
    """
    A bag: a directory or a bare .mcap file.

    files: its .mcap files in order.  problem: what cut reading short, known after all was read.
    ValueError: path is no bag of MCAP files.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.files = bag_files(self.path)
        self.problem: str | None = None

    def items(self) -> Iterator[TopicBlock | Metadata]:
        """Yield messages in blocks, and metadata records, in the order of the bag."""
        for path in self.files:
            topics: dict[int, str] = {}
            try:
                for item in scan(path):
                    if isinstance(item, Block):
                        _, channels = item.contents.declarations()
                        topics |= {i: channel.topic for i, channel in channels.items()}
                        yield TopicBlock(item.contents, topics)
                    elif isinstance(item, Metadata):
                        yield item
            except Incomplete as error:
                self.problem = str(error)

    def messages(self, topic: str) -> Messages:
        """Return all messages on a topic ('/attitude'), in the order of the bag."""
        blocks = (item.by_topic() for item in self.items() if isinstance(item, TopicBlock))
        return Messages.joined([block[topic] for block in blocks if topic in block])

    @cached_property
    def topics(self) -> dict[str, TopicMetadata]:
        """The recorded topics by name; of an unfinished file, those that have messages."""
        topics = {}
        for path in self.files:
            schemas, channels = _declarations(path)
            for channel in channels.values():
                schema = schemas.get(channel.schema_id)
                topics[channel.topic] = TopicMetadata.from_records(channel, schema)
        return topics

    @cached_property
    def channel_ids(self) -> dict[str, int]:
        """The channels by the topic's name, those of its last file that has it."""
        found = (_declarations(path)[1] for path in self.files)
        return {channel.topic: i for channels in found for i, channel in channels.items()}


def bag_files(path: Path) -> list[Path]:
    """Return the .mcap files of a bag in order; ValueError: path is no bag of MCAP files."""
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise ValueError(f'{path} is no bag: there is no such file or directory')
    if (path / FILE_NAME).exists():
        text = (path / FILE_NAME).read_text(encoding='utf-8')
        information = yaml.safe_load(text)['rosbag2_bagfile_information']
        if information['storage_identifier'] != 'mcap':
            raise ValueError(
                f'{path} is stored as {information["storage_identifier"]}; we read mcap'
            )
        return [path / name for name in information['relative_file_paths']]
    files = sorted(path.glob('*.mcap'), key=_number)
    if not files:
        raise ValueError(f'{path} is no bag: there is no .mcap file in it')
    return files


def _declarations(path: Path) -> tuple[dict[int, Schema], dict[int, Channel]]:
    """Return the schemas and channels of a file by id, from its summary if it has one."""
    summary = read_summary(path)
    if summary is not None:
        return summary.schemas, summary.channels
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    try:
        for item in scan(path):
            if isinstance(item, Block):
                declared = item.contents.declarations()
                schemas |= declared[0]
                channels |= declared[1]
    except Incomplete:
        pass
    return schemas, channels


def _number(path):
    """Return the number that ends a file's name, which counts the files of a bag."""
    return int(re.search(r'(\d*)$', path.stem).group() or 0)

"""Reads a bag from any writer, complete or truncated because its writer died."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.records import Channel, Metadata, Schema
from mcap.summary import Summary

from ..base.regular_file import regular_file
from . import metadata
from .chunk import Contents
from .errors import BagError, Damaged, Incomplete
from .metadata import TopicMetadata
from .scan import Block, Flaw, scan
from .summary import SummaryBuilder, read_summary


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
    """Consecutive messages of several topics; topics: names by channel."""

    contents: Contents
    topics: dict[int, str]

    def messages(self, channel_id: int) -> Messages:
        """Return the messages on a channel that has any."""
        indices = self.contents.indices[channel_id]
        return Messages(self.contents.log_times[indices], self.contents.data_at(indices))


class Bag:
    """
    A bag: a directory or a bare .mcap file.

    files: its .mcap files in order.  information: what its metadata.yaml says, None: it has none.
    has_compressed_messages: rosbag2 compressed each message separately, with zstd; they are read
    as they are stored.  problem: what cut reading short, known after everything was read.

    BagError, here and while reading: path is not a bag of MCAP files, or the bag is damaged.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        said = self.path / metadata.FILE_NAME
        self.information = metadata.read(said) if said.exists() else None
        self.has_compressed_messages = has_compressed_messages(self.path, self.information)
        self.files = bag_files(self.path, self.information)
        self.problem: str | None = None

    def items(self) -> Iterator[TopicBlock | Metadata]:
        """Yield messages in blocks, and metadata records, in the order of the bag."""
        for path in self.files:
            topics: dict[int, str] = {}
            for found in scan(path):
                match found.item:
                    case Flaw(Incomplete() as error):
                        self.problem = str(error)
                    case Flaw(error):
                        raise error
                    case Block(contents):
                        _, channels = contents.declarations
                        topics |= {i: channel.topic for i, channel in channels.items()}
                        if not contents.counts.keys() <= topics.keys():
                            raise Damaged(f'{path} is damaged: a channel is not declared')
                        yield TopicBlock(contents, topics)
                    case Metadata():
                        yield found.item

    def messages(self, topic: str) -> Messages:
        """Return all messages on a topic ('/attitude'), in the order of the bag."""
        blocks = (item for item in self.items() if isinstance(item, TopicBlock))
        found = ((block, i) for block in blocks for i in block.contents.indices)
        return Messages.joined([b.messages(i) for b, i in found if b.topics[i] == topic])

    @cached_property
    def topics(self) -> dict[str, TopicMetadata]:
        """The recorded topics by name; of an unfinished file, those that have messages."""
        return {
            channel.topic: TopicMetadata.from_records(channel, schemas.get(channel.schema_id))
            for schemas, channels in self.declarations
            for channel in channels.values()
        }

    @cached_property
    def channel_ids(self) -> dict[str, int]:
        """Channel ids by topic name, from the last file that has the topic."""
        declared = (channels for _, channels in self.declarations)
        return {channel.topic: i for channels in declared for i, channel in channels.items()}

    @cached_property
    def declarations(self) -> list[tuple[dict[int, Schema], dict[int, Channel]]]:
        """The schemas and channels of each file by id, from its summary if it has one."""
        declared = []
        for path in self.files:
            try:
                summary: Summary = read_summary(path)
            except Incomplete:
                summary = in_data = SummaryBuilder()
                for found in scan(path):
                    if isinstance(found.item, Block):
                        in_data.add_messages(found.item.contents)
            declared.append((summary.schemas, summary.channels))
        return declared

    @property
    def message_counts(self) -> Counter[str]:
        """How many messages each topic has, from the summaries; BagError: a file has none."""
        counts: Counter[str] = Counter()
        for summary in map(read_summary, self.files):
            held = summary.statistics.channel_message_counts if summary.statistics else {}
            for i, count in held.items():
                counts[summary.channels[i].topic] += count
        return counts


def bag_files(path: Path, information: dict[str, Any] | None) -> list[Path]:
    """Return the .mcap files of a bag in order; BagError: path is not a bag of MCAP files."""
    if not path.exists():
        raise BagError(f'{path} is not a bag: no such file or directory')
    if path.is_file() and not path.stat().st_size:
        raise BagError(f'{path} is not a bag: it is empty')
    if not path.is_dir():
        files = [path]
    elif information is not None:
        files = [path / name for name in information['relative_file_paths']]
        missing = [file for file in files if not file.exists()]
        if missing:
            raise Damaged(f'{path} is damaged: {missing[0].name} of its metadata.yaml is missing')
    else:
        files = sorted(path.glob('*.mcap'), key=_number)
    if not files:
        raise BagError(f'{path} is not a bag: it has no .mcap file')
    for file in files:
        try:
            regular_file(file)
        except OSError as error:
            what = 'a bag' if file == path else 'a file of a bag'
            raise BagError(f'{file} is not {what}: {error.strerror}') from None
    return files


def has_compressed_messages(path: Path, information: dict[str, Any] | None) -> bool:
    """Return whether messages are compressed; BagError: whole files are, or not by zstd."""
    said = information or {}
    mode, form = str(said.get('compression_mode') or 'NONE'), said.get('compression_format')
    if mode.upper() == 'NONE':
        return False
    if mode.upper() != 'MESSAGE' or form != 'zstd':
        raise BagError(
            f'{path} was compressed by rosbag2 (compression_mode {mode}, compression_format '
            f'{form}); only MESSAGE with zstd is supported, and ros2 bag convert decompresses it'
        )
    return True


def _number(path: Path) -> int:
    """Return the number that ends a file's name, which counts the files of a bag."""
    digits = re.findall(r'[0-9]{1,18}$', path.stem)
    return int(digits[0]) if digits else 0

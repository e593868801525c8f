"""The messages of any rosbag2 MCAP bag, from any writer, in the order of their log times."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..base import ros_yaml
from ..messages.qos import Qos
from ..rosbag2.compression import decompress, zstd_size
from ..rosbag2.errors import BagError, Damaged, Incomplete
from ..rosbag2.reader import Bag
from ..rosbag2.summary import read_summary
from ..rosbag2.timeline import LoggedMessage, Timeline

# rosbag2 wrote rmw's numbers before version 9 of its metadata, and its words since then.
_BEST_EFFORT = ('best_effort', 2)
_TRANSIENT_LOCAL = ('transient_local', 1)
_SMALLEST_DEPTH, _LARGEST_DEPTH = 10, 20_000
# A publisher takes milliseconds to make.
_MOST_TOPICS = 2000


class Playback:
    """
    A complete bag to play.

    Parameters
    ----------
    path : str or Path
        the bag

    Attributes
    ----------
    types, qos : dict
        of each topic that has messages in CDR, by its name
    begin_ns, end_ns : ns
        the first and the last log time

    Raises
    ------
    BagError
        here and while reading: path is no such bag, holds no messages, or more topics than any
        system has, or is damaged
    """

    def __init__(self, path: str | Path):
        bag = Bag(path)
        self._has_compressed_messages = bag.has_compressed_messages
        self._timelines = []
        spans = []
        self.types: dict[str, str] = {}
        for file in bag.files:
            try:
                summary = read_summary(file)
            except Incomplete:
                raise BagError(f'{path} is not complete; satdyn recover completes it') from None
            statistics = summary.statistics
            if statistics is None:
                raise BagError(f'{file} has no statistics; satdyn recover makes them')
            if statistics.message_count:
                spans.append((statistics.message_start_time, statistics.message_end_time))
                self._timelines.append(Timeline(file, summary))
            for channel_id, channel in summary.channels.items():
                counts = statistics.channel_message_counts
                schema = summary.schemas.get(channel.schema_id)
                if counts.get(channel_id) and channel.message_encoding == 'cdr' and schema:
                    self.types[channel.topic] = schema.name
        if not spans:
            raise BagError(f'{path} holds no messages')
        if len(self.types) > _MOST_TOPICS:
            raise BagError(f'{path} has {len(self.types)} topics; the limit is {_MOST_TOPICS}')
        self.begin_ns = min(begin for begin, _ in spans)
        self.end_ns = max(end for _, end in spans)
        self.qos = {name: offered(bag.topics[name].qos) for name in self.types}

    def messages(self, topics: list[str], from_ns: int) -> Iterator[LoggedMessage]:
        """Yield the messages of topics whose log time is not before from_ns."""
        for timeline in self._timelines:
            for message in timeline.messages(topics, from_ns):
                yield _expanded(message) if self._has_compressed_messages else message


def _expanded(message: LoggedMessage) -> LoggedMessage:
    """Return a message that rosbag2 compressed separately."""
    try:
        data = decompress('zstd', message.data, zstd_size(message.data))
    except Damaged as error:
        raise Damaged(f'a message on {message.topic} is damaged: {error}') from None
    return message._replace(data=data)


def offered(text: str) -> Qos:
    """
    Return the QoS that suits all subscribers of the publishers of offered_qos_profiles.

    Damaged: the text is not a list of profiles.

    >>> offered('- {depth: 5, reliability: 2, durability: 2}').reliability
    'best_effort'
    """
    profiles = _profiles(text)
    least = any(profile.get('reliability') in _BEST_EFFORT for profile in profiles)
    latched = profiles and all(p.get('durability') in _TRANSIENT_LOCAL for p in profiles)
    depths = [depth for p in profiles if isinstance(depth := p.get('depth', 0), int)]
    return Qos(
        depth=min(_LARGEST_DEPTH, max([_SMALLEST_DEPTH, *depths])),
        reliability='best_effort' if least else 'reliable',
        durability='transient_local' if latched else 'volatile',
    )


def _profiles(text: str) -> list[dict[str, Any]]:
    try:
        profiles = ros_yaml.load(text, 'offered_qos_profiles') or []
    except ValueError as error:
        raise Damaged(str(error)) from None
    if not isinstance(profiles, list) or not all(isinstance(p, dict) for p in profiles):
        raise Damaged('offered_qos_profiles is not a list of profiles')
    return profiles

"""The messages of any rosbag2 MCAP bag in the order of their log times, ours or another's."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from mcap.reader import SeekingReader

from ..messages.qos import Qos
from ..rosbag2.reader import Bag
from ..rosbag2.scan import read_summary

# rosbag2 wrote rmw's numbers until version 9 of its metadata, its words since then.
_BEST_EFFORT = ('best_effort', 2)
_TRANSIENT_LOCAL = ('transient_local', 1)
_SMALLEST_DEPTH = 10


class Message(NamedTuple):
    """A message: when it was logged, on which topic, its CDR bytes."""

    log_time_ns: int
    topic: str
    data: bytes


class Playback:
    """
    A complete bag to play.

    types, qos: of each topic that has messages in CDR, by its name.  begin_ns, end_ns: the first
    and the last log time.  ValueError: path is no such bag, or holds no messages.
    """

    def __init__(self, path: str | Path):
        bag = Bag(path)
        self._files = bag.files
        summaries = [read_summary(file) for file in bag.files]
        spans = []
        self.types: dict[str, str] = {}
        for summary in summaries:
            if summary is None or summary.statistics is None:
                raise ValueError(f'{path} is not complete; satdyn recover completes it')
            statistics = summary.statistics
            if statistics.message_count:
                spans.append((statistics.message_start_time, statistics.message_end_time))
            for channel_id, channel in summary.channels.items():
                counts = statistics.channel_message_counts
                schema = summary.schemas.get(channel.schema_id)
                if counts.get(channel_id) and channel.message_encoding == 'cdr' and schema:
                    self.types[channel.topic] = schema.name
        if not spans:
            raise ValueError(f'{path} holds no messages')
        self.begin_ns = min(begin for begin, _ in spans)
        self.end_ns = max(end for _, end in spans)
        self.qos = {name: offered(bag.topics[name].qos) for name in self.types}

    def messages(self, topics: list[str], from_ns: int) -> Iterator[Message]:
        """Yield the messages of topics whose log time is not before from_ns."""
        for path in self._files:
            with open(path, 'rb') as file:
                found = SeekingReader(file).iter_messages(topics, start_time=from_ns)
                for _, channel, message in found:
                    yield Message(message.log_time, channel.topic, message.data)


def offered(text: str) -> Qos:
    """
    Return what suits all that subscribed to the publishers of offered_qos_profiles.

    >>> offered('- {depth: 5, reliability: 2, durability: 2}').reliability
    'best_effort'
    """
    profiles: list[dict[str, Any]] = yaml.safe_load(text) or []
    least = any(profile.get('reliability') in _BEST_EFFORT for profile in profiles)
    latched = profiles and all(p.get('durability') in _TRANSIENT_LOCAL for p in profiles)
    return Qos(
        depth=max([_SMALLEST_DEPTH, *(int(profile.get('depth', 0)) for profile in profiles)]),
        reliability='best_effort' if least else 'reliable',
        durability='transient_local' if latched else 'volatile',
    )

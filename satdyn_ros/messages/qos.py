"""The quality of service of our topics, and its text in a bag."""

import math
from dataclasses import dataclass

_INFINITE = 'sec: 9223372036\n    nsec: 854775807'


@dataclass(frozen=True)
class Qos:
    """A publisher's or subscription's quality of service, in the words of rmw."""

    depth: int
    reliability: str = 'reliable'
    durability: str = 'volatile'
    history: str = 'keep_last'

    def to_yaml(self) -> str:
        """Return the list item of offered_qos_profiles in a rosbag2 bag, version 9."""
        return (
            f'- history: {self.history}\n'
            f'  depth: {self.depth}\n'
            f'  reliability: {self.reliability}\n'
            f'  durability: {self.durability}\n'
            f'  deadline:\n    {_INFINITE}\n'
            f'  lifespan:\n    {_INFINITE}\n'
            '  liveliness: automatic\n'
            f'  liveliness_lease_duration:\n    {_INFINITE}\n'
            '  avoid_ros_namespace_conventions: false'
        )


def state_topics(rate_hz: float) -> Qos:
    """Return that of the state topics: reliable, one second of ticks kept, at least 10."""
    return Qos(depth=max(10, math.ceil(rate_hz)))


INPUTS = Qos(depth=10)
CLOCK = Qos(depth=1, reliability='best_effort')
DIAGNOSTICS = Qos(depth=1)

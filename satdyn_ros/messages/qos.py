"""The quality of service of the topics, and its text in a bag."""

import math
from dataclasses import dataclass

_MOST = 20_000
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


def state_topics(ticks_per_wall_s: float) -> Qos:
    """
    Return the QoS of the state topics: reliable, one wall second of ticks kept, 10 to 20 000.

    ticks_per_wall_s: rate times time.factor; 0: as fast as possible, which keeps the most.
    """
    depth = math.ceil(min(ticks_per_wall_s, _MOST)) if ticks_per_wall_s else _MOST
    return Qos(depth=max(10, depth))


# Commands come at the rate of a controller; a busy node reads them slightly later.
INPUTS = Qos(depth=1000)
# What waits in it: those of seconds, at thousands a second.
WAITING_INPUTS = Qos(depth=_MOST)
# For whoever comes at any time.
LATCHED = Qos(depth=1, durability='transient_local')
CLOCK = Qos(depth=1, reliability='best_effort')
DIAGNOSTICS = Qos(depth=1)

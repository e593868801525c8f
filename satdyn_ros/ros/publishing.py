"""The node's outputs: each block of ticks packed once, published row by row."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from std_msgs.msg import String

from ..base.sparse import Rows, SparseMessages
from ..messages import qos
from ..messages.packers import Packer, pack_tf_static, packer
from ..messages.robot_description import urdf
from ..run.samples import Samples
from ..run.scenario import Scenario

# The node never follows a simulated time, its own least of all.
STEADY = Clock(clock_type=ClockType.STEADY_TIME)
_AT_ONCE = Duration()


class PackedTicks:
    """
    The messages of consecutive ticks.

    Parameters
    ----------
    count : int
        how many ticks
    rows : dict
        by topic the messages
    outputs : sequence
        what publishes them, with the messages of every tick or SparseMessages
    """

    def __init__(
        self, count: int, rows: Mapping[str, Rows], outputs: Sequence[tuple[Callable, Rows]]
    ):
        self.rows = rows
        # All rows are cut here, while the caches are warm, not tick by tick.
        full = [_calls(publish, r) for publish, r in outputs if not isinstance(r, SparseMessages)]
        self._calls = list(zip(*full, strict=True)) if full else [()] * count
        for publish, some in outputs:
            if isinstance(some, SparseMessages):
                calls = _calls(publish, some.rows)
                for index, call in zip(some.indices.tolist(), calls, strict=True):
                    self._calls[index] += (call,)

    def publish(self, row: int) -> None:
        """Publish the messages of one tick."""
        for publish, message in self._calls[row]:
            publish(message)


class Publishing:
    """
    The state topics and /clock of a node.

    Topics that a scenario does not have, or whose type is not installed, are left out with one
    warning each.

    Parameters
    ----------
    node : Node
        that publishes
    scenario : Scenario
        of the node

    Attributes
    ----------
    publishers : dict
        those of the state topics and the sensors, by name
    offered : dict
        their quality of service, with what the parameters qos_overrides.* change

    Raises
    ------
    ValueError
        here and in open: these are not allowed
    """

    def __init__(self, node: Node, scenario: Scenario):
        self._node = node
        self._scenario = scenario
        self._packers: dict[str, Packer] = {}
        self.publishers: dict[str, Publisher] = {}
        self.offered: dict[str, qos.Qos] = {}
        self._left_out: set[str] = set()
        self._clock: Publisher | None = None
        if scenario['time.publish_clock']:
            self._clock = node.create_publisher(
                message_class('rosgraph_msgs/msg/Clock'), '/clock', qos_profile(qos.CLOCK)
            )
            self._clock_packer = packer('clock', scenario)
            self._timer = node.create_timer(1.0, self._watch_clock, clock=STEADY)
        self.open(scenario.sensors)

    def open(self, names: Iterable[str]) -> tuple[str, ...]:
        """Make the publishers of topics that have none yet; return those that can be published."""
        names = tuple(names)
        self._refuse_shared(names)
        return tuple(name for name in names if name in self.publishers or self._add(name))

    def latch(self, scenario: Scenario) -> None:
        """Publish the URDF, and where there are sensors their mountings; scenario: with epoch."""
        latched = qos_profile(qos.LATCHED)
        description = self._node.create_publisher(String, 'robot_description', latched)
        description.publish(String(data=urdf(scenario)))
        if not scenario.sensors:
            return
        topic = scenario.topic_table['tf_static']
        try:
            message = message_class(topic.type)
        except ImportError as error:
            self._warn_once('tf_static', error)
            return
        publisher = self._node.create_publisher(message, topic.name, latched)
        publisher.publish(pack_tf_static(scenario))

    def close_others(self, names: Iterable[str]) -> None:
        """
        Destroy the publishers of state topics that are not among names.

        One whose last messages have not all arrived stays until a later call.
        """
        kept = {*names, *self._scenario.sensors}
        for name in self.publishers.keys() - kept:
            if self.publishers[name].wait_for_all_acked(_AT_ONCE):
                self._node.destroy_publisher(self.publishers.pop(name))

    def pack(self, samples: Samples, names: Iterable[str]) -> PackedTicks:
        """Return the messages of samples on the named topics."""
        packed = (*names, *samples.measured)
        rows: dict[str, Rows] = {name: self._packers[name].pack(samples) for name in packed}
        outputs: list[tuple[Callable, Rows]] = [
            (self.publishers[name].publish, table) for name, table in rows.items()
        ]
        if self._clock is not None:
            outputs.insert(0, (self._clock.publish, self._clock_packer.pack(samples)))
        return PackedTicks(len(samples), rows, outputs)

    def _refuse_shared(self, names):
        """Raise ValueError where remapping makes one topic of two."""
        scenario = self._scenario
        by_topic: dict[str, str] = {}
        for name in dict.fromkeys((*scenario.inputs, *scenario.sensors, *names)):
            topic = self._node.resolve_topic_name(scenario.topic_table[name].name)
            other = by_topic.setdefault(topic, name)
            if other != name:
                raise ValueError(
                    f'{other} and {name} are both the topic {topic}; each must have one of its '
                    'own, by which a bag tells them apart'
                )

    def _watch_clock(self):
        """Warn once when the time has a second source."""
        if self._node.count_publishers('/clock') > 1:
            self._node.get_logger().warning(
                '/clock has another publisher; nodes that follow it see the time jump'
            )
            self._node.destroy_timer(self._timer)

    def _add(self, name):
        topic = self._scenario.topic_table[name]
        try:
            topic_packer = packer(name, self._scenario)
            message = message_class(topic.type)
        except (ValueError, ImportError) as error:
            self._warn_once(name, error)
            return False
        wanted = qos.state_topics(self._scenario.ticks_per_wall_s)
        try:
            publisher = self._node.create_publisher(
                message,
                topic.name,
                qos_profile(wanted),
                qos_overriding_options=QoSOverridingOptions.with_default_policies(),
            )
        except (RuntimeError, AssertionError, ParameterException) as error:
            where = f'qos_overrides.{self._node.resolve_topic_name(topic.name)}.publisher'
            raise ValueError(f'{where} is not allowed: {error}') from error
        self._packers[name] = topic_packer
        self.publishers[name] = publisher
        offered = publisher.qos_profile
        self.offered[name] = qos.Qos(
            depth=offered.depth,
            reliability=offered.reliability.short_key,
            durability=offered.durability.short_key,
            history=offered.history.short_key,
        )
        return True

    def _warn_once(self, name, error):
        if name in self._left_out:
            return
        self._left_out.add(name)
        reason = error if isinstance(error, ValueError) else f'{error.name} is not installed'
        self._node.get_logger().warning(f'{name} is not published: {reason}')


def _calls(publish, table):
    data, size = table.tobytes(), table.itemsize
    return [(publish, data[begin : begin + size]) for begin in range(0, len(data), size)]


def message_class(type_name: str) -> type:
    """Return the class of 'package/msg/Name'; ImportError: the package is not installed."""
    package, _, name = type_name.split('/')
    return getattr(import_module(f'{package}.msg'), name)


def qos_profile(offered: qos.Qos) -> QoSProfile:
    """Return the quality of service in the words of rclpy."""
    return QoSProfile(
        depth=offered.depth,
        history=HistoryPolicy.get_from_short_key(offered.history),
        reliability=ReliabilityPolicy.get_from_short_key(offered.reliability),
        durability=DurabilityPolicy.get_from_short_key(offered.durability),
    )

"""What a running node says: its newest sample, found by asking the graph, and its diagnostics."""

from collections import defaultdict
from typing import Any, NamedTuple

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import QuaternionStamped, VelocityStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from sensor_msgs.msg import Imu, JointState

from ..actuators import ACTUATORS, is_commanding
from ..messages import qos
from ..ros.publishing import message_class, qos_profile
from ..run.topics import TOPICS

_SERVICE = '/set_initial_conditions'
_SERVICE_TYPE = 'rcl_interfaces/srv/SetParametersAtomically'

# The newest messages alone, whatever was lost before: the publisher never waits for a page.  Two,
# because of two nodes of one name that publish at one instant the newest is always the same's.
_NEWEST = QoSProfile(depth=2, reliability=ReliabilityPolicy.BEST_EFFORT)
# A command may be published once, as soon as its publisher is matched; that reaches no best-effort
# subscription.  As many wait as the node itself lets wait: each may be for another thruster.
_COMMANDS = qos_profile(qos.WAITING_INPUTS)

_CLASSES = {
    'odometry': Odometry,
    'imu': Imu,
    'attitude': QuaternionStamped,
    'angular_velocity': VelocityStamped,
    'rotor': JointState,
    'thruster': JointState,
    # What motors are commanded is in the messages of the rotors.
    **{
        topic: message_class(kind.message)
        for topic, kind in ACTUATORS.items()
        if kind.in_body_axes or not kind.is_held
    },
}


class HeardState(NamedTuple):
    """
    A state that was published.

    Attributes
    ----------
    stamp_ns : ns
        of the message
    q_ib : (4,), x, y, z, w
        attitude, body to inertial
    omega_bi_b : (3,), rad/s, body axes
        rate of the body
    """

    stamp_ns: int
    q_ib: np.ndarray
    omega_bi_b: np.ndarray


class Listener:
    """
    The topics of one satellite, polled.

    Messages are taken from the reader when a frame is due, not as they come: what lies between
    two frames costs nothing in Python.
    """

    def __init__(self, node: Node):
        self._node = node
        self._subscriptions: dict[str, Subscription] = {}
        self._latest: dict[str, Any] = {}

    def look(self, name: str) -> dict[str, str]:
        """Find the topics of a node ('/sat1/satdyn'); return them by their names in TOPICS."""
        namespace, _, base = name.rpartition('/')
        try:
            graph = self._node
            out = graph.get_publisher_names_and_types_by_node(base, namespace or '/')
            taken = graph.get_subscriber_names_and_types_by_node(base, namespace or '/')
        except RuntimeError:
            return {}
        found = {
            key: topic
            for key in _CLASSES
            if (topic := _topic(key, taken if TOPICS[key].role == 'input' else out)) is not None
        }
        found = _named(taken) | found
        for key, topic in found.items():
            old = self._subscriptions.get(key)
            if old is None or old.topic_name != topic:
                self._leave(key)
                self._subscriptions[key] = self._node.create_subscription(
                    _CLASSES[key.partition('/')[0]],
                    topic,
                    lambda message: None,
                    _COMMANDS if is_commanding(key) else _NEWEST,
                )
        for key in self._subscriptions.keys() - found.keys():
            self._leave(key)
        return found

    def endpoints(self) -> defaultdict[str, set[bytes]]:
        """Return by node the identities of what publishes its diagnostics: new ones each start."""
        found: defaultdict[str, set[bytes]] = defaultdict(set)
        for info in self._node.get_publishers_info_by_topic('/diagnostics'):
            name = f'{info.node_namespace.rstrip("/")}/{info.node_name}'
            found[name].add(bytes(info.endpoint_gid))
        return found

    def samples(self) -> list[HeardState]:
        """Return the newest samples that were not returned before, at most two, oldest first."""
        if 'odometry' in self._subscriptions:
            return [
                _sample(message, message.pose.pose.orientation, message.twist.twist.angular)
                for message in self._take_all('odometry')
            ]
        if 'imu' in self._subscriptions:
            return [
                _sample(message, message.orientation, message.angular_velocity)
                for message in self._take_all('imu')
            ]
        for key in ('attitude', 'angular_velocity'):
            self._latest[key] = self._take(key) or self._latest.get(key)
        attitude, rate = self._latest.get('attitude'), self._latest.get('angular_velocity')
        if attitude is None or rate is None:
            return []
        self._latest['attitude'] = None
        return [_sample(attitude, attitude.quaternion, rate.velocity.angular)]

    def joints(self, key: str) -> JointState | None:
        """Return the newest message of the rotors or the thrusters, or None before the first."""
        self._latest[key] = self._take(key) or self._latest.get(key)
        return self._latest[key]

    def commands(self) -> list[tuple[str, Any]]:
        """Return what was commanded since the last call, topics and messages, oldest first."""
        inputs = [key for key in self._subscriptions if is_commanding(key)]
        return [(key, message) for key in inputs for message in self._take_all(key)]

    def leave(self) -> None:
        """Listen to no satellite."""
        for key in list(self._subscriptions):
            self._leave(key)

    def forget(self) -> None:
        """Forget what came before: another node has taken the name."""
        self._latest.clear()

    def _take(self, key):
        """Return the newest message of a topic, or None."""
        return next(reversed(self._take_all(key)), None)

    def _take_all(self, key):
        """Return the messages of a topic that wait, oldest first."""
        messages: list[Any] = []
        subscription = self._subscriptions.get(key)
        if subscription is None:
            return messages
        with subscription.handle:
            for _ in range(subscription.qos_profile.depth):
                taken = subscription.handle.take_message(subscription.msg_type, subscription.raw)
                if taken is None:
                    break
                messages.append(taken[0])
        return messages

    def _leave(self, key):
        subscription = self._subscriptions.pop(key, None)
        if subscription is not None:
            self._node.destroy_subscription(subscription)
        self._latest.pop(key, None)


def satellites(node: Node) -> list[str]:
    """Return the names of the satellites in the graph, those that have our service."""
    return sorted(
        name.removesuffix(_SERVICE)
        for name, types in node.get_service_names_and_types()
        if name.endswith(_SERVICE) and _SERVICE_TYPE in types
    )


def parts(message: DiagnosticArray, name: str) -> dict[str, dict[str, Any]]:
    """Return the diagnostics of a node by part: level (0: good), text and values."""
    prefix = f'{name.lstrip("/")}: '
    return {
        status.name.removeprefix(prefix): {
            'level': status.level[0],
            'text': status.message,
            'values': [[value.key, value.value] for value in status.values],
        }
        for status in message.status
        if status.name.startswith(prefix)
    }


def _topic(key, topics):
    """Return the topic of the type of TOPICS[key], the one of its own name first, or None."""
    wanted = TOPICS[key]
    names = [name for name, types in topics if wanted.type in types]
    own = [name for name in names if name.rsplit('/', 1)[-1] == wanted.name]
    # A type of several topics, such as those of the sensors, is taken by its name alone.
    is_alone = sum(topic.type == wanted.type for topic in TOPICS.values()) == 1
    return next(iter(own or (names if is_alone else [])), None)


def _named(taken):
    """Return the topics of actuators that have names, such as torque/drag, by these."""
    found = {}
    for topic, types in taken:
        kind, name = topic.split('/')[-2:]
        if kind in ACTUATORS and ACTUATORS[kind].message in types:
            found[f'{kind}/{name}'] = topic
    return found


def _sample(message, q, omega):
    stamp = message.header.stamp
    return HeardState(
        stamp.sec * 10**9 + stamp.nanosec,
        np.array([q.x, q.y, q.z, q.w]),
        np.array([omega.x, omega.y, omega.z]),
    )

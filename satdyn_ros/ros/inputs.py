"""The inputs: commands that come in on topics and act at the next tick."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.subscription import Subscription

from ..actuators import Actuator, Command
from ..base.sentences import one_sentence
from ..messages import qos
from ..run.events import Event
from ..run.scenario import Scenario
from ..run.ticks import Ticks
from .pacing import Pacing
from .publishing import message_class, qos_profile

# The same warning comes at most this often.
_QUIET_S = 10.0


@dataclass
class InputCounts:
    """Messages received: how many were accepted, refused or lost, and the last reason."""

    accepted: int = 0
    refused: int = 0
    lost: int = 0
    reason: str = ''


class Refused(ValueError):  # noqa: N818
    """Why a command does not act; kind: what warnings of the same kind have in common."""

    def __init__(self, kind: tuple[str, str], reason: str):
        super().__init__(reason)
        self.kind = kind


def accepted(scenario: Scenario, topic: str, message: Any) -> Any:
    """
    Return the value of a command, as its actuator has it.

    Parameters
    ----------
    scenario : Scenario
        of the node
    topic : str
        the name of the topic, one of scenario.equipment.topics
    message : object
        that came on it

    Raises
    ------
    Refused
        it is given in another frame than the body's, its actuator does not take it, or
        motion.method is exact and there is no closed form with it
    """
    actuator = scenario.equipment.of_topic[topic]
    if actuator.in_body_axes:
        frame, body = message.header.frame_id, scenario.frames.body
        if frame not in ('', body):
            reason = f'{topic} is given in the frame {frame}; it must be {body} or empty'
            raise Refused((topic, 'frame'), reason)
    try:
        value = actuator.read(topic, message)
    except ValueError as error:
        raise Refused((topic, 'message'), str(error)) from error
    try:
        actuator.check(topic, value)
    except ValueError as error:
        raise Refused((topic, 'value'), str(error)) from error
    if scenario['motion.method'] == 'exact':
        try:
            system = scenario.equipment.commanded_alone(scenario.system, topic, value)
            scenario.motion_from(system, scenario.initial_state, 0.0)
        except ValueError as error:
            raise Refused((topic, 'closed form'), f'{topic} is refused: {error}') from error
    return value


class CommandInputs:
    """
    The subscriptions of the actuators that a scenario has.

    What is not accepted() is refused; of each kind of refusal a warning comes at most every ten
    seconds.

    Parameters
    ----------
    node : Node
        that subscribes
    scenario : Scenario
        of the node
    ticks : Ticks
        of the run
    pacing : Pacing
        which takes the commands

    Attributes
    ----------
    timeout_s : s
        simulated time after which a command drops to zero; 0: never
    subscriptions : dict
        by the names of their topics
    """

    def __init__(self, node: Node, scenario: Scenario, ticks: Ticks, pacing: Pacing):
        self.counts = InputCounts()
        self.subscriptions: dict[str, Subscription] = {}
        self._warned_s: dict[tuple[str, str], float] = {}
        self.timeout_s: float = scenario['torque.timeout']
        self._node, self._scenario = node, scenario
        self._ticks, self._pacing = ticks, pacing
        for topic, actuator in scenario.equipment.of_topic.items():
            if actuator.is_fitted:
                self._subscribe(topic, partial(self._take, topic, actuator))

    def _subscribe(self, name: str, callback: Callable):
        topic = self._scenario.topic_table[name]
        self.subscriptions[name] = self._node.create_subscription(
            message_class(topic.type),
            topic.name,
            callback,
            qos_profile(qos.WAITING_INPUTS),
            event_callbacks=SubscriptionEventCallbacks(message_lost=self._count_lost),
        )

    def _count_lost(self, lost):
        self.counts.lost += lost.total_count_change

    def _take(self, topic: str, actuator: Actuator, message: Any):
        try:
            value = accepted(self._scenario, topic, message)
        except Refused as refused:
            return self._refuse(refused.kind, str(refused))
        self.counts.accepted += 1

        def event_at(tick: int) -> Event:
            until_tick = self._ticks.timeout(tick, self.timeout_s) if actuator.is_held else None
            return Command(tick, topic, value, until_tick)

        self._pacing.put(event_at, ' '.join(sorted(actuator.held(topic, value))))

    def _refuse(self, kind, reason):
        self.counts.refused += 1
        self.counts.reason = one_sentence(reason)
        now_s = time.monotonic()
        if now_s - self._warned_s.get(kind, -_QUIET_S) >= _QUIET_S:
            self._warned_s[kind] = now_s
            self._node.get_logger().warning(self.counts.reason)

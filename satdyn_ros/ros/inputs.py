"""The inputs: commands that come in on topics and act at the next tick."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite

import numpy as np
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.subscription import Subscription

from ..base.sentences import one_sentence
from ..dynamics.system import System
from ..messages import qos
from ..run.events import DipoleCommand, Event, RotorCommand, Torque, rotor_torques
from ..run.scenario import Scenario
from ..run.ticks import Ticks
from ..run.topics import MAGNETORQUERS
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


class CommandInputs:
    """
    The subscriptions of applied torques and, where there are such, of motors and magnetorquers.

    A message is refused in another frame than the body's, with a force or a speed, with a number
    that is not finite, or where motion.method is exact and there is no closed form with it; of
    each kind of refusal a warning comes at most every ten seconds.
    timeout_s: simulated time after which a command drops to zero; 0: never.  subscriptions: by the
    names of their topics.
    """

    def __init__(self, node: Node, scenario: Scenario, ticks: Ticks, pacing: Pacing):
        self.counts = InputCounts()
        self.subscriptions: dict[str, Subscription] = {}
        self._warned_s: dict[str, float] = {}
        self.timeout_s: float = scenario['torque.timeout']
        self._node, self._scenario = node, scenario
        self._ticks, self._pacing = ticks, pacing
        for topic in scenario.torque_topics:
            self._subscribe(topic, partial(self._take_torque, topic))
        if any(rotor.mode == 'motor' for rotor in scenario.system.rotors):
            self._subscribe('rotor_command', self._take_rotor_command)
        if scenario.has_magnetorquers:
            self._subscribe(MAGNETORQUERS, self._take_dipole)

    def _subscribe(self, name: str, callback: Callable):
        topic = self._scenario.topic_table[name]
        self.subscriptions[name] = self._node.create_subscription(
            message_class(topic.type),
            topic.name,
            callback,
            qos_profile(qos.INPUTS),
            event_callbacks=SubscriptionEventCallbacks(message_lost=self._count_lost),
        )

    def _count_lost(self, lost):
        self.counts.lost += lost.total_count_change

    def _take_torque(self, topic, message):
        x, y, z = message.wrench.torque.x, message.wrench.torque.y, message.wrench.torque.z
        if not self._is_in_body_axes(topic, message):
            return
        force = message.wrench.force
        if (force.x, force.y, force.z) != (0.0, 0.0, 0.0):
            return self._refuse(
                'force',
                f'{topic} has a force of {force.x:g}, {force.y:g}, {force.z:g}; the force must '
                'be zero',
            )

        def event_at(tick: int) -> Event:
            return Torque(tick, (x, y, z), self._until(tick), topic)

        if self._is_taken(topic, (x, y, z), torque_b=np.array([x, y, z])):
            self._pacing.put(event_at, topic)

    def _take_dipole(self, message):
        x, y, z = message.vector.x, message.vector.y, message.vector.z

        def event_at(tick: int) -> Event:
            return DipoleCommand(tick, (x, y, z), self._until(tick))

        if self._is_in_body_axes(MAGNETORQUERS, message) and self._is_taken(
            MAGNETORQUERS, (x, y, z), 'A m^2'
        ):
            self._pacing.put(event_at, MAGNETORQUERS)

    def _take_rotor_command(self, message):
        names, efforts = list(message.name), list(message.effort)
        if len(names) != len(efforts):
            return self._refuse(
                'rotors',
                f'rotor_command has {len(names)} names and {len(efforts)} efforts; it must '
                'have one effort per name',
            )
        if len(message.velocity):
            return self._refuse(
                'velocity',
                'rotor_command has velocities; a speed cannot be commanded, so that velocity must '
                'be empty',
            )
        if len(set(names)) != len(names):
            return self._refuse('rotors', f'rotor_command names a rotor twice: {", ".join(names)}')
        try:
            torques = rotor_torques(dict(zip(names, efforts, strict=True)), self._scenario)
        except ValueError as error:
            return self._refuse('rotors', f'rotor_command is refused: {error}')

        def event_at(tick: int) -> Event:
            return RotorCommand(tick, torques, self._until(tick))

        acting = [torques.get(rotor.label, 0.0) for rotor in self._scenario.system.rotors]
        if self._is_taken('rotor_command', efforts, rotor_torque=np.array(acting)):
            self._pacing.put(event_at, ' '.join(['rotor_command', *sorted(names)]))

    def _until(self, tick):
        return self._ticks.timeout(tick, self.timeout_s)

    def _is_in_body_axes(self, name, message):
        frame, body = message.header.frame_id, self._scenario.frames.body
        return frame in ('', body) or self._refuse(
            'frame', f'{name} is given in the frame {frame}; it must be {body} or empty'
        )

    def _is_taken(self, name, numbers, unit='N m', **torques):
        if not all(isfinite(number) for number in numbers):
            given = ', '.join(f'{number:g}' for number in numbers)
            return self._refuse(name, f'{name} is {given}; it must be finite [{unit}]')
        try:
            self._check_closed_form(replace(self._scenario.system, **torques))
        except ValueError as error:
            return self._refuse('closed form', f'{name} is refused: {error}')
        self.counts.accepted += 1
        return True

    def _check_closed_form(self, system: System):
        """Raise ValueError if motion.method is exact and the driven system has no closed form."""
        if self._scenario['motion.method'] == 'exact':
            self._scenario.motion_from(system, self._scenario.initial_state, 0.0)

    def _refuse(self, kind, reason):
        self.counts.refused += 1
        self.counts.reason = one_sentence(reason)
        now_s = time.monotonic()
        if now_s - self._warned_s.get(kind, -_QUIET_S) >= _QUIET_S:
            self._warned_s[kind] = now_s
            self._node.get_logger().warning(self.counts.reason)
        return False

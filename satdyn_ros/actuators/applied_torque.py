"""Torques on the body: one, or with torque.names several, whose sum acts."""

from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from operator import add
from typing import Any, ClassVar

import numpy as np

from ..base.key import Key
from ..base.sentences import one_sentence
from ..dynamics.rotor import Rotor
from ..dynamics.system import System
from .actuator import column
from .body_vector import ZERO, BodyVector


class AppliedTorque(BodyVector):
    """
    The torque that a message applies to the body [N m] (3,), body axes, from wherever it comes.

    Each of torque.names has a topic of its own, is held and ends by itself.
    """

    topic = 'torque'
    message = 'geometry_msgs/msg/WrenchStamped'
    says = (
        'torque on the body in body axes [N m], held until the next one or the timeout; with '
        'torque.names in its place torque/NAME, each held by itself, all summed'
    )
    words: ClassVar[Mapping[str, str]] = {'torque': 'torque_b'}
    quantity = Key('torque', 'double_array', None, 'N m', '', lengths=(3,))
    field, record = 'wrench.torque', 'torque_b'
    keys = (
        Key(
            'torque.names',
            'string_array',
            (),
            '',
            'names of several applied torques, each commanded on torque/NAME, held and timed out '
            'by itself, all summed; without names there is the one torque',
        ),
    )

    def __init__(self, values: Mapping[str, Any], rotors: tuple[Rotor, ...]):
        self._names = tuple(values['torque.names'])
        self.topics = tuple(f'torque/{name}' for name in self._names) or ('torque',)
        self.none = dict.fromkeys(self.topics, ZERO)
        self._keys = {topic: replace(self.quantity, name=topic) for topic in self.topics}

    def given(self, word: str, given: Any) -> dict[str, Any]:
        """Return by topic the checked values of a word; ValueError: as of Actuator.given."""
        return {topic: self._keys[topic].checked(x) for topic, x in self._by_topic(given).items()}

    def columns(self, word: str, given: Any, count: int) -> dict[str, Any]:
        """Return what is held of torques (M, 3); ValueError: as of Actuator.columns."""
        return {
            topic: tuple(column(topic, x, count, 3).T)
            for topic, x in self._by_topic(given).items()
        }

    def _by_topic(self, given):
        names = self._names
        if isinstance(given, Mapping) != bool(names):
            allowed = (
                f'with torque.names torques are given by name, such as '
                f'{{{names[0]}: [0, 0, 0.01]}}'
                if names
                else f'without torque.names it must be {self.quantity.allowed}'
            )
            raise ValueError(f'torque is {one_sentence(given)}; {allowed}')
        for name in given if names else ():
            if name not in names:
                raise ValueError(f'there is no torque {name}; torque.names has {", ".join(names)}')
        return {f'torque/{name}': x for name, x in given.items()} if names else {'torque': given}

    @classmethod
    def plain(cls, topic: str, value: Any) -> dict[str, Any]:
        """Return a value as given() takes it, by its word."""
        return {'torque': _by_name({topic: value})}

    def read(self, topic: str, message: Any) -> tuple[float, float, float]:
        """Return the value in a message; ValueError: it is built otherwise."""
        force = message.wrench.force
        if (force.x, force.y, force.z) != ZERO:
            raise ValueError(
                f'{topic} has a force of {force.x:g}, {force.y:g}, {force.z:g}; the force must '
                'be zero'
            )
        return super().read(topic, message)

    def effect(self, acting: Mapping[str, Any]) -> tuple[float, ...]:
        """Return the sum (3,) of the torques, added in their order."""
        # Not by NumPy, which would warn of a sum beyond its range: such torques are dropped.
        torques_b = (acting[topic] for topic in self.topics)
        return tuple(reduce(add, parts) for parts in zip(*torques_b, strict=True))

    def driven(self, system: System, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields of a system under what acts."""
        return {'torque_b': np.array(self.effect(acting))}

    def to_plain(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts as plain data."""
        return {'torque_b': _by_name({topic: acting[topic] for topic in self.topics})}

    def from_plain(self, snapshot: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acted when to_plain was asked."""
        return {**self.none, **self.given('torque', snapshot['torque_b'])}

    def report(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts in words."""
        torques_b = {'torque': self.effect(acting)} | {name: acting[name] for name in self.topics}
        return {f'{name} that acts [N m]': torque_b for name, torque_b in torques_b.items()}


def _by_name(torques_b):
    """Return torques by topic as given() takes them."""
    if 'torque' in torques_b:
        return list(torques_b['torque'])
    return {topic.removeprefix('torque/'): list(x) for topic, x in torques_b.items()}

"""The motors of rotors, which follow a torque or, where a drive has a loop for it, a speed."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..base.key import Key
from ..base.sentences import distinct_texts, one_sentence
from ..dynamics.rotor import Rotor
from ..dynamics.system import System
from .actuator import Actuator, column

# The largest command [N m] to a motor without max_torque.
MOST_TORQUE = 1e12
_HELD = 'rotor_command.'


@dataclass(frozen=True)
class MotorCommands:
    """Torques [N m] and speeds [rad/s] by rotor; rotors that are not named keep theirs."""

    torques: Mapping[str, float]
    speeds: Mapping[str, float]


class Motor(NamedTuple):
    """What a motor is commanded: a torque [N m] or, in place of it, a speed [rad/s]."""

    torque: Any = 0.0
    speed: Any = None


class Wheels(Actuator):
    """The motors of the rotors, each commanded, held and timed out by itself."""

    topic = 'rotor_command'
    message = 'sensor_msgs/msg/JointState'
    says = (
        'motor torques (effort [N m]) or speeds (velocity [rad/s]) by name, held until the next '
        'one or the timeout; rotors not named keep theirs'
    )
    words: ClassVar[Mapping[str, str]] = {
        'rotor_torque': 'rotor_torque',
        'rotor_speed': 'rotor_speed',
    }
    limit = 'max_torque'
    # Version 0.1 had one rotor, and its torque alone.
    earlier: ClassVar[Mapping[str, str]] = {'rotor_torque': 'std_msgs/msg/Float64'}
    _torque = Key('rotor_torque', 'double', None, 'N m', '')
    _speed = Key('rotor_speed', 'double', None, 'rad/s', '')

    def __init__(self, values: Mapping[str, Any], rotors: tuple[Rotor, ...]):
        self._has_names = bool(values['rotor.names'])
        self._rotors = {rotor.label: rotor for rotor in rotors}
        self._keys = {
            label: (
                replace(self._torque, name=f'torque on the rotor {label}'),
                replace(self._speed, name=f'speed of the rotor {label}'),
            )
            for label in self._rotors
        }
        self.topics = (self.topic,)
        self.is_fitted = any(rotor.mode == 'motor' for rotor in rotors)
        self.rotors = {f'{_HELD}{label}': label for label in self._rotors}
        self.none = dict.fromkeys(self.rotors, Motor())

    def given(self, word: str, given: Any) -> dict[str, Any]:
        """Return by topic the checked values of a word; ValueError: as of Actuator.given."""
        given = self._by_label(word, given)
        is_torque = word == 'rotor_torque'
        value = self._checked(given, {}) if is_torque else self._checked({}, given)
        return {self.topic: value}

    def columns(self, word: str, given: Any, count: int) -> dict[str, Any]:
        """Return what is held of torques or speeds (M,); ValueError: as of Actuator.columns."""
        held = {}
        for label, commands in self._by_label(word, given).items():
            numbers = column(f'{word} of {label}', commands, count)
            # What one of them may be, all may: the largest is asked for.
            largest = float(numbers[np.argmax(np.abs(numbers))])
            if word == 'rotor_torque':
                self._checked_torque(label, largest)
                held[f'{_HELD}{label}'] = Motor(numbers)
            else:
                self._checked_speed(label, largest)
                held[f'{_HELD}{label}'] = Motor(np.zeros(count), numbers)
        return held

    def _by_label(self, word, given):
        if isinstance(given, Mapping):
            return given
        if self._has_names:
            whats = f'{word.removeprefix("rotor_")}s'
            raise ValueError(
                f'{word} is {one_sentence(given)}; with rotor.names {whats} are given by name, '
                f'such as {{{next(iter(self._rotors))}: 0.001}}'
            )
        return {'rotor': given}

    def _checked(self, torques, speeds):
        return MotorCommands(
            {name: self._checked_torque(name, x) for name, x in torques.items()},
            {name: self._checked_speed(name, x) for name, x in speeds.items()},
        )

    def _motor(self, name, what):
        """Return a rotor that is commanded; ValueError: there is none, or it has no motor."""
        rotor = self._rotors.get(name)
        if rotor is None:
            raise ValueError(f'there is no rotor {name}; there are {", ".join(self._rotors)}')
        if rotor.mode != 'motor':
            raise ValueError(
                f'a {what} the rotor {name} is given and {_key_of(rotor, "mode")} is '
                f'{rotor.mode}; it must be motor'
            )
        return rotor

    def _checked_torque(self, label, given):
        rotor = self._motor(label, 'torque on')
        # As a loop commands it at every tick.
        if type(given) is float and -MOST_TORQUE <= given <= MOST_TORQUE:
            return given
        key, _ = self._keys[label]
        torque = key.checked(given)
        if abs(torque) > MOST_TORQUE and not rotor.max_torque:
            given, most = distinct_texts(torque, math.copysign(MOST_TORQUE, torque))
            raise ValueError(
                f'{key.name} is {given}; without {_key_of(rotor, "max_torque")} it must be at '
                f'most {most.removeprefix("-")} N m, in either direction'
            )
        return torque

    def _checked_speed(self, label, given):
        rotor = self._motor(label, 'speed of')
        _, key = self._keys[label]
        if not rotor.speed_gain:
            raise ValueError(
                f'a {key.name} is given and {_key_of(rotor, "speed_gain")} is 0; it must be '
                'above 0'
            )
        return key.checked(given)

    @classmethod
    def plain(cls, topic: str, value: MotorCommands) -> dict[str, Any]:
        """Return a value as given() takes it, by its word."""
        if value.speeds:
            return {'rotor_speed': dict(value.speeds)}
        return {'rotor_torque': dict(value.torques)}

    def read(self, topic: str, message: Any) -> MotorCommands:
        """Return the value in a message; ValueError: it is built otherwise."""
        if topic in self.earlier:
            return MotorCommands({'rotor': message.data}, {})
        names, efforts, velocities = map(list, (message.name, message.effort, message.velocity))
        if efforts and velocities:
            raise ValueError('rotor_command has efforts and velocities; one of both must be empty')
        what = 'velocity' if velocities else 'effort'
        commands = velocities or efforts
        if len(names) != len(commands):
            raise ValueError(
                f'rotor_command has {len(names)} names and {len(commands)} of {what}; it must '
                f'have one {what} per name'
            )
        if len(set(names)) != len(names):
            raise ValueError(f'rotor_command names a rotor twice: {", ".join(names)}')
        by_name = dict(zip(names, commands, strict=True))
        return MotorCommands({}, by_name) if velocities else MotorCommands(by_name, {})

    def check(self, topic: str, value: MotorCommands) -> None:
        """Raise ValueError, in one sentence, for a value that is not allowed."""
        self._checked(value.torques, value.speeds)

    @classmethod
    def fields(cls, topic: str, value: MotorCommands) -> dict[str, Any]:
        """Return the fields of the message with a value."""
        if topic in cls.earlier:
            return {'data': value.torques['rotor']}
        what, commands = ('velocity', value.speeds) if value.speeds else ('effort', value.torques)
        return {'name': list(commands), what: list(commands.values())}

    def held(self, topic: str, value: MotorCommands) -> dict[str, Any]:
        """Return what a command holds, by name."""
        torques = {f'{_HELD}{name}': Motor(x) for name, x in value.torques.items()}
        return torques | {f'{_HELD}{name}': Motor(0.0, x) for name, x in value.speeds.items()}

    def commanding(self, held: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
        """Yield topics and values of the commands that hold this and nothing else."""
        by_label = {name.removeprefix(_HELD): motor for name, motor in held.items()}
        torques = {label: m.torque for label, m in by_label.items() if m.speed is None}
        speeds = {label: m.speed for label, m in by_label.items() if m.speed is not None}
        if torques:
            yield self.topic, MotorCommands(torques, {})
        if speeds:
            yield self.topic, MotorCommands({}, speeds)

    def within(self, name: str, held: Motor) -> Motor:
        """Return what acts of what is held under a name."""
        most = self._rotors[self.rotors[name]].max_torque
        if isinstance(held.torque, np.ndarray):
            return Motor(np.clip(held.torque, -most, most), held.speed) if most else held
        if 0.0 < most < abs(held.torque):
            return Motor(most if held.torque > 0.0 else -most)
        return held

    def driven(self, system: System, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields of a system under what acts."""
        motors = [acting[name] for name in self.none]
        speeds = [np.nan if motor.speed is None else motor.speed for motor in motors]
        return {
            'rotor_torque': np.array([motor.torque for motor in motors], float),
            'rotor_target': np.array(speeds, float),
        }

    def kept(self, acting: Mapping[str, Any], others: Any, at_s: float) -> dict[str, Any]:
        """Return what continues on this body of what acts on another one."""
        kept = super().kept(acting, others, at_s)
        for name, label in self.rotors.items():
            rotor = self._rotors[label]
            if rotor.mode != 'motor' or (kept[name].speed is not None and not rotor.speed_gain):
                kept[name] = Motor()
        return kept

    def to_plain(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts as plain data."""
        by_label = {label: acting[name] for name, label in self.rotors.items()}
        speeds = {label: m.speed for label, m in by_label.items() if m.speed is not None}
        torques = {'rotor_torque': [motor.torque for motor in by_label.values()]}
        # Only where speeds are commanded are there any.
        return torques | ({'rotor_speed': speeds} if speeds else {})

    def from_plain(self, snapshot: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acted when to_plain was asked."""
        torques = zip(self._rotors, snapshot['rotor_torque'], strict=True)
        by_label = {label: Motor(float(torque)) for label, torque in torques}
        speeds = snapshot.get('rotor_speed', {}).items()
        by_label |= {label: Motor(0.0, float(speed)) for label, speed in speeds}
        return {name: by_label[label] for name, label in self.rotors.items()}


def _key_of(rotor, leaf):
    return f'rotor.{rotor.name}.{leaf}' if rotor.name else f'rotor.{leaf}'

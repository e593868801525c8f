"""Thrusters: on-times in seconds, which begin at ticks and end between them."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import isfinite
from typing import Any, ClassVar

from ..base.key import Key
from ..base.sentences import one_sentence
from ..dynamics.rotor import Rotor
from ..torques.thrust import Firing, Thrust, Thruster
from .actuator import Actuator
from .body_vector import ZERO

_HELD = 'thruster_command.'
# The longest on-time, and the longest of what a thruster has of times: a day [s].
_LONGEST_S = 86_400.0


class Thrusters(Actuator):
    """The thrusters; a command gives on-times [s] by name, replacing the rest of earlier ones."""

    topic = 'thruster_command'
    message = 'trajectory_msgs/msg/JointTrajectory'
    says = (
        'on-times of thrusters [s], from the tick on, replacing the rest of earlier ones: '
        'joint_names, and one point whose positions are the on-times, all else empty or zero; '
        'only with thruster.names'
    )
    words: ClassVar[Mapping[str, str]] = {'thrusters': 'thrusters'}
    limit, limiting = 'min_on_time', 'lengthened to'
    acts_on = Thrust
    is_held = False
    keys = (
        Key(
            'thruster.names',
            'string_array',
            (),
            '',
            'names of thrusters, each described by thruster.NAME.position and so on',
        ),
    )
    of_each = (
        Key(
            'position',
            'double_array',
            ZERO,
            'm',
            'where the thruster acts, from the mass centre, body axes',
            lengths=(3,),
        ),
        Key(
            'direction',
            'double_array',
            (0.0, 0.0, 1.0),
            '',
            'direction of the force on the body, against that of the plume, body axes; only its '
            'direction counts',
            lengths=(3,),
            is_direction=True,
        ),
        Key('thrust', 'double', 0.0, 'N', 'thrust of the open valve', low=0.0, high=1e12),
        Key(
            'min_on_time',
            'double',
            0.0,
            's',
            'shortest on-time; a shorter one above 0 counts as this',
            low=0.0,
            high=_LONGEST_S,
        ),
        Key(
            'delay',
            'double',
            0.0,
            's',
            'time after which the valve follows a command, opening and closing',
            low=0.0,
            high=_LONGEST_S,
        ),
        Key(
            'time_constant',
            'double',
            0.0,
            's',
            'time constant with which the thrust follows the valve; 0: at once',
            low=0.0,
            high=_LONGEST_S,
        ),
        Key(
            'specific_impulse',
            'double',
            0.0,
            's',
            'specific impulse, which gives the propellant used; 0: it is not known',
            low=0.0,
            high=1e9,
        ),
    )
    _on_time = Key('on-time', 'double', None, 's', '', low=0.0, high=_LONGEST_S)

    def __init__(self, values: Mapping[str, Any], rotors: tuple[Rotor, ...]):
        names = values['thruster.names']
        self._thrusters = {
            name: Thruster(*(values[f'thruster.{name}.{key.name}'] for key in self.of_each))
            for name in names
        }
        self.is_fitted = bool(names)
        self.topics = (self.topic,) if names else ()
        self.none = {f'{_HELD}{name}': Firing() for name in names}
        self._keys = {
            name: replace(self._on_time, name=f'on-time of the thruster {name}') for name in names
        }

    @classmethod
    def without_effect(cls, values: Mapping[str, Any]) -> Iterator[str]:
        """Yield a sentence on each thruster without a thrust."""
        for name in values['thruster.names']:
            if not values[f'thruster.{name}.thrust']:
                yield f'thruster.{name}.thrust is 0, so that it has no effect'

    def given(self, word: str, given: Any) -> dict[str, Any]:
        """Return by topic the checked values of a word; ValueError: as of Actuator.given."""
        if not self.is_fitted:
            raise ValueError(f'thrusters is {given}, and thruster.names has none')
        if not isinstance(given, Mapping):
            raise ValueError(
                f'thrusters is {one_sentence(given)}; on-times are given by name, such as '
                f'{{{next(iter(self._thrusters))}: 0.03}}'
            )
        return {self.topic: self._checked(given)}

    def _checked(self, on_times):
        for name in on_times:
            if name not in self._thrusters:
                raise ValueError(
                    f'there is no thruster {name}; thruster.names has {", ".join(self._thrusters)}'
                )
        return {name: self._keys[name].checked(x) for name, x in on_times.items()}

    @classmethod
    def plain(cls, topic: str, value: Mapping[str, float]) -> dict[str, Any]:
        """Return a value as given() takes it, by its word."""
        return {'thrusters': dict(value)}

    def read(self, topic: str, message: Any) -> dict[str, float]:
        """Return the value in a message; ValueError: it is built otherwise."""
        names, points = list(message.joint_names), list(message.points)
        if len(points) != 1:
            raise ValueError(f'{topic} has {len(points)} points; it must have one')
        (point,) = points
        on_times = list(point.positions)
        if len(names) != len(on_times):
            raise ValueError(
                f'{topic} has {len(names)} names and {len(on_times)} positions; it must have one '
                'position, the on-time, per name'
            )
        if len(set(names)) != len(names):
            raise ValueError(f'{topic} names a thruster twice: {", ".join(names)}')
        for what in ('velocities', 'accelerations', 'effort'):
            if len(getattr(point, what)):
                raise ValueError(f'{topic} has {what}; its point must have only positions')
        start = point.time_from_start
        if start.sec or start.nanosec:
            raise ValueError(
                f'{topic} has a time_from_start of {start.sec + 1e-9 * start.nanosec:g} s; it '
                'must be 0, the tick at which the command acts'
            )
        return dict(zip(names, on_times, strict=True))

    def check(self, topic: str, value: Mapping[str, float]) -> None:
        """Raise ValueError, in one sentence, for a value that is not allowed."""
        self._checked(value)

    @classmethod
    def fields(cls, topic: str, value: Mapping[str, float]) -> dict[str, Any]:
        """Return the fields of the message with a value."""
        return {'joint_names': list(value), 'points': [{'positions': list(value.values())}]}

    def held(self, topic: str, value: Mapping[str, float]) -> dict[str, Any]:
        """Return the on-times of a command, by name."""
        return {f'{_HELD}{name}': on_time for name, on_time in value.items()}

    def commanding(self, held: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
        """Yield topics and values of the commands that hold this and nothing else."""
        if held:
            yield self.topic, {name.removeprefix(_HELD): x for name, x in held.items()}

    def within(self, name: str, held: float) -> float:
        """Return the on-time that a command comes to."""
        least = self._of(name).min_on_time
        return least if 0.0 < held < least else held

    def from_instant(self, name: str, held: float, before: Firing, at_s: float) -> Firing:
        """Return the firing under an on-time that is commanded at an instant."""
        return self._of(name).commanded(before, at_s, self.within(name, held))

    def ended(self, acting: Mapping[str, Any], at_s: float) -> dict[str, Any]:
        """Return what is left where the valves close: what was used."""
        return {name: self._of(name).ended(acting[name], at_s) for name in self.none}

    def _of(self, name):
        return self._thrusters[name.removeprefix(_HELD)]

    def torque(self) -> Thrust | None:
        """Return the torque of the thrusters, with their valves closed."""
        return Thrust(self._thrusters, [*self.none.values()]) if self.is_fitted else None

    def commanded(self, torque: Thrust, acting: Mapping[str, Any]) -> Thrust:
        """Return the torque of the thrusters as they fire."""
        return torque.firing([acting[name] for name in self.none])

    def kept(self, acting: Mapping[str, Any], others: 'Thrusters', at_s: float) -> dict[str, Any]:
        """Return what continues on this body of what acts on another one."""
        found = {
            name: self._of(name).taking_over(acting[name], others._of(name), at_s)
            for name in self.none
            if name in acting
        }
        return {**self.none, **found}

    def to_plain(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts as plain data."""
        if not self.is_fitted:
            return {}
        firings = {name.removeprefix(_HELD): acting[name] for name in self.none}
        return {
            'firings': {
                name: firing._asdict() | {'switches_s': list(firing.switches_s)}
                for name, firing in firings.items()
            }
        }

    def from_plain(self, snapshot: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acted when to_plain was asked."""
        if not self.is_fitted:
            return {}
        return {name: _firing(snapshot['firings'][name.removeprefix(_HELD)]) for name in self.none}


def _firing(plain: Mapping[str, Any]) -> Firing:
    """Return a firing of plain data; ValueError, LookupError: it is none."""
    numbers = [float(plain[name]) for name in Firing._fields[:3]]
    switches_s = tuple(map(float, plain['switches_s']))
    if not all(map(isfinite, (*numbers, *switches_s))) or [*switches_s] != sorted(switches_s):
        raise ValueError(
            f'a firing has {numbers} and switches at {switches_s}; they must be finite, and the '
            'switches ascend'
        )
    since_s, force, impulse = numbers
    return Firing(since_s, force, impulse, bool(plain['is_open']), switches_s)

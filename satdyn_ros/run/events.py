"""
What can happen to a run, as data.

An event acts at a tick, never between ticks.  Requests and resets replace the state of their
tick; torques leave it and act from then on.  In a file, events are a YAML list:

    - {at_s: 12.5, torque: [0.0, 0.0, 0.01]}
    - {at_s: 20, request: {initial.angular_velocity: [0.0, 0.0, 0.1]}}
    - {tick: 3000, reset: true}
    - {at_s: 40, rotor_torque: 0.05, until_s: 45}
    - {at_s: 50, magnetorquer: [0.0, 0.0, 0.1]}
    - {at_s: 60, topics: [attitude]}

Each acts at a tick, or at the first tick at or after at_s seconds from tick 0.  A torque and
a dipole end after torque.timeout, as in the node, unless until_s or until_tick says when; null: it
holds until the next one.  What so acts longer or shorter than its times say is in the log.
With rotor.names a rotor_torque is given by name,
{rw_x: 0.001, rw_z: -0.002}; rotors that it does not name keep theirs.  So is a rotor_speed, which
commands speeds in place of torques.  With torque.names so is a
torque, {drag: [0.0, 0.0, 0.01]}.
"""

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import yaml

from ..actuators import ACTUATORS, Command, kind_of
from ..base import ros_yaml
from ..base.key import Key, listed
from ..base.sentences import nearest
from .parameter_file import flattened
from .scenario import Scenario
from .ticks import Ticks


@dataclass(frozen=True)
class Request:
    """New initial conditions, by the keys of the scenario; keys not given stay in force."""

    tick: int
    values: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Reset:
    """A restart from the initial conditions in force."""

    tick: int


@dataclass(frozen=True)
class Timeout:
    """The end of what a command holds: its topic, or what an actuator has behind a point too."""

    tick: int
    topic: str


@dataclass(frozen=True)
class RotorLimited:
    """
    A limit of a rotor: 'max_torque' cuts a command, 'max_speed' was reached since the tick before.

    By rules below 3 'max_speed' drops the command until the next one.
    """

    tick: int
    rotor: str
    limit: str


@dataclass(frozen=True)
class Topics:
    """A change of the published topics."""

    tick: int
    names: tuple[str, ...]


@dataclass(frozen=True)
class TorquesDropped:
    """The end of all torques at the tick before, because with them this tick cannot be reached."""

    tick: int


@dataclass(frozen=True)
class Halt:
    """The end of a motion that does not reach this tick; a request or reset begins a new one."""

    tick: int


Event = Request | Reset | Command | Timeout | RotorLimited | Topics | TorquesDropped | Halt
# They follow from the run and from the others: what a bag has of them is compared, never applied.
Derived = Timeout | RotorLimited | TorquesDropped | Halt

# As large as an integer of ROS; no stamp is so late.
_LARGEST_TICK = 2**63 - 1
_AT = {
    'at_s': Key('at_s', 'double', None, 's', '', low=0.0),
    'tick': Key('tick', 'integer', None, '', '', low=0, high=_LARGEST_TICK),
}
_UNTIL = {
    'until_s': Key('until_s', 'double', None, 's', '', low=0.0),
    'until_tick': Key('until_tick', 'integer', None, '', '', low=0, high=_LARGEST_TICK),
}
_FLAGS: dict[str, Callable[[int], Event]] = {
    'reset': Reset,
    'torques_dropped': TorquesDropped,
    'halt': Halt,
}
# What is commanded, and what of it holds until its end.
_COMMANDS = {word: kind for kind in ACTUATORS.values() for word in kind.words}
_HELD = tuple(word for word, kind in _COMMANDS.items() if kind.is_held)
_WHAT = (*_COMMANDS, 'request', 'topics', 'timeout', 'rotor_limited', *_FLAGS)


def from_yaml(path: str | Path, scenario: Scenario) -> list[Event]:
    """Return the events of a file in the order of their ticks; ValueError: as from_yaml_text."""
    return from_yaml_text(ros_yaml.read_text(path, 'the events'), scenario, str(path))


def from_yaml_text(text: str, scenario: Scenario, origin: str = 'events') -> list[Event]:
    """
    Return the events of a YAML text in the order of their ticks.

    A warning in the log says what is held longer or shorter than its times say, as ticks do it.
    ValueError, in one sentence that names the event: one that the scenario does not allow.
    """
    entries = ros_yaml.load(text, origin) or []
    if not isinstance(entries, list):
        raise ValueError(f'{origin} must be a list of events')
    events: list[Event] = []
    sentences: list[str] = []
    for number, entry in enumerate(entries, 1):
        try:
            held = list(_events(entry, scenario))
        except ValueError as error:
            raise ValueError(f'{origin}, event {number}: {error}') from None
        events += held
        # All of an entry are held alike.
        for event in held[:1]:
            sentences += [f'{origin}{x}' for x in _stretched(number, entry, event, scenario)]
    for sentence in dict.fromkeys(sentences):
        logging.getLogger(__name__).warning(sentence)
    return sorted(events, key=lambda event: event.tick)


def warnings(events: Iterable[Event], end: int, scenario: Scenario) -> list[str]:
    """
    Return what is doubtful about events of a run that ends before tick end, each in one sentence.

    An event that is not allowed is refused by the run, not here.
    """
    found = []
    for event in events:
        at = f'the {name_of(event)} at {float(event.tick / scenario.rate):g} s'
        if event.tick >= end and not isinstance(event, Derived):
            found.append(
                f'{at} (tick {event.tick}) does not act: the run ends at '
                f'{float(end / scenario.rate):g} s; at_s and --duration are in seconds'
            )
        elif isinstance(event, Request):
            with suppress(ValueError):
                conditions = scenario.with_values(event.values)
                found += [f'{at}: {text}' for text in conditions.warnings_about(event.values)]
    return found


def name_of(event: Event) -> str:
    """Return what an event is called in sentences: its class, or the topic of a command."""
    return event.topic if isinstance(event, Command) else type(event).__name__


def to_yaml(events: Iterable[Event]) -> str:
    r"""
    Return the YAML text of events, which says the same whatever the scenario.

    >>> to_yaml([Reset(300)])
    '- {tick: 300, reset: true}\n'
    """
    return ''.join(
        '- ' + yaml.safe_dump(_entry(event), default_flow_style=True, sort_keys=False, width=1e9)
        for event in events
    )


def _events(entry, scenario) -> Iterator[Event]:
    """Yield the events of an entry: one, or of body torques one each."""
    if not isinstance(entry, Mapping):
        raise ValueError(f'it is {entry}; it must be keys and values')
    unknown = [name for name in entry if name not in (*_AT, *_WHAT, *_UNTIL)]
    if unknown:
        allowed = *_AT, *_WHAT, *_UNTIL
        raise ValueError(
            f'{unknown[0]} is not a key of an event; the nearest is '
            f'{nearest(unknown[0], allowed)}; allowed: {", ".join(allowed)}'
        )
    what = _only(entry, _WHAT)
    at = _only(entry, _AT)
    ticks = Ticks(scenario.rate, scenario.epoch_ns)
    tick = _tick(ticks, at, _AT[at].checked(entry[at]))
    if what not in _HELD and any(name in entry for name in _UNTIL):
        raise ValueError(f'{what} does not end; until_s and until_tick belong to torques')
    value = entry[what]
    if what in _COMMANDS:
        actuator = scenario.equipment.of_word[what]
        until_tick = _until(entry, tick, ticks, scenario) if actuator.is_held else None
        for topic, given in actuator.given(what, value).items():
            yield Command(tick, topic, given, until_tick)
        return
    match what:
        case 'request':
            if not isinstance(value, Mapping):
                raise ValueError(f'request is {value}; it must be keys and values')
            yield Request(tick, dict(flattened(value)))
        case 'topics':
            yield Topics(tick, scenario.keys['publish.topics'].checked(value))
        case 'rotor_limited':
            if not (isinstance(value, Mapping) and set(value) == {'rotor', 'limit'}):
                raise ValueError(f'rotor_limited is {value}; it must be a rotor and a limit')
            yield RotorLimited(tick, str(value['rotor']), str(value['limit']))
        case 'timeout':
            equipment = scenario.equipment
            choices = dict.fromkeys((*equipment.none, *equipment.topics, *equipment.of_earlier))
            key = Key('timeout', 'string', None, '', '', choices=tuple(choices))
            yield Timeout(tick, key.checked(value))
        case _:
            if not Key(what, 'bool', None, '', '').checked(value):
                raise ValueError(f'{what} is false; it must be true')
            yield _FLAGS[what](tick)


def _only(entry, names):
    """Return the one of names that the entry has."""
    given = [name for name in names if name in entry]
    if len(given) != 1:
        raise ValueError(
            f'it has {" and ".join(given) or "none"} of {", ".join(names)}; '
            'it must have exactly one'
        )
    return given[0]


def _tick(ticks, name, value) -> int:
    return ticks.ceil(value) if name.endswith('_s') else value


def _until(entry, tick, ticks, scenario) -> int | None:
    given = [name for name in _UNTIL if name in entry]
    if not given:
        return ticks.timeout(tick, scenario['torque.timeout'])
    name = _only(entry, _UNTIL)
    if entry[name] is None:
        return None
    until_tick = _tick(ticks, name, _UNTIL[name].checked(entry[name]))
    if until_tick <= tick:
        at = _only(entry, _AT)
        says = f'{name} is {entry[name]}'
        if _instant_s(name, entry, scenario) > _instant_s(at, entry, scenario):
            raise ValueError(
                f'{says} and {at} {entry[at]}: both fall on tick {tick} '
                f'({float(tick / scenario.rate):g} s); it must fall on a later one'
            )
        raise ValueError(f'{says}; it must be after {at}, {entry[at]}')
    return until_tick


def _stretched(number, entry, event, scenario) -> Iterator[str]:
    """Yield what says that an entry is held for another time than it or torque.timeout says."""
    until_tick = getattr(event, 'until_tick', None)
    if until_tick is None:
        return
    if any(name in entry for name in _UNTIL):
        at, until = _only(entry, _AT), _only(entry, _UNTIL)
        asked_s = _instant_s(until, entry, scenario) - _instant_s(at, entry, scenario)
        what = f', event {number}: from {at} {entry[at]} to {until} {entry[until]} it is'
    else:
        asked_s = Fraction(str(scenario['torque.timeout']))
        what = ': torque.timeout is'
    acts_s = (until_tick - event.tick) / scenario.rate
    asked, acts = f'{float(asked_s):g} s', f'{float(acts_s):g} s'
    if asked != acts:
        rate = f'{float(scenario.rate):g} Hz'
        yield f'{what} {asked}; in whole ticks of {rate} it acts for {acts}'


def _instant_s(name, entry, scenario) -> Fraction:
    """Return the time from tick 0 that one of _AT or _UNTIL gives."""
    value = Fraction(str((_AT | _UNTIL)[name].checked(entry[name])))
    return value if name.endswith('_s') else value / scenario.rate


def _entry(event) -> dict[str, Any]:
    what: dict[str, Any]
    match event:
        case Command():
            kind = kind_of(event.topic)
            until = {'until_tick': event.until_tick} if kind.is_held else {}
            what = kind.plain(event.topic, event.value) | until
        case RotorLimited():
            what = {'rotor_limited': {'rotor': event.rotor, 'limit': event.limit}}
        case Request():
            what = {'request': {name: listed(x) for name, x in event.values.items()}}
        case Topics():
            what = {'topics': list(event.names)}
        case Timeout():
            what = {'timeout': event.topic}
        case _:
            what = {name: True for name, kind in _FLAGS.items() if type(event) is kind}
    return {'tick': event.tick} | what

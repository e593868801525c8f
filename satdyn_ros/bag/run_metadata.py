"""What a bag says of the run in it: the scenario, what happened, and what made it."""

import dataclasses
import json
import platform
from collections.abc import Iterable, Mapping
from typing import Any, get_args

import numpy
import scipy

from .. import __version__
from ..actuators import Command
from ..base.key import Key
from ..kernel.code_folder import compiler
from ..rosbag2.errors import Damaged
from ..run import events
from ..run.events import Event
from ..run.keys import KEYS
from ..run.parameter_file import parameters_of_record
from ..run.rules import RULES
from ..run.scenario import Scenario
from ..torques.body_torque import KNOWN, BodyTorque

SCENARIO = 'satdyn_ros/scenario'
SNAPSHOT = 'satdyn_ros/snapshot'
EVENT = 'satdyn_ros/event'
HELD = 'satdyn_ros/held'

# Commands are recorded as the messages that brought them.
_EVENTS = {kind.__name__: kind for kind in get_args(Event) if kind is not Command}
_LENGTHS = {'q_ib': 4, 'omega_bi_b': 3}


def provenance(
    scenario: Scenario, topics: Mapping[str, str], control: Mapping[str, Any] | None = None
) -> dict[str, str]:
    """
    Return what every file of a bag begins with.

    Parameters
    ----------
    scenario : Scenario
        with the epoch resolved
    topics : dict
        the names in the bag by those in the scenario, {'attitude': '/sat1/attitude'}
    control : dict or None
        name and needs_truth of a controller

    Raises
    ------
    ValueError
        the scenario is larger than what is read of a bag
    """
    text = scenario.to_yaml()
    parameters_of_record(text, 'the scenario, written out for a bag,')
    provenance = {
        'version': __version__,
        'rules': str(RULES),
        'scenario': text,
        'topics': json.dumps(dict(topics)),
        'machine': json.dumps(machine(scenario.torques)),
    }
    if scenario.typed:
        provenance['typed'] = json.dumps(scenario.typed)
    if control:
        provenance['controller'] = json.dumps(dict(control))
    if scenario.torques:
        provenance['torques'] = json.dumps([kind.full_name() for kind in scenario.torques])
    return provenance


def machine(torques: Iterable[type[BodyTorque]] = ()) -> dict[str, str]:
    """Return what the bits of a run depend on besides the scenario and the events."""
    compiled_by = compiler()
    return {
        'processor': f'{platform.machine()} {compiled_by["processor"]}',
        'system': ' '.join([platform.system(), *platform.libc_ver()]).strip(),
        'satdyn_ros': __version__,
        'numba': compiled_by['numba'],
        'llvmlite': compiled_by['llvmlite'],
        'numpy': numpy.__version__,
        'scipy': scipy.__version__,
        **{kind.full_name(): kind.version() for kind in torques},
    }


def to_record(plain: Mapping[str, Any]) -> dict[str, str]:
    """Return plain data as the content of a metadata record."""
    return {name: json.dumps(value) for name, value in plain.items()}


def from_record(record: Mapping[str, str]) -> dict[str, Any]:
    """Return the plain data of a metadata record; Damaged: it has none."""
    try:
        return {name: json.loads(value) for name, value in record.items()}
    except (ValueError, RecursionError):
        raise Damaged('its values are not JSON') from None


def names_and_machine(record: Mapping[str, str]) -> tuple[dict[str, str], dict[str, str]]:
    """Return the names of topics and the machine of provenance; Damaged: it has none."""
    missing = [name for name in ('scenario', 'topics', 'machine') if name not in record]
    if missing:
        raise Damaged(f'it has no {missing[0]}')
    plain = from_record({name: record[name] for name in ('topics', 'machine')})
    for name, texts in plain.items():
        if not isinstance(texts, dict) or not all(isinstance(t, str) for t in texts.values()):
            raise Damaged(f'its {name} does not map names to texts')
    return plain['topics'], plain['machine']


def torques_of(record: Mapping[str, str]) -> list[type[BodyTorque]]:
    """
    Return the kinds of torques of provenance; ValueError: one is not known to this process.

    A bag's own word does not suffice to load code.
    """
    names = from_record({'torques': record.get('torques', '[]')})['torques']
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise Damaged('its torques are not a list of names')
    if unknown := [name for name in names if name not in KNOWN]:
        raise ValueError(
            f'the run in this bag has the torque {unknown[0]}; name it by --torque {unknown[0]}'
        )
    return [KNOWN[name] for name in names]


def typed_of(record: Mapping[str, str]) -> dict[str, Any]:
    """Return the texts with a unit of provenance; Damaged: they do not belong to keys."""
    typed = from_record({'typed': record.get('typed', '{}')})['typed']
    if not isinstance(typed, dict):
        raise Damaged('its typed does not map keys to texts')
    return typed


def rules_of(record: Mapping[str, str]) -> int:
    """Return the rules of provenance; Damaged: this version does not know them."""
    rules = record.get('rules', '0')
    if rules not in map(str, range(RULES + 1)):
        raise Damaged(f'its rules are {rules}; this version of satdyn_ros knows 0 to {RULES}')
    return int(rules)


def held_record(ticks: int | None) -> dict[str, str]:
    """
    Return for how many ticks the torques that follow are held, as a metadata record's content.

    None: until the next one.  A message has no field for it; where no record says otherwise, it is
    torque.timeout of the scenario.
    """
    return to_record({'ticks': ticks})


def held_from_record(record: Mapping[str, str]) -> int | None:
    """Return the ticks of held_record; Damaged: it has none."""
    ticks = from_record(record).get('ticks', 0)
    if ticks is not None and not (type(ticks) is int and ticks > 0):
        raise Damaged('its ticks are not a number of ticks')
    return ticks


def snapshot_from_record(record: Mapping[str, str], scenario: Scenario) -> dict[str, Any]:
    """Return the snapshot of a scenario in a metadata record; ValueError: it is not one."""
    snapshot = from_record(record)
    begin, tick = snapshot.get('begin_tick'), snapshot.get('tick')
    if type(snapshot.get('is_start', False)) is not bool:
        raise Damaged('its is_start is neither true nor false')
    if not (type(begin) is int and type(tick) is int and 0 <= begin <= tick):
        raise Damaged('its ticks are not tick numbers')
    if not isinstance(state := snapshot.get('begin_state'), dict):
        raise Damaged('it has no begin_state')
    for name, vector in state.items():
        length = _LENGTHS.get(name)
        if length and not (
            isinstance(vector, list)
            and len(vector) == length
            and all(isinstance(x, int | float) for x in vector)
        ):
            raise Damaged(f'its {name} is not a vector of {length} numbers')
    inner = state.get('inner', {})
    if not isinstance(inner, dict) or not all(type(x) in (int, float) for x in inner.values()):
        raise Damaged('its inner does not hold inner coordinates')
    until = snapshot.get('until')
    if not isinstance(until, dict) or not all(type(tick) is int for tick in until.values()):
        raise Damaged('its until does not hold ticks')
    scenario.equipment.from_plain(snapshot)
    scenario.keys['publish.topics'].checked(snapshot.get('topics'))
    return snapshot


def event_record(event: Event) -> dict[str, str]:
    """
    Return an event as the content of a metadata record.

    >>> event_record(events.Timeout(300, 'torque'))
    {'event': 'Timeout', 'tick': '300', 'topic': '"torque"'}
    """
    return {'event': type(event).__name__} | to_record(dataclasses.asdict(event))


def event_from_record(record: Mapping[str, str], keys: Mapping[str, Key] = KEYS) -> Event:
    """Return the event of a metadata record; keys: those of the scenario.  Damaged: it is none."""
    kind = _EVENTS.get(record.get('event', ''))
    if kind is None:
        raise Damaged(f'its event is {record.get("event")!r}; allowed: {", ".join(_EVENTS)}')
    values = from_record({name: value for name, value in record.items() if name != 'event'})
    fields = dataclasses.fields(kind)
    if (
        values.keys() != {field.name for field in fields}
        or any(type(values[f.name]) is not f.type for f in fields if f.type in (int, str))
        or values['tick'] < 0
    ):
        raise Damaged(f'it does not describe a {record["event"]}')
    if kind is events.Topics:
        values['names'] = keys['publish.topics'].checked(values['names'])
    if kind is events.Request and not isinstance(values['values'], dict):
        raise Damaged('its request is not keys and values')
    return kind(**values)

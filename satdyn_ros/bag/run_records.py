"""What a bag says of the run in it: the scenario, what happened, and what made it."""

import dataclasses
import json
import platform
from collections.abc import Mapping
from typing import Any

import llvmlite.binding
import numba
import numpy
import scipy

from .. import __version__
from ..run import events
from ..run.events import Event
from ..run.scenario import Scenario

SCENARIO = 'satdyn_ros/scenario'
SNAPSHOT = 'satdyn_ros/snapshot'
EVENT = 'satdyn_ros/event'


def provenance(scenario: Scenario, topics: Mapping[str, str]) -> dict[str, str]:
    """
    Return what every file of a bag begins with.

    scenario: with the epoch resolved.  topics: the names in the bag by those in the scenario,
    {'attitude': '/sat1/attitude'}.
    """
    return {
        'version': __version__,
        'scenario': scenario.to_yaml(),
        'topics': json.dumps(dict(topics)),
        'machine': json.dumps(machine()),
    }


def machine() -> dict[str, str]:
    """Return what the bits of a run depend on beside the scenario and the events."""
    return {
        'processor': f'{platform.machine()} {llvmlite.binding.get_host_cpu_name()}',
        'system': ' '.join([platform.system(), *platform.libc_ver()]).strip(),
        'satdyn_ros': __version__,
        'numba': numba.__version__,
        'llvmlite': llvmlite.__version__,
        'numpy': numpy.__version__,
        'scipy': scipy.__version__,
    }


def to_record(plain: Mapping[str, Any]) -> dict[str, str]:
    """Return plain data as the content of a metadata record."""
    return {name: json.dumps(value) for name, value in plain.items()}


def from_record(record: Mapping[str, str]) -> dict[str, Any]:
    """Return the plain data of a metadata record."""
    return {name: json.loads(value) for name, value in record.items()}


def event_record(event: Event) -> dict[str, str]:
    """
    Return an event as the content of a metadata record.

    >>> event_record(events.Timeout(300, 'torque'))
    {'event': 'Timeout', 'tick': '300', 'topic': '"torque"'}
    """
    return {'event': type(event).__name__} | to_record(dataclasses.asdict(event))


def event_from_record(record: Mapping[str, str]) -> Event:
    """Return the event of a metadata record."""
    values = from_record({name: value for name, value in record.items() if name != 'event'})
    if record['event'] == 'Topics':
        values['names'] = tuple(values['names'])
    return getattr(events, record['event'])(**values)

"""
Spacecraft attitude under the gravity-gradient torque: true dynamics with proof, for ROS 2.

Scenario: a run, from a file or nested keys; scenario.motion().at(t_s) gives its states.
Simulation: a scenario and its events tick by tick.
SideBySide: many runs in step, with commands and samples in columns.
Propagation: the numerical motion of any system from any state.
exact: the motions in closed form; exact.recognise(system, state) finds the one that applies.
describe: what theory says about a scenario, as data.
"""

from importlib import import_module
from typing import Any

__version__ = '0.3.0'

_PUBLIC = {
    'Scenario': 'satdyn_ros.run.scenario',
    'SideBySide': 'satdyn_ros.run.side_by_side',
    'Simulation': 'satdyn_ros.bag.recordable',
    'Propagation': 'satdyn_ros.integrate.propagation',
    'describe': 'satdyn_ros.run.describe',
}

# Where it has another name there.
_NAMES = {'Simulation': 'RecordableSimulation'}

__all__ = ['Propagation', 'Scenario', 'SideBySide', 'Simulation', 'describe', 'exact']


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: a command pays only for what it needs."""
    if name == 'exact':
        return import_module('satdyn_ros.exact')
    if name in _PUBLIC:
        return getattr(import_module(_PUBLIC[name]), _NAMES.get(name, name))
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')


def __dir__() -> list[str]:
    """Return the public names, imported or not, for tab completion and help."""
    return [*__all__, *(name for name in globals() if name.startswith('__'))]

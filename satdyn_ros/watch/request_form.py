"""Requests of a page for new initial conditions: what can be requested, and in what form."""

from typing import Any

from rclpy.parameter import Parameter

from ..ros.client import as_float
from ..run.in_place import OF_ATTITUDE
from ..run.scenario import Scenario

_MOST_VALUES, _MOST_NUMBERS = 32, 16


def initial_conditions(scenario: Scenario) -> dict[str, Any]:
    """Return what a request can change, including those that the rotors' modes have."""
    modes = {'momentum': ('constant_momentum',), 'speed': ('free', 'motor')}
    names = scenario.initial_conditions
    shown = (name for name in names if name.startswith('initial.') and name not in OF_ATTITUDE)
    values = {name: scenario[name] for name in shown}
    for name, value in scenario.values.items():
        rotor, _, what = name.rpartition('.')
        if rotor.startswith('rotor') and scenario[f'{rotor}.mode'] in modes.get(what, ()):
            values[name] = value
    return values


def checked(values: Any) -> dict[str, Any]:
    """Return the values of a request as parameters hold them; ValueError: they are not valid."""
    if not isinstance(values, dict) or not values or len(values) > _MOST_VALUES:
        raise ValueError('values must hold at least one initial condition')
    return {name: _checked(name, value) for name, value in values.items()}


def _checked(name: str, value: Any) -> Any:
    value = as_float(value)
    if isinstance(value, list) and len(value) <= _MOST_NUMBERS:
        value = [as_float(x) for x in value]
    try:
        Parameter(name, value=value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f'{name} must be a number, a list of numbers or a text') from None
    return value

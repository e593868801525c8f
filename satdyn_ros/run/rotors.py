"""The rotors that a scenario describes, under rotor.* or, with names, under rotor.NAME.*."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from ..base.sentences import Faults, told_apart
from ..dynamics import inertia
from ..dynamics.rotor import Rotor
from .keys import KEYS

# What belongs to some modes only.
_MODES_OF = {
    'momentum': ('constant_momentum',),
    'inertia': ('free', 'motor'),
    'speed': ('free', 'motor'),
    'friction': ('free', 'motor'),
    'max_torque': ('motor',),
    'max_speed': ('motor',),
}
# The keys of the one rotor, which have no meaning beside rotor.names.
OF_THE_ONE = tuple(name for name in KEYS if name.startswith('rotor.') and name != 'rotor.names')


def prefixes(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the prefix of the keys of each rotor."""
    return tuple(f'rotor.{name}' for name in names) or ('rotor',)


def belongs(names: tuple[str, ...]) -> list[tuple[str, str, tuple[str, ...]]]:
    """Return of each key that belongs to some modes only: key, the choosing key, the choices."""
    return [
        (f'{prefix}.{leaf}', f'{prefix}.mode', modes)
        for prefix in prefixes(names)
        for leaf, modes in _MODES_OF.items()
    ]


def default(name: str) -> Any:
    """Return the default of a key, of a rotor with a name too."""
    return KEYS[name if name in KEYS else f'rotor.{name.rpartition(".")[2]}'].default


def rotors_of(values: Mapping[str, Any]) -> tuple[Rotor, ...]:
    """Return the rotors of a scenario's values."""
    names = values['rotor.names']
    return tuple(
        Rotor(
            mode=values[f'{prefix}.mode'],
            axis=np.array(values[f'{prefix}.axis']),
            momentum=values[f'{prefix}.momentum'],
            inertia=values[f'{prefix}.inertia'],
            friction=values[f'{prefix}.friction'],
            max_torque=values[f'{prefix}.max_torque'],
            max_speed=values[f'{prefix}.max_speed'],
            name=name,
        )
        for prefix, name in zip(prefixes(names), names or ('',), strict=True)
    )


def faults(values: Mapping[str, Any]) -> Faults:
    """Yield where a rotor leaves the body no inertia, and where one is too fast."""
    left, those_before = inertia.entries(values['body.inertia']), ''
    for prefix, rotor in zip(prefixes(values['rotor.names']), rotors_of(values), strict=True):
        if not rotor.turns_freely:
            continue
        axis, J = rotor.axis, np.asarray(rotor.inertia)
        largest = 1.0 / np.sum(axis * np.linalg.solve(left, axis[..., None])[..., 0], axis=-1)
        is_too_much = ~((J > 0.0) & (J < largest))
        yield is_too_much, partial(_too_much, prefix, rotor, largest, those_before)
        speed = values[f'{prefix}.speed']
        yield (
            (rotor.max_speed > 0.0) & (rotor.max_speed < abs(speed)),
            partial(_too_fast, prefix, rotor, speed),
        )
        rest = left - J[..., None, None] * axis[..., :, None] * axis[..., None, :]
        # Of many, those that leave none are refused; whatever is left can be solved for.
        left = np.where(is_too_much[..., None, None], np.eye(3), rest)
        those_before = ' and the rotors before it'


def _too_much(prefix, rotor, largest, those_before):
    given, most = told_apart(rotor.inertia, float(largest))
    return (
        f'{prefix}.inertia is {given}; with {prefix}.mode {rotor.mode} it must be above 0 and '
        f'below {most} kg m^2, the most that body.inertia{those_before} '
        f'{"allow" if those_before else "allows"}'
    )


def _too_fast(prefix, rotor, speed):
    given, most = told_apart(speed, math.copysign(rotor.max_speed, speed))
    return (
        f'{prefix}.speed is {given}; it must be at most {prefix}.max_speed, '
        f'{most.removeprefix("-")} rad/s, either way'
    )


def speeds_and_angles(
    values: Mapping[str, Any], rotors: tuple[Rotor, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the initial speeds [rad/s] and angles [rad] (R,), nan where a rotor has none."""
    names = prefixes(values['rotor.names'])
    of_each = [
        values[f'{prefix}.speed'] if rotor.turns_freely else np.nan
        for prefix, rotor in zip(names, rotors, strict=True)
    ]
    speeds = np.stack(np.broadcast_arrays(*of_each), axis=-1)
    return speeds, np.where(np.isnan(speeds), np.nan, 0.0)

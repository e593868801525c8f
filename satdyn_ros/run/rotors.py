"""The rotors that a scenario describes, under rotor.* or, with names, under rotor.NAME.*."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.sentences import Checks, distinct_texts
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
    'coulomb_friction': ('free', 'motor'),
    'friction_speed': ('free', 'motor'),
    'speed_gain': ('motor',),
    'static_imbalance': ('free', 'motor'),
    'dynamic_imbalance': ('free', 'motor'),
    'position': ('free', 'motor'),
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


def unnamed(name: str) -> str:
    """Return a key as it is without names, if it is that of a rotor with a name."""
    is_named = name not in KEYS and name.startswith('rotor.')
    return f'rotor.{name.rpartition(".")[2]}' if is_named else name


def default(name: str) -> Any:
    """Return the default of a key, of a rotor with a name too."""
    return KEYS[unnamed(name)].default


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
            coulomb_friction=values[f'{prefix}.coulomb_friction'],
            friction_speed=values[f'{prefix}.friction_speed'],
            speed_gain=values[f'{prefix}.speed_gain'],
            static_imbalance=values[f'{prefix}.static_imbalance'],
            dynamic_imbalance=values[f'{prefix}.dynamic_imbalance'],
            position=np.array(values[f'{prefix}.position']),
            name=name,
        )
        for prefix, name in zip(prefixes(names), names or ('',), strict=True)
    )


def checks(values: Mapping[str, Any]) -> Checks:
    """Check that the rotors leave the body an inertia, and that none is too fast."""
    left, others = inertia.entries(values['body.inertia']), ''
    for prefix, rotor in zip(prefixes(values['rotor.names']), rotors_of(values), strict=True):
        if not rotor.turns_freely:
            continue
        axis, J = rotor.axis, np.asarray(rotor.inertia)
        largest = 1.0 / np.sum(axis * np.linalg.solve(left, axis[..., None])[..., 0], axis=-1)
        # A body of which only rounding is left cannot be solved for.
        is_too_much = ~((J > 0.0) & (J < largest * (1.0 - inertia.ROUNDING)))
        if (yield is_too_much):
            given, most = distinct_texts(rotor.inertia, float(largest))
            raise ValueError(
                f'{prefix}.inertia is {given}; with {prefix}.mode {rotor.mode} it must '
                f'be above 0 and below {most} kg m^2, the most that body.inertia{others} '
                f'{"allow" if others else "allows"}'
            )
        rest = left - J[..., None, None] * axis[..., :, None] * axis[..., None, :]
        # Among many, those that are refused keep what can be solved for.
        left = np.where(is_too_much[..., None, None], left, rest)
        others = ' and the rotors before it'
        speed = values[f'{prefix}.speed']
        if (yield (rotor.max_speed > 0.0) & (rotor.max_speed < abs(speed))):
            given, most = distinct_texts(speed, math.copysign(rotor.max_speed, speed))
            raise ValueError(
                f'{prefix}.speed is {given}; it must be at most {prefix}.max_speed, '
                f'{most.removeprefix("-")} rad/s, in either direction'
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

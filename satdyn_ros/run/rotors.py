"""The rotors that a scenario describes, under rotor.* or, with names, under rotor.NAME.*."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.key import listed
from ..base.sentences import told_apart
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


def refuse_foreign(values: Mapping[str, Any]) -> None:
    """Raise ValueError for a key that does not belong to its rotor's mode or to rotor.names."""
    names = values['rotor.names']
    if names:
        for name in OF_THE_ONE:
            if values[name] != KEYS[name].default:
                raise ValueError(
                    f'{name} is {listed(values[name])}; with rotor.names only its default '
                    f'is allowed; use {name.replace("rotor.", f"rotor.{names[0]}.")} and so on'
                )
    for name, chooser, modes in belongs(names):
        mode, leaf = values[chooser], name.rpartition('.')[2]
        if mode not in modes and values[name] != KEYS[f'rotor.{leaf}'].default:
            raise ValueError(
                f'{name} is {values[name]}; with {chooser} {mode} only its default is allowed: '
                f'it belongs to {" and ".join(modes)}'
            )


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


def check(values: Mapping[str, Any], rotors: tuple[Rotor, ...], inertia: np.ndarray) -> None:
    """Raise ValueError where the rotors leave the body no inertia, or one is too fast."""
    left = inertia
    for prefix, rotor in zip(prefixes(values['rotor.names']), rotors, strict=True):
        if not rotor.turns_freely:
            continue
        largest = 1.0 / (rotor.axis @ np.linalg.solve(left, rotor.axis))
        if not 0.0 < rotor.inertia < largest:
            others = '' if left is inertia else ' and the rotors before it'
            given, most = told_apart(rotor.inertia, float(largest))
            raise ValueError(
                f'{prefix}.inertia is {given}; with {prefix}.mode {rotor.mode} it must '
                f'be above 0 and below {most} kg m^2, the most that body.inertia{others} '
                f'{"allow" if others else "allows"}'
            )
        left = left - rotor.inertia * np.outer(rotor.axis, rotor.axis)
        speed = values[f'{prefix}.speed']
        if 0.0 < rotor.max_speed < abs(speed):
            given, most = told_apart(speed, math.copysign(rotor.max_speed, speed))
            raise ValueError(
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

"""The sensors that a scenario describes."""

import secrets
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.sentences import Checks
from ..sensors import COMMON, KINDS, Gyro, Sensor
from ..sensors.noise import stream_of
from ..sensors.sensor_keys import type_of_sensor
from .keys import KEYS
from .orbits import type_of
from .rules import TURNS_ARE_COUNTED


def given_types(given: Mapping[str, Any]) -> dict[str, str]:
    """
    Return the types of the sensors by name, where they are given.

    ValueError, in one sentence: a name is not allowed, or has no type.
    """
    types = {}
    for name in KEYS['sensors.names'].checked(given.get('sensors.names', ())):
        if not (name.isidentifier() and name.isascii()) or name in ('names', 'seed'):
            raise ValueError(
                f'sensors.names has {name!r}; a name has letters, digits and _, does not begin '
                'with a digit and is neither names nor seed'
            )
        key = type_of_sensor(name)
        if key.name in given:
            types[name] = key.checked(given[key.name])
        elif name not in KINDS:
            raise ValueError(
                f'sensors.names has {name}, which is not a type; {key.name} must be one of '
                f'{", ".join(KINDS)}'
            )
    return types


def kinds(values: Mapping[str, Any]) -> dict[str, type[Sensor]]:
    """Return the kinds of the sensors of a scenario by name, in the order of KINDS."""
    names = values['sensors.names']
    types = {name: values.get(f'sensors.{name}.type', name) for name in names}
    return {
        name: kind
        for type_name, kind in KINDS.items()
        for name in names
        if types[name] == type_name
    }


def of(values: Mapping[str, Any], rate_hz: float) -> dict[str, Sensor]:
    """Return the sensors of a scenario's values by name, in the order in which they publish."""
    return {
        name: kind.of(_options(values, name, kind), values[f'sensors.{name}.divisor'] / rate_hz)
        for name, kind in kinds(values).items()
    }


def by_rules(sensors: Mapping[str, Sensor], rules: int) -> dict[str, Sensor]:
    """Return sensors that measure as runs of these rules do."""
    if rules >= TURNS_ARE_COUNTED:
        return dict(sensors)
    return {
        name: replace(sensor, folds=True) if isinstance(sensor, Gyro) else sensor
        for name, sensor in sensors.items()
    }


def checks(values: Mapping[str, Any]) -> Checks:
    """Check what is said of sensors that are not there, and what orbit and environment allow."""
    for sensor in [kind for kind in KINDS if kind not in values['sensors.names']]:
        for name, key in KEYS.items():
            if name.startswith(f'sensors.{sensor}.') and (yield values[name] != key.default):
                raise ValueError(
                    f'{name} is given, and sensors.names has no {sensor}; add it there or leave '
                    f'{name} out'
                )
    orbit_type = type_of(values)
    for sensor, kind in kinds(values).items():
        if kind.needs and (yield values[kind.needs] == 'none'):
            raise ValueError(
                f'sensors.names has {sensor}, a {kind.kind}, and {kind.needs} is none; give '
                f'{kind.needs}, or leave {sensor} out'
            )
        for leaf in kind.with_sun if values['environment.sun'] == 'none' else ():
            value = values[f'sensors.{sensor}.{leaf}']
            if (yield value != 0.0):
                raise ValueError(
                    f'sensors.{sensor}.{leaf} is {value:g}, and environment.sun is none; give '
                    f'environment.sun, or leave sensors.{sensor}.{leaf} out'
                )
        for leaf in () if orbit_type.has_lvlh else kind.with_orbit:
            value = values[f'sensors.{sensor}.{leaf}']
            if (yield value != 0.0):
                raise ValueError(
                    f'sensors.{sensor}.{leaf} is {value:g}; with orbit.type {orbit_type.name} '
                    'there is no Earth to look away from, so it must be 0'
                )


def drawn_seed() -> int:
    """Return a random seed above 0."""
    return secrets.randbelow(int(KEYS['sensors.seed'].high)) + 1


def _options(values: Mapping[str, Any], name: str, kind: type[Sensor]) -> dict[str, Any]:
    leaves = (key.name for key in (*COMMON, *kind.keys) if key.name != 'frame_id')
    options = {leaf: values[f'sensors.{name}.{leaf}'] for leaf in leaves}
    return options | {
        'seed': values['sensors.seed'],
        'stream': stream_of(name),
        'mounting': np.array(options['mounting']),
    }

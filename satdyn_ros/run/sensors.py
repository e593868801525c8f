"""The sensors that a scenario describes."""

import secrets
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..base.sentences import Rules
from ..sensors import Gyro, StarTracker
from ..sensors.suite import Sensor
from .keys import KEYS, SENSORS


def of(values: Mapping[str, Any], rate_hz: float) -> dict[str, Sensor]:
    """Return the sensors of a scenario's values by name, in the order of SENSORS."""
    chosen = (name for name in SENSORS if name in values['sensors.names'])
    return {name: _BUILDERS[name](_options(values, name), rate_hz) for name in chosen}


def rules(values: Mapping[str, Any]) -> Rules:
    """Check what is said of sensors that are not there, and what the orbit does not allow."""
    for sensor in SENSORS:
        for name in () if sensor in values['sensors.names'] else _names(sensor):
            if (yield values[name] != KEYS[name].default):
                raise ValueError(
                    f'{name} is given, and sensors.names has no {sensor}; add it there or leave '
                    f'{name} out'
                )
    exclusion = values['sensors.star_tracker.earth_exclusion']
    if (yield exclusion and values['orbit.type'] == 'fixed'):
        raise ValueError(
            f'sensors.star_tracker.earth_exclusion is {exclusion:g}; with orbit.type fixed there '
            'is no Earth to look away from, so it must be 0'
        )


def drawn_seed() -> int:
    """Return a random seed above 0."""
    return secrets.randbelow(int(KEYS['sensors.seed'].high)) + 1


def _names(sensor: str) -> list[str]:
    return [name for name in KEYS if name.startswith(f'sensors.{sensor}.')]


def _options(values: Mapping[str, Any], sensor: str) -> dict[str, Any]:
    options = {name.rpartition('.')[2]: values[name] for name in _names(sensor)}
    del options['frame_id']
    return options | {'seed': values['sensors.seed'], 'mounting': np.array(options['mounting'])}


def _gyro(options: dict[str, Any], rate_hz: float) -> Gyro:
    return Gyro(interval_s=options['divisor'] / rate_hz, **options)


def _star_tracker(options: dict[str, Any], rate_hz: float) -> StarTracker:
    return StarTracker(**options)


_BUILDERS: dict[str, Callable[[dict[str, Any], float], Sensor]] = {
    'gyro': _gyro,
    'star_tracker': _star_tracker,
}

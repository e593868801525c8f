"""
Keys that may be given in place of others, in the terms in which people have them.

A scenario has the value of the other key; these are then as if they had not been given.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..base.nanoseconds import stamp_ns
from ..kernel import rotation
from ..orbits.kepler import EARTH_RADIUS_M
from . import pointing
from .keys import KEYS

# The key, the one in whose place it is given, and the value of that.
IN_PLACE: dict[str, tuple[str, Callable[[Any], Any]]] = {
    'orbit.altitude': ('orbit.semi_major_axis', lambda altitude_m: EARTH_RADIUS_M + altitude_m),
    'time.epoch': ('time.epoch_ns', stamp_ns),
    'initial.roll_pitch_yaw': (
        'initial.attitude',
        lambda angles_rad: rotation.from_roll_pitch_yaw(*np.moveaxis(angles_rad, -1, 0)),
    ),
}
# What is given in place of the attitude.
OF_ATTITUDE = ('initial.roll_pitch_yaw', *pointing.POINTING)
NOT_GIVEN = {name: KEYS[name].default for name in IN_PLACE}


def resolved(values: Mapping[str, Any], given: Iterable[str]) -> dict[str, Any]:
    """
    Return what the keys of IN_PLACE that have been given change in the values of others.

    given: the names of those given.  ValueError, one sentence: both are given, or the value that
    follows is not allowed.
    """
    changes = {}
    for name, (other, value_of) in IN_PLACE.items():
        value = values[name]
        if value == NOT_GIVEN[name]:
            continue
        # An epoch of 0 is none.
        if other in given and values[other]:
            raise ValueError(
                f'{name} is {value} and {other} {values[other]}; only one of the two may be given'
            )
        try:
            changes[other] = KEYS[other].checked(value_of(value))
            if name == 'time.epoch' and not changes[other]:
                raise ValueError(f'{other} is 0, which is not a time in ROS; it must be later')
        except ValueError as error:
            raise ValueError(f'{name} is {value}, and then {error}') from None
    return changes


def of(name: str) -> tuple[str, ...]:
    """Return a key, and the one in whose place it is given."""
    return (name, IN_PLACE[name][0]) if name in IN_PLACE else (name,)


def replaced(given: Iterable[str]) -> set[str]:
    """Return the keys in whose place some of those given are."""
    names = {*given}
    found = {IN_PLACE[name][0] for name in names if name in IN_PLACE}
    # A new attitude takes the place of one that is pending, however it is given.
    if names & {'initial.attitude', 'initial.roll_pitch_yaw', 'initial.pointing'}:
        found |= {'initial.attitude', *pointing.POINTING} - names
    return found

"""
The initial attitude by what points where: one body axis at a target, a second as near as can be.

The target is the attracting centre (nadir), the Sun, or a direction in inertial axes.  The second
body axis then comes as near as possible to the velocity for nadir, and to the normal of the orbit
else, which is inertial Z for orbit.type fixed.  Black 1964, the algebraic method of two vectors.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..environment import sun_direction
from ..kernel import rotation
from . import environment, orbits
from .keys import KEYS

_ATTITUDE, _POINTING = 'initial.attitude', 'initial.pointing'
_AXES = 'initial.pointing_axis', 'initial.second_axis'
_DIRECTION = 'initial.direction'
# All are given in place of the attitude, and belong to initial.pointing.
POINTING = (_POINTING, *_AXES, _DIRECTION)
_NOT_POINTING = {name: KEYS[name].default for name in POINTING}
# Nearer to each other than this two directions are one [rad].
_PARALLEL = 1e-9


def check(values: Mapping[str, Any], given: Iterable[str]) -> None:
    """Raise ValueError, in one sentence, unless the keys of the pointing suit each other."""
    target = values[_POINTING]
    if not target:
        for name in (*_AXES, _DIRECTION):
            if values[name] != _NOT_POINTING[name]:
                raise ValueError(
                    f'{name} is {list(values[name])} and {_POINTING} is not given; it must be one '
                    f'of {", ".join(filter(None, KEYS[_POINTING].choices))}'
                )
        return
    for name in (_ATTITUDE, 'initial.roll_pitch_yaw'):
        if name in given and values[name] != KEYS[name].default:
            raise ValueError(
                f'{_POINTING} is {target} and {name} {list(values[name])}; only one of the two '
                'may be given'
            )
    kind = orbits.type_of(values)
    if target == 'nadir' and not kind.has_lvlh:
        raise ValueError(
            f'{_POINTING} is nadir; with orbit.type {kind.name} there is no velocity, so it must '
            'be inertial'
        )
    if target == 'sun' and values['environment.sun'] == 'none':
        raise ValueError(f'{_POINTING} is sun, and environment.sun is none; it must be ephemeris')
    if (target == 'inertial') != any(values[_DIRECTION]):
        must = 'have a direction' if target == 'inertial' else 'not be given'
        raise ValueError(
            f'{_DIRECTION} is {list(values[_DIRECTION])}; with {_POINTING} {target} it must {must}'
        )
    first, second = (values[name] for name in _AXES)
    if not np.linalg.norm(_across(first, second)) > _PARALLEL:
        raise ValueError(
            f'{_AXES[1]} is {list(second)} and {_AXES[0]} {list(first)}; both must have a '
            'direction, and not the same'
        )


def resolved(values: Mapping[str, Any], at_s: float, rules: int) -> dict[str, Any]:
    """
    Return what initial.pointing, where it is given, changes at a time.

    It is not given then.  Where it needs the instant of tick 0 and there is none yet, nothing
    changes.

    Parameters
    ----------
    values : dict
        of a scenario
    at_s : s
        the time, from tick 0
    rules : int
        of a scenario
    """
    target, in_lvlh = values[_POINTING], values['initial.frame'] == 'lvlh'
    if not target:
        return {}
    is_constant = target == 'nadir' and in_lvlh
    if not is_constant and environment.needs_epoch(values) and not values['time.epoch_ns']:
        return {}
    if is_constant:
        return {_ATTITUDE: _attitude(values, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]), **_NOT_POINTING}
    orbit = orbits.orbit_of(values, rules)
    q_il, near_i = rotation.IDENTITY, np.array([0.0, 0.0, 1.0])
    if orbit.has_lvlh:
        q_il = orbit.lvlh(at_s)
        near_i = rotation.rotate(q_il, [0.0, -1.0, 0.0])
    toward_i = np.array(values[_DIRECTION])
    if target == 'nadir':
        toward_i, near_i = (rotation.rotate(q_il, axis) for axis in ([0, 0, 1], [1, 0, 0]))
    elif along := environment.along(values, orbit, rules) if target == 'sun' else None:
        r_i, _ = orbit.position_velocity(at_s)
        toward_i, _ = sun_direction(r_i, along.modelled_sun(np.array([at_s]))[0])
    q_ib = _attitude(values, toward_i, near_i)
    if in_lvlh:
        q_ib = rotation.multiply(rotation.conjugate(q_il), q_ib)
    return {_ATTITUDE: q_ib, **_NOT_POINTING}


def _attitude(values, toward_a, near_a):
    """Return q_ab that takes the one body axis to a direction, and the other near a second."""
    if np.linalg.norm(_across(toward_a, near_a)) < _PARALLEL:
        # Every turn about the direction is as near as any other; this one is far from it.
        near_a = np.eye(3)[np.argmin(np.abs(toward_a))]
    in_b = _triad(*(values[name] for name in _AXES))
    return rotation.from_matrix(_triad(toward_a, near_a) @ in_b.T)


def _triad(first, second):
    """Return as columns the unit vectors along the first, across both, and across these two."""
    along = np.asarray(first, float) / np.linalg.norm(first)
    across = _across(first, second)
    across = across / np.linalg.norm(across)
    return np.stack([along, across, np.cross(along, across)], axis=-1)


def _across(first, second):
    """Return the product of the directions of two vectors."""
    lengths = np.linalg.norm(first) * np.linalg.norm(second)
    return np.cross(first, second) / lengths if lengths else np.zeros(3)

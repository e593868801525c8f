"""What a sweep can vary: a scenario's keys, their components, angles and ratios from them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.key import Key
from ..base.sentences import nearest
from ..kernel import rotation
from ..run.in_place import IN_PLACE
from ..run.keys import KEYS
from ..theory.stability import smelt_moments, smelt_parameters

_MOTION = ('body', 'rotor', 'orbit', 'initial', 'motion')
_COMPONENTS = ('x', 'y', 'z')
_ANGLES = ('initial.roll', 'initial.pitch', 'initial.yaw')
_ANGLES_OF_ATTITUDE = 'initial.roll_pitch_yaw'
_SMELT = ('smelt.k_R', 'smelt.k_Y')

# Every kind of name, and what it stands for.
QUANTITY_FORMS = {
    ', '.join(f'`{group}.*`' for group in _MOTION): 'the keys of a scenario that its motion '
    'depends on, whole: numbers, lists and texts; those of torques of your own too; not '
    '`rotor.names`, which decides on the keys, nor `initial.pointing` with its axes',
    ', '.join(f'`KEY.{c}`' for c in _COMPONENTS): 'one component of such a key that has three',
    ', '.join(f'`{name}`' for name in _ANGLES): 'one of the 3-2-1 angles of `initial.attitude` '
    '[rad], the others as they are',
    ', '.join(f'`{name}`' for name in _SMELT): '`body.inertia` by the Smelt parameters '
    '(I_n - I_r) / I_t and (I_n - I_t) / I_r, for body axes x ahead, y normal to the orbit, '
    'z vertical; the sum of the moments does not change',
}


@dataclass(frozen=True)
class Quantity:
    """
    One quantity that a sweep varies.

    Attributes
    ----------
    key : Key
        its kind and range
    changes : function of values and value
        returns the scenario's keys that change when the quantity takes value in a scenario of
        values; of many scenarios, all are arrays (M,), (M, k)
    part_of : str
        the key of whose value it is a part, empty: it is a whole key
    """

    key: Key
    changes: Callable[[Mapping[str, Any], Any], dict[str, Any]]
    part_of: str = ''


def quantity(name: str, keys: Mapping[str, Key] = KEYS) -> Quantity:
    """
    Return the quantity of a name, keys being those of the scenario; ValueError: it is unknown.

    >>> quantity('initial.angular_velocity.y').changes(
    ...     {'initial.angular_velocity': (0.0, 0.0, 0.0)}, 0.1)
    {'initial.angular_velocity': array([0. , 0.1, 0. ])}
    """
    if name == 'rotor.names':
        raise ValueError(
            'rotor.names in vary cannot be varied: it decides which keys there are; give each '
            'choice of rotors a sweep of its own'
        )
    if name in keys and _is_of_the_motion(name):
        other, value_of = IN_PLACE.get(name, (name, lambda value: value))
        return Quantity(keys[name], lambda values, value: {name: value, other: value_of(value)})
    whole, _, component = name.rpartition('.')
    has_three = whole in keys and 3 in keys[whole].lengths and whole not in IN_PLACE
    if component in _COMPONENTS and has_three:
        return _component(name, keys[whole], _COMPONENTS.index(component))
    if name in _ANGLES:
        return _angle(name)
    if name in _SMELT:
        return _smelt(name)
    varied = [key for key in keys if _is_of_the_motion(key)]
    raise ValueError(
        f'{name} in vary cannot be varied; the nearest that can is {nearest(name, varied)}; '
        'allowed: keys of body, rotor, orbit, initial and motion, components such as '
        'initial.angular_velocity.y, '
        f'{", ".join((*_ANGLES, *_SMELT))}'
    )


def _is_of_the_motion(key):
    return (key.split('.')[0] in _MOTION or key not in KEYS) and key != 'rotor.names'


def _component(name, whole, i):
    def changes(values, value):
        parts = _parts(name, whole.name, values[whole.name])
        parts[i] = value
        return {whole.name: _stacked(parts)}

    return Quantity(replace(whole, name=name, kind='double', lengths=()), changes, whole.name)


def _angle(name):
    def changes(values, value):
        # Of an attitude they are read once: its angles would be others beyond 90 deg of pitch.
        given = values[_ANGLES_OF_ATTITUDE]
        if not np.size(given):
            given = rotation.roll_pitch_yaw(values['initial.attitude'])
        angles = [*np.moveaxis(np.asarray(given, float), -1, 0)]
        angles[_ANGLES.index(name)] = value
        together = _stacked(angles)
        other, value_of = IN_PLACE[_ANGLES_OF_ATTITUDE]
        return {_ANGLES_OF_ATTITUDE: together, other: value_of(together)}

    key = Key(name, 'double', 0.0, 'rad', 'a 3-2-1 angle of the initial attitude')
    return Quantity(key, changes, 'initial.attitude')


def _smelt(name):
    def changes(values, value):
        I_t, I_n, I_r = _parts(name, 'body.inertia', values['body.inertia'])
        total = I_t + I_n + I_r
        ratios = list(smelt_parameters(I_r, I_t, I_n))
        ratios[_SMELT.index(name)] = value
        I_r, I_t, I_n = smelt_moments(*ratios)
        size = total / (I_r + I_t + I_n)
        return {'body.inertia': _stacked([size * I_t, size * I_n, size * I_r])}

    key = Key(name, 'double', 0.0, '', 'a Smelt parameter', above=-1.0, below=1.0)
    return Quantity(key, changes, 'body.inertia')


def _parts(name, whole, vector):
    """Return the three components of a vector; ValueError: it does not have three."""
    parts = [*np.moveaxis(np.asarray(vector, float), -1, 0)]
    if len(parts) != 3:
        raise ValueError(f'{name} is varied, but {whole} has {len(parts)} entries; it must have 3')
    return parts


def _stacked(parts):
    return np.stack(np.broadcast_arrays(*parts), axis=-1)

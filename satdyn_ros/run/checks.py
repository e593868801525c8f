"""
What the values of a scenario may not be together: a check each, for one scenario and for many.

values: every key by its dotted name, each allowed by itself; of many, what differs as (M, 1) or
(M, 1, k).  A sentence names the key.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from ..base.key import listed
from ..base.sentences import Checks, distinct_texts, written
from ..dynamics import inertia
from ..kernel.rows import length
from ..torques.thrust import LEAST_TIME_CONSTANT_S
from . import environment, modes, orbits, rotors, sensors
from .keys import DIRECTIONS
from .ticks import LAST_STAMP_NS, Ticks, rate_of

# What moves by more than this between two ticks [rad] takes more steps than a tick may.
_MOST_RAD_PER_TICK = 1e6
# The longest wall time between two ticks: the system waits for no more.
_LONGEST_TICK_S = 1e9
# What a quaternion of four digits may be off; less than the second is not worth a word.
_UNIT_TO, _UNIT_TO_ROUNDING = 1e-4, 1e-6

# A key that belongs to some choices only: key, the choosing key, the choices.
BELONGS = (
    *orbits.belongs(),
    *environment.OF_THE_AIR,
)


def units(values: Mapping[str, Any]) -> Checks:
    """Check that quaternions are units but for their digits, and that axes have a direction."""
    for name, allowed_error in _units_of(values):
        norm = np.linalg.norm(np.asarray(values[name]), axis=-1)
        if (yield norm == 0.0):
            raise ValueError(f'{name} is {list(values[name])}; it must not be zero')
        if (yield norm == np.inf):
            raise ValueError(f'{name} is {list(values[name])}; its norm must be finite')
        if (yield abs(norm - 1.0) > allowed_error):
            raise ValueError(
                f'{name} is {list(values[name])}, of norm {distinct_texts(norm, 1.0)[0]}; it must '
                f'be a unit quaternion x, y, z, w, to within {allowed_error:g}'
            )


def as_units(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the quaternions and axes as unit vectors."""
    return {name: _unit(values[name]) for name, _ in _units_of(values)}


def divided(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence on each quaternion that is not quite a unit one."""
    for name in _quaternions(values):
        norm = math.hypot(*values[name])
        if abs(norm - 1.0) > _UNIT_TO_ROUNDING:
            given = f'{name} is {list(values[name])}, of norm {distinct_texts(norm, 1.0)[0]}'
            yield f'{given}; it is divided by it'


def _units_of(values):
    """Return the names of quaternions and axes, with what the norm of each may be off."""
    quaternions = ((name, _UNIT_TO) for name in _quaternions(values))
    directions = [] if values['rotor.names'] else ['rotor.axis']
    for names, leaf in DIRECTIONS:
        group = names.partition('.')[0]
        directions += [f'{group}.{name}.{leaf}' for name in values[names]]
    return [*quaternions, *((name, np.inf) for name in directions)]


def _quaternions(values):
    mountings = (name for name in values if re.fullmatch(r'sensors\.\w+\.mounting', name))
    return ['initial.attitude', *mountings]


def _unit(vector):
    """Return a vector, or many (..., k), as units; one that is unit to rounding stays as it is."""
    vectors = np.asarray(vector)
    # One alone goes to BLAS, whose sum may differ in the last bit.
    axis = -1 if vectors.ndim > 1 else None
    norm = np.linalg.norm(vectors, axis=axis, keepdims=True)
    is_unit = np.abs(norm - 1.0) < 4.0 * np.finfo(float).eps
    if np.all(is_unit):
        return vector
    found = np.where(is_unit, vectors, vectors / norm)
    return found if vectors.ndim > 1 else tuple(found.tolist())


def belongs(values: Mapping[str, Any]) -> Checks:
    """Check that what belongs to other choices than those made is not given."""
    names = values['rotor.names']
    for name in rotors.OF_THE_ONE if names else ():
        if (yield _is_given(values, name)):
            raise ValueError(
                f'{name} is {listed(values[name])}; with rotor.names only its default '
                f'is allowed; use {name.replace("rotor.", f"rotor.{names[0]}.")} and so on'
            )
    for name, chooser, choices in (*BELONGS, *rotors.belongs(names)):
        if values[chooser] not in choices and (yield _is_given(values, name)):
            raise ValueError(
                f'{name} is {_shown(values, name)}; with {chooser} {values[chooser]} only its '
                f'default is allowed: it belongs to {" and ".join(choices)}'
            )


def _shown(values, name):
    """Return a value as a sentence shows it, a text of many lines not at all."""
    return 'given' if name in orbits.TEXTS else listed(values[name])


def _is_given(values, name):
    """Return whether a key has another value than its default; of many, whether each has."""
    value, default = values[name], rotors.default(name)
    if isinstance(value, np.ndarray) and isinstance(default, tuple):
        return np.any(value != np.array(default), axis=-1)
    return value != default


def torques(values: Mapping[str, Any]) -> Checks:
    """Check that the names of applied torques may stand in topics."""
    for name in values['torque.names']:
        if (yield not (name.isidentifier() and name.isascii())):
            raise ValueError(
                f'torque.names has {name!r}; a name has letters, digits and _ and does not begin '
                'with a digit'
            )


def thrusters(values: Mapping[str, Any]) -> Checks:
    """Check that chambers are at once or slow enough to be integrated."""
    for name in (f'thruster.{each}.time_constant' for each in values['thruster.names']):
        if (yield (values[name] > 0.0) & (values[name] < LEAST_TIME_CONSTANT_S)):
            raise ValueError(
                f'{name} is {written(values[name])}; it must be 0 or at least '
                f'{LEAST_TIME_CONSTANT_S:g} s'
            )


def body(values: Mapping[str, Any]) -> Checks:
    """Check that the inertia is that of a body."""
    return inertia.checks(values['body.inertia'])


def ticks(values: Mapping[str, Any]) -> Checks:
    """Check that a run has a second tick."""
    rate_hz, epoch_ns, factor = (
        values[name] for name in ('publish.rate', 'time.epoch_ns', 'time.factor')
    )
    if (yield Ticks(rate_of(rate_hz), epoch_ns).stamp_ns(1) > LAST_STAMP_NS):
        raise ValueError(
            f'publish.rate is {written(rate_hz)} and time.epoch_ns {epoch_ns}; the second tick '
            f'then comes after the last stamp of ROS, {LAST_STAMP_NS // 10**9} s'
        )
    if (yield factor and rate_hz * factor < 1.0 / _LONGEST_TICK_S):
        raise ValueError(
            f'time.factor is {written(factor)} and publish.rate {written(rate_hz)}; their product '
            f'must be 0 or at least {1.0 / _LONGEST_TICK_S:g} ticks per second'
        )


def frame(values: Mapping[str, Any]) -> Checks:
    """Check that there is an initial frame."""
    kind = orbits.type_of(values)
    if (yield not kind.has_lvlh and values['initial.frame'] == 'lvlh'):
        raise ValueError(
            f'initial.frame is lvlh; with orbit.type {kind.name} there is no LVLH, so it must be '
            'inertial'
        )


def turns_a_tick(values: Mapping[str, Any]) -> Checks:
    """Check how far the orbit and the body turn between two ticks."""
    most_rad_s = _MOST_RAD_PER_TICK * values['publish.rate']
    if ellipse := orbits.type_of(values).ellipse(values):
        mu, a, e, name = ellipse
        at_pericentre = np.sqrt(mu / a) / a * np.sqrt((1.0 + e) / (1.0 - e)) / (1.0 - e)
        if (yield ~(at_pericentre <= most_rad_s)):
            found, most = distinct_texts(at_pericentre, most_rad_s)
            raise ValueError(
                f'{name} is {written(a)} and orbit.mu {written(mu)}; the '
                f'orbital rate at pericentre is then {found} rad/s; it must be at most {most} '
                '(1e6 rad per tick)'
            )
    rate = np.asarray(values['initial.angular_velocity'])
    if (yield ~(length(rate) <= most_rad_s)):
        raise ValueError(
            f'initial.angular_velocity is {rate.tolist()}; it must be at most {most_rad_s:g} '
            'rad/s (1e6 rad per tick)'
        )


# In this order, of values as_units.
ALL_CHECKS: tuple[Callable[[Mapping[str, Any]], Checks], ...] = (
    belongs,
    orbits.checks,
    environment.checks,
    sensors.checks,
    torques,
    thrusters,
    body,
    rotors.checks,
    modes.checks_of_kinds,
    modes.checks,
    environment.checks_of_torques,
    ticks,
    frame,
    turns_a_tick,
)

"""
What the values of a scenario may not be together.

values: every key by its dotted name, each allowed by itself.  ValueError: one sentence that names
the key.
"""

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from ..base.key import listed
from ..base.sentences import told_apart, written
from .keys import KEYS
from .ticks import LAST_STAMP_NS, Ticks

# What moves by more than this between two ticks [rad] takes more steps than a tick may.
MOST_RAD_PER_TICK = 1e6
# The longest wall time between two ticks: the system waits for no more.
_LONGEST_TICK_S = 1e9
# What a quaternion of four digits may be off; less than the second is not worth a word.
_UNIT_TO, _UNIT_TO_ROUNDING = 1e-4, 1e-6

# A key that belongs to some choices only: key, the choosing key, the choices.
BELONGS = (
    ('body.weight_moment', 'orbit.type', ('fixed',)),
    ('orbit.gradient', 'orbit.type', ('fixed',)),
    ('orbit.mu', 'orbit.type', ('circular', 'kepler')),
    ('orbit.semi_major_axis', 'orbit.type', ('circular', 'kepler')),
    ('orbit.altitude', 'orbit.type', ('circular',)),
    ('orbit.eccentricity', 'orbit.type', ('kepler',)),
    ('orbit.inclination', 'orbit.type', ('circular', 'kepler')),
    ('orbit.raan', 'orbit.type', ('circular', 'kepler')),
    ('orbit.argument_of_periapsis', 'orbit.type', ('circular', 'kepler')),
    ('orbit.true_anomaly', 'orbit.type', ('circular', 'kepler')),
)


def unit(values: Mapping[str, Any], name: str, allowed_error: float) -> tuple[float, ...]:
    """Return the vector under name as a unit; one that is unit to rounding stays as it is."""
    vector = np.array(values[name])
    with np.errstate(over='ignore'):
        norm = float(np.linalg.norm(vector))
    if norm == 0.0:
        raise ValueError(f'{name} is {list(values[name])}; it must not be zero')
    if norm == np.inf:
        raise ValueError(f'{name} is {list(values[name])}; its norm must be finite')
    if abs(norm - 1.0) > allowed_error:
        raise ValueError(
            f'{name} is {list(values[name])}, of norm {told_apart(norm, 1.0)[0]}; it must be a '
            f'unit quaternion x, y, z, w, to within {allowed_error:g}'
        )
    if abs(norm - 1.0) < 4.0 * np.finfo(float).eps:
        return values[name]
    return tuple(float(x) for x in vector / norm)


def normalised(values: Mapping[str, Any], name: str) -> tuple[tuple[float, ...], list[str]]:
    """Return the quaternion under name as a unit, and the sentence that it was not quite one."""
    taken, norm = unit(values, name, _UNIT_TO), math.hypot(*values[name])
    if abs(norm - 1.0) <= _UNIT_TO_ROUNDING:
        return taken, []
    return taken, [
        f'{name} is {list(values[name])}, of norm {told_apart(norm, 1.0)[0]}; it is divided by it'
    ]


def refuse_what_does_not_belong(values: Mapping[str, Any]) -> None:
    """Raise ValueError for a key that belongs to other choices than those made."""
    for name, chooser, choices in BELONGS:
        if values[chooser] not in choices and values[name] != KEYS[name].default:
            raise ValueError(
                f'{name} is {listed(values[name])}; with {chooser} {values[chooser]} only its '
                f'default is allowed: it belongs to {" and ".join(choices)}'
            )


def check_ticks(values: Mapping[str, Any], rate: Fraction) -> None:
    """Refuse what leaves a run without a second tick."""
    rate_hz, epoch_ns, factor = (
        values[name] for name in ('publish.rate', 'time.epoch_ns', 'time.factor')
    )
    if Ticks(rate, epoch_ns).stamp_ns(1) > LAST_STAMP_NS:
        raise ValueError(
            f'publish.rate is {written(rate_hz)} and time.epoch_ns {epoch_ns}; the second tick '
            f'then comes after the last stamp of ROS, {LAST_STAMP_NS // 10**9} s'
        )
    if factor and rate_hz * factor < 1.0 / _LONGEST_TICK_S:
        raise ValueError(
            f'time.factor is {written(factor)} and publish.rate {written(rate_hz)}; their product '
            f'must be 0 or at least {1.0 / _LONGEST_TICK_S:g} ticks per second'
        )


def check_turns_a_tick(values: Mapping[str, Any], rate: Fraction) -> None:
    """Refuse an orbit or a body that turns too far between two ticks."""
    tick_s = float(1 / rate)
    if values['orbit.type'] != 'fixed':
        mu, a, e = (values[f'orbit.{name}'] for name in ('mu', 'semi_major_axis', 'eccentricity'))
        mean_motion = math.sqrt(mu / a) / a
        at_pericentre = mean_motion * math.sqrt((1.0 + e) / (1.0 - e)) / (1.0 - e)
        if not at_pericentre * tick_s <= MOST_RAD_PER_TICK:
            found, most = told_apart(at_pericentre, MOST_RAD_PER_TICK / tick_s)
            raise ValueError(
                f'orbit.semi_major_axis is {written(a)} and orbit.mu {written(mu)}; the orbital '
                f'rate at pericentre is then {found} rad/s; it must be at most {most} (1e6 rad '
                'per tick)'
            )
    turn_rate = math.hypot(*values['initial.angular_velocity'])
    if not turn_rate * tick_s <= MOST_RAD_PER_TICK:
        raise ValueError(
            f'initial.angular_velocity is {list(values["initial.angular_velocity"])}; it must '
            f'be at most {MOST_RAD_PER_TICK / tick_s:g} rad/s (1e6 rad per tick)'
        )

"""References that look somewhere: to the Earth's centre, to the Sun, to a point on the ground."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.nanoseconds import SECOND_NS
from ..base.units import in_unit
from ..environment.earth import EARTH_RATE_RAD_S, gcrs_to_itrs, on_the_ground, turned
from ..environment.sun import sun_position
from ..kernel.rows import dot, length
from ..orbits.kepler import EARTH_MU
from .reference import Moving, OrbitState, Reference, aligned

# The Sun's rate is a difference over so long: it turns by 2e-7 rad/s.
_SUN_STEP_S = 3600
_PARALLEL = 1e-9


def nadir(sample: OrbitState) -> Reference:
    """
    Return LVLH: z to the Earth's centre, x as near as possible to the velocity.

    Rate and acceleration are those on the Kepler ellipse through the state; other forces turn a
    low orbit by less than 2e-6 rad/s.

    Parameters
    ----------
    sample : OrbitState
        position, velocity and stamp, such as simulation.sample

    Raises
    ------
    ValueError
        the sample has no position, as with orbit.type fixed
    """
    position, velocity = _on_orbit(sample)
    down = Moving(*(tuple(-x for x in row) for row in position))
    return aligned(down, velocity, 'the reference nadir')


def sun(second_axis: ArrayLike = (1.0, 0.0, 0.0)) -> Callable[[OrbitState], Reference]:
    """
    Return the reference with body z to the Sun, second_axis as near as can be to the orbit normal.

    The Sun is that of environment.sun_position, even when the Earth hides it; this needs the extra
    environment.

    Parameters
    ----------
    second_axis : (3,), body axes
        its part along z plays no role

    Raises
    ------
    ValueError
        second_axis is along z; or, for a sample, the Sun is along the orbit normal, near which the
        reference turns fast
    """
    axis_b = np.array(second_axis, float)
    if axis_b.shape != (3,) or not np.hypot(*axis_b[:2]) > _PARALLEL * np.linalg.norm(axis_b):
        raise ValueError(
            f'second_axis is {axis_b.tolist()}; it must be 3 numbers, not along z, which points '
            'to the Sun'
        )
    return partial(_sun, axis_b)


def _sun(axis_b, sample):
    position, velocity = _on_orbit(sample)
    stamps_ns = np.asarray(sample.stamp_ns, np.int64)[..., None]
    sun_i = sun_position(stamps_ns + SECOND_NS * np.array([-_SUN_STEP_S, 0, _SUN_STEP_S]))
    before, now, after = np.moveaxis(sun_i, -2, 0)
    sun = Moving.of_rows(
        now,
        (after - before) / (2.0 * _SUN_STEP_S),
        (after - 2.0 * now + before) / _SUN_STEP_S**2,
    )
    toward, normal = sun.minus(position), position.across(velocity)
    return aligned(toward, normal, 'the reference sun').of_body_axis(axis_b)


def target(latitude: float | str, longitude: float | str) -> Callable[[OrbitState], Reference]:
    """
    Return the reference with z to a point on the ground, x as near as possible to the velocity.

    The Earth turns as in environment.gcrs_to_itrs, which needs the extra environment.  The point
    is tracked even through the Earth.

    Parameters
    ----------
    latitude : rad
        on WGS 84 at height 0, or a text such as '48.1 deg'
    longitude : rad
        east positive, or a text

    Raises
    ------
    ValueError
        there is no such point
    """
    angles = [_angle('latitude', latitude, 0.5), _angle('longitude', longitude, 2.0)]
    return partial(_target, on_the_ground(*angles))


def _target(point_t, sample):
    orbit, velocity = _on_orbit(sample)
    to_inertial = gcrs_to_itrs(sample.stamp_ns).swapaxes(-1, -2)
    # What else moves the pole turns by less than 1e-11 rad/s.
    spin_t = np.array([0.0, 0.0, EARTH_RATE_RAD_S])
    rate_t = np.cross(spin_t, point_t)
    rows = (turned(to_inertial, v) for v in (point_t, rate_t, np.cross(spin_t, rate_t)))
    return aligned(Moving.of_rows(*rows).minus(orbit), velocity, 'the reference target')


def _on_orbit(sample: OrbitState) -> tuple[Moving, Moving]:
    """Return position and velocity on the Kepler orbit through r_i and v_i, as they move."""
    r_i, v_i = np.asarray(sample.r_i, float), np.asarray(sample.v_i, float)
    r = length(r_i)[..., None]
    if not np.all(r > 0.0):
        raise ValueError('the sample has no position, as with orbit.type fixed; it must have one')
    a_i = -EARTH_MU / r**3 * r_i
    jerk_i = -EARTH_MU / r**3 * (v_i - 3.0 * dot(r_i, v_i)[..., None] / r**2 * r_i)
    return Moving.of_rows(r_i, v_i, a_i), Moving.of_rows(v_i, a_i, jerk_i)


def _angle(name: str, given: Any, half_turns: float) -> float:
    """Return an angle [rad] of a number or a text; ValueError: beyond so many half turns."""
    try:
        number = in_unit(given, 'rad') if isinstance(given, str) else given
        angle = np.asarray(number, float).item()
    except (TypeError, ValueError):
        angle = np.nan
    # A quarter turn may be written with any number of digits.
    if not abs(angle) <= half_turns * np.pi + 1e-9:
        raise ValueError(
            f'{name} is {given}; it must be a number in radians, or a text such as 48.1 deg, '
            f'between -{180 * half_turns:g} and {180 * half_turns:g} deg'
        )
    return angle

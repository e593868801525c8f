"""Orbits by elements or by the state at tick 0: an ellipse or, with J2, what begins on it."""

from collections.abc import Mapping
from functools import lru_cache
from math import pi
from typing import Any

import numpy as np

from ..base.key import Key
from ..base.sentences import Checks
from .j2 import OblateOrbit
from .kepler import EARTH_MU, EARTH_RADIUS_M, KeplerOrbit, state_checks
from .orbit import Orbit
from .orbit_type import Ellipse, OrbitType
from .tabled import tabled_orbit

_TWO_TURNS = 4.0 * pi

MU = Key(
    'orbit.mu',
    'double',
    EARTH_MU,
    'm^3/s^2',
    'gravitational parameter of the attracting centre',
    above=0.0,
)
SEMI_MAJOR_AXIS = Key(
    'orbit.semi_major_axis', 'double', 6.878137e6, 'm', 'semi-major axis', above=0.0
)
ALTITUDE = Key(
    'orbit.altitude',
    'double',
    0.0,
    'm',
    'height above 6378137 m, in place of orbit.semi_major_axis, which then has the value; '
    '0: not given; orbit.type circular only',
    low=0.0,
)
ECCENTRICITY = Key(
    'orbit.eccentricity',
    'double',
    0.0,
    '',
    'eccentricity, below 1; orbit.type kepler only',
    low=0.0,
    below=1.0,
)
ANGLES = (
    Key('orbit.inclination', 'double', 0.0, 'rad', 'inclination', low=0.0, high=pi),
    Key(
        'orbit.raan',
        'double',
        0.0,
        'rad',
        'right ascension of the ascending node',
        low=-_TWO_TURNS,
        high=_TWO_TURNS,
    ),
    Key(
        'orbit.argument_of_periapsis',
        'double',
        0.0,
        'rad',
        'argument of periapsis; on a circular orbit it is added to the true anomaly',
        low=-_TWO_TURNS,
        high=_TWO_TURNS,
    ),
    Key(
        'orbit.true_anomaly',
        'double',
        0.0,
        'rad',
        'true anomaly at tick 0',
        low=-_TWO_TURNS,
        high=_TWO_TURNS,
    ),
)
STATE = (
    Key(
        'orbit.position',
        'double_array',
        (0.0, 0.0, 0.0),
        'm',
        'position at tick 0, inertial axes; orbit.type state only',
        lengths=(3,),
        is_optional=True,
    ),
    Key(
        'orbit.velocity',
        'double_array',
        (0.0, 0.0, 0.0),
        'm/s',
        'velocity at tick 0, inertial axes; orbit.type state only',
        lengths=(3,),
        is_optional=True,
    ),
)
OBLATENESS = (
    Key(
        'orbit.j2',
        'double',
        0.0,
        '',
        "oblateness of the attracting centre about Z, the Earth's 1.08262668e-3: the elements "
        'are then those at tick 0, and the orbit is integrated; orbit.type circular, kepler '
        'and state only',
        low=0.0,
        below=1.0,
        is_optional=True,
    ),
    Key(
        'orbit.reference_radius',
        'double',
        EARTH_RADIUS_M,
        'm',
        'equatorial radius that orbit.j2 belongs to',
        above=0.0,
        is_optional=True,
    ),
)
_ELEMENTS = (
    'mu',
    'semi_major_axis',
    'eccentricity',
    'inclination',
    'raan',
    'argument_of_periapsis',
    'true_anomaly',
)


class _OfAnEllipse(OrbitType):
    """An ellipse, with J2 the orbit that begins on it."""

    @classmethod
    def orbit(cls, values: Mapping[str, Any], is_earlier: bool) -> Orbit:
        """Return the orbit."""
        kepler, j2 = cls._kepler(values), values['orbit.j2']
        if not j2:
            return kepler
        source = _oblate(kepler, j2, values['orbit.reference_radius'])
        return tabled_orbit(source, values['orbit.mu'])

    @classmethod
    def _kepler(cls, values):
        return KeplerOrbit(**{name: values[f'orbit.{name}'] for name in _ELEMENTS})

    @classmethod
    def is_shared(cls, values: Mapping[str, Any]) -> bool:
        """Return whether the orbit is integrated."""
        return values['orbit.j2'] != 0.0

    @classmethod
    def ellipse(cls, values: Mapping[str, Any]) -> Ellipse | None:
        """Return that of the elements."""
        mu, a, e = (values[f'orbit.{name}'] for name in _ELEMENTS[:3])
        return Ellipse(mu, a, e, 'orbit.semi_major_axis')


class Circular(_OfAnEllipse):
    """A circle by its elements."""

    name = 'circular'
    keys = (MU, ALTITUDE, SEMI_MAJOR_AXIS, *ANGLES, *OBLATENESS)


class ByElements(_OfAnEllipse):
    """An ellipse by its elements."""

    name = 'kepler'
    keys = (MU, SEMI_MAJOR_AXIS, ECCENTRICITY, *ANGLES, *OBLATENESS)


class ByState(_OfAnEllipse):
    """An ellipse by position and velocity at tick 0."""

    name = 'state'
    keys = (MU, *STATE, *OBLATENESS)

    @classmethod
    def checks(cls, values: Mapping[str, Any]) -> Checks:
        """Check that the state is on an ellipse."""
        yield from state_checks(*_state(values))

    @classmethod
    def _kepler(cls, values):
        return KeplerOrbit.from_state(*_state(values))

    @classmethod
    def ellipse(cls, values: Mapping[str, Any]) -> Ellipse | None:
        """Return that through the state."""
        orbit = cls._kepler(values)
        name = 'the semi-major axis of orbit.position and orbit.velocity'
        return Ellipse(values['orbit.mu'], orbit.semi_major_axis, orbit.eccentricity, name)


# Runs that share the elements share what is integrated.
_oblate = lru_cache(maxsize=4)(OblateOrbit)


def _state(values):
    """Return r_i, v_i and mu."""
    r_i, v_i = np.asarray(values['orbit.position']), np.asarray(values['orbit.velocity'])
    return r_i, v_i, values['orbit.mu']

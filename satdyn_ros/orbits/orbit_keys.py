"""The keys of orbits, in the order of the table of a scenario's keys."""

from ..base.key import Key
from .ellipses import (
    ALTITUDE,
    ANGLES,
    ECCENTRICITY,
    MU,
    OBLATENESS,
    SEMI_MAJOR_AXIS,
    STATE,
)
from .fixed import GRADIENT
from .orbit_texts import FILE, TLE
from .orbit_type import ORBIT_TYPES

_SHIPPED = (
    *(MU, SEMI_MAJOR_AXIS, ALTITUDE, ECCENTRICITY, *ANGLES),
    *(*STATE, TLE, FILE, *OBLATENESS),
)


def keys_of_orbits() -> tuple[Key, ...]:
    """Return the keys of all types of orbits but a fixed one, those of one's own last."""
    kind = Key(
        'orbit.type',
        'string',
        'circular',
        '',
        'position of the attracting centre: fixed direction, circular orbit, Kepler ellipse '
        'by its elements or by the state at tick 0, element set by SGP4, ephemeris message',
        choices=tuple(ORBIT_TYPES),
    )
    own = dict.fromkeys(key for each in ORBIT_TYPES.values() for key in each.keys)
    return kind, *_SHIPPED, *(key for key in own if key not in (*_SHIPPED, GRADIENT))

"""The Sun: where it is, its direction from the body, and how much of it the Earth leaves."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.imports import brought_by
from ..kernel.functions import asin, atan, divide, maximum, minimum, select, sqrt
from ..kernel.rows import components, length
from ..kernel.rows import dot as dot_rows
from ..kernel.vector import Vector, add, dot, scale, subtract
from .earth import terrestrial_time

AU_M = 149_597_870_700.0
# Of sunlight at 1 au [lx].
ILLUMINANCE_LX = 128_000.0
SUN_RADIUS_M = 6.957e8

# The Earth that hides the Sun is a sphere with the radius of the equator.
_HIDING_RADIUS_M = 6_378_137.0
# What a denominator is at least.
_TINY = 1e-300


def sun_position(unix_ns: ArrayLike) -> np.ndarray:
    """
    Return the position of the Sun from the Earth's centre (..., 3) [m], in GCRS.

    It is from the ephemeris of ERFA's epv00, from 1900 to 2100: the true position, not the
    apparent one (20 arcsec).

    Parameters
    ----------
    unix_ns : (...), ns
        Unix time
    """
    with brought_by('environment', 'pyerfa'):
        import erfa
    # TT is within 2 ms of the time of the ephemeris, in which the Earth moves 60 m.
    earth_from_sun, _ = erfa.epv00(*terrestrial_time(unix_ns))
    return -AU_M * earth_from_sun['p']


def sun_direction(r_i: ArrayLike, sun_i: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """
    Return s_i (..., 3), the unit vector from the body to the Sun, and the distance (...) [m].

    Parameters
    ----------
    r_i : (..., 3), m, inertial
        position of the body
    sun_i : (..., 3), m, inertial
        position of the Sun
    """
    to_sun = np.subtract(sun_i, r_i)
    distance_m = length(to_sun)
    return to_sun / distance_m[..., None], distance_m


def lit_fraction(r_i: ArrayLike, sun_i: ArrayLike) -> np.ndarray:
    """
    Return nu (...), the part of the Sun's disc that the Earth's leaves free, by lit_part.

    Parameters
    ----------
    r_i : (..., 3), m, inertial
        position of the body
    sun_i : (..., 3), m, inertial
        position of the Sun
    """
    r_i, sun_i = np.broadcast_arrays(np.asarray(r_i, float), np.asarray(sun_i, float))
    with np.errstate(all='ignore'):
        return np.asarray(lit_part(tuple(components(r_i)), tuple(components(sun_i))))


def lit_part(r_i: Vector, sun_i: Vector) -> Any:
    """
    Return nu, the part of the Sun's disc that the Earth's leaves free.

    Discs of the radii a and b whose centres are c apart, as if on a plane: Montenbruck and Gill,
    Satellite Orbits, section 3.4.2.
    """
    to_sun = subtract(sun_i, r_i)
    r, distance = sqrt(dot(r_i, r_i)), sqrt(dot(to_sun, to_sun))
    s, down = scale(divide(1.0, distance), to_sun), scale(divide(-1.0, r), r_i)
    # From within the sphere half of the sky is Earth.
    a = asin(divide(SUN_RADIUS_M, distance))
    b = asin(minimum(divide(_HIDING_RADIUS_M, r), 1.0))
    # From the chord: an arc cosine would lose half of the digits of a small angle.
    chord, bisector = subtract(s, down), add(s, down)
    tangent = sqrt(divide(dot(chord, chord), maximum(dot(bisector, bisector), _TINY)))
    c = 2.0 * atan(tangent)
    # Where the discs do not cross, as if they just did.
    between = minimum(maximum(c, abs(a - b)), a + b)
    # The chord that the discs have in common: x from the centre of the Sun's, 2 y long.
    x = divide((between - b) * (between + b) + a * a, 2.0 * maximum(between, _TINY))
    y = sqrt(maximum((a - x) * (a + x), 0.0))
    hidden = divide(_segment(a, x, y) + _segment(b, between - x, y), math.pi * a * a)
    share = minimum(divide(b, a), 1.0)
    hidden = select(c <= abs(a - b), share * share, hidden)
    return 1.0 - select(c >= a + b, 0.0, hidden)


def _segment(radius, x, y):
    """Return the area that a chord cuts from a disc: x from its centre, 2 y long."""
    return radius * radius * 2.0 * atan(divide(y, maximum(radius + x, _TINY))) - x * y


def shadow_margins(r_i: ArrayLike, sun_i: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """
    Return how far the discs are clear of the penumbra and of the umbra (...), smooth in time.

    Each changes its sign at a contact: the first is positive where all of the Sun is seen, the
    second negative where none is, or, from beyond the umbra's tip, where it is a ring.  They are
    cos(a + b) - cos c and cos(a - b) - cos c of the discs of lit_part.

    Parameters
    ----------
    r_i : (..., 3), m, inertial
        position of the body
    sun_i : (..., 3), m, inertial
        position of the Sun
    """
    r_i = np.asarray(r_i, float)
    s_i, distance_m = sun_direction(r_i, sun_i)
    r = length(r_i)
    sin_a, sin_b = SUN_RADIUS_M / distance_m, np.minimum(_HIDING_RADIUS_M / r, 1.0)
    cosines = np.sqrt((1.0 - sin_a**2) * (1.0 - sin_b**2))
    cos_c = -dot_rows(s_i, r_i) / r
    return cosines - sin_a * sin_b - cos_c, cosines + sin_a * sin_b - cos_c

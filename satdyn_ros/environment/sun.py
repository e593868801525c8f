"""The Sun: where it is, its direction from the body, and how much of it the Earth leaves."""

import numpy as np
from numpy.typing import ArrayLike

from ..base.extras import brought_by
from ..kernel.rows import length
from .earth import terrestrial_time

AU_M = 149_597_870_700.0
SUN_RADIUS_M = 6.957e8

# The Earth that hides the Sun is a sphere with the radius of the equator.
_HIDING_RADIUS_M = 6_378_137.0


def sun_position(unix_ns: ArrayLike) -> np.ndarray:
    """
    Return the place of the Sun from the Earth's centre [m] at times (...), in GCRS, (..., 3).

    By the ephemeris of ERFA's epv00, from 1900 to 2100: where the Sun is, not where it is seen
    (20 arcsec).
    """
    with brought_by('environment', 'pyerfa'):
        import erfa
    # TT is within 2 ms of the time of the ephemeris, in which the Earth moves 60 m.
    earth_from_sun, _ = erfa.epv00(*terrestrial_time(unix_ns))
    return -AU_M * earth_from_sun['p']


def sun_direction(r_i: ArrayLike, sun_i: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return s_i (..., 3), the unit vector from the body to the Sun, and the distance [m]."""
    to_sun = np.subtract(sun_i, r_i)
    distance_m = length(to_sun)
    return to_sun / distance_m[..., None], distance_m


def lit_fraction(r_i: ArrayLike, sun_i: ArrayLike) -> np.ndarray:
    """
    Return nu, the part of the Sun's disc (...) that the Earth's leaves free, seen from r_i.

    Discs of the radii a and b whose centres are c apart, as if on a plane: Montenbruck and Gill,
    Satellite Orbits, section 3.4.2.
    """
    a, b, c = _discs(r_i, sun_i)
    cross = (c < a + b) & (c > abs(a - b))
    # Of discs that do not cross, numbers that cause no warning.
    between = np.where(cross, c, np.hypot(a, b))
    # The chord that the discs have in common: x from the centre of the Sun's, 2 y long.
    x = ((between - b) * (between + b) + a * a) / (2.0 * between)
    y = np.sqrt((a - x) * (a + x))
    hidden = (_segment(a, x, y) + _segment(b, between - x, y)) / (np.pi * a * a)
    covered = np.where(c < a + b, np.minimum(b / a, 1.0) ** 2, 0.0)
    return 1.0 - np.where(cross, hidden, covered)


def shadow_margins(r_i: ArrayLike, sun_i: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the angles [rad] (...) by which the discs are clear of the penumbra and of the umbra.

    Each changes its sign at a contact: the first is positive where all of the Sun is seen, the
    second negative where none is, or, from beyond the umbra's tip, where it is a ring.
    """
    a, b, c = _discs(r_i, sun_i)
    return c - (a + b), c - abs(a - b)


def _discs(r_i, sun_i):
    """Return the radii of the Sun and the Earth and the angle between them [rad], (...) each."""
    r_i = np.asarray(r_i, float)
    s_i, distance_m = sun_direction(r_i, sun_i)
    r = length(r_i)
    down = -r_i / r[..., None]
    # From the chord: arccos would lose half of the digits of a small angle.
    between = 2.0 * np.arctan2(length(s_i - down), length(s_i + down))
    # From within the sphere half of the sky is Earth.
    earth = np.arcsin(np.minimum(_HIDING_RADIUS_M / r, 1.0))
    return np.arcsin(SUN_RADIUS_M / distance_m), earth, between


def _segment(radius, x, y):
    """Return the area that a chord cuts from a disc: x from its centre, 2 y long."""
    return radius * radius * np.arctan2(y, x) - x * y

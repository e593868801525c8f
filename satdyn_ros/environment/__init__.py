"""
The Earth as functions of time and position: frames and time, magnetic field, air, Sun.

Times are Unix times in integer nanoseconds (...), positions and vectors rows (..., 3): r_i [m] in
GCRS, which is the inertial frame, r_t in ITRS, which turns with the Earth.  A row has the same
bits alone and among many, as far as the libraries keep that.
"""

from .atmosphere import Exponential, Msis, air_velocity
from .earth import (
    gcrs_to_intermediate,
    gcrs_to_itrs,
    geodetic,
    leap_seconds_ns,
    on_the_ground,
    teme_to_gcrs,
    terrestrial_time,
    turned,
)
from .magnetic_field import (
    dipole_field,
    dipole_vector,
    igrf_field,
    igrf_warning,
    igrf_years_ns,
)
from .sun import lit_fraction, shadow_margins, sun_direction, sun_position

__all__ = [
    'Exponential',
    'Msis',
    'air_velocity',
    'dipole_field',
    'dipole_vector',
    'gcrs_to_intermediate',
    'gcrs_to_itrs',
    'geodetic',
    'igrf_field',
    'igrf_warning',
    'igrf_years_ns',
    'leap_seconds_ns',
    'lit_fraction',
    'on_the_ground',
    'shadow_margins',
    'sun_direction',
    'sun_position',
    'teme_to_gcrs',
    'terrestrial_time',
    'turned',
]

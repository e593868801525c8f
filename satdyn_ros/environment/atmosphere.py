"""
The air: the logarithm of its density, and the velocity of a body through it.

The logarithm, since a polynomial in time follows it where it does not follow the density.
"""

import numpy as np
from numpy.typing import ArrayLike

from ..base.extras import brought_by
from ..base.nanoseconds import SECOND_NS
from ..kernel.rows import components
from .earth import EARTH_RATE_RAD_S


def log_exponential(
    height_m: ArrayLike, density: float, density_height_m: float, scale_height_m: float
) -> np.ndarray:
    """Return ln of rho = rho_0 exp(-(h - h_0) / H) [kg/m^3] at geodetic heights (...)."""
    return np.log(density) - (np.asarray(height_m, float) - density_height_m) / scale_height_m


def log_msis(
    unix_ns: ArrayLike,
    latitude: ArrayLike,
    longitude: ArrayLike,
    height_m: ArrayLike,
    f107: float,
    f107_average: float,
    ap: float,
) -> np.ndarray:
    """
    Return ln rho [kg/m^3] of NRLMSIS 2.1 at times and geodetic places, (...) each; angles in rad.

    f107, f107_average [1e-22 W/m^2/Hz] and ap are the activity of the Sun and of the Earth's
    field, as constants.  The result has single precision, and it jumps at 00:00 UTC, where the
    model takes the next day of the year.  ValueError: a time is no whole second; the model would
    cut it to one.
    """
    with brought_by('environment', 'pymsis'):
        import pymsis
    unix_ns = np.asarray(unix_ns, np.int64)
    if np.any(unix_ns % SECOND_NS):
        raise ValueError('MSIS knows whole seconds of UTC only')
    unix_ns, latitude, longitude, height_m = np.broadcast_arrays(
        unix_ns, latitude, longitude, height_m
    )
    rows = unix_ns.size
    result = pymsis.calculate(
        unix_ns.ravel().view('datetime64[ns]'),
        np.degrees(longitude.ravel()),
        np.degrees(latitude.ravel()),
        1e-3 * height_m.ravel(),
        np.full(rows, f107),
        np.full(rows, f107_average),
        np.full((rows, 7), ap),
        version=2.1,
    )
    density = result.reshape(rows, -1)[:, pymsis.Variable.MASS_DENSITY]
    return np.log(density.astype(float)).reshape(unix_ns.shape)


def air_velocity(r_i: ArrayLike, v_i: ArrayLike, pole_i: ArrayLike) -> np.ndarray:
    """
    Return w = v - omega_E pole x r [m/s], (..., 3): through air that turns with the Earth.

    pole_i (..., 3): the Earth's axis, the third row of gcrs_to_itrs.
    """
    r, v, p = components(r_i), components(v_i), components(pole_i)
    wind = p[1] * r[2] - p[2] * r[1], p[2] * r[0] - p[0] * r[2], p[0] * r[1] - p[1] * r[0]
    return np.stack([a - EARTH_RATE_RAD_S * b for a, b in zip(v, wind, strict=True)], axis=-1)

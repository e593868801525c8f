"""
The air: the logarithm of its density, and the velocity of a body through it.

The logarithm, since a polynomial in time follows it where it does not follow the density.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.imports import brought_by
from ..kernel.rows import components
from .earth import EARTH_RATE_RAD_S

# Without a flare the flux has been from 60 to 400 [1e-22 W/m^2/Hz] since 1947, and the scale of ap
# ends at 400.  Above this flux MSIS has no temperature at any height of an orbit.
LARGEST_F107, LARGEST_AP = 1000.0, 400.0


class Exponential(NamedTuple):
    """
    Air of the density rho_0 exp(-(h - h_0) / H), h the geodetic height.

    Attributes
    ----------
    density : kg/m^3
        rho_0
    density_height : m
        h_0
    scale_height : m
        H
    """

    density: float
    density_height: float
    scale_height: float

    def log_density(self, height_m: ArrayLike) -> np.ndarray:
        """
        Return ln rho [kg/m^3] (...).

        Parameters
        ----------
        height_m : (...), m
            geodetic heights
        """
        above_m = np.asarray(height_m, float) - self.density_height
        return np.log(self.density) - above_m / self.scale_height


class Msis(NamedTuple):
    """
    Air of NRLMSIS 2.1 with constant activity of the Sun and of the Earth's field.

    Attributes
    ----------
    f107 : 1e-22 W/m^2/Hz
        flux of the day before
    f107_average : 1e-22 W/m^2/Hz
        mean flux over 81 days
    ap : float
        daily index
    """

    f107: float = 150.0
    f107_average: float = 150.0
    ap: float = 4.0

    def log_density(
        self,
        unix_s: ArrayLike,
        latitude: ArrayLike,
        longitude: ArrayLike,
        height_m: ArrayLike,
    ) -> np.ndarray:
        """
        Return ln rho [kg/m^3] (...).

        The model cuts times to whole seconds of UTC.  The result has single precision, and it
        jumps at 00:00 UTC, where the model takes the next day of the year.

        Parameters
        ----------
        unix_s : (...), s
            Unix time in whole seconds
        latitude, longitude : (...), rad
            geodetic
        height_m : (...), m
            geodetic heights

        Raises
        ------
        ValueError
            the model has no density there, below the ground or with an activity far from any
            measured one
        """
        with brought_by('environment', 'pymsis'):
            import pymsis
        unix_s, latitude, longitude, height_m = np.broadcast_arrays(
            np.asarray(unix_s, np.int64), latitude, longitude, height_m
        )
        if not np.all(np.isfinite(height_m)):
            raise ValueError(
                'NRLMSIS has no density at a position without a height above the ground'
            )
        rows = unix_s.size
        result = pymsis.calculate(
            unix_s.ravel().view('datetime64[s]'),
            np.degrees(longitude.ravel()),
            np.degrees(latitude.ravel()),
            1e-3 * height_m.ravel(),
            np.full(rows, self.f107),
            np.full(rows, self.f107_average),
            np.full((rows, 7), self.ap),
            version=2.1,
        )
        density = result.reshape(rows, -1)[:, pymsis.Variable.MASS_DENSITY].astype(float)
        lacking = ~((density > 0.0) & (density < np.inf))
        if np.any(lacking):
            raise ValueError(
                f'NRLMSIS has no density at a height of {1e-3 * height_m.ravel()[lacking][0]:.6g} '
                f'km with environment.f107 {self.f107:g}, environment.f107_average '
                f'{self.f107_average:g} and environment.ap {self.ap:g}'
            )
        return np.log(density).reshape(unix_s.shape)


def air_velocity(r_i: ArrayLike, v_i: ArrayLike, pole_i: ArrayLike) -> np.ndarray:
    """
    Return the velocity (..., 3) [m/s] through air that turns with the Earth.

    w = v - omega_E pole x r.

    Parameters
    ----------
    r_i, v_i : (..., 3), m and m/s, inertial
        position and velocity
    pole_i : (..., 3), inertial
        the Earth's axis, the third row of gcrs_to_itrs
    """
    r, v, p = components(r_i), components(v_i), components(pole_i)
    wind = p[1] * r[2] - p[2] * r[1], p[2] * r[0] - p[0] * r[2], p[0] * r[1] - p[1] * r[0]
    return np.stack([a - EARTH_RATE_RAD_S * b for a, b in zip(v, wind, strict=True)], axis=-1)

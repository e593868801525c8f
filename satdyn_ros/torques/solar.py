"""The torque of sunlight on the plates of a body."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..environment.sun import AU_M, lit_part
from ..kernel.functions import divide, maximum, sqrt
from ..kernel.time_table import NO_TABLE, Table, interpolate_vector
from ..kernel.vector import add, cross, dot, scale, subtract, to_body
from ..orbits.along_orbit import AlongOrbit
from ..orbits.pieces import Pieces
from .environment_torque import EnvironmentTorque
from .plates import Plate, along_normals, given_plates, plates_of

# Of sunlight at 1 au: 1361 W/m^2 over the speed of light.
PRESSURE_PA = 1361.0 / 299_792_458.0


class PlateInLight(NamedTuple):
    """
    A plate in sunlight, by its constants; p is its position from the mass centre, n its normal.

    Attributes
    ----------
    normal : (3,), body axes
        n
    absorbed : (3,), m^3, body axes
        (1 - specular) A p
    mirrored : (3,), m^3, body axes
        2 specular A p x n
    scattered : (3,), m^3, body axes
        2/3 diffuse A p x n
    """

    normal: tuple[float, ...]
    absorbed: tuple[float, ...]
    mirrored: tuple[float, ...]
    scattered: tuple[float, ...]


class Solar(EnvironmentTorque):
    """
    The torque of sunlight: p x F on each plate.

    F = -nu P A cos [(1 - specular) s + 2 (specular cos + diffuse / 3) n], cos = (n . s)+, with s
    the direction of the Sun, P its pressure at the body and nu the part of it that the Earth
    leaves free.  No plate shades another.
    """

    name = 'solar'
    needs = 'environment.sun'
    given = staticmethod(given_plates)

    class Constants(NamedTuple):
        """plates; sun [m]: the position of the Sun from the Earth's centre, inertial axes."""

        plates: tuple[PlateInLight, ...]
        sun: Table

    def __init__(self, plates: Iterable[Plate], sun: Pieces):
        super().__init__(self.Constants(tuple(map(_in_light, plates)), NO_TABLE), {'sun': sun})

    @classmethod
    def along(cls, values: Mapping[str, Any], environment: AlongOrbit) -> 'Solar':
        """Return the torque on the plates of the surface."""
        return cls(plates_of(values), environment.sun)

    @staticmethod
    def torque(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, float, float]:
        """Return the sum of p x F."""
        sun_i = interpolate_vector(constants.sun, 0, t_s)
        s, distance = _sun_in_body_axes(q_ib, r_i, sun_i)
        torque = (0.0, 0.0, 0.0)
        for plate in constants.plates:
            cosine = maximum(dot(plate.normal, s), 0.0)
            along_n = add(scale(cosine, plate.mirrored), plate.scattered)
            torque = add(torque, scale(cosine, add(cross(plate.absorbed, s), along_n)))
        au = divide(AU_M, distance)
        return scale(-lit_part(r_i, sun_i) * PRESSURE_PA * au * au, torque)

    @staticmethod
    def signs(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, ...]:
        """Return n . s of each plate."""
        sun_i = interpolate_vector(constants.sun, 0, t_s)
        s, _ = _sun_in_body_axes(q_ib, r_i, sun_i)
        return along_normals(constants.plates, s)


def _sun_in_body_axes(q_ib, r_i, sun_i):
    """Return the unit vector s to the Sun, and its distance [m]."""
    to_sun = subtract(sun_i, r_i)
    distance = sqrt(dot(to_sun, to_sun))
    return to_body(q_ib, scale(divide(1.0, distance), to_sun)), distance


def _in_light(plate):
    p, n, A = np.asarray(plate.position), np.asarray(plate.normal), plate.area
    absorbed = (1.0 - plate.specular) * A * p
    about = 2.0 * A * np.cross(p, n)
    parts = absorbed, plate.specular * about, plate.diffuse / 3.0 * about
    return PlateInLight(plate.normal, *map(tuple, parts))

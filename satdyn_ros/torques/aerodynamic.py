"""The torque of the air on the plates of a body."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..kernel.functions import exp, maximum
from ..kernel.time_table import NO_TABLE, Table, interpolate, interpolate_vector
from ..kernel.vector import add, cross, dot, scale, to_body
from ..orbits.along_orbit import AlongOrbit
from ..orbits.pieces import Pieces
from .environment_torque import EnvironmentTorque
from .plates import Plate, along_normals, given_plates, plates_of


class PlateInAir(NamedTuple):
    """
    A plate in the air, by its constants.

    Attributes
    ----------
    normal : (3,), body axes
        n
    arm : (3,), m^3, body axes
        C_D A p, where p is its position from the mass centre
    """

    normal: tuple[float, ...]
    arm: tuple[float, ...]


class Aerodynamic(EnvironmentTorque):
    """
    The torque of the air: p x F on each plate, F = -1/2 rho C_D A (n . w)+ w.

    w is the velocity relative to the air, n the outward normal of the plate.  No plate shades
    another, and there is no lift.

    Parameters
    ----------
    plates : iterable of Plate
        the surface of the body
    velocity : Pieces
        w [m/s] along the orbit, inertial axes
    log_density : Pieces
        ln rho [kg/m^3]
    """

    name = 'aerodynamic'
    needs = 'environment.atmosphere'
    given = staticmethod(given_plates)

    class Constants(NamedTuple):
        """
        The constants of the torque.

        Attributes
        ----------
        plates : tuple of PlateInAir
            the surface of the body
        velocity : Table
            w [m/s] along the orbit, inertial axes
        log_density : Table
            ln rho [kg/m^3]
        """

        plates: tuple[PlateInAir, ...]
        velocity: Table
        log_density: Table

    def __init__(self, plates: Iterable[Plate], velocity: Pieces, log_density: Pieces):
        in_air = tuple(
            PlateInAir(p.normal, tuple(p.drag_coefficient * p.area * np.asarray(p.position)))
            for p in plates
        )
        super().__init__(
            self.Constants(in_air, NO_TABLE, NO_TABLE),
            {'velocity': velocity, 'log_density': log_density},
        )

    @classmethod
    def along(cls, values: Mapping[str, Any], environment: AlongOrbit) -> 'Aerodynamic':
        """Return the torque on the plates of the surface."""
        return cls(plates_of(values), environment.air_velocity, environment.log_density)

    @staticmethod
    def torque(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, float, float]:
        """Return -1/2 rho (sum C_D A (n . w)+ p) x w."""
        w = to_body(q_ib, interpolate_vector(constants.velocity, 0, t_s))
        arm = (0.0, 0.0, 0.0)
        for plate in constants.plates:
            arm = add(arm, scale(maximum(dot(plate.normal, w), 0.0), plate.arm))
        rho = exp(interpolate(constants.log_density, 0, t_s))
        return scale(-0.5 * rho, cross(arm, w))

    @staticmethod
    def signs(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, ...]:
        """Return n . w of each plate."""
        w = to_body(q_ib, interpolate_vector(constants.velocity, 0, t_s))
        return along_normals(constants.plates, w)

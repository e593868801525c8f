"""The torque of the Earth's magnetic field on the body's dipole."""

from collections.abc import Iterable, Mapping, Sequence
from operator import add
from typing import Any, NamedTuple

import numpy as np

from ..base.key import Key
from ..kernel.time_table import NO_TABLE, Table, interpolate_vector
from ..kernel.vector import cross, to_body
from ..orbits.along_orbit import AlongOrbit
from ..orbits.pieces import Pieces
from .body_torque import BodyTorque
from .environment_torque import EnvironmentTorque


class Magnetic(EnvironmentTorque):
    """
    The torque m x B in the field B along the orbit.

    m is the residual dipole of the body and one that is commanded, constant in body axes from one
    command to the next.

    Parameters
    ----------
    residual : (3,), A m^2, body axes
        of the body
    field : Pieces
        B [T], inertial axes
    commanded : (3,), A m^2, body axes
        of the magnetorquers
    """

    name = 'magnetic'
    needs = 'environment.magnetic_field'
    keys = (
        Key(
            'body.dipole',
            'double_array',
            (0.0, 0.0, 0.0),
            'A m^2',
            'residual magnetic dipole, body axes; with environment.magnetic_field it is turned',
            lengths=(3,),
            is_optional=True,
        ),
    )

    class Constants(NamedTuple):
        """
        The constants of the torque.

        Attributes
        ----------
        dipole : (3,), A m^2, body axes
            m
        field : Table
            B [T] along the orbit, inertial axes
        """

        dipole: tuple[float, ...]
        field: Table

    def __init__(
        self,
        residual: Sequence[Any],
        field: Pieces,
        commanded: Sequence[Any] = (0.0, 0.0, 0.0),
    ):
        dipole = tuple(map(add, residual, commanded))
        super().__init__(self.Constants(dipole, NO_TABLE), {'field': field})
        self._residual, self._field, self.of_torquers = residual, field, tuple(commanded)

    @classmethod
    def along(cls, values: Mapping[str, Any], environment: AlongOrbit) -> 'Magnetic':
        """Return the torque on the residual dipole."""
        return cls(values['body.dipole'], environment.magnetic_field)

    @classmethod
    def of_many(cls, torques: Sequence['Magnetic']) -> 'Magnetic':
        """Return M torques as one, with dipoles of columns (M,)."""
        residuals = zip(*(torque._residual for torque in torques), strict=True)
        return cls([np.array(parts) for parts in residuals], torques[0]._field)

    def commanded(self, dipole: Sequence[Any]) -> 'Magnetic':
        """Return the torque under a commanded dipole (3,) [A m^2] too, body axes."""
        return type(self)(self._residual, self._field, dipole)

    @staticmethod
    def torque(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, float, float]:
        """Return m x B."""
        B = to_body(q_ib, interpolate_vector(constants.field, 0, t_s))
        return cross(constants.dipole, B)


def torquer_dipole(torques: Iterable[BodyTorque]) -> tuple[float, ...]:
    """Return the commanded dipole [A m^2] that the field turns, body axes; zero without one."""
    torque = Magnetic.among(torques)
    return (0.0, 0.0, 0.0) if torque is None else torque.of_torquers


def dipole_of(torques: Iterable[BodyTorque]) -> np.ndarray | None:
    """Return the dipole (3,) [A m^2] that the field turns, body axes, or None."""
    torque = Magnetic.among(torques)
    return None if torque is None else np.array(torque.constants.dipole)

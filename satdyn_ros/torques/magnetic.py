"""The torque of the Earth's magnetic field on the body's dipole."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from ..base.key import Key
from ..kernel.time_table import NO_TABLE, Table, interpolate_vector
from ..kernel.vector import cross, to_body
from ..orbits.pieces import Pieces
from .body_torque import BodyTorque


class Magnetic(BodyTorque):
    """The torque m x B on a dipole m that is fixed in the body, in the field B along the orbit."""

    name = 'magnetic'
    keys = (
        Key(
            'body.dipole',
            'double_array',
            (0.0, 0.0, 0.0),
            'A m^2',
            'residual magnetic dipole, body axes; with environment.magnetic_field it is turned',
            lengths=(3,),
        ),
    )

    class Constants(NamedTuple):
        """dipole [A m^2]: m, body axes; field [T]: B along the orbit, inertial axes."""

        dipole: tuple[float, ...]
        field: Table

    def __init__(self, dipole: Sequence[float], field: Pieces):
        super().__init__(self.Constants(tuple(dipole), NO_TABLE), {'field': field})

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

"""The weight of a body with a fixed point."""

from typing import NamedTuple

from ..base.key import Key
from .central_torque import CentralTorque


class Weight(CentralTorque):
    """The torque -m x c of the weight moment m; its potential is m . c (Beletsky 1957, eq. 2)."""

    name = 'weight'
    keys = (
        Key(
            'body.weight_moment',
            'double_array',
            (0.0, 0.0, 0.0),
            'N m',
            "weight times the mass centre's position from the fixed point, body axes; "
            'orbit.type fixed only',
            lengths=(3,),
        ),
    )

    class Constants(NamedTuple):
        """moment (3,) [N m]: weight times the mass centre's position from the fixed point."""

        moment: tuple[float, float, float]

    @staticmethod
    def field(
        c_b: tuple[float, ...], gradient: float, constants: Constants
    ) -> tuple[float, float, float]:
        """Return m."""
        return constants.moment

"""The torques of the attracting centre: they act about the line to it."""

from collections.abc import Callable
from typing import Any, ClassVar

from .body_torque import BodyTorque


class CentralTorque(BodyTorque):
    """
    A torque c x field, c the unit vector from the attracting centre to the body.

    field(c_b, gradient, constants) -> (x, y, z) [N m], body axes, is called in place of
    torque(...): c_b are the components of c in body axes, gradient is 3 mu / r^3 [1/s^2].  It is
    the gradient, by c, of a potential.

    orbit_power(c_b, along_b, gradient, turn_rate, growth_rate, constants) -> [W], where there is
    one, is at what rate the orbit changes the potential of a body that holds its attitude.
    along_b: the unit vector along track, towards which c turns at turn_rate [rad/s]; growth_rate:
    r' / r [1/s].
    """

    is_steady = True
    orbit_power: ClassVar[Callable[..., float] | None] = None

    @staticmethod
    def field(
        c_b: tuple[float, ...], gradient: float, constants: Any
    ) -> tuple[float, float, float]:
        """Return the field [N m] in body axes."""
        raise NotImplementedError

"""The torques of the attracting centre: they act about the line to it."""

from typing import Any

from .body_torque import BodyTorque


class CentralTorque(BodyTorque):
    """
    A torque c x field, c the unit vector from the attracting centre to the body.

    field(c_b, gradient, constants) -> (x, y, z) [N m], body axes, is compiled in place of
    torque(...): c_b are the components of c in body axes, gradient is 3 mu / r^3 [1/s^2].  It is
    the gradient, by c, of a potential.
    """

    is_steady = True

    @staticmethod
    def field(
        c_b: tuple[float, ...], gradient: float, constants: Any
    ) -> tuple[float, float, float]:
        """Return the field [N m] in body axes."""
        raise NotImplementedError

    @staticmethod
    def orbit_power(
        c_b: tuple[float, ...],
        along_b: tuple[float, ...],
        gradient: float,
        turn_rate: float,
        growth_rate: float,
        constants: Any,
    ) -> float:
        """
        Return at what rate the orbit changes the potential of a body that holds its attitude [W].

        along_b: the unit vector along track, towards which c turns at turn_rate [rad/s];
        growth_rate: r' / r [1/s].
        """
        raise NotImplementedError

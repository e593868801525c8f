"""The torque that is commanded: constant in body axes from one command to the next."""

from typing import Any, NamedTuple

from .body_torque import BodyTorque


class Applied(BodyTorque):
    """The applied torque and what the motors of the rotors leave on the body."""

    name = 'applied'
    is_steady = True

    class Constants(NamedTuple):
        """torque_b (3,) [N m]: the applied torque less the motors' torques on their rotors."""

        torque_b: tuple[float, float, float]

    @staticmethod
    def torque(
        t_s: float,
        r_i: tuple[float, ...],
        v_i: tuple[float, ...],
        q_ib: tuple[float, ...],
        omega_bi_b: tuple[float, ...],
        constants: Any,
    ) -> tuple[float, float, float]:
        """Return torque_b."""
        return constants.torque_b

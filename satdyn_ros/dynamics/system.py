"""What moves and from where: a body with its rotor in an attracting field, and its state."""

from dataclasses import dataclass, field

import numpy as np

from .orbit import FixedDirection, KeplerOrbit
from .rotor import Rotor

_ZERO = np.zeros(3)


@dataclass(frozen=True, eq=False)
class System:
    """
    A gyrostat in a Newtonian field, with the torques that are applied to it.

    inertia [kg m^2] (3, 3): body axes, locked rotor included, about the mass centre, or about the
    fixed point where weight_moment [N m] (3,), the weight times the mass centre's place, is not
    zero.  torque_b [N m] (3,) acts on the body, rotor_torque [N m] from the body on the rotor.
    """

    inertia: np.ndarray
    rotor: Rotor = Rotor()
    orbit: FixedDirection | KeplerOrbit = FixedDirection()
    weight_moment: np.ndarray = field(default_factory=lambda: _ZERO)
    torque_b: np.ndarray = field(default_factory=lambda: _ZERO)
    rotor_torque: float = 0.0

    @property
    def carrier_inertia(self) -> np.ndarray:
        """
        Return the inertia (3, 3) that turns with the rate omega [kg m^2].

        The whole body's; for a rotor with a speed of its own, without J a a^T (see rotor.py).
        """
        rotor = self.rotor
        if rotor.turns_freely:
            outer = rotor.axis[..., :, None] * rotor.axis[..., None, :]
            return self.inertia - np.asarray(rotor.inertia)[..., None, None] * outer
        return self.inertia

    def rotor_momentum(self, state: 'State') -> np.ndarray:
        """
        Return h (3,) of state in body axes [N m s], the part of H beside carrier_inertia omega.

        It is constant unless a motor torque acts.
        """
        rotor = self.rotor
        return rotor.axial_momentum(state.rotor_speed, state.omega_bi_b) * rotor.axis


@dataclass(frozen=True, eq=False)
class State:
    """
    Attitude and rates at one instant.

    q_ib (4,): body to inertial; omega_bi_b [rad/s] (3,); rotor_speed [rad/s] relative to the body
    and rotor_angle [rad], nan where the rotor has none.
    """

    q_ib: np.ndarray
    omega_bi_b: np.ndarray
    rotor_speed: float = np.nan
    rotor_angle: float = np.nan

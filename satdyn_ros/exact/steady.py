"""
Steady motions: omega constant in body axes, and therefore in space.

Permanent rotations of a free body, rotations about the fixed direction of a field (Agostinelli
1977, nu = 0), relative equilibria on a circular orbit with or without a rotor, and the uniform
rotations of Balli and Grioli 1979.  The rate is constant where the torque balances omega x H and
is constant in the body, as the torque of the field is where

    it is zero in every attitude, or
    the direction c to the attracting centre stays in the body, or
    it is zero now and the body turns about an axis of symmetry that keeps its angle to c.

These are all: the components of c x I c are constant along a moving c only if they vanish.
"""

import numpy as np

from ..dynamics.inertia import ROUNDING, are_parallel
from ..dynamics.system import State, System
from ..kernel import rotation
from ..theory.equilibria import direction, is_balanced
from ..torques.gravity_gradient import gravity_gradient
from .axes import is_symmetric
from .exact_motion import ExactMotion, Fact


class Steady(ExactMotion):
    """
    The uniform rotation about a body axis, or rest.

    A state that balances to 1e-12 of the torques is taken as steady: that is the rounding of a
    start made from angles, although the true motion may leave an unstable equilibrium from there.

    Attributes
    ----------
    rate : rad/s
        its constant size
    axis_b : (3,), body axes
        its unit axis

    Examples
    --------
    >>> Steady(system, state).at(1e6).q_ib  # doctest: +SKIP
    """

    name = 'steady rotation'
    takes_torque_b = True
    source = 'Agostinelli 1977; Balli and Grioli 1979, sec. 3'

    def __init__(self, system: System, state: State, start_s: float = 0.0):
        super().__init__(system, state, start_s)
        self.rate = float(np.linalg.norm(state.omega_bi_b))
        self.axis_b = state.omega_bi_b / self.rate if self.rate else np.array([0.0, 0.0, 1.0])

    @classmethod
    def _why_not(cls, system: System, state: State, start_s: float = 0.0) -> str | None:
        """Return one sentence that says why this closed form does not apply, or None."""
        if not is_balanced(system, state, start_s):
            return 'the torque does not balance omega x H: the rate of rotation changes'
        if not _torque_stays(system, state, start_s):
            return 'the direction to the attracting centre, and the torque, turn in the body'
        return None

    def facts(self) -> list[Fact]:
        """Return the constants, periods and limits that say what the motion is like."""
        turn_s = 2.0 * np.pi / self.rate if self.rate else np.inf
        return [
            Fact('rate', self.rate, 'rad/s', 'rate of rotation, constant'),
            Fact('axis_b', self.axis_b, '', 'axis of rotation, body axes'),
            Fact('turn', turn_s, 's', 'time of one turn in space'),
        ]

    def attitude(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return q_ib (N, 4) and omega_bi_b (N, 3) at t_s (N,)."""
        turn = rotation.about(self.axis_b, self.rate * np.asarray(t_s))
        omega = np.tile(self.state.omega_bi_b, (len(t_s), 1))
        return rotation.multiply(self.state.q_ib, turn), omega

    def axial_turn(self, t_s: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """Return the integral of axis . omega from 0 to t_s [rad], (N,), for a rotor's axis."""
        return axis @ self.state.omega_bi_b * np.asarray(t_s)


def _torque_stays(system, state, start_s):
    """Whether the field's torque is constant in body axes while omega is."""
    orbit, I, m = system.orbit, system.inertia, system.weight_moment
    gradient = float(orbit.gradient_at(start_s))
    spherical = np.max(np.abs(I - I[0, 0] * np.eye(3))) <= ROUNDING * I[0, 0]
    if not np.any(m) and (gradient == 0.0 or spherical):
        return True
    omega, c = state.omega_bi_b, direction(system, state, start_s)
    rate = np.linalg.norm(omega)
    if not orbit.has_lvlh:
        axis = omega / rate if rate else c
        c_stays, c_keeps_angle = are_parallel(omega, c), are_parallel(m, axis)
    elif not orbit.is_keplerian:
        return False
    else:
        axis = rotation.rotate(rotation.conjugate(state.q_ib), orbit.normal)
        gone = np.linalg.norm(omega - orbit.mean_motion * axis)
        c_stays = not orbit.is_eccentric and gone <= ROUNDING * orbit.mean_motion
        c_keeps_angle = np.linalg.norm(np.cross(omega, axis)) <= ROUNDING * rate and not np.any(m)
    if c_stays or not (c_keeps_angle and is_symmetric(I, axis)):
        return c_stays
    torque = gravity_gradient(I, c, gradient) - np.cross(m, c)
    size = abs(gradient) * np.max(I) + np.linalg.norm(m)
    return bool(np.linalg.norm(torque) <= ROUNDING * size)

"""
Planar motions: rotation about a principal axis that keeps its direction in space.

Beletsky 1957, sec. 2: a body held in a field of fixed direction turns about a horizontal axis.
Balli and Grioli 1979: on a circular orbit a gyrostat with its rotor along the orbit normal turns
about it, the only rotations about a body-fixed axis that are not uniform.  A rotor along the axis
does not affect the motion.  With theta from the line of the centre c to a principal axis across,
of inertia I_1,

    I_n theta'' + k (I_2 - I_1) sin theta cos theta = m_1 sin theta + m_2 cos theta,

k = 3 mu / r^3 the gradient and m the weight moment, where there is one.
"""

import numpy as np

from ..dynamics.inertia import ROUNDING, are_parallel
from ..dynamics.system import State, System
from ..kernel import rotation
from . import attitude
from .axes import is_principal, principal_axes_about
from .exact_motion import ExactMotion, Fact
from .offset_pendulum import Field, OffsetPendulum
from .pendulum import Pendulum


class Planar(ExactMotion):
    """
    The motion in a plane across a principal axis.

    Attributes
    ----------
    normal_b : (3,), body axes
        that axis
    pendulum : Pendulum or OffsetPendulum
        the motion of theta
    k : float
        its modulus
    regime : str
        'libration', 'tumbling', 'separatrix' or 'rest', relative to the line of the centre
    period_s : s
        of the libration, or of a whole turn relative to that line

    Examples
    --------
    >>> Planar(system, state).period_s  # doctest: +SKIP
    """

    name = 'planar motion'
    source = 'Beletsky 1957, sec. 2; Balli and Grioli 1979'

    def __init__(self, system: System, state: State, start_s: float = 0.0):
        super().__init__(system, state, start_s)
        (I_1, I_2, _), R_bp = principal_axes_about(_normal(system, state), system.inertia)
        e_1, e_2, self.normal_b = R_bp.T
        stiffness = float(system.orbit.gradient_at(start_s)) * (I_2 - I_1)
        if stiffness < 0.0:
            e_1, e_2, stiffness = e_2, -e_1, -stiffness
        I_n = self.normal_b @ system.carrier_inertia @ self.normal_b
        c_i = system.orbit.direction(start_s)
        c_b = rotation.rotate(rotation.conjugate(state.q_ib), c_i)
        self._theta0 = np.arctan2(-c_b @ e_2, c_b @ e_1)
        self._line_rate = _line_rate(system, state) @ self.normal_b
        rate0 = state.omega_bi_b @ self.normal_b - self._line_rate
        m_1, m_2 = system.weight_moment @ e_1, system.weight_moment @ e_2
        if np.any(system.weight_moment):
            G1, delta = 2.0 * np.hypot(m_1, m_2) / I_n, np.arctan2(-m_2, -m_1)
            field = Field(G1, delta, stiffness / (2.0 * I_n), self._theta0, rate0)
            self.pendulum: Pendulum | OffsetPendulum = OffsetPendulum(field)
        else:
            self.pendulum = Pendulum(np.sqrt(stiffness / I_n), self._theta0, rate0)
        self.k, self.regime = self.pendulum.k, self.pendulum.regime
        self.period_s = self.pendulum.period_s

    @classmethod
    def _why_not(cls, system: System, state: State, start_s: float = 0.0) -> str | None:
        """Return one sentence that says why this closed form does not apply, or None."""
        orbit = system.orbit
        if orbit.has_lvlh and not orbit.is_keplerian:
            return 'the orbit is not a circle'
        omega, normal = state.omega_bi_b, _normal(system, state)
        if orbit.has_lvlh:
            if orbit.is_eccentric:
                return f'orbit.eccentricity is {orbit.eccentricity:g}, not 0'
            name, speed = 'orbit normal', max(float(np.linalg.norm(omega)), orbit.mean_motion)
            if np.linalg.norm(np.cross(omega, normal)) > ROUNDING * speed:
                return 'the body does not rotate about the orbit normal'
        else:
            name, c_i = 'axis of rotation', orbit.direction(0.0)
            if abs(rotation.rotate(state.q_ib, normal) @ c_i) > ROUNDING:
                return (
                    'the axis of rotation is not perpendicular to the direction to the attracting '
                    'centre'
                )
        if not are_parallel(system.rotor_momentum(state), normal):
            return f'the rotor is not along the {name}'
        if not all(is_principal(I, normal) for I in (system.inertia, system.carrier_inertia)):
            return f'the {name} is not a principal axis of the body'
        if abs(system.weight_moment @ normal) > ROUNDING * np.linalg.norm(system.weight_moment):
            return f'body.weight_moment is not perpendicular to the {name}'
        return None

    def facts(self) -> list[Fact]:
        """Return the constants, periods and limits that say what the motion is like."""
        facts = [
            Fact('regime', self.regime, '', 'what the angle to the line of the centre does'),
            Fact('normal_b', self.normal_b, '', 'axis of rotation, body axes'),
            Fact('theta0', self._theta0, 'rad', 'angle to the line of the centre at the start'),
            Fact('k', self.k, '', 'modulus of the elliptic functions'),
        ]
        if self.pendulum.limits is not None:
            facts.append(Fact('theta', self.pendulum.limits, 'rad', 'limits of that angle'))
        if self.period_s is not None:
            meaning = 'period of the libration' if self.regime == 'libration' else 'of one turn'
            facts.append(Fact('T', self.period_s, 's', meaning))
        return facts

    def attitude(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return q_ib (N, 4) and omega_bi_b (N, 3) at t_s (N,)."""
        theta, rate = self.pendulum.at(t_s)
        turn = rotation.about(self.normal_b, self._turn(theta, t_s))
        omega = (rate + self._line_rate)[:, None] * self.normal_b
        return attitude.turned(self.state.q_ib, turn), omega

    def axial_turn(self, t_s: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """Return the integral of axis . omega from 0 to t_s [rad], (N,), for a rotor's axis."""
        theta, _ = self.pendulum.at(t_s)
        return axis @ self.normal_b * self._turn(theta, t_s)

    def _turn(self, theta, t_s):
        """Return the angle about the normal that the body has turned in space [rad]."""
        return theta - self._theta0 + self._line_rate * t_s


def _line_rate(system, state):
    """Return the angular velocity of the line to the centre in body axes [rad/s], (3,)."""
    if system.orbit.has_lvlh:
        return system.orbit.mean_motion * _normal(system, state)
    return np.zeros(3)


def _normal(system, state):
    """
    Return the unit vector (3,), body axes, that a planar motion must be about.

    The orbit normal; in a fixed field the axis of the rate or, at rest, of the rotor's momentum
    or of the torque or, in an equilibrium, the principal axis most nearly perpendicular to the
    direction of the field.
    """
    q_bi = rotation.conjugate(state.q_ib)
    if system.orbit.has_lvlh:
        return rotation.rotate(q_bi, system.orbit.normal)
    for vector in (state.omega_bi_b, system.rotor_momentum(state)):
        if np.any(vector):
            return vector / np.linalg.norm(vector)
    c_b, I, weight = rotation.rotate(q_bi, [0.0, 0.0, 1.0]), system.inertia, system.weight_moment
    gradient = float(system.orbit.gradient_at(0.0))
    torque = gradient * np.cross(c_b, I @ c_b) - np.cross(weight, c_b)
    size = abs(gradient) * np.max(I) + np.linalg.norm(weight)
    if np.linalg.norm(torque) > ROUNDING * size:
        return torque / np.linalg.norm(torque)
    _, R_bp = principal_axes_about(c_b, I) if is_principal(I, c_b) else np.linalg.eigh(I)
    return R_bp[:, np.argmin(np.abs(c_b @ R_bp))]

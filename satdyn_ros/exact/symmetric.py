"""
The symmetric body about a fixed point in a field about a fixed direction.

Paladini 1888 ch. 1: U = H1 cos^2(theta) + H2 cos(theta), U a force function (the potential energy
is -U), theta the angle from the field's direction Z to the symmetry axis.  Lagrange's top is
H1 = 0, Beletsky's satellite (1957, sec. 3) H1 = -(3 mu / 2 r^3)(C - A), H2 = -M g z0, and the free
body H1 = H2 = 0.  The coefficients of f are derived in docs/theory/closed_forms.md.
"""

import numpy as np

from ..dynamics.inertia import are_parallel, symmetry_axis
from ..dynamics.motion import Motion
from ..dynamics.rotor import Rotor
from ..dynamics.system import State, System
from ..kernel import rotation
from ..orbits import FixedDirection
from . import attitude
from .arguments import Arguments
from .axes import is_symmetric, principal_axes_about, rotor_axes
from .cones import Cones
from .exact_motion import ExactMotion, Fact
from .flow import Flow
from .geometry import Rolling
from .nutation import EPS, Nutation

# What counts as no miss of a pole, relative to the rates: states of a motion vary by 12 EPS.
_MISS = 64.0 * EPS


class Symmetric(ExactMotion):
    """
    The motion of a symmetric body, with or without a rotor on its axis, from any state.

    Body axis 3 is the symmetry axis.  The motion is Rz(Om_P t) R'(t) Rz(Om_S t), where R' has the
    period period_s.  Where the axis passes exactly through a pole, Om_P and Om_S leave out its
    jumps by pi, halfway between a miss on one side and on the other, and R' has twice the period.
    A miss that rounding of the rates may make, some 1e-14 rad, is such a passage, from every state
    of the motion.

    Attributes
    ----------
    A, C : kg m^2
        moments A, A, C of what turns with the body
    h3 : N m s
        rotor momentum along the axis
    q_bp : (4,)
        axes 1, 2, 3 in body axes
    r0 : rad/s
        the constant rate about the axis
    g : N m s
        the area integral H . Z
    h_prime : J
        the energy integral A (p^2 + q^2) / 2 - U
    roots : (k,), complex
        all roots of f, u'^2 = f(u)
    theta_limits : rad
        the angles between which the axis stays
    Om_P, Om_S : rad/s
        mean precession and mean spin
    period_s : s
        period of the nutation
    flow : Flow
        the attitude

    Examples
    --------
    >>> Symmetric(system, state).at([10.0, 20.0]).q_ib  # doctest: +SKIP
    """

    name = 'symmetric body'
    source = 'Paladini 1888, ch. 1; Beletsky 1957, sec. 3'

    def __init__(self, system: System, state: State, start_s: float = 0.0):
        super().__init__(system, state, start_s)
        (A, _, C), R_bp = principal_axes_about(_axis(system, state), system.carrier_inertia)
        (whole_A, _, whole_C), _ = principal_axes_about(R_bp[:, 2], system.inertia)
        h3 = system.rotor_momentum(state) @ R_bp[:, 2]
        H1 = -float(system.orbit.gradient_at(start_s)) / 2.0 * (whole_C - whole_A)
        H2 = -system.weight_moment @ R_bp[:, 2]
        self._solve(A, C, h3, H1, H2, R_bp)

    @classmethod
    def in_potential(
        cls, A: float, C: float, h3: float, H1: float, H2: float, state: State
    ) -> 'Symmetric':
        """
        Return the motion under any U = H1 u^2 + H2 u [J], body axis 3 the symmetry axis.

        A, C [kg m^2], h3 [N m s]; for A = C and H1 != 0 no satellite has that potential.
        """
        rotor = Rotor('constant_momentum', axis=np.array([0.0, 0.0, 1.0]), momentum=h3)
        motion = cls.__new__(cls)
        Motion.__init__(motion, System(np.diag([A, A, C]), (rotor,), FixedDirection()), state)
        motion._solve(A, C, h3, H1, H2, np.eye(3))
        return motion

    @property
    def abc(self) -> np.ndarray:
        """
        Return a, b, c [1/s^2] (3,) of Beletsky's (12), which he leaves open.

        x'^2 = -(2 H1 / A) x^4 - (2 H2 / A) x^3 - a x^2 - b x + c, x = cos theta.
        """
        energy, k, turn = 2.0 * self.h_prime / self.A, self.g / self.A, self.C * self.r0 + self.h3
        turn /= self.A
        a = energy - 2.0 * self.H1 / self.A + turn**2
        return np.array([a, -2.0 * (k * turn + self.H2 / self.A), energy - k**2])

    @property
    def sigma(self) -> np.ndarray:
        """Return Paladini's sigma_1 and sigma_2 (2,) (arguments.py)."""
        return Arguments.of(self).sigma

    @property
    def tau(self) -> complex:
        """Return Paladini's tau, at i times which cos theta is infinite (arguments.py)."""
        return Arguments.of(self).tau

    @property
    def N1(self) -> float:
        """Return the characteristic number of the integral in precession plus spin."""
        return float(Arguments.of(self).N[0])

    @property
    def N2(self) -> float:
        """Return the characteristic number of the integral in precession less spin."""
        return float(Arguments.of(self).N[1])

    @classmethod
    def _why_not(cls, system: System, state: State, start_s: float = 0.0) -> str | None:
        """Return one sentence that says why this closed form does not apply, or None."""
        if system.orbit.has_lvlh:
            return 'the direction to the attracting centre turns; orbit.type must be fixed'
        axis, carrier = _axis(system, state), system.carrier_inertia
        if not is_symmetric(carrier, axis):
            return 'the body (without a rotor that turns freely) has no two equal moments'
        if system.orbit.gradient_at(0.0) != 0.0 and not is_symmetric(system.inertia, axis):
            return 'body.inertia is not symmetric about the axis of the body without its rotor'
        if not are_parallel(axis, system.weight_moment):
            return 'body.weight_moment is not along the symmetry axis'
        if not all(are_parallel(axis, a) for a in rotor_axes(system, state)):
            return 'rotor.axis is not along the symmetry axis'
        return None

    def facts(self) -> list[Fact]:
        """Return the constants, periods and limits that say what the motion is like."""
        cones, period_s = Cones.of(self), np.inf if self.period_s is None else self.period_s
        return [
            Fact('A', self.A, 'kg m^2', 'moment across the axis'),
            Fact('C', self.C, 'kg m^2', 'moment about the axis'),
            Fact('h3', self.h3, 'N m s', 'rotor momentum along the axis'),
            Fact('H1', self.H1, 'J', 'force function, factor of cos^2 theta'),
            Fact('H2', self.H2, 'J', 'force function, factor of cos theta'),
            Fact('r0', self.r0, 'rad/s', 'rate about the axis, constant'),
            Fact('g', self.g, 'N m s', 'area integral'),
            Fact('h_prime', self.h_prime, 'J', 'energy integral A (p^2 + q^2) / 2 - U'),
            Fact('theta', self.theta_limits, 'rad', 'the cones between which the axis stays'),
            Fact('cones', cones.thetas, 'rad', 'all limiting cones theta_i (sec. 1)'),
            Fact('interval', cones.interval, '', 'the two of all roots a_i that bound cos theta'),
            Fact('k', cones.k, '', 'modulus of the elliptic functions (sec. 2, 7)'),
            Fact('T', period_s, 's', 'period of the nutation, inf where it has none'),
            Fact('Om_P', self.Om_P, 'rad/s', 'mean precession about the field'),
            Fact('Om_S', self.Om_S, 'rad/s', 'mean spin about the axis'),
            Fact('quadric', Rolling.of(self).kind, '', 'the body cone rolls on it (sec. 12)'),
        ]

    def attitude(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return q_ib (N, 4) and omega_bi_b (N, 3) at t_s (N,)."""
        alpha, beta, pq = self.flow.at(t_s)
        q_ib, _ = attitude.in_body(alpha, beta, rotation.conjugate(self.q_bp))
        return q_ib, attitude.rotated(self.q_bp, self._rates(pq))

    def pole(self, t_s: np.ndarray) -> np.ndarray:
        """Return the rates p, q, r0 [rad/s] (N, 3) about axes 1, 2, 3 at t_s (N,)."""
        _, _, pq = self.flow.at(t_s)
        return self._rates(pq)

    def _rates(self, pq):
        return np.stack([pq.real, pq.imag, np.full(len(pq), self.r0)], axis=-1)

    def axial_turn(self, t_s: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """Return the integral of axis . omega from 0 to t_s [rad], (N,), for a rotor's axis."""
        axis_b = rotation.rotate(self.q_bp, [0.0, 0.0, 1.0])
        return np.sign(axis_b @ axis) * self.r0 * np.asarray(t_s)

    def _solve(self, A, C, h3, H1, H2, R_bp):
        self.A, self.C, self.h3, self.H1, self.H2 = A, C, h3, H1, H2
        self.q_bp = rotation.from_matrix(R_bp)
        x, y, z, w = rotation.multiply(self.state.q_ib, self.q_bp)
        p, q, self.r0 = rotation.rotate(rotation.conjugate(self.q_bp), self.state.omega_bi_b)
        gamma_1, gamma_2 = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x)
        above, below = 2.0 * (x * x + y * y), 2.0 * (z * z + w * w)
        u = 1.0 - above if above < below else below - 1.0
        j = (C * self.r0 + h3) / A
        S2, W, s2 = p * p + q * q, p * gamma_1 + q * gamma_2, above * below
        u_dot, torque = gamma_1 * q - gamma_2 * p, (2.0 * H1 * u + H2) / A
        self.g = A * (W + j * u)
        kinetic = A * S2 / 2.0
        self.h_prime = kinetic - H1 * u * u - H2 * u
        up, down = kinetic + H1 * s2 + H2 * above, kinetic + H1 * s2 - H2 * below
        missed = np.array([W + j * below, W - j * above])
        # What rounding of a state leaves of them at a passage exactly through a pole.
        axial = abs(self.r0) + (C * abs(self.r0) + abs(h3)) / A
        transverse = np.sqrt(2.0 / A * np.maximum(kinetic, [down, up]))
        sizes = transverse + axial * np.sqrt([below, above])
        lp, lm = np.where(np.abs(missed) <= _MISS * sizes, 0.0, missed)
        # Beside a pole that is hit, all of the transverse rate leads to it.
        lost = max(missed - [lp, lm], key=abs)
        f = [
            u_dot**2 + lost**2,
            2.0 * (-u * S2 + s2 * torque + (W - lost) * j),
            -S2 - 4.0 * u * torque + 2.0 * H1 / A * s2 - j * j,
            -2.0 * (H2 + 4.0 * H1 * u) / A,
            -2.0 * H1 / A,
        ]
        f_up = _from_pole(A, H1, H2, j, lm, up)
        f_down = _from_pole(A, H1, -H2, -j, lp, down)
        nutation = Nutation(f, f_up, f_down, above, below, u_dot)
        start = complex(w, z), complex(x, y), complex(p, q)
        self.flow = Flow(nutation, (self.r0 - j, lp), (j - self.r0, lm), *start)
        self.Om_P, self.Om_S = self.flow.mean_precession, self.flow.mean_spin
        self.period_s = nutation.period if nutation.period < np.inf else None
        self.roots = u + np.roots(f[::-1])
        self.theta_limits = nutation.turning.theta_limits


def _axis(system, state):
    """Return the unit vector (3,) that is the symmetry axis, if the system has one."""
    candidates = [symmetry_axis([system.carrier_inertia])]
    if system.orbit.gradient_at(0.0) != 0.0:
        candidates.append(symmetry_axis([system.inertia]))
    for vector in (system.weight_moment, *rotor_axes(system, state)):
        if np.any(vector):
            candidates.append(vector / np.linalg.norm(vector))
    return next((axis for axis in candidates if axis is not None), np.array([0.0, 0.0, 1.0]))


def _from_pole(A, H1, H2, j, l, kinetic):
    """
    Return the coefficients of f(1 - s) in s, where 1 - s = cos theta.

    l = (g - J3) / A and kinetic [J], that of the transverse rate, are those at theta = 0.
    """
    slope = (2.0 * H1 + H2) / A
    return [
        -l * l,
        4.0 * kinetic / A - 2.0 * l * j,
        -2.0 * kinetic / A - 4.0 * slope - j * j,
        2.0 * slope + 4.0 * H1 / A,
        -2.0 * H1 / A,
    ]

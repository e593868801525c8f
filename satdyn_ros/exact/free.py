"""
Free rotation: Euler and Poinsot's triaxial body, and the gyrostat, its rotor on a principal axis.

About the constant momentum L along space axis z', with body axis 3 the rotor's or, without a
rotor, the one that the polhode encircles, and v = cos theta = (I3 O3 + h) / L,

    2 E' = I1 O1^2 + I2 O2^2 = 2 E - (L v - h)^2 / I3,    N = L^2 (1 - v^2),
    v'^2 = (2 I2 E' - N)(N - 2 I1 E') / (I1 I2 L^2),

a quartic that is a product of two quadratics: the flow of flow.py, with the phases' constants
((L + h) / I3, 2 E'(-1) / L) and ((L - h) / I3, 2 E'(1) / L).  Textbook sections 44 to 46.
"""

import numpy as np
from numpy.polynomial import polynomial

from ..dynamics.inertia import ROUNDING, are_parallel
from ..dynamics.system import State, System
from ..kernel import rotation
from ..theory.stability import eigenvalue_squared
from . import attitude
from .axes import is_principal, principal_axes_about, rotor_axes
from .exact_motion import ExactMotion, Fact
from .flow import Flow
from .nutation import Nutation
from .poinsot import Poinsot, commensurability


class Free(ExactMotion):
    """
    The motion of a body on which no torque acts, with or without a rotor on a principal axis.

    Body axis 3 is the rotor's.  Without a rotor it is the axis that the polhode encircles, for a
    symmetric body its axis of symmetry.

    Attributes
    ----------
    L : N m s
        the angular momentum
    E : J
        the kinetic energy omega . I omega / 2
    Om_P, Om_S : rad/s
        mean precession of axis 3 about L, and mean spin about it
    theta_limits : rad
        the angles from L between which axis 3 stays
    T1 : s
        period of the rates (46.11); for a symmetric body that of their cone in the body, for a
        permanent rotation that of small departures; inf on a separatrix and where departures grow
    chi0, T2 : rad/s, s
        mean precession and its period 2 pi / chi0: without a rotor those of the axis of the
        largest moment, for a symmetric body those of its axis, the coning period
    Psi : rad/s
        mean spin about that axis; chi0 is Phi beside it (46.34, 46.35)
    chi : rad
        the angle about L that the body turns in T1 (45.17)
    poinsot : Poinsot or None
        the constants of a body without a rotor
    period_s : s or None
        T1; None where the rates are constant or the motion is asymptotic
    flow : Flow
        the attitude

    Examples
    --------
    >>> Free(system, state).at([10.0, 20.0]).q_ib  # doctest: +SKIP
    """

    name = 'free rotation'
    source = 'textbook sections 44-46; Euler and Poinsot'

    def __init__(self, system: System, state: State, start_s: float = 0.0):
        super().__init__(system, state, start_s)
        h_b = system.rotor_momentum(state)
        H_b = system.carrier_inertia @ state.omega_bi_b + h_b
        self.L = float(np.linalg.norm(H_b))
        self.E = float(state.omega_bi_b @ system.carrier_inertia @ state.omega_bi_b) / 2.0
        axes = rotor_axes(system, state)
        self._is_rigid = not axes
        axis = _polhode_axis(system, state) if self._is_rigid else axes[0]
        self._moments, self._R_bp = principal_axes_about(axis, system.carrier_inertia)
        self._h = float(h_b @ self._R_bp[:, 2])
        self._q_bp = rotation.from_matrix(self._R_bp)
        q_ip = rotation.multiply(state.q_ib, self._q_bp)
        self._q_il = rotation.from_z_to(rotation.rotate(state.q_ib, H_b) / self.L)
        q_lp = rotation.multiply(rotation.conjugate(self._q_il), q_ip)
        omega_p = self._R_bp.T @ state.omega_bi_b
        if np.linalg.norm(omega_p[:2]) <= ROUNDING * np.linalg.norm(omega_p):
            # A turn about body axis 3 to rounding: its transverse rate is no nutation.
            omega_p[:2] = 0.0
        self._solve(q_lp, omega_p)

    @property
    def axis_b(self) -> np.ndarray:
        """Return body axis 3 (3,), in the axes of the body."""
        return self._R_bp[:, 2]

    @property
    def t0(self) -> float:
        """
        Return the phase t0 [s]: since the rate about the middle axis was at its least (46.17).

        ValueError: there is a rotor.
        """
        if self.poinsot is None:
            raise ValueError('the body has a rotor: t0 is that of a rigid body')
        return self.poinsot.t0

    @classmethod
    def _why_not(cls, system: System, state: State, start_s: float = 0.0) -> str | None:
        """Return one sentence that says why this closed form does not apply, or None."""
        if np.any(system.weight_moment):
            return 'body.weight_moment is not zero'
        moments = np.linalg.eigvalsh(system.inertia)
        gradient = 1.0 if system.orbit.has_lvlh else system.orbit.gradient_at(0.0)
        if gradient != 0.0 and np.ptp(moments) > ROUNDING * np.max(moments):
            return 'the gravity gradient acts on the body'
        carrier, h_b = system.carrier_inertia, system.rotor_momentum(state)
        axes = rotor_axes(system, state)
        if axes and not is_principal(carrier, axes[0]):
            return 'rotor.axis is not a principal axis of the body'
        if not all(are_parallel(axes[0], axis) for axis in axes):
            return 'the rotors are not all along one principal axis of the body'
        H = np.linalg.norm(carrier @ state.omega_bi_b + h_b)
        if H <= ROUNDING * (np.linalg.norm(h_b) + np.linalg.norm(carrier @ state.omega_bi_b)):
            return 'the angular momentum is zero'
        return None

    def facts(self) -> list[Fact]:
        """Return the constants, periods and limits that say what the motion is like."""
        returns = commensurability(self.T1, self.T2)
        facts = [
            Fact('L', self.L, 'N m s', 'angular momentum, the direction of the reference axis'),
            Fact('E', self.E, 'J', 'kinetic energy'),
            Fact('axis_b', self.axis_b, '', 'the body axis that the rest describes, body axes'),
            Fact('theta', self.theta_limits, 'rad', 'the cones about L between which it stays'),
            Fact('Om_P', self.Om_P, 'rad/s', 'its mean precession about L'),
            Fact('Om_S', self.Om_S, 'rad/s', 'mean spin about it'),
            Fact('T1', self.T1, 's', 'period of the body rates (46.11)'),
            Fact('chi0', self.chi0, 'rad/s', 'mean precession whose period is T2'),
            Fact('T2', self.T2, 's', 'period of that precession, the coning period (46.11)'),
            Fact('chi', self.chi, 'rad', 'turn about L in T1 (45.17)'),
            Fact(
                'T1/T2',
                'not commensurable' if returns is None else str(returns),
                '',
                'the attitude returns after the denominator times T1, if at all (45.17)',
            ),
        ]
        if self.poinsot is None or self.poinsot.lam == 0.0:
            return facts
        known = self.poinsot
        return [
            *facts,
            Fact('k2', known.k2, '', 'squared modulus of the elliptic functions'),
            Fact('lambda', known.lam, 'rad/s', 'rate of their argument'),
            Fact('B', known.B, 'rad/s', 'largest rates about axes of ascending moment (46.12)'),
            Fact('a1', known.a1, 'rad/s', 'root of V about the largest moment (46.15)'),
            Fact('a3', known.a3, 'rad/s', 'root of V about the smallest moment (46.15)'),
            Fact(
                't0',
                known.t0,
                's',
                'since the rate about the middle axis was at its least (46.17)',
            ),
            Fact('herpolhode', known.herpolhode_radii, '1/(kg^0.5 m)', 'radii of its annulus'),
        ]

    def attitude(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return q_ib (N, 4) and omega_bi_b (N, 3) at t_s (N,)."""
        alpha, beta, _ = self.flow.at(t_s)
        q_pb = rotation.conjugate(self._q_bp)
        q_ib, gamma_p = attitude.in_body(alpha, beta, q_pb, self._q_il)
        # The momentum in body axes is L times the space axis z', seen from the body.
        momentum_p = self.L * gamma_p
        momentum_p[:, 2] -= self._h
        return q_ib, attitude.rotated(self._q_bp, momentum_p / self._moments)

    def axial_turn(self, t_s: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """Return the integral of axis . omega from 0 to t_s [rad], (N,), for a rotor's axis."""
        sign = np.sign(self._R_bp[:, 2] @ axis)
        swept = self.L * self.flow.nutation.integral(t_s) - self._h * t_s
        return sign * swept / self._moments[2]

    def _solve(self, q_lp, omega_p):
        x, y, z, w = q_lp
        (I1, I2, I3), (O1, O2, O3), h, L = self._moments, omega_p, self._h, self.L
        above, below = _distances(np.array([I1 * O1, I2 * O2, I3 * O3 + h]), L)
        # The quadratics 2 I2 E' - N and N - 2 I1 E' in v - v0, and from the poles v = 1 and -1.
        first = [(I2 - I1) * I1 * O1**2, 2.0 * L * ((I3 - I2) * O3 + h), L**2 * (1.0 - I2 / I3)]
        second = [(I2 - I1) * I2 * O2**2, -2.0 * L * ((I3 - I1) * O3 + h), L**2 * (I1 / I3 - 1.0)]
        at_top, at_bottom = (self._energy_at_pole(omega_p, v) for v in (1.0, -1.0))
        scale = I1 * I2 * L**2
        nutation = Nutation(
            np.convolve(first, second) / scale,
            _from_pole(at_top, L, -h, self._moments) / scale,
            _from_pole(at_bottom, L, h, self._moments) / scale,
            above,
            below,
            (I1 - I2) * O1 * O2 / L,
            is_even=self._is_rigid,
        )
        start = complex(w, z), complex(x, y), complex(O1, O2)
        plus, minus = ((L + h) / I3, at_bottom / L), ((L - h) / I3, at_top / L)
        self.flow = Flow(nutation, plus, minus, *start)
        self.Om_P, self.Om_S = self.flow.mean_precession, self.flow.mean_spin
        self._set_periods(nutation, _same_root(first, second, nutation.turning), omega_p)

    def _set_periods(self, nutation, each_nod, omega_p):
        """Set T1 and what follows from it; each_nod: the rates repeat after one nod, not two."""
        (I1, I2, I3), turning = self._moments, nutation.turning
        is_constant = turning.steady
        self.theta_limits = turning.theta_limits
        self.Psi = self.Om_S
        if I1 == I2:
            self.Om_P = float(self.L / I1)
            self.Om_S = float(((I1 - I3) * omega_p[2] - self._h) / I1)
            self.Psi = self.Om_S
            self.T1 = 2.0 * np.pi / abs(self.Om_S) if self.Om_S else np.inf
            is_constant = not np.any(omega_p[:2])
        elif is_constant:
            self.T1 = self._wobble_period()
        else:
            self.T1 = nutation.period * (1.0 if each_nod else 2.0)
        self.chi0 = self.Om_P
        if self._is_rigid and I1 != I2 and I3 < max(I1, I2):
            # the axis of the largest moment is another, which body axis 3 turns once in T1
            self.chi0, self.Psi = self.Om_P + 2.0 * np.pi / self.T1, 0.0
        self.T2, self.chi = 2.0 * np.pi / self.chi0, self.chi0 * self.T1
        self.period_s = None if is_constant or self.T1 == np.inf else self.T1
        self.poinsot = None
        if self._is_rigid:
            self.poinsot = Poinsot(self.system.carrier_inertia, self.state.omega_bi_b)

    def _wobble_period(self):
        """Return the period of small departures from the permanent rotation [s], or inf."""
        square = eigenvalue_squared(
            self.system.carrier_inertia,
            self.state.omega_bi_b,
            self.system.rotor_momentum(self.state),
        )
        return 2.0 * np.pi / np.sqrt(-square) if square < 0.0 else np.inf

    def _energy_at_pole(self, omega_p, v):
        """Return 2 E' at v = 1 or -1; at the nearer pole without cancellation."""
        (I1, I2, I3), (O1, O2, O3), h, L = self._moments, omega_p, self._h, self.L
        L3 = I3 * O3 + h
        energies = np.array([I1 * O1**2, I2 * O2**2])
        if h == 0.0 or v * L3 >= 0.0:
            # (v L - L3)(v L + L3) = L1^2 + L2^2
            share = 1.0 - 2.0 * h / (v * L + L3) if h != 0.0 else 1.0
            return energies @ (1.0 - np.array([I1, I2]) / I3 * share)
        rise = v * L - L3
        return np.sum(energies) - (2.0 * O3 + rise / I3) * rise


def _polhode_axis(system, state):
    """Return the axis of the largest or smallest moment that the polhode runs about."""
    moments, axes = np.linalg.eigh(system.carrier_inertia)
    if moments[1] - moments[0] <= ROUNDING * moments[2]:
        return axes[:, 2]
    if moments[2] - moments[1] <= ROUNDING * moments[2]:
        return axes[:, 0]
    # L^2 - 2 E I2 without cancellation
    excess = (moments - moments[1]) @ (moments * (axes.T @ state.omega_bi_b) ** 2)
    return axes[:, 2] if excess >= 0.0 else axes[:, 0]


def _distances(H, L):
    """Return 1 - v and 1 + v of the momentum H (3,), both with all their digits."""
    near = (H[0] ** 2 + H[1] ** 2) / (L * (L + abs(H[2])))
    return (near, 2.0 - near) if H[2] >= 0.0 else (2.0 - near, near)


def _from_pole(energy, L, h, moments):
    """Return I1 I2 L^2 f (5,) in the distance s from a pole where 2 E' is energy."""
    I1, I2, I3 = moments
    E = np.array([energy, 2.0 * L * (L + h) / I3, -(L**2) / I3])
    N = np.array([0.0, 2.0 * L**2, -(L**2)])
    return np.convolve(I2 * E - N, N - I1 * E)


def _same_root(first, second, turning):
    """Return whether both turning points are roots of one of the two quadratics."""
    nearer = [
        abs(polynomial.polyval(end, first)) <= abs(polynomial.polyval(end, second))
        for end in (turning.da, turning.db)
    ]
    return nearer[0] == nearer[1]

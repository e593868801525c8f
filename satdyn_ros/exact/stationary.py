"""
The stationary motions of a body held in a Newtonian field (Agostinelli 1977).

The energy is stationary at fixed |gamma|, area integral and fourth integral (multipliers lambda,
mu, nu) where omega_i = omega_0 alpha_i gamma_i in the principal axes, omega_0^2 = |gradient|,

    alpha_i = s sqrt|N1 N2 N3| / N_i,   N_i = 1 - 2 nu I_i,   s = +-1,

with N1 N2 N3 of the gradient's sign: negative in De Brun's problem, of a body drawn to a plane,
and for the pull averaged over an orbit.  Such a motion remains so, and gamma moves like the rate
of a free body with the alphas for moments: gamma_1' = omega_0 (alpha_3 - alpha_2) gamma_2 gamma_3,
with e = alpha . gamma^2 constant.  About the axis that gamma circles the attitude is a flow
(flow.py), its phases by the paper's (31).
"""

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.inertia import ROUNDING, principal_axes
from ..dynamics.system import State, System
from ..kernel import rotation
from ..theory.euler_angles import from_zxz
from . import attitude, elliptic, multiplier
from .exact_motion import ExactMotion, Fact
from .flow import Flow
from .nutation import Nutation
from .polhode import Polhode

_NO_FIELD = 'orbit.gradient is 0: there is no field'


class Stationary(ExactMotion):
    """
    The motion of a body without rotor, about its mass centre, that has a multiplier nu.

    Attributes
    ----------
    moments : (3,), kg m^2
        about principal axes 1, 2, 3, ordered as in dynamics/inertia.py
    omega_0 : rad/s
        root of the size of the gradient
    nu, lambda_, mu : float
        the multipliers, nu in 1 / (kg m^2)
    alpha : (3,)
        rates over omega_0 gamma
    e, c0 : float
        sum of alpha gamma^2, and e - alpha_3
    h, c1, c2 : float
        energy [J], area integral, fourth integral
    m, m1, lam : float
        parameter of the elliptic functions, 1 - m, and their rate [rad/s]
    period_s : s
        of gamma in the body

    Examples
    --------
    >>> Stationary(system, state).at([10.0, 20.0]).q_ib  # doctest: +SKIP
    """

    omega_0: float
    nu: float
    alpha: np.ndarray

    name = 'stationary motion'
    source = 'Agostinelli 1977, eqs. 13, 28-32'

    def __init__(self, system: System, state: State, start_s: float = 0.0):
        super().__init__(system, state, start_s)
        moments, _, gamma, omega_p = _in_principal_axes(system, state)
        omega_0, field = _field(system)
        found = multiplier.find(moments, omega_0, gamma, omega_p, field)
        assert found is not None  # checked by why_not
        self._set_multiplier(*found)

    @classmethod
    def from_attitude(
        cls, system: System, nu: float, q_ib: ArrayLike, sign: int = 1
    ) -> 'Stationary':
        """
        Return the motion with a multiplier nu from an attitude.

        Parameters
        ----------
        system : System
            the body and its field
        nu : 1 / (kg m^2)
            the multiplier
        q_ib : (4,)
            attitude at the start
        sign : 1 or -1
            of mu

        Raises
        ------
        ValueError
            nu is not admissible: N1 N2 N3 must have the gradient's sign
        """
        moments, R_bp = principal_axes(system.inertia)
        omega_0, field = _field(system)
        alpha = multiplier.alphas(moments, nu, sign, field)
        q_bp = rotation.from_matrix(R_bp)
        q_ib = rotation.normalise(q_ib)
        gamma = rotation.rotate(rotation.conjugate(rotation.multiply(q_ib, q_bp)), [0, 0, 1])
        omega_p = omega_0 * alpha * gamma
        motion = cls(system, State(q_ib, rotation.rotate(q_bp, omega_p)))
        off = np.max(np.abs(motion.alpha - alpha))
        if off > elliptic.LAST_DIGITS * np.max(np.abs(alpha)):
            # A permanent rotation has more than one multiplier: it is to have the given one.
            motion._set_multiplier(nu, sign)
        return motion

    @classmethod
    def from_constants(
        cls,
        system: System,
        nu: float,
        c0: float,
        phase: float = 0.0,
        psi0: float = 0.0,
        sign: int = 1,
    ) -> 'Stationary':
        """
        Return the motion with the paper's constants nu and c0.

        Of the two motions with these constants it is the one in which the cosine that never
        vanishes is positive.

        Parameters
        ----------
        system : System
            the body and its field
        nu : 1 / (kg m^2)
            the multiplier
        c0 : float
            e - alpha_3
        phase : float
            argument u of the elliptic functions at the start; where c0 leaves gamma anywhere in a
            principal plane of equal alphas, its angle there
        psi0 : rad
            precession of principal axis 3 at the start
        sign : 1 or -1
            of mu

        Raises
        ------
        ValueError
            nu is not admissible, or c0 is beyond the alphas
        """
        return cls._from_c0(system, nu, c0, 0.0, phase, psi0, sign)

    @classmethod
    def from_energy(
        cls,
        system: System,
        nu: float,
        h: float,
        phase: float = 0.0,
        psi0: float = 0.0,
        sign: int = 1,
    ) -> 'Stationary':
        """
        Return the motion with the paper's constants nu and h (27).

        Parameters
        ----------
        system : System
            the body and its field
        nu : 1 / (kg m^2)
            the multiplier
        h : J
            the energy
        phase, psi0, sign : see from_constants
            the start

        Raises
        ------
        ValueError
            nu is not admissible, all motions with it have one energy, or none has this energy
        """
        moments, _ = principal_axes(system.inertia)
        omega_0, field = _field(system)
        c0, rounding = multiplier.c0_of_energy(moments, nu, sign, field, h / omega_0**2)
        return cls._from_c0(system, nu, c0, rounding, phase, psi0, sign)

    @classmethod
    def _from_c0(cls, system, nu, c0, rounding, phase, psi0, sign):
        """Return the motion of from_constants, where c0 is known to no more than rounding."""
        moments, R_bp = principal_axes(system.inertia)
        alpha = multiplier.alphas(moments, nu, sign, _field(system)[1])
        differences = multiplier.differences(moments, nu, sign)
        low, high = np.min(differences[:, 2]), np.max(differences[:, 2])
        rounding += elliptic.LAST_DIGITS * np.max(np.abs(alpha)) + ROUNDING * (high - low)
        if not low - rounding <= c0 <= high + rounding:
            raise ValueError(
                f'c0 is {c0:.12g}; for this nu it must be from {low:.12g} to {high:.12g}'
            )
        c0 = min(max(c0, low), high)
        c, b, a = _ascending(differences)
        x, y, z = (b, a, c) if c0 - differences[b, 2] >= 0.0 else (b, c, a)
        polhode = Polhode.of(
            differences[[y, y, x], [z, x, z]],
            (c0 - differences[z, 2], differences[y, 2] - c0, c0 - differences[x, 2]),
        )
        gamma = _frame(y, z, np.ones(3)) @ np.array(polhode.at(phase))
        nutation = np.arctan2(np.hypot(gamma[0], gamma[1]), gamma[2])
        q_ip = from_zxz(psi0, nutation, np.arctan2(gamma[0], gamma[1]))
        q_pb = rotation.conjugate(rotation.from_matrix(R_bp))
        return cls.from_attitude(system, nu, rotation.multiply(q_ip, q_pb), sign)

    def _set_multiplier(self, nu, sign):
        """Set the constants and the flow of the state with the multiplier nu, sign that of mu."""
        self.nu = nu
        self.omega_0, field = _field(self.system)
        self.moments, q_bp, gamma, _ = _in_principal_axes(self.system, self.state)
        self._constants(sign, field, gamma)
        differences = multiplier.differences(self.moments, nu, sign)
        # e - alpha_3 without cancellation
        self.c0 = float(differences[:, 2] @ gamma**2)
        self._solve(self.omega_0 * self.alpha, self.omega_0 * differences, gamma, q_bp)

    @classmethod
    def _why_not(cls, system: System, state: State, start_s: float = 0.0) -> str | None:
        """Return one sentence that says why this closed form does not apply, or None."""
        if system.orbit.has_lvlh:
            return 'the direction to the attracting centre turns; orbit.type must be fixed'
        if system.orbit.gradient_at(0.0) == 0.0:
            return _NO_FIELD
        if np.any(system.weight_moment):
            return 'body.weight_moment is not zero'
        if system.has_turning_rotor or np.any(system.rotor_momentum(state)):
            return 'there is a rotor'
        moments, _, gamma, omega_p = _in_principal_axes(system, state)
        omega_0, field = _field(system)
        if multiplier.find(moments, omega_0, gamma, omega_p, field) is None:
            return 'no nu gives the rates omega_i = omega_0 alpha_i gamma_i about all three axes'
        return None

    def facts(self) -> list[Fact]:
        """Return the constants, periods and limits that say what the motion is like."""
        period_s = np.inf if self.period_s is None else self.period_s
        return [
            Fact('omega_0', self.omega_0, 'rad/s', 'root of the size of the gradient'),
            Fact('nu', self.nu, '1/(kg m^2)', 'multiplier of the fourth integral'),
            Fact('lambda', self.lambda_, 'kg m^2/s^2', 'multiplier of |gamma| (13)'),
            Fact('mu', self.mu, 'rad/s', 'multiplier of the area integral (12)'),
            Fact('alpha', self.alpha, '', 'rates over omega_0 gamma in principal axes (14)'),
            Fact('e', self.e, '', 'alpha . gamma^2'),
            Fact('c0', self.c0, '', 'e - alpha_3 (25)'),
            Fact('h', self.h, 'J', 'energy (3)'),
            Fact('c1', self.c1, 'N m s', 'area integral (4)'),
            Fact('c2', self.c2, '(N m s)^2', 'fourth integral (5)'),
            Fact('m', self.m, '', 'parameter of the elliptic functions'),
            Fact('lam', self.lam, 'rad/s', 'rate of their argument'),
            Fact('T', period_s, 's', 'period of gamma in the body, inf where it has none'),
        ]

    def attitude(self, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return q_ib (N, 4) and omega_bi_b (N, 3) at t_s (N,)."""
        alpha, beta, _ = self._flow.at(t_s)
        q_ib, gamma_k = attitude.in_body(alpha, beta, rotation.conjugate(self._q_bk))
        return q_ib, attitude.rotated(self._q_bk, self._rates * gamma_k)

    def axial_turn(self, t_s: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """Return nan (N,): no rotor turns here."""
        return np.full(len(t_s), np.nan)

    def _constants(self, sign, field, gamma):
        """Set what the paper calls h, c0, c1, c2, lambda and mu (its eqs. 2-4, 12, 16)."""
        I, omega_0, square = self.moments, self.omega_0, gamma**2
        A, B, C = I
        self.alpha = alpha = multiplier.alphas(I, self.nu, sign, field)
        self.e = float(alpha @ square)
        self.h = omega_0**2 / 2.0 * float(I * (alpha**2 + field) @ square)
        self.c1 = omega_0 * float(I * alpha @ square)
        self.c2 = omega_0**2 * float((I**2 * alpha**2 - field * A * B * C / I) @ square)
        product = abs(float(np.prod(1.0 - 2.0 * self.nu * I)))
        self.mu = sign * omega_0 * float(np.sqrt(product))
        pairs = A * B + B * C + C * A
        self.lambda_ = field * omega_0**2 * (pairs * self.nu - 2.0 * A * B * C * self.nu**2)

    def _solve(self, rates, differences, gamma, q_bp):
        """
        Find the polhode and the flow of frame k, whose axis 3 gamma circles, never across it.

        Axis 1 of k is the other axis with an extreme alpha, axis 2 the middle one.  rates: omega_0
        alpha_i, differences (3, 3) theirs, both [rad/s].
        """
        c, b, a = _ascending(differences)
        around_a = differences[a, b] * gamma[a] ** 2 >= differences[b, c] * gamma[c] ** 2
        x, y, z = (b, a, c) if around_a else (b, c, a)
        gamma = np.where(np.abs(gamma) > elliptic.LAST_DIGITS, gamma, 0.0)
        R_pk = _frame(y, z, gamma)[:, [2, 0, 1]]
        self._q_bk = rotation.multiply(q_bp, rotation.from_matrix(R_pk))
        gamma_z, gamma_x, gamma_y = gamma_k = R_pk.T @ gamma
        self._rates = rates[[z, x, y]]
        yz, yx, xz = differences[[y, y, x], [z, x, z]]
        known = Polhode.of(
            (yz, yx, xz),
            (
                yz * gamma_y**2 + xz * gamma_x**2,
                yx * gamma_x**2 + yz * gamma_z**2,
                yx * gamma_y**2 - xz * gamma_z**2,
            ),
        )
        self.lam, self.m, self.m1 = known.lam, known.m, known.m1
        nutation, depth = _nutation(gamma_k, (yz, yx, xz))
        if known.S * self.lam != 0.0 and np.sum(gamma != 0.0) > 1 and self.m1 > 0.0:
            self.period_s = float(4.0 * elliptic.K(self.m1) / self.lam)
        qx, qy, qz, qw = rotation.multiply(self.state.q_ib, self._q_bk)
        phase = self._rates[2], -depth
        p, q, _ = self._rates * gamma_k
        self._flow = Flow(nutation, phase, phase, complex(qw, qz), complex(qx, qy), complex(p, q))


def _nutation(gamma_k, differences):
    """
    Return the nutation of axis 3 of frame k from Z and omega_0 (alpha_3 - e) [rad/s].

    differences: r_3 - r_1, r_3 - r_2, r_2 - r_1 of r_i = omega_0 alpha_i.  With u = gamma_3 and
    E = omega_0 e,

        u'^2 = (E - r_2 - (r_3 - r_2) u^2) (r_1 - E + (r_3 - r_1) u^2)          (30)
        s+-' = r_3 - (r_3 - E) / (1 +- u)                                       (31)
    """
    gamma_1, gamma_2, u = gamma_k
    r31, r32, r21 = differences
    depth = r31 * gamma_1**2 + r32 * gamma_2**2
    first = [-r21 * gamma_1**2, -2.0 * r32 * u, -r32]
    second = [-r21 * gamma_2**2, 2.0 * r31 * u, r31]
    at_pole = np.convolve([-depth, 2.0 * r32, -r32], [depth, -2.0 * r31, r31])
    above = (gamma_1**2 + gamma_2**2) / (1.0 + u)
    nutation = Nutation(
        np.convolve(first, second),
        at_pole,
        at_pole,
        above,
        1.0 + u,
        r21 * gamma_1 * gamma_2,
        is_even=True,
    )
    return nutation, depth


def _field(system):
    """
    Return omega_0 [rad/s], the root of the gradient's size, and the gradient's sign.

    ValueError: it is zero.
    """
    gradient = float(system.orbit.gradient_at(0.0))
    if gradient == 0.0:
        raise ValueError(_NO_FIELD)
    return float(np.sqrt(abs(gradient))), int(np.sign(gradient))


def _in_principal_axes(system, state):
    """Return the moments, q_bp, and gamma and omega in principal axes."""
    moments, R_bp = principal_axes(system.inertia)
    q_bp = rotation.from_matrix(R_bp)
    q_pi = rotation.conjugate(rotation.multiply(state.q_ib, q_bp))
    omega_p = rotation.rotate(rotation.conjugate(q_bp), state.omega_bi_b)
    return moments, q_bp, rotation.rotate(q_pi, [0.0, 0.0, 1.0]), omega_p


def _ascending(differences):
    """Return the axes in the order of their alphas, in keeping with the differences' signs."""
    return np.argsort(np.sum(differences > 0.0, axis=1), kind='stable')


def _frame(y, z, gamma):
    """Return R_pk (3, 3): axes y and z of p, turned to gamma's side, are the second and third."""
    Y = np.eye(3)[y] * np.copysign(1.0, gamma[y])
    Z = np.eye(3)[z] * np.copysign(1.0, gamma[z])
    return np.stack([np.cross(Y, Z), Y, Z], axis=-1)

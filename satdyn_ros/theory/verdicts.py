"""
Whether a steady motion is stable, and by which argument.

Stable means that the rate and the direction of the field in body axes stay near those of the
steady motion: an angle that drifts about the axis of rotation, or about an axis of symmetry, does
not count.  In this order,

    without a field the energy on the sphere of constant |H| decides every case,
    a strict minimum of the amended potential is stable (Routh, Lagrange),
    a growing solution of the linear equations is unstable (Lyapunov),

and in all other cases the linear terms do not decide.
"""

from typing import NamedTuple

import numpy as np

from ..dynamics.inertia import ROUNDING
from ..dynamics.system import State, System
from ..dynamics.torque import angular_momentum
from ..kernel import rotation
from .equilibria import direction
from .precession import feels_field, symmetry_axis
from .stability import cross_matrices, linear_equations

# Growth that rounding gives to multiple zero eigenvalues, relative to the largest.
_GROWTH = 1e-5


class Verdict(NamedTuple):
    """
    A verdict on the stability of a steady motion.

    Attributes
    ----------
    stability : str
        'stable', 'unstable' or 'undecided'
    argument : str
        the reason, in one sentence
    """

    stability: str
    argument: str


def verdict(system: System, state: State, orbit_s: float = 0.0) -> Verdict:
    """
    Return the verdict on a steady motion: omega and, where there is a field, c stay in the body.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state, which must balance (equilibria.is_balanced)
    orbit_s : s
        time from the instant of the orbit's elements

    Raises
    ------
    ValueError
        the orbit is elliptic: nothing is steady there

    Examples
    --------
    >>> verdict(System(np.diag([1.0, 2.0, 3.0])), State(q_ib, np.array([0.0, 0.1, 0.0])))
    ... # doctest: +SKIP
    Verdict(stability='unstable', argument='the energy has a saddle at constant angular momentum')
    """
    if not feels_field(system):
        H = angular_momentum(system, state.omega_bi_b, state.rotor_speed)
        h = system.rotor_momentum(state)
        return free_verdict(system.carrier_inertia, state.omega_bi_b, H, h)
    if system.orbit.is_eccentric:
        raise ValueError('there are no steady motions on an elliptic orbit')
    steady = _Steady.of(system, state, orbit_s)
    aside = '' if steady.axis is None else ', apart from the rotation about the symmetry axis'
    if np.min(steady.hessian()) > ROUNDING * steady.size:
        return Verdict('stable', f'the amended potential has a strict minimum{aside}')
    roots = steady.roots()
    fastest = np.max(np.abs(roots))
    if np.max(roots.real) > _GROWTH * fastest:
        return Verdict('unstable', 'a solution of the linear equations grows')
    return Verdict(
        'undecided',
        'no solution of the linear equations grows exponentially, but the amended potential has '
        f'no strict minimum{aside}: gyroscopic stability at best, which damping ends',
    )


def small_motion_roots(system: System, state: State, orbit_s: float = 0.0) -> np.ndarray:
    """
    Return the six eigenvalues [1/s] of small motion about a steady motion in a field.

    Like stability.eigenvalues, but in axes that do not spin about an axis of symmetry.
    """
    return _Steady.of(system, state, orbit_s).roots()


def free_verdict(inertia: np.ndarray, omega: np.ndarray, H: np.ndarray, h: np.ndarray) -> Verdict:
    """
    Return the verdict on a permanent rotation omega (3,) [rad/s] without a field.

    H = inertia omega + h [N m s].  On the sphere |H| = L = const, with H = r u + a e + b f, u the
    unit vector of H and r^2 = L^2 - a^2 - b^2, the energy (H - h) . inertia^-1 (H - h) / 2 is
    stationary at a = b = 0.  The motion follows its level curves there, so that an extremum is
    stable and a saddle is not (textbook, 44.11 to 44.14).  Where the second variation is zero in
    a direction e the terms of third and fourth order decide, and where these are zero too e is
    along a circle of permanent rotations, on which the neighbours drift.
    """
    L = float(np.linalg.norm(H))
    rate = float(np.linalg.norm(omega))
    M = np.linalg.inv(inertia)
    if L <= ROUNDING * (np.linalg.norm(inertia @ omega) + np.linalg.norm(h)):
        return Verdict('stable', 'the angular momentum is zero and keeps its length')
    u = H / L
    across = _across(u)
    second, turn = np.linalg.eigh(across @ M @ across.T - float(omega @ u) / L * np.eye(2))
    zero = np.abs(second) <= ROUNDING * np.max(M)
    if not np.any(zero):
        if second[0] * second[1] < 0.0:
            return Verdict('unstable', 'the energy has a saddle at constant angular momentum')
        kind = 'minimum' if second[0] > 0.0 else 'maximum'
        return Verdict('stable', f'the energy has a {kind} at constant angular momentum')
    # The terms of third order are -(a^2 + b^2) (a M_ue + b M_uf) / 2 L.
    skew = turn.T @ across @ M @ u
    quartic = float(u @ M @ h) / (8.0 * L**3)
    size = np.max(M) / L**2
    if np.all(zero):
        if rate == 0.0 or np.max(np.abs(skew)) <= ROUNDING * np.max(M):
            if abs(quartic) <= ROUNDING * size:
                return Verdict('stable', 'every rotation of the body is permanent')
            return Verdict('stable', 'the energy has an extremum of fourth order')
        return Verdict('unstable', 'the energy has a saddle of third order')
    e, f = (0, 1) if zero[0] else (1, 0)
    if abs(skew[e]) > ROUNDING * np.max(M):
        return Verdict('unstable', 'the energy has a saddle of third order')
    quartic -= skew[f] ** 2 / (8.0 * L**2 * second[f])
    if abs(quartic) <= ROUNDING * size:
        return Verdict('unstable', 'the neighbours drift along a circle of permanent rotations')
    if quartic * second[f] > 0.0:
        return Verdict('stable', 'the energy has an extremum of fourth order')
    return Verdict('unstable', 'the energy has a saddle of fourth order')


class _Steady(NamedTuple):
    """
    A steady motion in a field, in body axes that do not spin about an axis of symmetry.

    W c or n k: the rate omega (3,) [rad/s]; h (3,) [N m s]: rotor momentum, with that of the
    proper spin about the axis, which acts on the rest like a rotor.
    """

    system: System
    axis: np.ndarray | None
    on_orbit: bool
    c: np.ndarray
    omega: np.ndarray
    h: np.ndarray
    gradient: float

    @classmethod
    def of(cls, system: System, state: State, orbit_s: float) -> '_Steady':
        """Return the steady motion of a state; see verdict."""
        K, h, omega = system.carrier_inertia, system.rotor_momentum(state), state.omega_bi_b
        c, axis = direction(system, state, orbit_s), symmetry_axis(system, state)
        orbit, gradient = system.orbit, float(system.orbit.gradient_at(orbit_s))
        on_orbit = orbit.is_keplerian
        if axis is not None:
            across = np.cross(axis, c)
            if on_orbit:
                normal_b = rotation.rotate(rotation.conjugate(state.q_ib), orbit.normal)
                unspun = orbit.mean_motion * normal_b
            elif np.linalg.norm(across) > ROUNDING:
                # omega = W c + (spin) axis
                unspun = np.cross(axis, omega) @ across / (across @ across) * c
            else:
                unspun = np.zeros(3)
            h = h + K @ (omega - unspun)
            omega = unspun
        return cls(system, axis, on_orbit, c, omega, h, gradient)

    @property
    def size(self) -> float:
        """Return the size of the terms of the amended potential [J]."""
        system, rate = self.system, np.linalg.norm(self.omega)
        largest = np.max(np.abs(system.inertia))
        turning = rate * (rate * largest + np.linalg.norm(self.h))
        return float(abs(self.gradient) * largest + np.linalg.norm(system.weight_moment) + turning)

    def roots(self) -> np.ndarray:
        """Return the eigenvalues [1/s] of the linear equations (6,)."""
        system = self.system
        K, m = system.carrier_inertia, system.weight_moment
        return np.linalg.eigvals(
            linear_equations(system.inertia, K, self.h, self.omega, self.c, self.gradient, m)
        )

    def hessian(self) -> np.ndarray:
        """
        Return the eigenvalues [J/rad^2] of the amended potential's second variation, ascending.

        In small turns of the body: on a circular orbit of normal k and rate n all three, of

            (3 mu / 2 r^3) c . I c - n^2 k . K k / 2 - n h . k;

        for a rotation W about a field's fixed direction c the two across c, of

            (3 mu / 2 r^3) c . I c + m . c + (H . c - h . c)^2 / (2 c . K c)   at constant H . c.

        With an axis of symmetry the momentum J3 about it is constant: then h is J3 along it, K
        counts without its moment about it, and the turn about it drops out.
        """
        system, c, omega, h, axis = self.system, self.c, self.omega, self.h, self.axis
        K = system.carrier_inertia
        if axis is not None:
            h = h + K @ axis * (axis @ omega)
            K = K - axis @ K @ axis * np.outer(axis, axis)
        still = self.gradient * _square_hessian(system.inertia, c)
        still += _linear_hessian(system.weight_moment, c)
        hessian = still - _square_hessian(K, omega) - _linear_hessian(h, omega)
        if self.on_orbit:
            free = np.eye(3) if axis is None else _across(axis)
        elif axis is not None and np.linalg.norm(np.cross(axis, c)) <= ROUNDING:
            # (H . c - h . c)^2 / (2 c . K c) is J3^2 tan^2(theta / 2) / 2 A, theta from c
            free = _across(c)[:1]
            hessian = still + float(h @ c) ** 2 / (2.0 * np.trace(K)) * np.eye(3)
        else:
            change = np.cross(c, h + 2.0 * K @ omega)
            hessian = hessian + np.outer(change, change) / (c @ K @ c)
            free = _across(c)
            if axis is not None:
                nod = np.cross(axis, c)
                free = nod[None] / np.linalg.norm(nod)
        return np.linalg.eigvalsh(free @ hessian @ free.T)


def _square_hessian(A: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the second variation (3, 3) of c . A c / 2 when the body turns under a fixed c."""
    C = cross_matrices(c)
    return C.T @ A @ C + _linear_hessian(A @ c, c)


def _linear_hessian(m: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the second variation (3, 3) of m . c when the body turns under a fixed c."""
    return (np.outer(c, m) + np.outer(m, c)) / 2.0 - float(c @ m) * np.eye(3)


def _across(axis: np.ndarray) -> np.ndarray:
    """Return two unit vectors across the unit vector axis, (2, 3)."""
    return np.linalg.svd(axis[None])[2][1:]

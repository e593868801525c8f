"""
Where a gyrostat turns uniformly: permanent rotations and relative equilibria.

A rate omega constant in body axes needs the torque that turns the angular momentum,

    omega x H = (3 mu / r^3) c x I c - m x c + torque,    H = K omega + h,

with K the inertia that turns with the body (System.carrier_inertia), h the rotor's momentum, I
the whole inertia, c the unit vector from the attracting centre and m the weight moment.
"""

from itertools import permutations, product

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from ..dynamics.inertia import ROUNDING, principal_axes
from ..dynamics.rotor import Rotor
from ..dynamics.system import State, System
from ..dynamics.torque import angular_momentum
from ..kernel import rotation
from ..orbits import KeplerOrbit
from ..torques.gravity_gradient import gravity_gradient


def direction(system: System, state: State, orbit_s: float = 0.0) -> np.ndarray:
    """Return c (3,), the unit vector from the attracting centre to the body, body axes."""
    return rotation.rotate(rotation.conjugate(state.q_ib), system.orbit.direction(orbit_s))


def imbalance(system: System, state: State, orbit_s: float = 0.0) -> np.ndarray:
    """
    Return torque - omega x H = K omega' (3,) [N m], body axes, zero where omega is constant.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state
    orbit_s : s
        time from the instant of the orbit's elements
    """
    c = direction(system, state, orbit_s)
    H = angular_momentum(system, state.omega_bi_b, state.rotor_speed)
    field = gravity_gradient(system.inertia, c, system.orbit.gradient_at(orbit_s))
    applied = system.torque_b - sum(
        (p_dot * rotor.axis for rotor, p_dot in rotor_torques(system, state)), np.zeros(3)
    )
    return np.cross(H, state.omega_bi_b) + field - np.cross(system.weight_moment, c) + applied


def rotor_torques(system: System, state: State) -> list[tuple[Rotor, float]]:
    """Return each rotor with p' [N m], the torque of motor and friction on it."""
    return [
        (rotor, torque - rotor.friction_torque(speed) if rotor.is_damped else torque)
        for rotor, torque, speed in zip(
            system.rotors, system.rotor_torque, system.rotor_speeds(state), strict=True
        )
    ]


def is_balanced(system: System, state: State, orbit_s: float = 0.0) -> bool:
    """Whether omega' is zero to rounding, relative to the sizes of the torques in the balance."""
    H = angular_momentum(system, state.omega_bi_b, state.rotor_speed)
    H_carrier = system.carrier_inertia @ state.omega_bi_b
    # The two may cancel, and leave their rounding.
    momenta = np.linalg.norm(H_carrier) + np.linalg.norm(H - H_carrier)
    torques = [
        momenta * np.linalg.norm(state.omega_bi_b),
        abs(system.orbit.gradient_at(orbit_s)) * np.max(system.inertia),
        np.linalg.norm(system.weight_moment),
        np.linalg.norm(system.torque_b),
        *(abs(p_dot) for _, p_dot in rotor_torques(system, state)),
    ]
    return bool(np.linalg.norm(imbalance(system, state, orbit_s)) <= ROUNDING * sum(torques))


def permanent_rotations(
    inertia: np.ndarray,
    rate: float,
    rotor_momentum: np.ndarray | tuple[float, ...] = (0.0, 0.0, 0.0),
) -> np.ndarray:
    """
    Return all omega (M, 3) [rad/s] of one size that stay constant in a free gyrostat.

    omega x (I omega + h) = 0 makes I omega + h = x omega: in principal axes omega_j = h_j / (x -
    I_j), with x a root of |omega| = rate or, where h_k = 0, x = I_k and omega_k makes up the rest.
    The principal axes represent a circle of axes, where equal moments allow one.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        of what turns with the body
    rate : rad/s
        the size
    rotor_momentum : (3,), N m s, body axes
        h

    Examples
    --------
    >>> permanent_rotations(np.diag([1.0, 2.0, 3.0]), 0.1)[:2]
    array([[ 0.1,  0. ,  0. ],
           [-0.1,  0. ,  0. ]])
    """
    moments, R_bp = _principal_axes_along(np.asarray(rotor_momentum, float), inertia)
    h = R_bp.T @ rotor_momentum
    h[np.abs(h) <= ROUNDING * (np.linalg.norm(h) + rate * np.max(np.abs(moments)))] = 0.0
    found = [omega for k in range(3) if h[k] == 0.0 for omega in _beside(k, moments, h, rate)]
    active = np.flatnonzero(h)
    if len(active):
        found += _with_momentum(active, moments, h, rate)
    return np.array(found).reshape(-1, 3) @ R_bp.T


def _principal_axes_along(h, inertia):
    """Return moments and principal axes; of two equal moments one axis is perpendicular to h."""
    moments, R_bp = principal_axes(inertia)
    for i, j in ((0, 1), (1, 2), (0, 2), (0, 1)):
        if abs(moments[i] - moments[j]) <= ROUNDING * np.max(np.abs(moments)):
            along, across = R_bp[:, i], R_bp[:, j]
            angle = np.arctan2(h @ across, h @ along)
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            R_bp[:, [i, j]] = R_bp[:, [i, j]] @ turn
    return moments, R_bp


def _beside(k, moments, h, rate):
    """Return the rotations with I omega + h = I_k omega, in principal axes; h_k is zero."""
    gap = moments[k] - moments
    if np.any((gap == 0.0) & (h != 0.0)):
        return []
    omega = np.divide(h, gap, out=np.zeros(3), where=gap != 0.0)
    left = rate**2 - omega @ omega
    if left < 0.0:
        return []
    along = np.sqrt(left) * np.eye(3)[k]
    return [omega + along, omega - along]


def _with_momentum(active, moments, h, rate):
    """
    Return the rotations in the span of the axes that have rotor momentum, in principal axes.

    As a function of x, |omega| is infinite at every moment I_j, falls outwards from the smallest
    and largest, and has one minimum between neighbours; x is measured from the nearest I_j, to
    avoid cancellation.
    """
    active = active[np.argsort(moments[active])]
    h, moments = h[active], moments[active]

    def root(j, outermost, side):
        """Return omega at the root between I_j and I_j + side * outermost."""
        innermost = abs(h[j]) / rate * (1.0 - 1e-9)
        away = moments[j] - moments
        x = brentq(
            lambda x: np.linalg.norm(h / (away + side * x)) - rate,
            innermost,
            outermost,
            xtol=1e-300,
        )
        omega = np.zeros(3)
        omega[active] = h / (away + side * x)
        return omega

    far = np.linalg.norm(h) / rate * (1.0 + 1e-9)
    found = [root(0, far, -1.0), root(len(h) - 1, far, 1.0)]
    for j in range(len(h) - 1):
        away, gap = moments[j] - moments, moments[j + 1] - moments[j]
        edges = 1e-10 * gap, (1.0 - 1e-10) * gap
        lowest = brentq(lambda x, away=away: -np.sum(h**2 / (away + x) ** 3), *edges)
        if np.linalg.norm(h / (away + lowest)) < rate:
            found += [root(j, lowest, 1.0), root(j + 1, gap - lowest, -1.0)]
    return found


def vertical_rotation_rates(
    inertia: ArrayLike,
    c_b: ArrayLike,
    gradient: float = 0.0,
    weight_moment: ArrayLike = (0.0, 0.0, 0.0),
    rotor_momentum: ArrayLike = (0.0, 0.0, 0.0),
) -> np.ndarray | None:
    """
    Return the rates W (M,) [rad/s] of uniform rotation about a field's fixed direction.

    c x (W^2 I c + W h - gradient I c - m) = 0.  None: at any rate.  A rigid body has
    W = +-sqrt(gradient) at any c (Agostinelli 1977, nu = 0).

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        I
    c_b : (3,), body axes
        c, the direction of the field
    gradient : 1/s^2
        3 mu / r^3
    weight_moment : (3,), N m, body axes
        m
    rotor_momentum : (3,), N m s, body axes
        h
    """
    c, I = np.asarray(c_b, float), np.asarray(inertia, float)
    h, m = np.asarray(rotor_momentum, float), np.asarray(weight_moment, float)
    square, linear = np.cross(c, I @ c), np.cross(c, h)
    constant = -gradient * square - np.cross(c, m)
    sizes = [
        np.max(I),
        np.linalg.norm(h),
        abs(gradient) * np.max(I) + np.linalg.norm(m),
    ]
    terms = [
        term if np.linalg.norm(term) > ROUNDING * size else np.zeros(3)
        for term, size in zip((square, linear, constant), sizes, strict=True)
    ]
    largest = next((term for term in terms if np.any(term)), None)
    if largest is None:
        return None
    rates = np.roots([term @ largest for term in terms])
    rates = np.sort(rates.real[np.abs(rates.imag) <= ROUNDING * np.abs(rates)])
    return np.array([W for W in rates if _is_zero([W * W, W, 1.0], terms)])


def _is_zero(factors, terms):
    """Whether the sum of factor * term (3,) is zero but for rounding."""
    parts = [factor * term for factor, term in zip(factors, terms, strict=True)]
    size = sum(np.linalg.norm(part) for part in parts)
    return np.linalg.norm(sum(parts)) <= ROUNDING * size


def vertical_axes(
    inertia: np.ndarray,
    carrier: np.ndarray,
    rate: float,
    gradient: float = 0.0,
    weight_moment: np.ndarray | tuple[float, ...] = (0.0, 0.0, 0.0),
    h: ArrayLike = (0.0, 0.0, 0.0),
) -> np.ndarray:
    """
    Return all c (M, 3), directions of the field in a body that turns about them at a rate.

    c x ((W^2 K - gradient I) c + W h - m) = 0 is the equation of permanent rotations.  The
    principal axes represent a circle of axes, or all axes where each is one.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        I, on which the field acts
    carrier : (3, 3), kg m^2, body axes
        K, which turns with the body
    rate : rad/s
        W
    gradient : 1/s^2
        3 mu / r^3
    weight_moment : (3,), N m, body axes
        m
    h : (3,), N m s, body axes
        momentum of the rotors
    """
    turning, field = rate**2 * np.asarray(carrier), gradient * np.asarray(inertia)
    matrix, vector = turning - field, rate * np.asarray(h) - np.asarray(weight_moment)
    if np.max(np.abs(matrix)) <= ROUNDING * np.max(np.abs(field)):
        matrix = np.zeros((3, 3))
    return permanent_rotations(matrix, 1.0, vector)


def relative_equilibria(inertia: np.ndarray) -> np.ndarray:
    """
    Return the attitudes q_lb (24, 4), body to LVLH, where a rigid body rests on a circular orbit.

    They put the principal axes along those of LVLH; a body of three different moments has no
    others.  The first has its axes x ahead, y against the normal and z down.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        of the body
    """
    _, R_bp = principal_axes(inertia)
    attitudes = []
    for order in permutations(range(3)):
        for signs in product([1.0, -1.0], repeat=3):
            R_lp = np.eye(3)[:, order] * signs
            if np.linalg.det(R_lp) > 0.0:
                attitudes.append(rotation.from_matrix(R_lp @ R_bp.T))
    return np.array(attitudes)


def equilibrium_momentum(
    inertia: np.ndarray, q_lb: np.ndarray, orbital_rate: float, along_normal: float = 0.0
) -> np.ndarray:
    """
    Return the rotor momentum (3,) [N m s] that balances an attitude on a circular orbit.

    It is relative to the body, in body axes: b x k + h_k k with b = 3 n c x I c - n k x I k.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        I, of the whole body
    q_lb : (4,)
        attitude, body to LVLH
    orbital_rate : rad/s
        n
    along_normal : N m s
        h_k, which is free

    Raises
    ------
    ValueError
        the gravity gradient has a pitch torque there, which no constant momentum balances
    """
    ahead, down = rotation.rotate(rotation.conjugate(q_lb), np.eye(3)[[0, 2]])
    c, k = -down, np.cross(-down, ahead)
    pitch = ahead @ inertia @ c
    if abs(pitch) > ROUNDING * np.max(inertia):
        raise ValueError(
            f'the attitude has the product of inertia {pitch:g} kg m^2 between up and ahead, and '
            'a constant rotor momentum cannot balance a pitch torque: it must be 0'
        )
    b = orbital_rate * (3.0 * np.cross(c, inertia @ c) - np.cross(k, inertia @ k))
    return np.cross(b, k) + along_normal * k


def at_rest_in_lvlh(orbit: KeplerOrbit, q_lb: np.ndarray, orbit_s: float = 0.0) -> State:
    """Return the state of a body that keeps the attitude q_lb (4,) to LVLH, without a rotor."""
    q_ib = rotation.multiply(orbit.lvlh(orbit_s), q_lb)
    return State(q_ib, rotation.rotate(rotation.conjugate(q_ib), orbit.lvlh_rate(orbit_s)))

"""
Whether a uniform rotation or relative equilibrium is stable, to first order.

For axes r (up), t (ahead) and n (orbit normal) principal and a rotor momentum h along n, on a
circular orbit of rate n, the small turns x from LVLH to the body follow (Hughes, Spacecraft
Attitude Dynamics, 1986)

    I_n x_n'' + 3 n^2 (I_t - I_r) x_n = 0                                                 pitch
    I_t x_t'' - G x_r' + (4 n^2 (I_n - I_r) + n h) x_t = 0                                roll
    I_r x_r'' + G x_t' + (n^2 (I_n - I_t) + n h) x_r = 0,  G = n (I_n - I_t - I_r) + h    yaw
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.system import State, System
from .equilibria import direction


def eigenvalue_squared(
    inertia: np.ndarray, omega: ArrayLike, rotor_momentum: ArrayLike = (0.0, 0.0, 0.0)
) -> float:
    """
    Return lambda^2 [1/s^2] of a permanent rotation of a free gyrostat: growth if positive.

    The eigenvalues of the linear equations are 0 and +-lambda.  About the principal axis j with
    the rotor along it, lambda^2 = -((I_j - I_k) W + h) ((I_j - I_l) W + h) / (I_k I_l), the
    textbook's (44.10) with the denominator corrected to I_1 I_2 I_3 in place of I_1 I_2^2 I_3.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        of what turns with the body
    omega : (3,), rad/s, body axes
        the rate
    rotor_momentum : (3,), N m s, body axes
        of the rotors

    Examples
    --------
    >>> eigenvalue_squared(np.diag([1.0, 2.0, 3.0]), [0.0, 1.0, 0.0])
    0.3333333333333333
    """
    H = inertia @ np.asarray(omega) + rotor_momentum
    matrix = np.linalg.solve(inertia, cross_matrices(H) - cross_matrices(omega) @ inertia)
    return float(np.trace(matrix @ matrix) / 2.0)


def attitude_drift(
    omega: ArrayLike, change: ArrayLike, duration_s: float | np.ndarray = 86400.0
) -> float | np.ndarray:
    """
    Return by how much a change of a permanent rotation turns the attitude [rad].

    It is |change . omega| / |omega| times duration_s.  A permanent rotation whose rate is stable
    is not stable in attitude (44.11, paragraph 44.16): neighbours at another rate get out of step,
    in the end by any angle.  A change across omega has an effect of second order only.

    Parameters
    ----------
    omega : (3,), rad/s, body axes
        the rate
    change : (3,), rad/s, body axes
        its small change
    duration_s : s
        the time

    Examples
    --------
    >>> round(attitude_drift([0.0, 0.0, 0.5], [0.0, 0.0, 0.5e-6]), 12)
    0.0432
    """
    omega = np.asarray(omega, float)
    rate = float(np.linalg.norm(omega))
    return abs(float(omega @ np.asarray(change))) / rate * duration_s if rate else 0.0


def eigenvalues(system: System, state: State, orbit_s: float = 0.0) -> np.ndarray:
    """
    Return the six eigenvalues [1/s] of small departures from a steady motion.

    With x the small turn from the steady attitude, c + c x x is the direction and x' = d omega -
    omega x x.  Rounding splits equal eigenvalues of opposite sign and pairs of zeros, by its
    square root relative to the largest.

    Parameters
    ----------
    system : System
        what moves
    state : State
        one in which omega and c stay in the body: a relative equilibrium on a circular orbit, a
        rotation about the fixed direction of the field, rest, or a rotation without a field
    orbit_s : s
        time from tick 0
    """
    return np.linalg.eigvals(
        linear_equations(
            system.inertia,
            system.carrier_inertia,
            system.rotor_momentum(state),
            state.omega_bi_b,
            direction(system, state, orbit_s),
            float(system.orbit.gradient_at(orbit_s)),
            system.weight_moment,
        )
    )


def linear_equations(
    inertia: np.ndarray,
    carrier: np.ndarray,
    h: np.ndarray,
    omega: np.ndarray,
    c: np.ndarray,
    gradient: float,
    weight_moment: np.ndarray,
) -> np.ndarray:
    """
    Return the matrix (6, 6) of (d omega, x)' for small departures from a steady motion.

    It follows from K omega' = (K omega + h) x omega + gradient c x I c - m x c.

    Parameters
    ----------
    inertia : (3, 3), kg m^2
        I, on which the field acts
    carrier : (3, 3), kg m^2
        K, which turns with omega
    h : (3,), N m s
        momentum of the rotors
    omega : (3,), rad/s
        the rate
    c : (3,)
        unit vector from the attracting centre
    gradient : 1/s^2
        3 mu / r^3
    weight_moment : (3,), N m
        m
    """
    turned, H = cross_matrices(c), carrier @ omega + h
    field = gradient * (turned @ inertia - cross_matrices(inertia @ c)) - cross_matrices(
        weight_moment
    )
    rate_to_rate = np.linalg.solve(carrier, cross_matrices(H) - cross_matrices(omega) @ carrier)
    turn_to_rate = np.linalg.solve(carrier, field @ turned)
    return np.block([[rate_to_rate, turn_to_rate], [np.eye(3), -cross_matrices(omega)]])


class SmallMotion(NamedTuple):
    """
    The squares s^2 [1/s^2] of the eigenvalues of small motion about a relative equilibrium.

    Attributes
    ----------
    pitch : float
        of the pitch, real
    roll_yaw : (2,)
        of roll and yaw, the fast one first, complex if the roots are
    """

    pitch: float
    roll_yaw: np.ndarray

    @property
    def is_stable(self) -> bool:
        """Whether all motion is oscillation: every s^2 real, negative and different."""
        fast, slow = self.roll_yaw
        real = fast.imag == 0.0 and slow.imag == 0.0
        return bool(self.pitch < 0.0 and real and fast.real < slow.real < 0.0)

    @property
    def frequencies(self) -> np.ndarray:
        """Return those of pitch and of fast and slow roll-yaw [rad/s] (3,); nan for none."""
        squares = np.array([self.pitch, *self.roll_yaw], complex)
        oscillates = (squares.imag == 0.0) & (squares.real <= 0.0)
        return np.where(oscillates, np.sqrt(np.abs(squares.real)), np.nan)


def small_motion(
    I_r: float, I_t: float, I_n: float, orbital_rate: float, h: float = 0.0
) -> SmallMotion:
    """
    Return the small motion about a relative equilibrium.

    Parameters
    ----------
    I_r, I_t, I_n : kg m^2
        moments up, ahead, along the normal
    orbital_rate : rad/s
        of a circular orbit
    h : N m s
        rotor momentum along the normal, constant

    Examples
    --------
    >>> small_motion(600, 800, 900, 1.0).frequencies
    array([0.81649658, 1.43754092, 0.34781619])
    """
    n = orbital_rate
    G = n * (I_n - I_t - I_r) + h
    yaw, roll = n * n * (I_n - I_t) + n * h, 4.0 * n * n * (I_n - I_r) + n * h
    # I_r I_t s^4 + (I_r roll + I_t yaw + G^2) s^2 + yaw roll = 0
    a, b, c = I_r * I_t, I_r * roll + I_t * yaw + G * G, yaw * roll
    root = np.sqrt(complex(b * b - 4.0 * a * c))
    # The root without cancellation first, the other by their product.
    fast = -(b + (root if b >= 0.0 else -root)) / (2.0 * a)
    slow = c / (a * fast) if fast != 0.0 else fast
    squares = np.array(sorted([fast, slow], key=abs, reverse=True))
    return SmallMotion(-3.0 * n * n * (I_t - I_r) / I_n, squares)


def is_surely_stable(
    I_r: float, I_t: float, I_n: float, orbital_rate: float, h: float = 0.0
) -> bool:
    """Whether the amended potential has a minimum, which proves it without linearisation."""
    n = orbital_rate
    return bool(I_t > I_r and n * (I_n - I_t) + h > 0.0 and 4.0 * n * (I_n - I_r) + h > 0.0)


def smelt_parameters(I_r: float, I_t: float, I_n: float) -> tuple[float, float]:
    """Return k_R = (I_n - I_r) / I_t and k_Y = (I_n - I_t) / I_r of a body without a rotor."""
    return (I_n - I_r) / I_t, (I_n - I_t) / I_r


def smelt_moments(k_R: float, k_Y: float) -> tuple[float, float, float]:
    """
    Return moments I_r, I_t, I_n, up to a common factor, that have these Smelt parameters.

    Every -1 < k_R, k_Y < 1 has a body: the triangle inequalities are (1 -+ k_R) (1 -+ k_Y) > 0.

    Parameters
    ----------
    k_R, k_Y : -1 to 1
        (I_n - I_r) / I_t and (I_n - I_t) / I_r

    Examples
    --------
    >>> smelt_parameters(*smelt_moments(0.5, 0.25))
    (0.5, 0.25)
    """
    return 1.0 - k_R, 1.0 - k_Y, 1.0 - k_R * k_Y


def stability_region(I_r: float, I_t: float, I_n: float) -> str | None:
    """
    Return 'Lagrange' or 'DeBra-Delp', the region of stability of the moments, or None.

    Lagrange: I_n > I_t > I_r, stable in the non-linear sense.  DeBra and Delp 1961: k_Y < k_R < 0
    and 1 + 3 k_R + k_R k_Y > 4 sqrt(k_R k_Y), gyroscopic stability, lost with damping.  The
    boundaries belong to neither.

    Parameters
    ----------
    I_r, I_t, I_n : kg m^2
        moments up, ahead, along the normal

    Examples
    --------
    >>> stability_region(600, 800, 900)
    'Lagrange'
    """
    k_R, k_Y = smelt_parameters(I_r, I_t, I_n)
    if k_R > k_Y > 0.0:
        return 'Lagrange'
    if 0.0 > k_R > k_Y and 1.0 + 3.0 * k_R + k_R * k_Y > 4.0 * np.sqrt(k_R * k_Y):
        return 'DeBra-Delp'
    return None


def cross_matrices(a: ArrayLike) -> np.ndarray:
    """Return the matrices (..., 3, 3) of a x for vectors a (..., 3)."""
    x, y, z = np.moveaxis(np.asarray(a, float), -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

"""
What rolls on what: Poinsot's curves of a free body, Paladini's quadric of a symmetric one.

A body about a fixed point moves as the cone of its instantaneous axes rolls on that in space.
For a free body the contact point xi = omega / sqrt(2 E) draws the polhode on the inertia
ellipsoid and the herpolhode on a fixed plane.  For a symmetric body under U = H1 u^2 + H2 u the
cone whose base is a plane curve rolls on a quadric of revolution about the vertical.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from ..dynamics.inertia import ROUNDING, are_parallel, principal_axes
from ..kernel import rotation
from .elliptic import LAST_DIGITS

# A sum of terms this much smaller than they are is zero: the constants of a motion have rounding.
AT_ZERO = 1e-14


def polhode(inertia: np.ndarray, omega: ArrayLike, angle_rad: np.ndarray) -> np.ndarray:
    """
    Return points (N, 3) of a polhode, in body axes.

    sum I_j xi_j^2 = 1 and sum I_j^2 xi_j^2 = L^2 / 2E.  On the separatrix, two curves that cross,
    it draws the halves towards omega; for a rotation about a principal axis it is a point.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        of the body
    omega : (3,), rad/s, body axes
        a rate on it
    angle_rad : (N,), rad
        around the axis that the curve encloses; a whole turn draws it all
    """
    omega, moments, R_bp = np.asarray(omega, float), *principal_axes(inertia)
    w = R_bp.T @ omega
    square = moments * w**2
    if are_parallel(omega, inertia @ omega):
        return np.tile(omega / np.sqrt(np.sum(square)), (len(angle_rad), 1))
    # L^2 - 2 E I_j without cancellation; the axis enclosed is the largest or smallest moment's.
    excess = [np.sum((moments - moments[j]) * square) for j in range(3)]
    low, middle, high = np.argsort(moments, kind='stable')
    p, o = (high, low) if excess[middle] >= 0.0 else (low, high)
    xi = np.zeros((len(angle_rad), 3))
    for j, wave in ((o, np.cos(angle_rad)), (middle, np.sin(angle_rad))):
        gap = moments[p] - moments[j]
        reach = -excess[p] / (moments[j] * gap) if gap != 0.0 else 0.0
        xi[:, j] = np.sqrt(max(reach, 0.0)) * wave
    left = np.sum(square) - xi**2 @ moments
    xi[:, p] = np.copysign(np.sqrt(np.maximum(left, 0.0) / moments[p]), w[p])
    return xi @ R_bp.T / np.sqrt(np.sum(square))


def herpolhode(inertia: np.ndarray, q_ib: np.ndarray, omega_bi_b: np.ndarray) -> np.ndarray:
    """
    Return points (N, 2) of the herpolhode, in the invariable plane about the foot of L.

    The plane is at the distance sqrt(2 E) / L along L, and its first axis is that of inertial x,
    projected (of y, for L along x).

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        of the body
    q_ib : (N, 4)
        attitudes of a free motion
    omega_bi_b : (N, 3), rad/s, body axes
        its rates
    """
    momentum = rotation.rotate(q_ib[0], inertia @ omega_bi_b[0])
    normal = momentum / np.linalg.norm(momentum)
    k = 0 if abs(normal[0]) < 0.9 else 1
    first = np.eye(3)[k] - normal[k] * normal
    first /= np.linalg.norm(first)
    contact = rotation.rotate(q_ib, omega_bi_b) / np.sqrt(omega_bi_b[0] @ inertia @ omega_bi_b[0])
    return contact @ np.stack([first, np.cross(normal, first)], axis=-1)


def herpolhode_rate(inertia: np.ndarray, omega_bi_b: np.ndarray) -> np.ndarray:
    """
    Return the rate (N,) [rad/s] at which the herpolhode turns about L; it is never negative.

    (O' . I O') / (L (|O|^2 - 4 E^2 / L^2)) for the rate O of a free body; nan for a rotation about
    a principal axis, whose herpolhode is a point.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        of the body
    omega_bi_b : (N, 3), rad/s, body axes
        rates O of a free motion
    """
    momentum = omega_bi_b @ inertia
    L = np.linalg.norm(momentum, axis=-1)
    torque = np.cross(momentum, omega_bi_b)
    change = np.sum(torque * np.linalg.solve(inertia, torque.T).T, axis=-1)
    # |O|^2 - (O . L / |L|)^2, the square of the part of O across L.
    across = np.sum(np.cross(omega_bi_b, momentum) ** 2, axis=-1) / L**2
    return np.divide(change, L * across, out=np.full(len(L), np.nan), where=across > 0.0)


@dataclass(frozen=True)
class Rolling:
    """
    The cone and the quadric of a symmetric motion (Paladini 1888, ch. 1).

    The pole v = R omega is on v_x^2 + v_y^2 = c2 v_z^2 + c1 v_z + c0 [rad/s], or on the plane
    v_z = g / A where Delta = J3 - A r0 is zero.

    Parameters
    ----------
    A : kg m^2
        moment across the axis
    J3 : N m s
        C r0 + h3
    r0 : rad/s
        rate about the axis
    g, h_prime, H1, H2 : N m s, J, J, J
        as in exact/symmetric.py

    Examples
    --------
    >>> Rolling.of(Symmetric(system, state)).kind  # doctest: +SKIP
    'ellipsoid'
    """

    A: float
    J3: float
    r0: float
    g: float
    h_prime: float
    H1: float
    H2: float

    @classmethod
    def of(cls, motion: Any) -> 'Rolling':
        """Return the rolling of an exact motion (symmetric.Symmetric)."""
        J3 = motion.C * motion.r0 + motion.h3
        return cls(motion.A, J3, motion.r0, motion.g, motion.h_prime, motion.H1, motion.H2)

    @property
    def Delta(self) -> float:
        """Return J3 - A r0 [N m s]; zero to rounding of all rates is zero."""
        difference = self.J3 - self.A * self.r0
        energies = abs(self.h_prime) + abs(self.H1) + abs(self.H2)
        size = abs(self.J3) + abs(self.A * self.r0) + np.sqrt(2.0 * self.A * energies)
        return difference if abs(difference) > ROUNDING * size else 0.0

    @property
    def coefficients(self) -> tuple[float, float, float]:
        """Return c2, c1 [rad/s] and c0 [rad^2/s^2]; infinite c2 and nan beside for a plane."""
        A, H1, H2, Delta = self.A, self.H1, self.H2, self.Delta
        if Delta == 0.0:
            return np.inf, np.nan, np.nan
        # u = al + be v_z
        al, be = self.g / Delta, -A / Delta
        c2 = 2.0 * A * H1 / Delta**2 - 1.0
        c1 = 2.0 / A * (2.0 * H1 * al + H2) * be
        c0 = self.r0**2 + 2.0 / A * (self.h_prime + H1 * al**2 + H2 * al)
        return c2, c1, c0

    @property
    def kind(self) -> str:
        """
        Return the quadric's name; the paper has three of them; here the limits are included.

        'ellipsoid', 'sphere', 'paraboloid', 'cylinder', 'hyperboloid of one sheet', 'hyperboloid
        of two sheets', 'cone' or 'plane'.
        """
        if self.Delta == 0.0:
            return 'plane'
        if self.H1 == 0.0:
            return 'sphere'
        c2, c1, c0 = self.coefficients
        if abs(c2) <= ROUNDING:
            slope = 2.0 * self.H1 * self.g / self.Delta + self.H2
            size = abs(2.0 * self.H1 * self.g / self.Delta) + abs(self.H2)
            return 'cylinder' if abs(slope) <= ROUNDING * size else 'paraboloid'
        if c2 < 0.0:
            return 'ellipsoid'
        discriminant = c1 * c1 - 4.0 * c2 * c0
        al = self.g / self.Delta
        parts = abs(self.h_prime) + abs(self.H1) * al**2 + abs(self.H2 * al)
        size = c1 * c1 + 4.0 * abs(c2) * (self.r0**2 + 2.0 / self.A * parts)
        if abs(discriminant) <= ROUNDING * size:
            return 'cone'
        return f'hyperboloid of {"two sheets" if discriminant > 0.0 else "one sheet"}'

    def space_radius(self, u: ArrayLike) -> np.ndarray:
        """Return the pole's distance from Z in space, (N,) [rad/s], at u = cos theta (42)."""
        return np.sqrt(np.maximum(self._square_in_space(np.asarray(u, float)), 0.0))

    def residual(self, v_i: ArrayLike) -> np.ndarray:
        """
        Return by how much poles v_i (N, 3) [rad/s] miss the quadric [rad^2/s^2] or plane [rad/s].

        v_i: the angular velocity in space with its third axis the field's direction.
        """
        x, y, z = np.moveaxis(np.asarray(v_i, float), -1, 0)
        if self.Delta == 0.0:
            return z - self.g / self.A
        c2, c1, c0 = self.coefficients
        return x * x + y * y - ((c2 * z + c1) * z + c0)

    def polar_radius(self, u: ArrayLike) -> np.ndarray:
        """
        Return the pole's distance from axis 3 in the body, (N,) [rad/s], at u = cos theta.

        sqrt(p^2 + q^2), with r0 the third coordinate: the base of the cone is a plane curve.
        """
        u = np.asarray(u, float)
        return np.sqrt(np.maximum(2.0 / self.A * (self.h_prime + (self.H1 * u + self.H2) * u), 0))

    def polar_limits(self, lowest_u: float, highest_u: float) -> tuple[float, float]:
        """Return the least and greatest polar radius [rad/s] while u is between two values."""
        turning = [lowest_u, highest_u]
        if self.H1 != 0.0 and lowest_u < -self.H2 / (2.0 * self.H1) < highest_u:
            turning.append(-self.H2 / (2.0 * self.H1))
        radii = self.polar_radius(turning)
        return float(np.min(radii)), float(np.max(radii))

    def polar_rate(self, u: ArrayLike) -> np.ndarray:
        """
        Return the rate (N,) [rad/s] at which the pole turns about axis 3 in the body (41).

        Delta / A + ((g - J3 u) / A) (rho^2)' / (2 rho^2), the prime d/du; at a cusp of the path of
        the axis, where p = q = 0, the limit.
        """
        return self.turning_in_body.rate(np.asarray(u, float))

    @property
    def turning_in_body(self) -> 'Winding':
        """Return how the pole turns about axis 3."""
        turn = Polynomial([self.Delta / self.A])
        across = Polynomial([self.g / self.A, -self.J3 / self.A])
        return Winding(turn, across, self._square_in_body)

    @property
    def turning_in_space(self) -> 'Winding':
        """Return how the pole turns about Z."""
        turn = Polynomial([0.0, self.Delta / self.A])
        across = Polynomial([-self.r0, self.g / self.A, -self.Delta / self.A])
        return Winding(turn, across, self._square_in_space)

    @property
    def _square_in_body(self):
        """The square of polar_radius as a polynomial in u."""
        return Polynomial([self.h_prime, self.H2, self.H1]) * (2.0 / self.A)

    @property
    def _square_in_space(self):
        """The square of space_radius, rho^2 + r0^2 - v_z^2, as a polynomial in u."""
        v_z = Polynomial([self.g / self.A, -self.Delta / self.A])
        return self._square_in_body + self.r0**2 - v_z**2


class Winding(NamedTuple):
    """
    The turning of a pole at the rate turn + across square' / (2 square), polynomials in u.

    square: that of its distance from the centre.  f = (1 - u^2) square - across^2: where square
    has a zero that u reaches, across has it too.
    """

    turn: Polynomial
    across: Polynomial
    square: Polynomial

    def rate(self, u: np.ndarray, through: Sequence[float] | None = None) -> np.ndarray:
        """
        Return the rate [rad/s] at u.

        through: where the pole is known to pass through the centre; else what rounding decides.
        """
        across, square = self.across, self.square
        if np.max(np.abs(across.coef)) <= LAST_DIGITS * np.sqrt(np.sum(np.abs(square.coef))):
            return self.turn(u)
        product = across * square.deriv() / 2.0
        zeros = across.roots().real if through is None else through
        for zero in zeros:
            known = through is not None
            while square.degree() and (known or _is_zero(square, zero)):
                factor, known = Polynomial([-zero, 1.0]), False
                product, square = product // factor, square // factor
        return self.turn(u) + product(u) / square(u)

    def rate_at(self, u: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """Return the rate [rad/s] at u and the distance from the centre, which has its digits."""
        return self.turn(u) + self.across(u) * self.square.deriv()(u) / 2.0 / distance**2


def _is_zero(polynomial, u):
    """Whether a polynomial is zero at u but for rounding of its terms."""
    terms = polynomial.coef * u ** np.arange(len(polynomial.coef))
    return abs(np.sum(terms)) <= AT_ZERO * np.sum(np.abs(terms))

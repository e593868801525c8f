"""
The solid in an unbounded ideal fluid: Kirchhoff's equations of a symmetric body.

Paladini 1888 ch. 2, for the body of fluid.py with theta measured from the constant impulse P0 e_z
to the axis.  The attitude is that of a symmetric body about a fixed point, R*, with two more
turns:

    R(t) = Rz(Oz t) R*(t) Rz(-kappa int cos(theta) dt).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.system import State
from ..kernel import rotation
from .axes import ROUNDING
from .fluid import E_Z, FluidBody
from .symmetric import Symmetric

# Gauss-Legendre nodes and weights on [0, 1].
NODES, WEIGHTS = (np.polynomial.legendre.leggauss(16) + np.array([[1.0], [0.0]])) / 2.0


@dataclass(frozen=True, eq=False)
class FluidStates:
    """
    A table of N states of one motion.

    Attributes
    ----------
    t_s : (N,), s
        since the motion began
    q_ib : (N, 4)
        attitude, body to inertial
    omega_bi_b : (N, 3), rad/s, body axes
        rate of the body relative to inertial axes
    v_b : (N, 3), m/s, body axes
        velocity of O
    x_i : (N, 3), m, inertial, z along the impulse
        position of O
    """

    t_s: np.ndarray
    q_ib: np.ndarray
    omega_bi_b: np.ndarray
    v_b: np.ndarray
    x_i: np.ndarray


class Immersed:
    """
    The motion of a fluid body from an attitude, a rate and a position.

    The attitude is that of the symmetric body `equivalent` (moments A_star, C_star [kg m^2],
    potential H1_star, H2_star [J]), turned in addition at Oz [rad/s] about z and at -kappa
    cos(theta) [rad/s] about the axis (Paladini 1888, ch. 2, eq. 12).

    Parameters
    ----------
    body : FluidBody
        the solid and the fluid around it
    q_ib : (4,)
        attitude at the start
    omega_bi_b : (3,), rad/s, body axes
        rate at the start
    P0 : N s
        impulse of body and fluid along the inertial z axis, from which the potential's theta is
        measured too; it may be negative or zero
    x_i : (3,), m, inertial
        position at the start

    Attributes
    ----------
    G3 : N m s
        the impulsive moment about the axis
    g : N m s
        the impulsive moment along the impulse
    energy : J
        T - U

    Examples
    --------
    >>> Immersed(body, [0.1, 0.5, 0.7, 0.5], [0.3, -0.2, 1.1], P0=1.5).at(15.0)  # doctest: +SKIP
    """

    name = 'solid in an ideal fluid'
    source = 'Paladini 1888, ch. 2'

    def __init__(
        self,
        body: FluidBody,
        q_ib: np.ndarray | Sequence[float],
        omega_bi_b: np.ndarray | Sequence[float],
        P0: float,
        x_i: np.ndarray | Sequence[float] = (0.0, 0.0, 0.0),
    ):
        if not body.is_symmetric:
            raise ValueError(
                'a22, a55 or a25 is not a11, a44 or a14: such a solid has no closed form here; '
                'FluidBody.kirchhoff has its equations'
            )
        self.body, self.P0, self._x0 = body, P0, np.asarray(x_i, float)
        self._q_frame = rotation.IDENTITY
        D, D_prime = body.D, body.D_prime
        self.A_star, self.C_star = D / body.a11, D_prime / body.a33
        self.Oz = -body.a14 * P0 / D
        self.kappa = P0 * (body.a36 / D_prime - body.a14 / D)
        q_ib = np.asarray(q_ib, float)
        gamma = rotation.rotate(rotation.conjugate(q_ib), E_Z)
        omega_star = omega_bi_b - self.Oz * gamma + self.kappa * gamma[2] * E_Z
        G3 = self.C_star * omega_star[2]
        self.G3 = float(G3)
        v_b = body.velocity(P0 * gamma, np.asarray(omega_bi_b, float))
        self.g = float(body.momenta(v_b, np.asarray(omega_bi_b, float))[1] @ gamma)
        self.energy = float(body.energy(q_ib, v_b, np.asarray(omega_bi_b, float)))
        self.H1_star = body.H1 + P0**2 / 2.0 * (body.a44 / D - body.a66 / D_prime)
        self.H2_star = body.H2 + G3 * self.kappa
        self.equivalent = Symmetric.in_potential(
            self.A_star, self.C_star, 0.0, self.H1_star, self.H2_star, State(q_ib, omega_star)
        )
        self._nutation = self.equivalent.flow.nutation
        self._set_panels()

    @classmethod
    def from_velocity(
        cls,
        body: FluidBody,
        q_ib: np.ndarray | Sequence[float],
        omega_bi_b: np.ndarray | Sequence[float],
        v_b: np.ndarray | Sequence[float],
        x_i: np.ndarray | Sequence[float] = (0.0, 0.0, 0.0),
    ) -> 'Immersed':
        """
        Return the motion from an attitude, a rate and a velocity.

        Without a potential the impulse may have any direction, and the states are in the inertial
        axes of q_ib and x_i.

        Parameters
        ----------
        body : FluidBody
            the solid and the fluid around it
        q_ib : (4,)
            attitude at the start
        omega_bi_b : (3,), rad/s, body axes
            rate at the start
        v_b : (3,), m/s, body axes
            velocity at the start
        x_i : (3,), m, inertial
            position at the start

        Raises
        ------
        ValueError
            there is a potential, and the impulse is not along its axis, inertial z: such a motion
            has no closed form here
        """
        q_ib, omega_bi_b = rotation.normalise(q_ib), np.asarray(omega_bi_b, float)
        impulse_b, _ = body.momenta(np.asarray(v_b, float), omega_bi_b)
        impulse_i = rotation.rotate(q_ib, impulse_b)
        size = float(np.linalg.norm(impulse_i))
        if np.linalg.norm(impulse_i[:2]) <= ROUNDING * size:
            return cls(body, q_ib, omega_bi_b, float(impulse_i[2]), x_i)
        if body.H1 != 0.0 or body.H2 != 0.0:
            raise ValueError(
                f'the impulse is [{", ".join(f"{x:g}" for x in impulse_i)}] N s; with H1 or H2 it '
                'must be along the inertial z axis, from which theta is measured'
            )
        frame = rotation.from_z_to(impulse_i / size)
        to_frame = rotation.conjugate(frame)
        start = rotation.multiply(to_frame, q_ib)
        motion = cls(body, start, omega_bi_b, size, rotation.rotate(to_frame, x_i))
        motion._q_frame = frame
        return motion

    def at(self, t_s: ArrayLike) -> FluidStates:
        """
        Return the states at some times, in any order; row i depends on t_s[i] alone.

        Parameters
        ----------
        t_s : float or (N,), s
            since the motion began

        Raises
        ------
        ValueError
            a time is negative or not finite
        """
        star = self.equivalent.at(t_s)
        t_s = star.t_s
        q, omega, v = self._without_own_turn(t_s, star.q_ib, star.omega_bi_b)
        turn = rotation.about(E_Z, self.kappa * self._nutation.integral(t_s))
        q_ib, x_i = rotation.multiply(q, rotation.conjugate(turn)), self._x0 + self._travel(t_s)
        if self._q_frame is not rotation.IDENTITY:
            q_ib = rotation.multiply(self._q_frame, q_ib)
            x_i = rotation.rotate(self._q_frame, x_i)
        return FluidStates(t_s, q_ib, rotation.rotate(turn, omega), rotation.rotate(turn, v), x_i)

    def _without_own_turn(self, t_s, q_star, omega_star):
        """Return q_ib, omega_bi_b and v_b without the turn -kappa int u dt about the axis."""
        q = rotation.multiply(rotation.about(E_Z, self.Oz * t_s), q_star)
        gamma = rotation.rotate(rotation.conjugate(q), E_Z)
        omega = omega_star + self.Oz * gamma - self.kappa * gamma[:, 2:] * E_Z
        return q, omega, self.body.velocity(self.P0 * gamma, omega)

    def _set_panels(self):
        """Divide two periods of u, after which the velocity is the same but for a turn about z."""
        period, imaginary, share = self._nutation.lattice
        turning_rate = self.equivalent.Om_P + self.Oz
        shortest = min(period, share * imaginary, 2.0 * np.pi / max(abs(turning_rate), 1e-300))
        self._period, self._panel = 2.0 * period, shortest / 5.0
        self._turn = 0.0
        if period < np.inf:
            self._panel = self._period / np.ceil(self._period / self._panel)
            self._turn = float(rotation.wrap(turning_rate * self._period))

    def _travel(self, t_s):
        """Return the integral of R v from 0 to t_s [m], (N, 3)."""
        n, rest = np.divmod(t_s, self._period)
        k = np.floor(rest / self._panel).astype(int)
        count = np.max(k, initial=0)
        if self._period < np.inf:
            count = int(np.rint(self._period / self._panel))
        starts = self._panel * np.arange(count)
        panels = np.zeros((count + 1, 3))
        panels[1:] = np.cumsum(self._travel_between(starts, starts + self._panel), axis=0)
        x = panels[k] + self._travel_between(k * self._panel, rest)
        # The n periods before are copies of the first, each turned by one turn more.
        angle, whole = n * self._turn, panels[-1]
        sum_of_turns = n * np.sinc(angle / (2.0 * np.pi)) / np.sinc(self._turn / (2.0 * np.pi))
        before = rotation.about(E_Z, (angle - self._turn) / 2.0)
        gone = rotation.rotate(before, whole) * np.stack([sum_of_turns, sum_of_turns, n], axis=-1)
        return gone + rotation.rotate(rotation.about(E_Z, angle), x)

    def _travel_between(self, start_s, stop_s):
        """Return the integral of R v from start_s to stop_s (N,) by Gauss-Legendre quadrature."""
        length = (stop_s - start_s)[:, None]
        t_s = (start_s[:, None] + length * NODES).ravel()
        # Where O goes does not depend on how the body is turned about its axis.
        q, _, v = self._without_own_turn(t_s, *self.equivalent.attitude(t_s))
        v_i = rotation.rotate(q, v).reshape(-1, len(NODES), 3)
        return length * np.sum(WEIGHTS[:, None] * v_i, axis=1)

"""
A solid in an unbounded ideal fluid at rest far away, and Kirchhoff's equations of its motion.

With body velocities v = (u, v, w) of its centre O and omega = (p, q, r),

    2 T = a11 (u^2 + v^2) + a33 w^2 + a44 (p^2 + q^2) + a66 r^2 + 2 a14 (u p + v q) + 2 a36 w r,

under the force function U = H1 cos^2(theta) + H2 cos(theta) (Paladini 1888, ch. 2).  A body of
three different axes has 2 T = a11 u^2 + a22 v^2 + a33 w^2 + a44 p^2 + a55 q^2 + a66 r^2 + 2 a14 u
p + 2 a25 v q + 2 a36 w r, and no closed form here.

Without couplings and potential, and with P = P0 c, Kirchhoff's equations are those of a satellite
in a fixed field,

    I omega' + omega x I omega = gradient c x I c,    P0^2 / a_i = gradient I_i + s,

for any s (Clebsch; Stekloff 1902 found it for De Brun's problem: Agostinelli 1977, sec. 1).
"""

from dataclasses import dataclass

import numpy as np

from ..dynamics.inertia import ROUNDING
from ..kernel import rotation

E_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class FluidBody:
    """
    A solid with the fluid around it, body axis 3 the axis, and its potential.

    The coefficients are those of the kinetic energy (Paladini 1888, ch. 2, eq. 2), which must be
    positive; a14 = a36 = 0 is Kirchhoff's body of revolution.

    Parameters
    ----------
    a11, a33 : kg
        masses across and along the axis
    a44, a66 : kg m^2
        moments across and about the axis
    a14, a36 : kg m
        couplings of velocity and rate
    H1, H2 : J
        force function H1 cos^2 theta + H2 cos theta, minus the potential energy
    a22, a55, a25 : kg, kg m^2, kg m
        those of axis 2; by default those of axis 1

    Raises
    ------
    ValueError
        the kinetic energy is not positive

    Examples
    --------
    >>> FluidBody(a11=2.0, a33=3.0, a44=1.0, a66=0.8, a14=0.3, a36=-0.4)  # doctest: +SKIP
    """

    a11: float
    a33: float
    a44: float
    a66: float
    a14: float = 0.0
    a36: float = 0.0
    H1: float = 0.0
    H2: float = 0.0
    a22: float | None = None
    a55: float | None = None
    a25: float | None = None

    def __post_init__(self) -> None:
        for second, first in (('a22', 'a11'), ('a55', 'a44'), ('a25', 'a14')):
            if getattr(self, second) is None:
                object.__setattr__(self, second, getattr(self, first))
        for name, value in vars(self).items():
            if not np.isfinite(value):
                raise ValueError(f'{name} is {value:g}; it must be finite')
        for name in ('a11', 'a22', 'a33', 'a44', 'a55', 'a66'):
            if getattr(self, name) <= 0.0:
                raise ValueError(f'{name} is {getattr(self, name):g}; it must be positive')
        for name, determinant, mass, inertia in zip(
            ('a14', 'a25', 'a36'),
            self.masses * self.inertias - self.couplings**2,
            ('a11', 'a22', 'a33'),
            ('a44', 'a55', 'a66'),
            strict=True,
        ):
            if determinant <= 0.0:
                raise ValueError(
                    f'{name} is {getattr(self, name):g}; its square must be less than {mass} '
                    f'{inertia} = {getattr(self, mass) * getattr(self, inertia):g}'
                )

    @property
    def D(self) -> float:
        """Return a11 a44 - a14^2."""
        return self.a11 * self.a44 - self.a14**2

    @property
    def D_prime(self) -> float:
        """Return a33 a66 - a36^2."""
        return self.a33 * self.a66 - self.a36**2

    @classmethod
    def of_satellite(
        cls, moments: np.ndarray, gradient: float, P0: float, s: float
    ) -> 'FluidBody':
        """
        Return the solid that turns as a satellite does in a field.

        Parameters
        ----------
        moments : (3,), kg m^2
            principal moments of the satellite about body axes 1, 2, 3
        gradient : 1/s^2
            of a field whose direction is that of the impulse
        P0 : N s
            the impulse
        s : N m
            any that makes a_i = P0^2 / (gradient I_i + s) positive
        """
        stiffness = gradient * np.asarray(moments, float) + s
        if not (P0 and np.min(stiffness) > 0.0):
            least = -np.min(gradient * np.asarray(moments, float))
            raise ValueError(f's is {s:g}; it must be above {least:g}, and P0 not 0')
        a11, a22, a33 = (float(a) for a in P0**2 / stiffness)
        a44, a55, a66 = (float(I) for I in moments)
        return cls(a11, a33, a44, a66, a22=a22, a55=a55)

    def satellite(self, P0: float) -> tuple[np.ndarray, float]:
        """
        Return moments (3,) [kg m^2] and gradient [1/s^2] of the satellite that turns alike.

        Parameters
        ----------
        P0 : N s
            the impulse

        Raises
        ------
        ValueError
            the solid has couplings or a potential, or P0^2 / a_i is not linear in its moments
            (Clebsch's condition)
        """
        if np.any(self.couplings) or self.H1 or self.H2:
            raise ValueError('the solid has a14, a25, a36, H1 or H2 that are not zero')
        I, stiffness = self.inertias, P0**2 / self.masses
        gradient, off = linear_fit(I, stiffness)
        if np.max(np.abs(off)) > ROUNDING * np.max(stiffness):
            raise ValueError('1 / a11, 1 / a22, 1 / a33 are not linear in a44, a55, a66')
        return I, gradient

    @property
    def is_symmetric(self) -> bool:
        """Whether axes 1 and 2 are alike, as the closed form has them."""
        return (self.a22, self.a55, self.a25) == (self.a11, self.a44, self.a14)

    @property
    def masses(self) -> np.ndarray:
        """Return a11, a22, a33 [kg] (3,)."""
        return np.array([self.a11, self.a22, self.a33])

    @property
    def couplings(self) -> np.ndarray:
        """Return a14, a25, a36 [kg m] (3,)."""
        return np.array([self.a14, self.a25, self.a36])

    @property
    def inertias(self) -> np.ndarray:
        """Return a44, a55, a66 [kg m^2] (3,)."""
        return np.array([self.a44, self.a55, self.a66])

    def momenta(self, v_b: np.ndarray, omega_bi_b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return the impulse P = dT/dv [N s] and the impulsive moment G = dT/domega [N m s].

        Both are of body and fluid, in body axes, (..., 3).

        Parameters
        ----------
        v_b : (..., 3), m/s, body axes
            velocity
        omega_bi_b : (..., 3), rad/s, body axes
            rate
        """
        P = self.masses * v_b + self.couplings * omega_bi_b
        return P, self.inertias * omega_bi_b + self.couplings * v_b

    def velocities(self, P: np.ndarray, G: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """
        Return v_b [m/s] and omega_bi_b [rad/s] (..., 3) with given momenta.

        Parameters
        ----------
        P : (..., 3), N s, body axes
            impulse
        G : (..., 3), N m s, body axes
            impulsive moment
        """
        determinants = self.masses * self.inertias - self.couplings**2
        omega_bi_b = (self.masses * G - self.couplings * P) / determinants
        return (self.inertias * P - self.couplings * G) / determinants, omega_bi_b

    def velocity(self, impulse_b: np.ndarray, omega_bi_b: np.ndarray) -> np.ndarray:
        """
        Return the velocity (..., 3) [m/s] in body axes with a given impulse and rate.

        Parameters
        ----------
        impulse_b : (..., 3), N s, body axes
            impulse
        omega_bi_b : (..., 3), rad/s, body axes
            rate
        """
        return (impulse_b - self.couplings * omega_bi_b) / self.masses

    def energy(self, q_ib: np.ndarray, v_b: np.ndarray, omega_bi_b: np.ndarray) -> np.ndarray:
        """
        Return the constant T - U [J] (...), theta in U measured from inertial z.

        Parameters
        ----------
        q_ib : (..., 4)
            attitude
        v_b : (..., 3), m/s, body axes
            velocity
        omega_bi_b : (..., 3), rad/s, body axes
            rate
        """
        P, G = self.momenta(v_b, omega_bi_b)
        u = rotation.rotate(q_ib, E_Z)[..., 2]
        kinetic = np.sum(P * v_b + G * omega_bi_b, axis=-1) / 2.0
        return kinetic - (self.H1 * u + self.H2) * u

    def kirchhoff(
        self, q_ib: np.ndarray, P: np.ndarray, G: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """
        Return q_ib', P' [N], G' [N m] and x_i' [m/s], by Kirchhoff's equations.

        P' = P x omega, G' = G x omega + P x v + N, x' = R v, with N = U'(u) e_3 x gamma the torque
        of the potential.

        Parameters
        ----------
        q_ib : (..., 4)
            attitude
        P : (..., 3), N s, body axes
            impulse
        G : (..., 3), N m s, body axes
            impulsive moment
        """
        v_b, omega_bi_b = self.velocities(P, G)
        gamma = rotation.rotate(rotation.conjugate(q_ib), E_Z)
        slope = 2.0 * self.H1 * gamma[..., 2:] + self.H2
        q_dot = rotation.multiply(q_ib, _without_real_part(omega_bi_b)) / 2.0
        G_dot = np.cross(G, omega_bi_b) + np.cross(P, v_b) + slope * np.cross(E_Z, gamma)
        return q_dot, np.cross(P, omega_bi_b), G_dot, rotation.rotate(q_ib, v_b)


def linear_fit(x: np.ndarray, y: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the slope of y (N,) as a linear function of x (N,), 0 for equal x, and the misses."""
    centred = x - np.mean(x)
    square = float(centred @ centred)
    slope = float(centred @ y) / square if square else 0.0
    return slope, y - np.mean(y) - slope * centred


def _without_real_part(v: np.ndarray) -> np.ndarray:
    """Return the vectors (..., 3) as quaternions (..., 4)."""
    v = np.asarray(v, float)
    return np.concatenate([v, np.zeros_like(v[..., :1])], axis=-1)

"""
What else turns as a satellite in a field of fixed direction does.

With the satellite's equations I omega' + omega x I omega = gradient c x I c, c' = c x omega,
Agostinelli (1977, sec. 1) names De Brun's problem, which is a negative gradient, the solid in a
fluid (fluid.py) and, by his theorem of 1962, a conducting fluid in an ellipsoidal vessel whose
vortex lines and lines of current are straight.  He gives no formulas for the last; those here are
derived in docs/theory/closed_forms.md, and with them those of a charged body in an electric field.
"""

from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0

from ..dynamics.inertia import ROUNDING
from .fluid import linear_fit


@dataclass(frozen=True)
class ConductingFluid:
    """
    An ideal incompressible fluid that conducts without loss, in an ellipsoidal vessel.

    The vessel does not turn and conducts as well.  Velocity and magnetic field are linear in the
    position r, and along the wall at the wall: r' = L(Omega) r and B = L(beta) r with
    L(v) r = S (v x S^-1 r), S the semi-axes.

    Parameters
    ----------
    semi_axes_m : (3,), m
        of the vessel
    density : kg/m^3
        of the fluid

    Raises
    ------
    ValueError
        a semi-axis or the density is not positive

    Examples
    --------
    >>> ConductingFluid(np.array([1.0, 1.2, 0.8]), density=1000.0)  # doctest: +SKIP
    """

    semi_axes_m: np.ndarray
    density: float

    def __post_init__(self) -> None:
        if not (np.min(self.semi_axes_m) > 0.0 and self.density > 0.0):
            raise ValueError(
                f'semi_axes_m is {self.semi_axes_m} and density {self.density:g}; all must be '
                'positive'
            )

    @classmethod
    def of_satellite(cls, moments: np.ndarray, density: float) -> 'ConductingFluid':
        """
        Return the fluid that moves as a satellite turns; frozen, it has the satellite's moments.

        Parameters
        ----------
        moments : (3,), kg m^2
            principal moments of the satellite
        density : kg/m^3
            of the fluid

        Raises
        ------
        ValueError
            no solid ellipsoid has these moments
        """
        moments = np.asarray(moments, float)
        # (5 / 2) (I_j + I_k - I_i) = M a_i^2
        squares = 2.5 * (np.sum(moments) - 2.0 * moments)
        if np.min(squares) <= 0.0:
            raise ValueError(f'moments is {moments}; each must be below the sum of the others')
        per_volume = 4.0 / 3.0 * np.pi * density
        volume = (np.prod(squares) / per_volume**3) ** 0.2
        return cls(np.sqrt(squares / (per_volume * volume)), density)

    @property
    def moments(self) -> np.ndarray:
        """Return the moments (3,) [kg m^2] of the satellite, those of the frozen fluid."""
        squares = np.square(self.semi_axes_m)
        mass = 4.0 / 3.0 * np.pi * self.density * np.prod(self.semi_axes_m)
        return mass / 5.0 * (np.sum(squares) - squares)

    def flow(
        self, omega_bi_b: np.ndarray, c_b: np.ndarray, gradient: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """
        Return Omega [rad/s] and beta [T/m] (..., 3) of the fluid for a satellite's state.

        Omega = -omega and beta = sqrt(mu_0 density gradient) c: the satellite's axes are those of
        the vessel.

        Parameters
        ----------
        omega_bi_b : (..., 3), rad/s, body axes
            the satellite's rate
        c_b : (..., 3), body axes
            unit vector from the attracting centre
        gradient : 1/s^2
            the satellite's gradient

        Raises
        ------
        ValueError
            the gradient is negative, as in De Brun's problem
        """
        if gradient < 0.0:
            raise ValueError(f'gradient is {gradient:g}; it must not be negative')
        return -np.asarray(omega_bi_b), np.sqrt(mu_0 * self.density * gradient) * np.asarray(c_b)

    def satellite(
        self, Omega: np.ndarray, beta: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """
        Return omega_bi_b [rad/s], c_b (3,) and the gradient [1/s^2] for the fluid's state.

        Parameters
        ----------
        Omega : (3,), rad/s
            of the velocity
        beta : (3,), T/m
            of the magnetic field
        """
        strength = float(np.linalg.norm(beta))
        if strength == 0.0:
            raise ValueError('beta is zero; without a magnetic field there is no direction c')
        gradient = strength**2 / (mu_0 * self.density)
        return -np.asarray(Omega), np.asarray(beta) / strength, gradient

    def linear(self, v: np.ndarray) -> np.ndarray:
        """Return the matrix L(v) (3, 3), r' or B of r, of Omega or beta (3,)."""
        turning = np.cross(np.eye(3), v)
        return self.semi_axes_m[:, None] * turning / self.semi_axes_m

    def vector(self, L: np.ndarray) -> np.ndarray:
        """Return the v (3,) of L(v), its inverse."""
        turning = L / self.semi_axes_m[:, None] * self.semi_axes_m
        return np.array([turning[2, 1], turning[0, 2], turning[1, 0]])


@dataclass(frozen=True)
class ChargedBody:
    """
    A charged body about a fixed point in an electric field E = slope ((c . r) c - r / 3).

    The field, free of curl and divergence, is that on the axis c of a source far off.

    Parameters
    ----------
    moments : (3,), kg m^2
        principal moments of the mass
    charge_moments : (3,), C m^2
        moments of the charge, about the same axes

    Examples
    --------
    >>> ChargedBody(np.array([1.0, 1.5, 2.2]), np.array([3.0, 4.5, 6.6]))  # doctest: +SKIP
    """

    moments: np.ndarray
    charge_moments: np.ndarray

    @classmethod
    def of_satellite(
        cls, moments: np.ndarray, gradient: float, slope: float, s: float = 0.0
    ) -> 'ChargedBody':
        """
        Return the body that turns in an electric field as a satellite does.

        Parameters
        ----------
        moments : (3,), kg m^2
            principal moments of the satellite
        gradient : 1/s^2
            the satellite's gradient
        slope : V/m^2
            of the field
        s : C m^2
            any, a share of the charge that is alike about all axes

        Raises
        ------
        ValueError
            there is no field
        """
        if slope == 0.0:
            raise ValueError('slope is 0; without a field there is no torque')
        moments = np.asarray(moments, float)
        return cls(moments, gradient / slope * moments + s)

    def satellite(self, slope: float) -> tuple[np.ndarray, float]:
        """
        Return moments (3,) [kg m^2] and gradient [1/s^2] of the satellite that turns alike.

        Parameters
        ----------
        slope : V/m^2
            of the field

        Raises
        ------
        ValueError
            the charge's moments are not linear in those of the mass
        """
        charge = np.asarray(self.charge_moments, float)
        ratio, off = linear_fit(self.moments, charge)
        if np.max(np.abs(off)) > ROUNDING * np.max(np.abs(charge)):
            raise ValueError('charge_moments are not linear in moments')
        return self.moments, slope * ratio

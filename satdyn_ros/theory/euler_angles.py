"""
Euler angles z-x-z: R_ab = Rz(P) Rx(theta) Rz(S) with theta from 0 to pi.

P is the precession about the fixed z, theta the nutation about the node and S the spin (proper
rotation) about the body's z.  The half-angle form has no singular matrix: the quaternion has

    w + i z = cos(theta / 2) exp(i (P + S) / 2),   x + i y = sin(theta / 2) exp(i (P - S) / 2).

Where theta is 0 or pi the node is not defined and S is taken as 0.
"""

import numpy as np
from numpy.typing import ArrayLike

from ..kernel import rotation

# Below this sine (cosine) of theta / 2 the direction of the node is rounding.
_POLE = 1e-12


def zxz_angles(q_ab: ArrayLike) -> np.ndarray:
    """
    Return precession, nutation and spin of frame b relative to frame a (..., 3) [rad].

    Parameters
    ----------
    q_ab : (..., 4)
        b to a

    Examples
    --------
    >>> zxz_angles(from_zxz(0.3, 1.1, -0.7))
    array([ 0.3,  1.1, -0.7])
    """
    x, y, z, w = np.moveaxis(np.asarray(q_ab, float), -1, 0)
    sine, cosine = np.hypot(x, y), np.hypot(z, w)
    half_sum, half_difference = np.arctan2(z, w), np.arctan2(y, x)
    regular = (sine > _POLE) & (cosine > _POLE)
    at_zero = sine <= _POLE
    spin = np.where(regular, half_sum - half_difference, 0.0)
    precession = np.where(
        regular, half_sum + half_difference, 2.0 * np.where(at_zero, half_sum, half_difference)
    )
    nutation = np.where(regular, 2.0 * np.arctan2(sine, cosine), np.where(at_zero, 0.0, np.pi))
    return np.stack([rotation.wrap(precession), nutation, rotation.wrap(spin)], axis=-1)


def from_zxz(
    precession_rad: ArrayLike, nutation_rad: ArrayLike, spin_rad: ArrayLike
) -> np.ndarray:
    """Return the quaternion q_ab of Rz(precession) Rx(nutation) Rz(spin), shape (..., 4)."""
    return rotation.multiply(
        rotation.about([0, 0, 1], precession_rad),
        rotation.multiply(
            rotation.about([1, 0, 0], nutation_rad), rotation.about([0, 0, 1], spin_rad)
        ),
    )


def zxz_rates(q_ab: ArrayLike, omega_ab_b: ArrayLike) -> np.ndarray:
    """
    Return the rates P', theta', S' (..., 3) [rad/s] of the angles.

    At theta = 0 or pi the rate theta' is that of leaving the pole, |omega perpendicular|,
    P' = +-omega_z and S' = 0.

    Parameters
    ----------
    q_ab : (..., 4)
        b to a
    omega_ab_b : (..., 3), rad/s, axes b
        rate of b relative to a
    """
    p, q, r = np.moveaxis(np.asarray(omega_ab_b, float), -1, 0)
    _, nutation, spin = np.moveaxis(zxz_angles(q_ab), -1, 0)
    sine, cosine = np.sin(nutation), np.cos(nutation)
    regular = (nutation > 0.0) & (nutation < np.pi)
    # p + i q = exp(-i S) (theta' + i P' sin theta)
    along_node = p * np.cos(spin) - q * np.sin(spin)
    across_node = p * np.sin(spin) + q * np.cos(spin)
    precession_rate = np.where(regular, across_node / np.where(regular, sine, 1.0), r * cosine)
    nutation_rate = np.where(regular, along_node, np.hypot(p, q))
    spin_rate = np.where(regular, r - precession_rate * cosine, 0.0)
    return np.stack([precession_rate, nutation_rate, spin_rate], axis=-1)


def rate_from_zxz(angles_rad: ArrayLike, rates: ArrayLike) -> np.ndarray:
    """
    Return the rate omega_ab_b (..., 3) [rad/s], by the textbook's (43.12).

    Parameters
    ----------
    angles_rad : (..., 3), rad
        P, theta, S
    rates : (..., 3), rad/s
        P', theta', S'
    """
    _, nutation, spin = np.moveaxis(np.asarray(angles_rad, float), -1, 0)
    precession_rate, nutation_rate, spin_rate = np.moveaxis(np.asarray(rates, float), -1, 0)
    across_node = precession_rate * np.sin(nutation)
    return np.stack(
        [
            nutation_rate * np.cos(spin) + across_node * np.sin(spin),
            across_node * np.cos(spin) - nutation_rate * np.sin(spin),
            spin_rate + precession_rate * np.cos(nutation),
        ],
        axis=-1,
    )


def node(q_ab: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the line of nodes, unit, in axes of a and of b, (..., 3) each.

    It is z_a x z_b over its length, (cos P, sin P, 0) in a and (cos S, -sin S, 0) in b; S counts
    as 0 where theta is 0 or pi.

    Parameters
    ----------
    q_ab : (..., 4)
        b to a
    """
    P, _, S = np.moveaxis(zxz_angles(q_ab), -1, 0)
    zero = np.zeros_like(P)
    in_a = np.stack([np.cos(P), np.sin(P), zero], axis=-1)
    return in_a, np.stack([np.cos(S), -np.sin(S), zero], axis=-1)


def kinetic_energy(moments: ArrayLike, angles_rad: ArrayLike, rates: ArrayLike) -> np.ndarray:
    """
    Return T (...) [J] of Euler's angles and their rates (textbook, 43.14).

    For I1 = I2 this is
    I1 (theta'^2 + P'^2 sin^2 theta) / 2 + I3 (S' + P' cos theta)^2 / 2 (43.15).

    Parameters
    ----------
    moments : (3,), kg m^2
        principal, about the axes that the angles turn
    angles_rad : (..., 3), rad
        P, theta, S
    rates : (..., 3), rad/s
        P', theta', S'
    """
    return np.square(rate_from_zxz(angles_rad, rates)) @ np.asarray(moments, float) / 2.0

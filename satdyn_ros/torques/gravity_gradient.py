"""The torque by which the field pulls more on what is nearer to the attracting centre."""

from typing import Any, NamedTuple

import numpy as np

from ..kernel.rows import components, from_components, times
from ..kernel.vector import apply, dot, scale
from .central_torque import CentralTorque


class GravityGradient(CentralTorque):
    """
    The torque (3 mu / r^3) c x I c of a point mass on a small body (Beletsky 1957, eq. 2).

    Its potential is V = (3 mu / 2 r^3) c . I c.
    """

    name = topic = 'gravity_gradient'
    title = 'gravity gradient'

    class Constants(NamedTuple):
        """inertia [kg m^2]: I, three rows or, where it has no more, the diagonal."""

        inertia: tuple[Any, ...]

    @staticmethod
    def field(
        c_b: tuple[float, ...], gradient: float, constants: Constants
    ) -> tuple[float, float, float]:
        """Return (3 mu / r^3) I c."""
        return scale(gradient, apply(constants.inertia, c_b))

    @staticmethod
    def orbit_power(
        c_b: tuple[float, ...],
        along_b: tuple[float, ...],
        gradient: float,
        turn_rate: float,
        growth_rate: float,
        constants: Constants,
    ) -> float:
        """Return v (3 mu / r^3) t . I c - 3 (r' / r) V, with c' = v t."""
        I_c = apply(constants.inertia, c_b)
        return gradient * (turn_rate * dot(I_c, along_b) - 1.5 * growth_rate * dot(I_c, c_b))


def gravity_gradient(
    inertia: np.ndarray, c_b: np.ndarray, gradient: float | np.ndarray
) -> np.ndarray:
    """
    Return the torque gradient c x I c [N m] in body axes, shape (..., 3).

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        I
    c_b : (..., 3), body axes
        unit vector from the attracting centre to the body
    gradient : (...), 1/s^2
        3 mu / r^3

    Examples
    --------
    >>> gravity_gradient(np.diag([1.0, 2.0, 3.0]), np.array([0.0, 0.6, 0.8]), 1.0)
    array([0.48, 0.  , 0.  ])
    """
    x, y, z = components(c_b)
    I_x, I_y, I_z = times(inertia, (x, y, z))
    torque = (y * I_z - z * I_y, z * I_x - x * I_z, x * I_y - y * I_x)
    return from_components([gradient * component for component in torque])

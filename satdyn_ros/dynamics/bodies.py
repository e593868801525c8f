"""Bodies put together from others, and the catalogue of homogeneous ones."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .inertia import parallel_axis


class Body(NamedTuple):
    """
    A body.

    Attributes
    ----------
    mass : kg
        of the body
    mass_centre : (3,), m
        its position
    inertia : (3, 3), kg m^2
        about that centre
    """

    mass: float
    mass_centre: np.ndarray
    inertia: np.ndarray


def compose(bodies: Iterable[Body]) -> Body:
    """
    Return the body that several bodies make together, all in the same axes.

    Parameters
    ----------
    bodies : bodies
        the parts

    Examples
    --------
    >>> bus = Body(9.0, np.zeros(3), sphere(9.0, 1.0))
    >>> boom = Body(1.0, np.array([0.0, 0.0, 20.0]), rod(1.0, 38.0))
    >>> compose([bus, boom]).mass_centre
    array([0., 0., 2.])
    """
    masses = np.array([body.mass for body in bodies])
    centres = np.array([body.mass_centre for body in bodies], float)
    mass = np.sum(masses)
    centre = masses @ centres / mass
    parts = [parallel_axis(body.inertia, body.mass, body.mass_centre - centre) for body in bodies]
    return Body(float(mass), centre, np.sum(parts, axis=0))


# The catalogue: homogeneous bodies, tensors about the mass centre with the symmetry axis along z.


def points(masses: ArrayLike, positions: ArrayLike, about: ArrayLike | None = None) -> np.ndarray:
    """
    Return the inertia (3, 3) [kg m^2] of point masses.

    Parameters
    ----------
    masses : (N,), kg
        the masses
    positions : (N, 3), m
        their positions
    about : (3,), m
        the point of reference, by default the mass centre
    """
    m_and_r = zip(np.asarray(masses, float), np.asarray(positions, float), strict=True)
    body = compose([Body(m, r, np.zeros((3, 3))) for m, r in m_and_r])
    if about is None:
        return body.inertia
    return parallel_axis(body.inertia, body.mass, np.asarray(about, float) - body.mass_centre)


def rod(mass: float, length: float) -> np.ndarray:
    """Return the inertia of a thin rod along z; its moment about z is zero."""
    return _about_z(mass * length**2 / 12.0, 0.0)


def ring(mass: float, radius: float) -> np.ndarray:
    """Return the inertia of a thin ring about z."""
    return _about_z(mass * radius**2 / 2.0, mass * radius**2)


def disk(mass: float, radius: float) -> np.ndarray:
    """Return the inertia of a thin disk about z."""
    return annulus(mass, 0.0, radius)


def annulus(mass: float, inner_radius: float, outer_radius: float) -> np.ndarray:
    """Return the inertia of a thin annulus about z."""
    square = mass * (inner_radius**2 + outer_radius**2)
    return _about_z(square / 4.0, square / 2.0)


def cylinder(mass: float, radius: float, height: float) -> np.ndarray:
    """Return the inertia of a solid cylinder about z."""
    return _about_z(mass * (3.0 * radius**2 + height**2) / 12.0, mass * radius**2 / 2.0)


def sphere(mass: float, radius: float) -> np.ndarray:
    """Return the inertia of a solid sphere."""
    return 0.4 * mass * radius**2 * np.eye(3)


def rectangular_plate(mass: float, length_x: float, length_y: float) -> np.ndarray:
    """Return the inertia of a thin plate normal to z with sides along x and y."""
    return mass / 12.0 * np.diag([length_y**2, length_x**2, length_x**2 + length_y**2])


def cone(mass: float, radius: float, height: float) -> np.ndarray:
    """Return the inertia of a solid cone about z; its mass centre is 3/4 height from the apex."""
    return _about_z(3.0 / 80.0 * mass * (4.0 * radius**2 + height**2), 0.3 * mass * radius**2)


def _about_z(transverse, axial):
    return np.diag([transverse, transverse, axial])

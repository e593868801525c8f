"""Bodies of any density: mass, mass centre and inertia by quadrature (textbook, 42.26, ex. 8)."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .bodies import Body

# A range of a coordinate: its ends, or a function of the coordinates before it that returns them.
Range = tuple[float, float] | Callable[..., tuple] | float
_MOST_POINTS = 80


def solid(
    density: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray | float],
    ranges: Sequence[Range],
    coordinates: str = 'cartesian',
    tolerance: float = 1e-10,
) -> Body:
    """
    Return the body that fills a region with a density.

    A coordinate given as a number in place of a range is held.  With one held, the body is a shell
    or a plate and the density that of the surface [kg/m^2]; with two, a rod or a ring and the
    density that of the line [kg/m].  Gauss-Legendre quadrature takes more and more points, until
    mass and inertia change by no more than the tolerance.

    Parameters
    ----------
    density : function, kg/m^3
        of x, y, z [m], arrays of one shape
    ranges : 3 pairs, numbers or functions, m and rad
        of x, y, z; 'cylindrical': of z, phi and the distance r from z; 'spherical': of theta from
        z, phi and the radius r.  A range may be a function of the coordinates before it
    coordinates : str
        'cartesian', 'cylindrical' or 'spherical'
    tolerance : float
        relative

    Raises
    ------
    ValueError
        the coordinates are unknown, the density is not smooth enough, or the mass is not positive

    Examples
    --------
    >>> ball = solid(lambda x, y, z: 1.0, [(0, np.pi), (0, 2 * np.pi), (0, 2.0)], 'spherical')
    >>> round(ball.mass, 9), round(float(ball.inertia[2, 2] / (0.4 * ball.mass * 4.0)), 9)
    (33.510321638, 1.0)
    >>> ring = solid(lambda x, y, z: 0.5, [0.0, (0, 2 * np.pi), 2.0], 'cylindrical')
    >>> round(float(ring.inertia[2, 2] / (ring.mass * 4.0)), 9)
    1.0
    """
    if coordinates not in _MAPPINGS:
        raise ValueError(f'coordinates is {coordinates}; allowed: {", ".join(_MAPPINGS)}')
    points, before = 10, np.full(10, np.inf)
    while points <= _MOST_POINTS:
        sums = _sums(density, ranges, _MAPPINGS[coordinates], points)
        if np.max(np.abs(sums - before)) <= tolerance * np.max(np.abs(sums)):
            return _body(sums)
        points, before = 2 * points, sums
    raise ValueError(
        f'the inertia does not settle to {tolerance:g} with {_MOST_POINTS} points in each '
        'direction; give ranges that end where the density jumps, or a larger tolerance'
    )


def _cartesian(x, y, z):
    return (x, y, z), (1.0, 1.0, 1.0)


def _cylindrical(z, phi, r):
    return (r * np.cos(phi), r * np.sin(phi), z), (1.0, r, 1.0)


def _spherical(theta, phi, r):
    across = r * np.sin(theta)
    return (across * np.cos(phi), across * np.sin(phi), r * np.cos(theta)), (r, across, 1.0)


# Coordinates to x, y, z and how far one goes in space for each; they are orthogonal.
_MAPPINGS = {'cartesian': _cartesian, 'cylindrical': _cylindrical, 'spherical': _spherical}


def _sums(density, ranges, mapping, points):
    """Return the integrals (10,) of density times 1, x, y, z, xx, yy, zz, xy, xz, yz."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    weight = np.einsum('i,j,k->ijk', weights, weights, weights) / 8.0
    unit = np.meshgrid(*[(nodes + 1.0) / 2.0] * 3, indexing='ij')
    given: list[np.ndarray] = []
    lengths: list[Any] = []
    for share, ends in zip(unit, ranges, strict=True):
        if np.ndim(ends) == 0 and not callable(ends):
            given.append(np.full_like(share, ends))
            lengths.append(None)
            continue
        low, high = ends(*given) if callable(ends) else ends
        given.append(low + (high - low) * share)
        lengths.append(high - low)
    (x, y, z), scales = mapping(*given)
    for length, scale in zip(lengths, scales, strict=True):
        if length is not None:
            weight = weight * length * scale
    mass = weight * density(x, y, z)
    powers = (1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z)
    return np.array([np.sum(mass * power) for power in powers])


def _body(sums):
    """Return the body of the ten integrals."""
    mass, centre = sums[0], sums[1:4]
    if not mass > 0.0:
        raise ValueError(f'the mass is {mass:g} kg; it must be positive')
    centre = centre / mass
    xx, yy, zz, xy, xz, yz = sums[4:]
    second = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    second -= mass * np.outer(centre, centre)
    return Body(float(mass), centre, np.trace(second) * np.eye(3) - second)

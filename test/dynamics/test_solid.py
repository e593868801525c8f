"""Bodies by quadrature against the catalogue and integrals known by heart."""

import math

import numpy as np
import pytest

from satdyn_ros.dynamics import bodies
from satdyn_ros.dynamics.solid import solid

TURN = (0.0, 2.0 * np.pi)


def uniform(x, y, z):
    return 1.0


@pytest.mark.parametrize(
    ('ranges', 'coordinates', 'volume', 'centre', 'shape'),
    [
        (
            [(-0.6, 0.6), TURN, (0.0, 0.5)],
            'cylindrical',
            np.pi * 0.25 * 1.2,
            [0.0, 0.0, 0.0],
            lambda m: bodies.cylinder(m, 0.5, 1.2),
        ),
        (
            [(0.0, 1.2), TURN, lambda z, phi: (0.0, 0.5 * z / 1.2)],
            'cylindrical',
            np.pi * 0.25 * 1.2 / 3.0,
            [0.0, 0.0, 0.9],
            lambda m: bodies.cone(m, 0.5, 1.2),
        ),
        (
            [(0.0, np.pi), TURN, (0.0, 0.5)],
            'spherical',
            np.pi / 6.0,
            [0.0, 0.0, 0.0],
            lambda m: bodies.sphere(m, 0.5),
        ),
        (
            [(0.0, 1.0), (0.0, 2.0), (0.0, 3.0)],
            'cartesian',
            6.0,
            [0.5, 1.0, 1.5],
            lambda m: m / 12.0 * np.diag([13.0, 10.0, 5.0]),
        ),
        (
            [(0.0, 1.0), lambda x: (0.0, 1.0 - x), lambda x, y: (0.0, 1.0 - x - y)],
            'cartesian',
            1.0 / 6.0,
            [0.25, 0.25, 0.25],
            # of the corner tetrahedron: m (3/40 + 1/80 off the diagonal)
            lambda m: m * (3.0 / 40.0 * np.eye(3) + (np.ones((3, 3)) - np.eye(3)) / 80.0),
        ),
    ],
    ids=['cylinder', 'cone', 'sphere', 'box', 'tetrahedron'],
)
def test_homogeneous_bodies(ranges, coordinates, volume, centre, shape):
    """Cylinder, cone, sphere, box and tetrahedron, by three kinds of coordinates."""
    body = solid(uniform, ranges, coordinates)
    assert body.mass == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(body.mass_centre, centre, atol=1e-12)
    np.testing.assert_allclose(body.inertia, shape(volume), atol=1e-12)


def test_a_density_that_varies():
    """A ball of density rho (1 - r^2) and a rod-like box that grows heavier along z."""
    ball = solid(
        lambda x, y, z: 1.0 - (x * x + y * y + z * z),
        [(0.0, np.pi), TURN, (0.0, 1.0)],
        'spherical',
    )
    # int r^2 (1 - r^2) and (2/3) int r^4 (1 - r^2), times 4 pi
    assert ball.mass == pytest.approx(4.0 * np.pi * (1.0 / 3.0 - 1.0 / 5.0), rel=1e-12)
    moment = 4.0 * np.pi * 2.0 / 3.0 * (1.0 / 5.0 - 1.0 / 7.0)
    np.testing.assert_allclose(ball.inertia, moment * np.eye(3), atol=1e-12)
    box = solid(lambda x, y, z: np.exp(z), [(-0.5, 0.5), (-0.5, 0.5), (0.0, 1.0)])
    assert box.mass == pytest.approx(math.e - 1.0, rel=1e-12)
    assert box.mass_centre[2] == pytest.approx(1.0 / (math.e - 1.0), rel=1e-12)


def test_what_is_no_body_is_refused():
    """Unknown coordinates, a jump inside the region, no mass: one sentence each."""
    cube = [(-1.0, 1.0)] * 3
    with pytest.raises(ValueError, match='coordinates is polar; allowed: cartesian'):
        solid(uniform, cube, 'polar')
    with pytest.raises(ValueError, match='end where the density jumps'):
        solid(lambda x, y, z: np.where(x + y + z < 0.3, 1.0, 0.0), cube)
    with pytest.raises(ValueError, match='the mass is -8 kg'):
        solid(lambda x, y, z: -1.0, cube)


@pytest.mark.parametrize(
    ('ranges', 'coordinates', 'expected'),
    [
        ([0.0, 0.0, (-1.5, 1.5)], 'cartesian', bodies.rod(1.0, 3.0)),
        ([0.0, (0.0, 2.0 * np.pi), 0.7], 'cylindrical', bodies.ring(1.0, 0.7)),
        ([0.0, (0.0, 2.0 * np.pi), (0.0, 0.7)], 'cylindrical', bodies.disk(1.0, 0.7)),
        ([(-1.0, 1.0), (-0.5, 0.5), 0.0], 'cartesian', bodies.rectangular_plate(1.0, 2.0, 1.0)),
        # a plate again, as half planes about z, and a thin shell: 2 m r^2 / 3
        ([(-1.0, 1.0), 0.0, (-0.5, 0.5)], 'cylindrical', np.diag([1 / 3, 5 / 12, 1 / 12])),
        ([(0.0, np.pi), (0.0, 2.0 * np.pi), 0.7], 'spherical', np.eye(3) * 0.98 / 3.0),
        # the mantle of a cone of height 1: m (h^2 / 18 + r^2 / 4), m r^2 / 2
        (
            [np.pi / 4.0, (0.0, 2.0 * np.pi), (0.0, np.sqrt(2.0))],
            'spherical',
            np.diag([1 / 18 + 0.25, 1 / 18 + 0.25, 0.5]),
        ),
    ],
)
def test_lines_and_surfaces(ranges, coordinates, expected):
    """Rods, rings, plates and shells by line and surface density are those of the catalogue."""
    body = solid(lambda x, y, z: 2.0, ranges, coordinates)
    np.testing.assert_allclose(body.inertia / body.mass, expected, atol=1e-12)

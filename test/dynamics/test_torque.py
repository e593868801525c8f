import numpy as np
import pytest

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import System
from satdyn_ros.dynamics.torque import angular_momentum, element_forces
from satdyn_ros.torques.gravity_gradient import gravity_gradient

RNG = np.random.default_rng(20240607)


def inertia_of(masses, points):
    """Return sum m (|x|^2 1 - x x^T) of point masses, shape (3, 3)."""
    pairs = zip(masses, points, strict=True)
    return sum(m * ((x @ x) * np.eye(3) - np.outer(x, x)) for m, x in pairs)


def test_gravity_gradient_is_newtons_attraction_of_the_parts():
    """
    The torque of the inverse-square law on point masses about their centre.

    Masses in opposite pairs cancel the next, third-order term of the expansion; what is left out
    is of the size (1e-3)^2 of what is kept, with a factor below 10.
    """
    half = RNG.normal(size=(4, 3))
    points = np.concatenate([half, -half])
    masses = np.tile(RNG.uniform(1.0, 2.0, 4), 2)
    mu, r = 7.0, 1e3 * np.max(np.linalg.norm(points, axis=1))
    directions = RNG.normal(size=(20, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for c in directions:
        position = r * c + points
        # The attraction less that of the centre, whose torque vanishes: it only costs digits.
        pull = position / np.linalg.norm(position, axis=1)[:, None] ** 3 - c / r**2
        attraction = -mu * masses[:, None] * pull
        expected = np.sum(np.cross(points, attraction), axis=0)
        torque = gravity_gradient(inertia_of(masses, points), c, 3.0 * mu / r**3)
        scale = 3.0 * mu / r**3 * np.trace(inertia_of(masses, points))
        assert torque == pytest.approx(expected, abs=1e-5 * scale)


@pytest.mark.parametrize('speed', [0.0, 40.0])
def test_angular_momentum_is_that_of_the_moving_parts(speed):
    """Sum m x cross v over a tumbling cloud and a ring that spins in it, to rounding."""
    cloud, masses = RNG.normal(size=(6, 3)), RNG.uniform(1.0, 2.0, 6)
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    across = np.cross(axis, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    angles = np.arange(5) * 2.0 * np.pi / 5.0
    ring = 0.7 * np.outer(np.cos(angles), across)
    ring += 0.7 * np.outer(np.sin(angles), np.cross(axis, across))
    ring_mass = 0.3
    points = np.concatenate([cloud, ring])
    all_masses = np.concatenate([masses, np.full(5, ring_mass)])
    omega = RNG.normal(size=3)
    velocity = np.cross(omega, points)
    velocity[len(cloud) :] += speed * np.cross(axis, ring)
    expected = np.sum(all_masses[:, None] * np.cross(points, velocity), axis=0)

    inertia = inertia_of(all_masses, points)
    J = 5 * ring_mass * 0.7**2
    free = System(inertia, (Rotor('free', axis, inertia=J),))
    held = System(inertia, (Rotor('constant_momentum', axis, momentum=J * speed),))
    assert angular_momentum(free, omega, np.array([speed])) == pytest.approx(expected, rel=1e-13)
    assert angular_momentum(held, omega, np.array([np.nan])) == pytest.approx(expected, rel=1e-13)


def test_a_row_alone_has_the_bits_of_a_row_among_many():
    """What is computed tick by tick equals what is computed in blocks, bit by bit."""
    A = RNG.normal(size=(3, 3))
    system = System(A @ A.T, (Rotor('free', np.array([0.48, 0.6, 0.64]), inertia=0.1),))
    vectors, numbers = RNG.normal(size=(999, 3)), RNG.normal(size=999)
    torques = gravity_gradient(system.inertia, vectors, numbers)
    momenta = angular_momentum(system, vectors, numbers[:, None])
    for i in range(0, 999, 37):
        row = slice(i, i + 1)
        torque = gravity_gradient(system.inertia, vectors[row], numbers[row])
        momentum = angular_momentum(system, vectors[row], numbers[row, None])
        assert np.array_equal(torque[0], torques[i])
        assert np.array_equal(momentum[0], momenta[i])


def test_the_pull_on_elements_adds_up_to_the_torques():
    """
    Moments of Beletsky's (1) over points are those of (2), whose field has the gradient 3 g / R.

    Against Newton's law for each point, the forces are right to the second order in x / R.
    """
    rng = np.random.default_rng(3)
    masses, positions = rng.uniform(0.5, 2.0, 12), rng.normal(size=(12, 3))
    c, gravity, radius = np.array([0.36, 0.48, 0.8]), 9.0, 1e4
    forces = element_forces(masses, positions, c, gravity, radius)
    moment = np.sum(np.cross(positions, forces), axis=0)
    inertia = np.sum(
        [m * (x @ x * np.eye(3) - np.outer(x, x)) for m, x in zip(masses, positions, strict=True)],
        axis=0,
    )
    weight = gravity * masses @ positions
    expected = gravity_gradient(inertia, c, 3.0 * gravity / radius) - np.cross(weight, c)
    np.testing.assert_allclose(moment, expected, rtol=1e-12)
    r = radius * c + positions
    distance = np.linalg.norm(r, axis=-1)[:, None]
    newton = -masses[:, None] * gravity * radius**2 * r / distance**3
    np.testing.assert_allclose(forces, newton, atol=50.0 * gravity / radius**2)

"""An orbit from a table answers as one in closed form does."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.orbits.j2 import OblateOrbit
from satdyn_ros.orbits.tabled import TabledOrbit

KEPLER = KeplerOrbit(semi_major_axis=9e6, eccentricity=0.2, inclination=0.9, raan=2.1)
# A hundred times that of the Earth: the plane turns by much.
SOURCE = OblateOrbit(KEPLER, j2=0.1)
OBLATE = TabledOrbit(SOURCE)
T_S = np.random.default_rng(2).uniform(0.0, 3e4, 200)


def test_without_j2_it_answers_as_the_ellipse():
    """Direction, distance, gradient, rates, LVLH and elements, to rounding."""
    orbit = TabledOrbit(OblateOrbit(KEPLER, j2=0.0))
    for name in ('direction', 'radius', 'gradient_at', 'rate', 'lvlh_rate'):
        true = getattr(KEPLER, name)(T_S)
        found = getattr(orbit, name)(T_S)
        assert_allclose(found, true, rtol=0.0, atol=1e-11 * np.max(np.abs(true)))
    assert np.max(rotation.angle_between(orbit.lvlh(T_S), KEPLER.lvlh(T_S))) < 1e-11
    assert orbit.mean_motion == pytest.approx(KEPLER.mean_motion, rel=1e-12)


def test_lvlh_points_along_track_against_the_momentum_and_down():
    """Of an orbit whose plane turns; the scalar part of its quaternion is never negative."""
    q_il = OBLATE.lvlh(T_S)
    x, y, z = np.moveaxis(rotation.matrix(q_il), -1, 0)
    r_i, v_i = OBLATE.position_velocity(T_S)
    momentum = np.cross(r_i, v_i)
    assert_allclose(z, -r_i / np.linalg.norm(r_i, axis=1)[:, None], rtol=0.0, atol=1e-12)
    assert_allclose(y, -momentum / np.linalg.norm(momentum, axis=1)[:, None], atol=1e-12)
    assert np.all(np.sum(x * v_i, axis=1) > 0.0)
    assert np.all(q_il[:, 3] >= 0.0)


def test_the_lvlh_rate_is_the_rate_of_lvlh():
    """
    By differences, and by its components: -h / r^2 about y, -r (a . n) / h about z, none about x.

    Central differences over 1 s leave the rate's third derivative / 6, 1e-9 of the rate; here the
    plane turns at 1e-5 rad/s.
    """
    h_s = 0.5
    turn = rotation.multiply(OBLATE.lvlh(T_S + h_s), rotation.conjugate(OBLATE.lvlh(T_S - h_s)))
    rate = OBLATE.lvlh_rate(T_S)
    assert_allclose(rate, rotation.to_vector(turn) / (2.0 * h_s), rtol=0.0, atol=3e-9)
    x, y, z = np.moveaxis(rotation.rotate(rotation.conjugate(OBLATE.lvlh(T_S)), rate), -1, 0)
    r_i, v_i = OBLATE.position_velocity(T_S)
    r, momentum = np.linalg.norm(r_i, axis=1), np.cross(r_i, v_i)
    h = np.linalg.norm(momentum, axis=1)
    a_n = np.sum(SOURCE.acceleration(r_i) * momentum, axis=1) / h
    assert np.max(np.abs(z)) > 1e-5
    assert_allclose(x, 0.0, atol=1e-15)
    assert_allclose(y, -h / r**2, rtol=0.0, atol=1e-14)
    assert_allclose(z, -r * a_n / h, rtol=0.0, atol=1e-13)


def test_it_goes_to_other_processes():
    """Where it makes its pieces anew, with the same bits."""
    sent = pickle.loads(pickle.dumps(OBLATE))
    np.testing.assert_array_equal(sent.lvlh_rate(T_S), OBLATE.lvlh_rate(T_S))


def test_one_time_has_the_shape_of_one():
    """As of an orbit in closed form, for every question."""
    for name in ('direction', 'radius', 'gradient_at', 'rate', 'lvlh', 'lvlh_rate'):
        assert np.shape(getattr(OBLATE, name)(7.0)) == np.shape(getattr(KEPLER, name)(7.0))
    assert [np.shape(each) for each in OBLATE.position_velocity(7.0)] == [(3,), (3,)]

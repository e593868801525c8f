"""The Sun is where the reference has it, and the Earth hides of it what geometry says."""

import numpy as np
import pytest
from environment import truth
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad

from satdyn_ros.environment import lit_fraction, shadow_margins, sun_direction, sun_position
from satdyn_ros.environment.sun import AU_M, SUN_RADIUS_M
from satdyn_ros.kernel.rows import dot, length
from satdyn_ros.orbits import KeplerOrbit

EARTH_M = 6378137.0
SUN_I = np.array([AU_M, 0.0, 0.0])

each_case = pytest.mark.parametrize('case', truth.cases('sun_b'), ids=lambda case: case['name'])


def sunlight(case):
    """Return s in body axes, the distance of the Sun and nu of a case."""
    r_i, sun_i = truth.column(case['orbit'], 'r_i'), sun_position(truth.stamps_ns(case))
    s_i, distance_m = sun_direction(r_i, sun_i)
    return truth.in_body_axes(case, s_i), distance_m, lit_fraction(r_i, sun_i)


def test_single_positions():
    """
    Position, direction, distance and lit fraction are the reference's.

    Tolerance: the same ephemeris, rounding.  The lit fraction is known to 1e-12: the reference
    takes arc cosines, which lose digits where the discs barely cross.
    """
    sun_i, r_i = sun_position(truth.points('epoch_ns')), truth.points('r_gcrs')
    s_i, distance_m = sun_direction(r_i, sun_i)
    assert_allclose(sun_i, truth.points('sun_gcrs_m'), rtol=0.0, atol=1e-4)
    assert_allclose(s_i, truth.points('sun_from_body'), rtol=0.0, atol=1e-15)
    assert_allclose(distance_m, truth.points('sun_distance_m'), rtol=1e-15)
    lit = truth.points('lit')
    assert np.count_nonzero((0.0 < lit) & (lit < 1.0)) > 8
    assert_allclose(lit_fraction(r_i, sun_i), lit, rtol=0.0, atol=1e-12)


@each_case
def test_along_orbits(case):
    """
    In body axes the direction is the reference's; so is the lit fraction.

    Tolerance: attitudes are given to rounding, 1e-15.
    """
    s_b, _, lit = sunlight(case)
    assert_allclose(s_b, truth.column(case['fields'], 'sun_b'), rtol=0.0, atol=1e-14)
    assert_allclose(lit, truth.column(case['fields'], 'lit'), rtol=0.0, atol=1e-12)


@each_case
def test_plates_feel_the_reference_torque(case):
    """Light on a body's plates, absorbed, reflected and scattered, gives the torque there."""
    s_b, distance_m, lit = sunlight(case)
    pressure = lit * 1361.0 / 299_792_458.0 * (AU_M / distance_m) ** 2
    torque = np.zeros_like(s_b)
    for plate in truth.plates(case['scenario']):
        normal, specular = np.asarray(plate['normal']), plate['specular']
        cosine = np.maximum(dot(normal, s_b), 0.0)[:, None]
        share = (1.0 - specular) * s_b + 2.0 * (specular * cosine + plate['diffuse'] / 3) * normal
        force = -pressure[:, None] * plate['area'] * cosine * share
        torque += np.cross(plate['position'], force)
    right = truth.column(case['fields'], 'solar_torque')
    assert np.max(length(torque - right)) < 1e-12 * np.max(length(right))


@pytest.mark.parametrize(
    'case',
    [case for case in truth.cases('sun_b') if 'penumbra_edges' in case],
    ids=lambda case: case['name'],
)
def test_contacts(case):
    """
    At each edge of a penumbra the outer or the inner margin changes its sign.

    The edges are roots found to about 1e-9 s, in which the discs move by 1e-12 rad.
    """
    given = case['scenario']['orbit']
    orbit = KeplerOrbit(**{key: value for key, value in given.items() if key != 'type'})

    def margins(t_s):
        stamps_ns = case['scenario']['time']['epoch_ns'] + np.rint(1e9 * t_s).astype(np.int64)
        return np.array(shadow_margins(orbit.position_velocity(t_s)[0], sun_position(stamps_ns)))

    edges_s = np.array(case['penumbra_edges'])
    each = np.argmin(abs(margins(edges_s)), axis=0), np.arange(len(edges_s))
    # Into the penumbra and the umbra and out of both, from where the run begins.
    dark = margins(np.zeros(1))[1, 0] < 0.0
    order = np.roll([(0, -1), (1, -1), (1, 1), (0, 1)], -2 * dark, axis=0)
    expected = np.resize(order, (len(edges_s), 2))
    assert_array_equal(each[0], expected[:, 0])
    assert np.max(abs(margins(edges_s)[each])) < 1e-12
    assert_array_equal(np.sign(margins(edges_s + 1.0)[each]), expected[:, 1])
    assert_array_equal(np.sign(margins(edges_s - 1.0)[each]), -expected[:, 1])


def behind(distance_m, angle):
    """Return a position behind the Earth, where its centre and the Sun's are an angle apart."""
    # In the triangle of Earth, body and Sun the angle at the Sun is the smallest.
    at_sun = np.arcsin(distance_m / AU_M * np.sin(angle))
    turn = np.pi - angle - at_sun
    return distance_m * np.array([np.cos(turn), np.sin(turn), 0.0])


@pytest.mark.parametrize('distance_m', [6.6e6, 4.2e7, 1.2e9, 1.6e9, 9e9])
def test_lit_fraction_is_an_area(distance_m):
    """
    What is hidden is the area of the disc's strips that the Earth's disc covers, by quadrature.

    From near, from about the tip of the umbra, 1.4e9 m, and from far, where a ring is left.
    Tolerance: what the quadrature claims, 1e-9.
    """
    b = np.arcsin(EARTH_M / distance_m)
    for share in (0.02, 0.3, 0.7, 0.98):
        a = np.arcsin(SUN_RADIUS_M / AU_M)
        angle = abs(a - b) + share * (a + b - abs(a - b))
        r_i = behind(distance_m, angle)
        a = np.arcsin(SUN_RADIUS_M / length(SUN_I - r_i))

        def strip(x, a=a, b=b, angle=angle):
            of_sun, of_earth = a * a - x * x, b * b - (x - angle) ** 2
            return 2.0 * np.sqrt(max(min(of_sun, of_earth), 0.0))

        crossing = (angle**2 + a * a - b * b) / (2.0 * angle)
        ends = max(-a, angle - b), min(a, angle + b)
        hidden, _ = quad(strip, *ends, points=[crossing], epsabs=0.0, epsrel=1e-11, limit=200)
        lit = 1.0 - hidden / (np.pi * a * a)
        assert_allclose(lit_fraction(r_i, SUN_I), lit, rtol=0.0, atol=1e-9)


def test_where_the_discs_do_not_cross():
    """All is lit on the day's side and beside the shadow, nothing in it; from far a ring is."""
    positions = np.array(
        [[7e6, 0, 0], [0, 7e6, 0], [-7e6, 0, 0], [-4e7, 5e6, 0], [-4e7, 7.5e6, 0]]
    )
    assert_array_equal(lit_fraction(positions, SUN_I), [1.0, 1.0, 0.0, 0.0, 1.0])
    far_m = 3e9
    ring = 1.0 - (np.arcsin(EARTH_M / far_m) / np.arcsin(SUN_RADIUS_M / (AU_M + far_m))) ** 2
    assert_allclose(lit_fraction([-far_m, 0.0, 0.0], SUN_I), ring, rtol=1e-14)
    outer, inner = shadow_margins([-far_m, 0.0, 0.0], SUN_I)
    assert outer < 0.0
    assert inner < 0.0


def test_a_low_orbit_through_the_shadow():
    """
    At 500 km in the plane of the Sun 35.8 of 94.6 min are dark, and each penumbra lasts 8 s.

    The first is the width of a cylinder behind the Earth, which lies within the penumbrae.
    """
    orbit = KeplerOrbit(semi_major_axis=EARTH_M + 5e5)
    period_s = 2.0 * np.pi / orbit.mean_motion
    t_s = np.arange(0.0, period_s, 0.1)
    lit = lit_fraction(orbit.position_velocity(t_s)[0], SUN_I)
    partly_s = 0.1 * np.count_nonzero((0.0 < lit) & (lit < 1.0))
    dark_s = 0.1 * np.count_nonzero(lit == 0.0)
    assert_allclose(period_s / 60.0, 94.6, atol=0.05)
    assert_allclose((dark_s + 0.5 * partly_s) / 60.0, 35.8, atol=0.05)
    assert_allclose(0.5 * partly_s, 8.0, atol=0.5)

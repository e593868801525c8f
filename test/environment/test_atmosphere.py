"""The air's density and velocity are the reference's, and the air turns with the ground."""

import warnings

import numpy as np
import pytest
from environment import truth
from numpy.testing import assert_allclose

from satdyn_ros.base.nanoseconds import SECOND_NS, stamp_ns
from satdyn_ros.environment import (
    Exponential,
    Msis,
    air_velocity,
    gcrs_to_itrs,
    geodetic,
    turned,
)
from satdyn_ros.kernel.rows import dot, length
from satdyn_ros.run.scenario import Scenario

QUIET = Msis(150.0, 150.0, 4.0)

each_case = pytest.mark.parametrize('case', truth.cases('density'), ids=lambda case: case['name'])


def air(case):
    """Return ln rho, w in body axes and the share of rho to which they are known, of a case."""
    stamps_ns, given = truth.stamps_ns(case), case['scenario']['environment']
    r_i, v_i = (truth.column(case['orbit'], name) for name in ('r_i', 'v_i'))
    to_itrs = gcrs_to_itrs(stamps_ns)
    latitude, longitude, height_m = geodetic(turned(to_itrs, r_i))
    w_b = truth.in_body_axes(case, air_velocity(r_i, v_i, to_itrs[:, 2]))
    if given['atmosphere'] == 'msis':
        activity = given['f107'], given['f107_average'], given['ap']
        # The model computes with 24 bits, which scatters the density by 3e-6 here and as much in
        # the reference, whose own curve is smooth.
        log_density = Msis(*activity).log_density(
            stamps_ns // SECOND_NS, latitude, longitude, height_m
        )
        return log_density, w_b, 2e-5
    base = given['density'], given['density_height'], given['scale_height']
    # A height is rounded to 1e-9 m, and H is 5e4 m.
    return Exponential(*base).log_density(height_m), w_b, 1e-12


@each_case
def test_density_along_orbits(case):
    """It is that of the reference at its positions."""
    log_density, _, share = air(case)
    assert_allclose(np.exp(log_density), truth.column(case['fields'], 'density'), rtol=share)


@each_case
def test_plates_feel_the_reference_torque(case):
    """The flow along a body's plates, each -1/2 rho C_D A (n . w)+ w, gives the torque there."""
    log_density, w_b, share = air(case)
    torque = np.zeros_like(w_b)
    for plate in truth.plates(case['scenario']):
        into_flow = np.maximum(dot(np.asarray(plate['normal']), w_b), 0.0)
        pressure = -0.5 * np.exp(log_density) * plate['drag_coefficient'] * plate['area']
        torque += np.cross(plate['position'], (pressure * into_flow)[:, None] * w_b)
    right = truth.column(case['fields'], 'aerodynamic_torque')
    assert np.max(length(torque - right)) < share * np.max(length(right))


def test_single_positions_of_msis():
    """It is what the reference's program gave; the stated bound, 1e-5, is single precision."""
    angles = (np.radians(truth.points(name)) for name in ('latitude_deg', 'longitude_deg'))
    positions = zip(
        truth.points('epoch_ns') // SECOND_NS, *angles, truth.points('height_m'), strict=True
    )
    activity = zip(*(truth.points(name) for name in Msis._fields), strict=True)
    found = np.exp(
        [
            Msis(*of).log_density(*position)
            for of, position in zip(activity, positions, strict=True)
        ]
    )
    assert_allclose(found, truth.points('msis_density'), rtol=1e-5)


def test_many_positions_of_msis_at_once():
    """They are those of each, whatever shape the arguments have together."""
    unix_s = truth.points('epoch_ns') // SECOND_NS
    height_m = np.array([[2e5], [4e5], [8e5]])
    found = QUIET.log_density(unix_s, 0.5, -2.0, height_m)
    assert found.shape == (3, len(unix_s))
    alone = [[QUIET.log_density(at, 0.5, -2.0, h) for at in unix_s] for h in height_m[:, 0]]
    assert_allclose(found, alone, rtol=0.0, atol=1e-5)


def test_msis_jumps_at_midnight():
    """Its day of the year is a whole number: pieces of a table have to end at 00:00 UTC."""
    midnight_ns = stamp_ns('2025-09-20T00:00:00')
    before, last, first = QUIET.log_density(
        midnight_ns // SECOND_NS + np.array([-2, -1, 0]), np.radians(40.0), 1.0, 4.5e5
    )
    assert abs(last - before) < 2e-4
    assert abs(first - last) > 1e-3


def test_what_stands_on_the_ground_feels_no_wind():
    """
    The velocity of a position that is fixed in ITRS, by differences, is that of the air.

    Tolerance: the pole moves by 8e-12 rad/s, 5e-5 m/s at 7e6 m, which the wind leaves out;
    the difference over 2 s leaves 6e-9 of 500 m/s, and rounding 1e-9 m.
    """
    stamps_ns, r_t = truth.points('epoch_ns'), truth.points('r_itrs')
    before, now, after = (
        gcrs_to_itrs(stamps_ns + step_ns).swapaxes(-1, -2) for step_ns in (-(10**9), 0, 10**9)
    )
    v_i = 0.5 * (turned(after, r_t) - turned(before, r_t))
    w_i = air_velocity(turned(now, r_t), v_i, gcrs_to_itrs(stamps_ns)[:, 2])
    assert np.max(length(w_i)) < 1e-4


@pytest.mark.parametrize(
    ('air', 'height_m'),
    [(QUIET, -2e4), (Msis(1000.0, 150.0, 4.0), 4e5), (Msis(60.0, 600.0, 4.0), 4e5)],
)
def test_where_msis_has_no_density_it_says_so(air, height_m):
    """Below the ground, and by fluxes that never were: one sentence and no warning of NumPy."""
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        with pytest.raises(ValueError, match=rf'no density at a height of {1e-3 * height_m:g} km'):
            air.log_density(np.full(2, 1772366400), 0.3, 0.2, height_m)


@pytest.mark.parametrize(('key', 'most'), [('f107', 1000), ('f107_average', 1000), ('ap', 400)])
def test_an_activity_that_never_was_is_refused(key, most):
    """The scale of ap ends at 400; a flux is never near 1000."""
    given = {'environment.atmosphere': 'msis', f'environment.{key}': 1e300}
    with pytest.raises(ValueError, match=rf'environment\.{key} is 1e\+300.*at most {most}'):
        Scenario(given)

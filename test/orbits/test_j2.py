"""The orbit with J2: against Kepler, finer pieces, SciPy, secular rates and reference states."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
from cases import REFERENCE
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.orbits.j2 import EARTH_J2, OblateOrbit
from satdyn_ros.orbits.kepler import EARTH_MU, EARTH_RADIUS_M
from satdyn_ros.orbits.tabled import CURVATURE, POSITION, TabledOrbit

DAY_S = 86400.0
WEEK_S = 7.0 * DAY_S
LOW = KeplerOrbit(EARTH_MU, 7.2e6, 0.05, 0.7, 0.8, 1.5, 0.3)
TRANSFER = KeplerOrbit(EARTH_MU, 2.4e7, 0.72, 0.1, -2.0, 3.1, 2.0)


@dataclass(eq=False)
class Finer(OblateOrbit):
    """The same in pieces of half the length."""

    @property
    def stretches(self):
        (stretch,) = super().stretches
        return (stretch._replace(length_s=stretch.length_s / 2.0),)


def times(end_s, count=300):
    return np.sort(np.random.default_rng(7).uniform(0.0, end_s, count))


@pytest.mark.parametrize('start', [LOW, TRANSFER])
def test_without_j2_it_is_keplers_ellipse_for_a_week(start):
    """A millimetre is allowed, and a micrometre per second."""
    t_s = times(WEEK_S)
    found = TabledOrbit(OblateOrbit(start, j2=0.0)).position_velocity(t_s)
    for values, true, allowed in zip(
        found, start.position_velocity(t_s), (1e-3, 1e-6), strict=True
    ):
        assert_allclose(values, true, rtol=0.0, atol=allowed)


@pytest.mark.parametrize('start', [LOW, TRANSFER])
def test_shorter_pieces_say_the_same_for_a_week(start):
    """A millimetre is allowed; the two share neither nodes nor the number of steps."""
    t_s = times(WEEK_S)
    (r_i, _), (finer, _) = (
        TabledOrbit(orbit(start)).position_velocity(t_s) for orbit in (OblateOrbit, Finer)
    )
    assert_allclose(r_i, finer, rtol=0.0, atol=1e-3)


def test_scipy_flies_the_equation_of_the_textbook():
    """
    The acceleration written out again from the potential, by DOP853, over three orbits.

    Tolerance: what DOP853 at its smallest relative tolerance makes of them, 1e-9 of the radius.
    """

    def rates(_, y):
        x, r = y[:3], np.linalg.norm(y[:3])
        # The gradient of (mu / r) (1 - J2 (R / r)^2 (3 sin^2 latitude - 1) / 2).
        k = EARTH_MU * EARTH_J2 * EARTH_RADIUS_M**2
        z2 = x[2] ** 2
        oblate = k * (x * (7.5 * z2 / r**7 - 1.5 / r**5) - [0.0, 0.0, 3.0 * x[2] / r**5])
        return np.concatenate([y[3:], -EARTH_MU * x / r**3 + oblate])

    t_s = np.linspace(0.0, 18000.0, 50)
    start = np.concatenate(LOW.position_velocity(0.0))
    solved = solve_ivp(rates, t_s[[0, -1]], start, 'DOP853', t_s, rtol=3e-14, atol=1e-9)
    r_i, v_i = TabledOrbit(OblateOrbit(LOW)).position_velocity(t_s)
    assert_allclose(r_i, solved.y[:3].T, rtol=0.0, atol=7e-3)
    assert_allclose(v_i, solved.y[3:].T, rtol=0.0, atol=7e-6)


def test_node_and_pericentre_drift_at_their_secular_rates():
    """
    -1.5 J2 (R / p)^2 n cos i and 0.75 J2 (R / p)^2 n (5 cos^2 i - 1), over ten days.

    Of the elements' means over an orbit; what is left out is of the second order in J2, some
    thousandths of the rates.
    """
    orbit = TabledOrbit(OblateOrbit(LOW))
    names = 'semi_major_axis', 'eccentricity', 'inclination', 'raan', 'argument_of_periapsis'

    def means(begin_s):
        t_s = np.linspace(begin_s, begin_s + 2.0 * np.pi / LOW.mean_motion, 60)
        rows = zip(*orbit.position_velocity(t_s), strict=True)
        found = [KeplerOrbit.from_state(r_i, v_i) for r_i, v_i in rows]
        return [np.mean(np.unwrap([getattr(each, name) for each in found])) for name in names]

    span_s = 10.0 * DAY_S
    a, e, i, *first = means(0.0)
    drifts = np.array(means(span_s)[3:]) - first
    size = EARTH_J2 * (EARTH_RADIUS_M / (a * (1.0 - e * e))) ** 2 * np.sqrt(EARTH_MU / a**3)
    secular = size * span_s * np.array([-1.5 * np.cos(i), 0.75 * (5.0 * np.cos(i) ** 2 - 1.0)])
    assert np.all(np.abs(secular) > 0.8)
    assert_allclose(rotation.wrap(drifts - secular) / secular, 0.0, atol=5e-3)


def test_reference_states():
    """Ten orbits of the reference case, by another integrator; a micrometre is its rounding."""
    cases = json.loads((REFERENCE / 'environment.json').read_text())['cases']
    (case,) = (case for case in cases if case['name'] == 'j2_ten_orbits')
    elements = case['scenario']['orbit']
    start = KeplerOrbit(**{key: elements[key] for key in elements if key not in ('type', 'j2')})
    orbit = TabledOrbit(OblateOrbit(start, elements['j2']))
    r_i, v_i = orbit.position_velocity(np.array([row['t'] for row in case['orbit']]))
    assert_allclose(r_i, [row['r_i'] for row in case['orbit']], rtol=0.0, atol=1e-5)
    assert_allclose(v_i, [row['v_i'] for row in case['orbit']], rtol=0.0, atol=1e-8)


def test_it_can_be_asked_in_any_order_and_before_tick_0():
    """The bits of one that goes ahead, backwards, and from the middle; r'' is the acceleration."""
    t_s = np.concatenate([-times(3000.0, 20), times(0.7 * DAY_S, 60)])
    source = OblateOrbit(LOW)
    ahead = TabledOrbit(source)
    right, _ = ahead.position_velocity(t_s)
    backwards = TabledOrbit(OblateOrbit(LOW))
    found = [backwards.position_velocity(t)[0] for t in t_s[::-1]]
    np.testing.assert_array_equal(found[::-1], right)
    r_i, curvature = ahead.pieces.values(t_s, POSITION), ahead.pieces.values(t_s, CURVATURE)
    assert_allclose(curvature, source.acceleration(r_i), rtol=0.0, atol=1e-10)


def test_an_orbit_into_the_centre_is_refused_there():
    """
    Where J2 outgrows the attraction the line to the centre has no end in time.

    Up to there the energy, whose potential the textbook gives, is constant; before, the orbit went
    on with ten thousand times as much.
    """
    start = KeplerOrbit(EARTH_MU, 7.0e6, 0.97, 0.3, 0.3, -1.0, 3.0)
    orbit = TabledOrbit(OblateOrbit(start))
    r_i, v_i = orbit.position_velocity(np.linspace(0.0, 4653.0, 500))
    r, z = np.linalg.norm(r_i, axis=1), r_i[:, 2]
    oblate = EARTH_J2 * (EARTH_RADIUS_M / r) ** 2 * (1.5 * (z / r) ** 2 - 0.5)
    energy = np.sum(v_i * v_i, axis=1) / 2.0 - EARTH_MU / r * (1.0 - oblate)
    assert_allclose(energy, energy[0], rtol=1e-9)
    with pytest.raises(ValueError, match=r'^with orbit\.j2 0\.00108263 the orbit comes too near'):
        orbit.position_velocity(np.array([4700.0]))

import json
from functools import partial

import numpy as np
import pytest
from cases import REFERENCE
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.orbits.kepler import EARTH_MU

close = partial(assert_allclose, rtol=0.0)

ECCENTRICITIES = [0.0, 0.1, 0.7, 0.99]


def tilted(e):
    return KeplerOrbit(
        semi_major_axis=9.0e6,
        eccentricity=e,
        inclination=0.9,
        raan=2.1,
        argument_of_periapsis=-0.7,
        true_anomaly=0.4,
    )


@pytest.mark.parametrize('e', ECCENTRICITIES)
def test_two_body_integration_agrees(e):
    """
    The ellipse is the solution of r'' = -mu r / r^3 from its own start.

    Tolerance: what DOP853 at 1e-13 makes of one revolution, 1e-9 of the semi-major axis.
    """
    orbit = tilted(e)
    start = np.concatenate(orbit.position_velocity(0.0))
    times = np.linspace(0.0, 2.0 * np.pi / orbit.mean_motion, 40)
    solution = solve_ivp(
        lambda _, y: [*y[3:], *(-orbit.mu * y[:3] / np.linalg.norm(y[:3]) ** 3)],
        times[[0, -1]],
        start,
        method='DOP853',
        t_eval=times,
        rtol=1e-13,
        atol=1e-9,
    )
    r_i, v_i = orbit.position_velocity(times)
    close(solution.y[:3].T, r_i, atol=1e-9 * orbit.semi_major_axis)
    # At the pericentre of a long ellipse an error in position is magnified in velocity by v' / v.
    pericentre = orbit.semi_major_axis * (1.0 - e)
    fastest = np.max(np.linalg.norm(v_i, axis=-1))
    allowed = 1e-9 * orbit.semi_major_axis / pericentre * fastest
    close(solution.y[3:].T, v_i, atol=allowed)


@given(
    e=st.floats(1e-3, 0.99),
    inclination=st.floats(0.01, 3.1),
    raan=st.floats(-3.0, 3.0),
    argument=st.floats(-3.0, 3.0),
    anomaly=st.floats(-3.0, 3.0),
)
def test_elements_of_a_state_give_the_state_back(e, inclination, raan, argument, anomaly):
    """from_state finds an ellipse through the state it was given, from any elements."""
    orbit = KeplerOrbit(EARTH_MU, 2.0e7, e, inclination, raan, argument, anomaly)
    r_i, v_i = orbit.position_velocity(0.0)
    found = KeplerOrbit.from_state(r_i, v_i)
    assert found.eccentricity == pytest.approx(e, abs=1e-12)
    # 1 / a = 2 / r - v^2 / mu cancels where the ellipse is long.
    assert found.semi_major_axis == pytest.approx(2.0e7, rel=1e-14 / (1.0 - e) ** 2 + 1e-13)
    for given_, again in zip((r_i, v_i), found.position_velocity(0.0), strict=True):
        assert np.linalg.norm(again - given_) <= 1e-11 / (1.0 - e) * np.linalg.norm(given_)


def test_textbook_example_of_elements():
    """
    Vallado, Fundamentals of Astrodynamics and Applications, example 2-5, to the digits printed.

    r = (6524.834, 6862.875, 6448.296) km and v = (4.901327, 5.533756, -1.976341) km/s have
    a = 36127.343 km, e = 0.832853, i = 87.870 deg, raan = 227.898 deg, argument 53.38 deg,
    anomaly 92.335 deg.
    """
    orbit = KeplerOrbit.from_state(
        [6524834.0, 6862875.0, 6448296.0], [4901.327, 5533.756, -1976.341], mu=3.986004418e14
    )
    assert orbit.semi_major_axis == pytest.approx(36127.343e3, rel=1e-6)
    assert orbit.eccentricity == pytest.approx(0.832853, abs=1e-6)
    degrees = np.degrees([orbit.inclination, orbit.raan % (2 * np.pi)])
    assert degrees == pytest.approx([87.870, 227.898], abs=1e-3)
    in_plane = np.degrees([orbit.argument_of_periapsis % (2 * np.pi), orbit.true_anomaly])
    assert in_plane == pytest.approx([53.38, 92.335], abs=5e-3)


def test_a_geostationary_satellite_takes_a_sidereal_day():
    """The published radius 42 164.17 km has the period 86 164.1 s; gradient and rate follow."""
    orbit = KeplerOrbit(semi_major_axis=42164.17e3)
    assert 2.0 * np.pi / orbit.mean_motion == pytest.approx(86164.1, abs=0.1)
    assert orbit.gradient_at(0.0) == pytest.approx(3.0 * orbit.mean_motion**2, rel=1e-14)
    assert orbit.rate(0.0) == pytest.approx(orbit.mean_motion, rel=1e-14)


@pytest.mark.parametrize('e', [1e-8, 0.1, 0.7, 0.99])
def test_keplers_equation_is_solved(e):
    """
    The true anomaly of each time satisfies Kepler's equation, solved by mpmath in 30 digits.

    Near the pericentre f changes with M as sqrt(1 - e^2) / (1 - e)^2, which a rounding of M
    magnifies.
    """
    orbit = KeplerOrbit(eccentricity=e)
    turns = np.array([0.0, 1e-9, 1e-4, 0.02, 0.3, 0.499, 0.5, 0.75, 0.999, 1.0, 7.3, -0.25])
    found = orbit.anomaly(2.0 * np.pi * turns / orbit.mean_motion)
    slope = np.sqrt(1.0 - e * e) / (1.0 - e) ** 2
    with mp.workdps(30):
        for f, turn in zip(found, turns, strict=True):
            M = 2 * mp.pi * mp.mpf(turn)
            E = mp.findroot(lambda x, M=M: x - e * mp.sin(x) - M, M + e * mp.sin(M))
            half = mp.atan2(mp.sqrt(1 + e) * mp.sin(E / 2), mp.sqrt(1 - e) * mp.cos(E / 2))
            whole = 2 * mp.pi * mp.nint((E - 2 * half) / (2 * mp.pi)) + 2 * half
            assert f == pytest.approx(float(whole), abs=1e-15 * slope * (5 + abs(float(M))))


@pytest.mark.parametrize('e', ECCENTRICITIES)
def test_lvlh_points_along_track_against_the_normal_and_down(e):
    """LVLH has z to the centre, y against r x v and x completing them, ahead."""
    orbit = tilted(e)
    times = np.linspace(0.0, 2.0e4, 60)
    r_i, v_i = orbit.position_velocity(times)
    x, y, z = np.moveaxis(rotation.matrix(orbit.lvlh(times)), -1, 0)
    momentum = np.cross(r_i, v_i)
    close(z, -r_i / np.linalg.norm(r_i, axis=-1, keepdims=True), atol=1e-13)
    close(y, -momentum / np.linalg.norm(momentum, axis=-1, keepdims=True), atol=1e-13)
    close(x, np.cross(y, z), atol=1e-13)
    assert np.all(np.sum(x * v_i, axis=-1) > 0.0)
    close(-z, orbit.direction(times), atol=1e-13)
    close(orbit.normal, -y[0], atol=1e-13)


@pytest.mark.parametrize('e', [0.0, 0.3])
def test_the_lvlh_rate_is_the_rate_of_the_lvlh_attitude(e):
    """
    The published rate of LVLH is R' R^T, and its quaternions follow without a change of sign.

    Central difference over 1 s: truncation f'''/6 < 1e-9 of the rate's own 1e-3.
    """
    orbit = tilted(e)
    times = np.linspace(0.0, 3.0e4, 400)
    q = orbit.lvlh(times)
    assert np.all(np.sum(q[1:] * q[:-1], axis=-1) > 0.0)
    h = 1.0
    turn = rotation.multiply(orbit.lvlh(times + h), rotation.conjugate(orbit.lvlh(times - h)))
    rate = turn[:, :3] * np.sign(turn[:, 3:]) / h
    close(rate, orbit.lvlh_rate(times), atol=1e-8)


def test_distance_and_gradient_are_those_of_the_position():
    """Radius, gradient 3 mu / r^3 and rate |r x v| / r^2 agree with the position and velocity."""
    orbit = tilted(0.3)
    times = np.linspace(0.0, 1.0e4, 30)
    r_i, v_i = orbit.position_velocity(times)
    r = np.linalg.norm(r_i, axis=-1)
    close(orbit.radius(times), r, rtol=1e-14)
    close(orbit.gradient_at(times), 3.0 * orbit.mu / r**3, rtol=1e-13)
    momentum = np.linalg.norm(np.cross(r_i, v_i), axis=-1)
    close(orbit.rate(times), momentum / r**2, rtol=1e-13)
    pericentre_s = -orbit.mean_anomaly / orbit.mean_motion
    assert orbit.fastest_rate == pytest.approx(orbit.rate(pericentre_s), rel=1e-14)


def test_a_fixed_direction_stays_and_has_no_lvlh():
    """The centre is always below along -Z, at a constant strength, and there is no orbit."""
    field = FixedDirection(gradient=3.6e-6)
    times = np.array([0.0, 10.0])
    assert np.array_equal(field.direction(times), [[0, 0, 1], [0, 0, 1]])
    assert np.array_equal(field.gradient_at(times), [3.6e-6, 3.6e-6])
    assert not np.any(field.position_velocity(times))
    with pytest.raises(ValueError, match=r'orbit\.type is fixed, which has no LVLH'):
        field.lvlh(times)


@pytest.mark.parametrize('inclination', [0.0, 1e-9, 0.7, np.pi])
@pytest.mark.parametrize('e', [0.0, 1e-9, 0.3])
def test_circles_and_equators_have_elements_too(e, inclination):
    """Where node or pericentre are not defined, the state is given back too."""
    orbit = KeplerOrbit(EARTH_MU, 2.0e7, e, inclination, 0.4, 1.1, -2.0)
    r_i, v_i = orbit.position_velocity(0.0)
    found = KeplerOrbit.from_state(r_i, v_i)
    assert found.is_eccentric == (e > 0.0)
    for given_, again in zip(
        orbit.position_velocity(1e4), found.position_velocity(1e4), strict=True
    ):
        assert np.linalg.norm(again - given_) <= 1e-13 * np.linalg.norm(given_)


@pytest.mark.parametrize(
    ('r_i', 'v_i', 'reason'),
    [
        (
            [7e6, 0, 0],
            [0, 1.1e4, 0],
            r'is 11000 m/s, and from 10671.7 m/s on the satellite leaves',
        ),
        ([7e6, 0, 0], [1.2e4, 0, 0], 'the satellite leaves: the orbit is no ellipse'),
        ([7e6, 0, 0], [5e3, 0, 0], 'the satellite falls into the centre'),
        ([7e6, 0, 0], [0, 0, 0], 'the satellite falls into the centre'),
        ([0, 0, 0], [1e3, 0, 0], 'is the attracting centre itself'),
    ],
)
def test_a_state_on_no_ellipse_is_refused(r_i, v_i, reason):
    """Hyperbolas, falls and the centre, each in a sentence."""
    with pytest.raises(ValueError, match=reason):
        KeplerOrbit.from_state(r_i, v_i)


def test_the_reference_state_vector():
    """The orbit of the case state_vector, by another program; ten nanometres are its rounding."""
    cases = json.loads((REFERENCE / 'environment.json').read_text())['cases']
    (case,) = (case for case in cases if case['name'] == 'state_vector')
    given_ = case['scenario']['orbit']
    orbit = KeplerOrbit.from_state(given_['position'], given_['velocity'])
    r_i, v_i = orbit.position_velocity(np.array([row['t'] for row in case['orbit']]))
    close(r_i, [row['r_i'] for row in case['orbit']], atol=1e-7)
    close(v_i, [row['v_i'] for row in case['orbit']], atol=1e-10)

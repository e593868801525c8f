"""What theory says about a scenario, against the references and the papers."""

import json
from pathlib import Path

import numpy as np
import pytest

from satdyn_ros.base.nanoseconds import epochs as epochs_of
from satdyn_ros.base.nanoseconds import stamp_ns
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.run.describe import describe
from satdyn_ros.run.scenario import Scenario

CONFIG = Path(__file__).parents[2] / 'config'


def facts(described):
    return {fact['name']: fact['value'] for fact in described['motion']['facts']}


@pytest.mark.parametrize(
    'path',
    # Code of its own is compiled for four wheels.
    [
        pytest.param(path, marks=[pytest.mark.long] * (path.stem == 'pyramid'), id=path.stem)
        for path in sorted(CONFIG.glob('*.yaml'))
    ],
)
def test_every_shipped_scenario_is_described(path):
    """Each gives plain data: a closed form or the reason why there is none, and integrals."""
    scenario = Scenario.from_yaml(path, '/sat4' if path.stem == 'constellation' else None)
    described = describe(scenario)
    assert json.loads(json.dumps(described, allow_nan=False)) == described
    assert (described['motion'] is None) != (described['why_not'] is None)
    assert described['first_integrals']
    for steady in described['steady_motions']:
        assert steady['stability'] in ('stable', 'unstable', 'undecided')
        assert np.linalg.norm(steady['axis_b']) == pytest.approx(1.0, abs=1e-12)


def test_the_coning_of_a_spinning_satellite():
    """A symmetric body: coning period 2 pi A / L and period of the rates 2 pi A / |C - A| r0."""
    scenario = Scenario.from_dict(
        {
            'body': {'inertia': [100.0, 100.0, 170.0]},
            'orbit': {'type': 'fixed'},
            'initial': {'attitude': [0, 0, 0, 1], 'angular_velocity': [0.03, 0.04, 0.11]},
        }
    )
    described = describe(scenario)
    L = np.hypot(5.0, 18.7)
    assert described['motion']['name'] == 'free rotation'
    assert facts(described)['T2'] == pytest.approx(2.0 * np.pi * 100.0 / L, rel=1e-14)
    assert facts(described)['T1'] == pytest.approx(2.0 * np.pi * 100.0 / (70.0 * 0.11), rel=1e-14)
    assert facts(described)['theta'] == pytest.approx([np.arctan2(5.0, 18.7)] * 2, rel=1e-14)
    assert described['first_integrals']['momentum']['value'] == pytest.approx(L, rel=1e-14)


def test_the_equilibria_of_a_satellite():
    """I_n > I_t > I_r: the 24, four of them stable, with Smelt's three periods."""
    described = describe(Scenario.from_dict({'body': {'inertia': [800.0, 900.0, 600.0]}}))
    steady = described['steady_motions']
    stable = [one for one in steady if one['stability'] == 'stable']
    assert (len(steady), len(stable)) == (24, 4)
    n = np.sqrt(3.986004418e14 / 6.878137e6**3)
    # THEORY of small motion for (900, 800, 600): 1.437541 n, 0.816497 n, 0.347816 n
    expected = 2.0 * np.pi / n / np.array([0.347816, 0.816497, 1.437541])
    for one in stable:
        assert one['periods_s'] == pytest.approx(expected, rel=2e-6)
        assert abs(one['axis_b'][2]) == pytest.approx(1.0, abs=1e-12)
        assert one['rate_rad_s'] == pytest.approx(n, rel=1e-12)


def test_why_there_is_none():
    """Where nothing is closed the reason is that of exact.explain, and equilibria are given."""
    described = describe(Scenario.from_yaml(CONFIG / 'default.yaml'))
    assert described['motion'] is None
    assert 'orbit normal' in described['why_not']
    assert described['rotation_class']['is_rotation'] is False
    assert described['steady_motions']


def test_a_rotation_about_the_orbit_normal():
    """The theorem of Balli and Grioli names the libration of its scenario."""
    described = describe(Scenario.from_yaml(CONFIG / 'balli_grioli.yaml'))
    assert described['motion']['name'] == 'planar motion'
    assert described['rotation_class'] == {
        'is_rotation': True,
        'is_uniform': False,
        'why': 'the body swings or tumbles about the orbit normal, a principal axis',
    }


def test_what_is_stable_in_rate_drifts_in_attitude():
    """
    A day of a millionth of 0.5 rad/s, for the four stable rotations of the free body (44.16).

    Equilibria in LVLH, which the field holds, do not drift, and neither does what is unstable.
    """
    described = describe(Scenario.from_yaml(CONFIG / 'euler_poinsot.yaml'))
    for one in described['steady_motions']:
        drift = one['attitude_drift_rad']
        if one['stability'] == 'stable':
            assert drift == pytest.approx(one['rate_rad_s'] * 0.0864, rel=1e-12)
        else:
            assert drift is None
    on_orbit = describe(Scenario.from_dict({'body': {'inertia': [800.0, 900.0, 600.0]}}))
    assert {one['attitude_drift_rad'] for one in on_orbit['steady_motions']} == {None}


def test_a_general_tensor_has_its_principal_moments_and_axes():
    """Each axis is one of the tensor with its moment, in a right-handed set."""
    inertia = np.array([[800.0, 40.0, -30.0], [40.0, 900.0, 20.0], [-30.0, 20.0, 600.0]])
    given = [*np.diagonal(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    described = describe(Scenario.from_dict({'body': {'inertia': [float(x) for x in given]}}))
    axes = np.array(described['principal_axes_b'])
    moments = np.array(described['principal_moments'])
    np.testing.assert_allclose(axes @ inertia, moments[:, None] * axes, atol=1e-10)
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-12)


def test_a_coning_satellite_precesses_regularly():
    """
    Spin and precession are those of (45.5), corrected: L_3 (1 / I_3 - 1 / I_1) and L / I_1.

    Flattened, it spins against its precession, and the space cone lies inside the body's.
    """
    body = {'inertia': [100.0, 100.0, 170.0]}
    start = {'attitude': [0, 0, 0, 1], 'angular_velocity': [0.03, 0.04, 0.11]}
    described = describe(
        Scenario.from_dict({'body': body, 'orbit': {'type': 'fixed'}, 'initial': start})
    )
    found = described['regular_precession']
    L = np.hypot(5.0, 18.7)
    assert found['precession_rad_s'] == pytest.approx(L / 100.0, rel=1e-13)
    assert found['spin_rad_s'] == pytest.approx(18.7 * (1 / 170.0 - 1 / 100.0), rel=1e-13)
    assert (found['sense'], found['cones']) == ('retrograde', 'space cone inside')
    tangents = np.tan([found['body_cone_rad'], found['space_cone_rad']])
    angle = np.arctan2(5.0, 18.7)
    np.testing.assert_allclose(tangents[0], 0.05 / 0.11, rtol=1e-13)
    np.testing.assert_allclose(tangents[1], np.tan(np.arctan2(0.05, 0.11) - angle), rtol=1e-12)
    assert facts(described)['chi'] == pytest.approx(
        facts(described)['T1'] * facts(described)['chi0'], rel=1e-14
    )


@pytest.mark.parametrize(('rate', 'returns'), [(0.5, '3'), (0.50001, 'not commensurable')])
def test_whether_the_periods_are_commensurable(rate, returns):
    """T1 / T2 = (L / I_1) / |(C - A) r0 / I_1|: 3 to the digits given, or no small fraction."""
    # L = 3 (C - A) r0 with C = 1.6, A = 1, so that across 1.8^2 = 1.6^2 + (p / r0)^2
    across = rate * np.sqrt(1.8**2 - 1.6**2) if returns == '3' else 0.4
    described = describe(
        Scenario.from_dict(
            {
                'body': {'inertia': [1.0, 1.0, 1.6]},
                'orbit': {'type': 'fixed'},
                'initial': {
                    'attitude': [0, 0, 0, 1],
                    'angular_velocity': [float(across), 0.0, rate],
                },
            }
        )
    )
    assert facts(described)['T1/T2'] == returns


def test_what_is_said_on_an_ellipse():
    """
    The shipped boom: period, p = 3 (I_t - I_r) / I_n of each axis, and the forced libration.

    Upright at rest in LVLH, an equilibrium of the circle, it does not rest: it sways by more than
    the forced libration, to which a free one is added.
    """
    scenario = Scenario.from_yaml(CONFIG / 'elliptic_orbit.yaml')
    described = describe(scenario)
    assert described['steady_motions'] == []
    assert 'three equal moments' in described['why_not']
    ellipse = described['elliptic_orbit']
    assert ellipse['eccentricity'] == 0.1
    assert ellipse['period_s'] == pytest.approx(2.0 * np.pi * np.sqrt(8e6**3 / 3.986004418e14))
    moments = np.array([1200.0, 1230.0, 40.0])
    found = {int(np.argmax(np.abs(one['normal_b']))): one for one in ellipse['librations']}
    for k in range(3):
        p = 3.0 * abs(moments[k - 1] - moments[k - 2]) / moments[k]
        assert found[k]['p'] == pytest.approx(p, rel=1e-12)
    amplitude = found[1]['forced_amplitude_rad']
    assert amplitude == pytest.approx(0.2 / (found[1]['p'] - 1.0), rel=1e-12)
    t_s = np.linspace(0.0, 5.0 * ellipse['period_s'], 2000)
    up = scenario.system.orbit.direction(t_s)
    states = Propagation(scenario.system, scenario.initial_state).at(t_s)
    axis = rotation.rotate(states.q_ib, [0.0, 0.0, 1.0])
    tilt = np.arcsin(np.linalg.norm(np.cross(axis, up), axis=-1))
    assert amplitude < np.max(tilt) < 2.2 * amplitude
    assert describe(Scenario.from_yaml(CONFIG / 'default.yaml'))['elliptic_orbit'] is None


def test_what_is_said_of_an_element_set():
    """
    The space station of 2008: the catalogue of the day has 347 km by 358 km, 91.6 min, 51.64 deg.

    The age is that between the epoch of the lines, day 264.51782528, and tick 0.
    """
    pytest.importorskip('sgp4')
    lines = [
        '1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927',
        '2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537',
    ]
    values = {'orbit.type': 'tle', 'orbit.tle': lines, 'time.epoch': '2008-09-22T12:00:00Z'}
    found = describe(Scenario(values))['orbit']
    assert found['tick_0'] == '2008-09-22T12:00:00.000000000'
    # Day 264 is 20 September.
    assert found['elements_epoch'].startswith('2008-09-20T12:25:40.104')
    assert found['age_days'] == pytest.approx(266.5 - 264.51782528, abs=1e-9)
    assert found['period_s'] == pytest.approx(86400.0 / 15.72125391, rel=1e-12)
    assert np.degrees(found['inclination_rad']) == pytest.approx(51.6416, abs=1e-12)
    # By Kepler's third law; the mean motion of the lines is 5e-4 off that of the mean ellipse.
    a_m = np.cbrt(3.986008e14 * (found['period_s'] / (2.0 * np.pi)) ** 2)
    heights = [found['perigee_height_m'], found['apogee_height_m']]
    wanted = a_m * (1.0 + 0.0006703 * np.array([-1.0, 1.0])) - 6378135.0
    np.testing.assert_allclose(heights, wanted, rtol=0.0, atol=3e3)
    assert describe(Scenario.from_yaml(CONFIG / 'default.yaml'))['orbit'] is None


def test_what_is_said_of_an_ephemeris():
    """Rows of a Kepler ellipse, whose heights, period and inclination are known."""
    pytest.importorskip('erfa')
    ellipse = KeplerOrbit(semi_major_axis=7e6, eccentricity=0.02, inclination=1.0)
    t_s = np.arange(0.0, 7200.1, 30.0)
    r_i, v_i = ellipse.position_velocity(t_s)
    epochs = epochs_of(stamp_ns('2026-03-01T12:00:00') + np.rint(t_s * 1e9).astype(np.int64))
    rows = [
        ' '.join([at, *map(repr, (np.hstack([r, v]) / 1e3).tolist())])
        for at, r, v in zip(epochs, r_i, v_i, strict=True)
    ]
    text = '\n'.join(
        [
            *('CCSDS_OEM_VERS = 2.0', 'CREATION_DATE = 2026-03-01T12:00:00', 'ORIGINATOR = X'),
            *('META_START', 'OBJECT_NAME = X', 'OBJECT_ID = X', 'CENTER_NAME = EARTH'),
            *('REF_FRAME = EME2000', 'TIME_SYSTEM = UTC', f'START_TIME = {epochs[0]}'),
            *(f'STOP_TIME = {epochs[-1]}', 'META_STOP', *rows, ''),
        ]
    )
    values = {'orbit.type': 'oem', 'orbit.file': text, 'time.epoch': '2026-03-01T12:10:00Z'}
    found = describe(Scenario(values))['orbit']
    assert (found['begin'], found['end']) == (epochs[0], epochs[-1])
    assert found['tick_0'] == '2026-03-01T12:10:00.000000000'
    assert found['period_s'] == pytest.approx(2.0 * np.pi / ellipse.mean_motion, rel=1e-6)
    assert found['inclination_rad'] == pytest.approx(1.0, abs=1e-6)
    # A turn in 721 steps passes the apses within half a degree, 5 m of 140 km.
    heights = [found['lowest_height_m'], found['highest_height_m']]
    np.testing.assert_allclose(heights, [7e6 * 0.98 - 6378137.0, 7e6 * 1.02 - 6378137.0], atol=10)


def test_a_sphere_on_an_ellipse_has_its_closed_form():
    """What the field does not turn; it has an ellipse all the same, and p = 0."""
    orbit = {'type': 'kepler', 'eccentricity': 0.2, 'semi_major_axis': 9e6}
    described = describe(
        Scenario.from_dict({'body': {'inertia': [5.0, 5.0, 5.0]}, 'orbit': orbit})
    )
    assert described['motion'] is not None
    assert [one['p'] for one in described['elliptic_orbit']['librations']] == [0.0, 0.0, 0.0]

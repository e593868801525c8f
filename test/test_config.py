"""Every shipped scenario loads, runs, and keeps what its motion conserves."""

import functools
from pathlib import Path

import numpy as np
import pytest
import yaml

from satdyn_ros import Scenario
from satdyn_ros.dynamics.integrals import relative_drift
from satdyn_ros.kernel import rotation
from satdyn_ros.run.parameter_file import ParameterFile, flattened

CONFIG = Path(__file__).parent.parent / 'config'
SCENARIOS = [path for path in sorted(CONFIG.glob('*.yaml')) if '/**:' in path.read_text()]
FAST_S = {'dual_spin': 300.0, 'euler_poinsot': 300.0}
LONG = ['cubesat_adcs', 'cubesat_leo', 'pyramid', 'sun_pointing']
EXACT = ['agostinelli', 'balli_grioli', 'beletsky', 'euler_poinsot', 'paladini']

every_exact = pytest.mark.parametrize('name', EXACT)
every_scenario = pytest.mark.parametrize('path', SCENARIOS, ids=lambda path: path.stem)


def constellation():
    """Return the scenarios of the constellation, name to Scenario, as rcl merges the sections."""
    sections = yaml.safe_load((CONFIG / 'constellation.yaml').read_text())
    parameters = {
        name: dict(flattened(section['ros__parameters'])) for name, section in sections.items()
    }
    shared = parameters.pop('/**')
    return {name: Scenario({**shared, **own}) for name, own in parameters.items()}


@functools.cache
def numeric(path):
    """Return the scenario of a file, propagated whatever its motion.method is."""
    parameters = ParameterFile.read([path]).parameters('/satdyn')
    return Scenario(parameters | {'motion.method': 'numeric'})


def times(path):
    """Return times over three low orbits, or over a hundred turns or so of something faster."""
    return np.linspace(0.0, FAST_S.get(path.stem, 20_000.0), 301)


def numbers_in_lists(node):
    """Return the lists of numbers of a YAML tree."""
    if isinstance(node, dict):
        for value in node.values():
            yield from numbers_in_lists(value)
    elif isinstance(node, list) and not isinstance(node[0], str):
        yield node


@every_scenario
def test_lists_hold_decimals_only(path):
    """The parser of rcl refuses lists that mix 1 and 1.0, and takes 1 for an integer."""
    for values in numbers_in_lists(yaml.safe_load(path.read_text())):
        assert {type(value) for value in values} == {float}


@every_scenario
def test_first_line_says_what_one_sees(path):
    """A user who opens the file reads what it shows before what it sets."""
    assert path.read_text().startswith('# ')


@pytest.mark.parametrize(
    'path',
    # Code of its own is compiled for four wheels, for all torques of the environment, for both.
    [
        pytest.param(
            path,
            marks=[pytest.mark.long] * (path.stem in LONG),
            id=path.stem,
        )
        for path in SCENARIOS
    ],
)
def test_flies_and_keeps_its_integrals(path):
    """Every scenario has a first integral or balance, which its propagation keeps to 2e-10."""
    scenario = numeric(path)
    states = scenario.motion().at(times(path))
    drift = relative_drift(scenario.system, states)
    assert drift
    for name, values in drift.items():
        assert np.max(np.abs(values)) < 2e-10, name


@every_exact
def test_closed_form_agrees_with_propagation(name):
    """A scenario of a paper flies in closed form, and its propagation goes the same way."""
    path = CONFIG / f'{name}.yaml'
    scenario = Scenario.from_yaml(path)
    assert scenario['motion.method'] == 'exact'
    t_s = times(path)
    exact, propagated = scenario.motion().at(t_s), numeric(path).motion().at(t_s)
    assert np.max(rotation.angle_between(exact.q_ib, propagated.q_ib)) < 1e-9


def test_only_closed_forms_ask_for_one():
    """Every file with motion.method exact is in the list above."""
    asking = {path.stem for path in SCENARIOS if 'method: exact' in path.read_text()}
    assert asking == set(EXACT)


def test_constellation():
    """Eight different satellites on one orbit, an eighth of it apart, each a valid scenario."""
    satellites = constellation()
    assert list(satellites) == [f'/sat{k}/satdyn' for k in range(1, 9)]
    ahead = [satellite['orbit.true_anomaly'] for satellite in satellites.values()]
    np.testing.assert_allclose(np.diff(ahead), np.pi / 4, atol=1e-6)  # written to six decimals
    assert len(set(satellites.values())) == 8
    t_s = np.linspace(0.0, 20_000.0, 301)
    for satellite in satellites.values():
        drift = relative_drift(satellite.system, satellite.motion().at(t_s))
        assert np.max(np.abs(drift['jacobi'])) < 2e-10


def test_nasa_cylinder_swings_with_the_published_period():
    """Released 5 deg from the vertical in the orbit plane it swings there with 3264.16 s."""
    t_s = np.arange(0.0, 40 * 3264.16, 1.0)
    states = numeric(CONFIG / 'nasa_cylinder.yaml').motion().at(t_s)
    in_plane = rotation.rotate(states.q_lb, [1.0, 0.0, 0.0])[:, 0]
    crossings = t_s[1:][in_plane[1:] * in_plane[:-1] < 0.0]
    # The one degree across the plane modulates single swings by a second or two.
    assert 2.0 * np.mean(np.diff(crossings)) == pytest.approx(3264.16, abs=0.3)


def test_elliptic_orbit_sways_in_pitch_alone():
    """Beletsky's planar equation: nothing drives roll and yaw, the eccentricity the pitch."""
    states = numeric(CONFIG / 'elliptic_orbit.yaml').motion().at(np.linspace(0.0, 7e4, 2001))
    roll, pitch, yaw = np.rad2deg(np.abs(rotation.roll_pitch_yaw(states.q_lb))).max(axis=0)
    assert roll < 1e-6
    assert yaw < 1e-6
    assert 8.0 < pitch < 12.0


def test_rotor_of_the_pitch_bias_gyrostat_holds_it_up():
    """With the rotor roll and yaw stay as small as they start; without it the body turns over."""
    t_s = np.linspace(0.0, 40 * 5677.0, 4001)
    scenario = numeric(CONFIG / 'pitch_bias_gyrostat.yaml')
    bare = scenario.with_values({'rotor.momentum': 0.0})
    largest = [
        np.rad2deg(np.abs(rotation.roll_pitch_yaw(each.motion().at(t_s).q_lb))).max()
        for each in (scenario, bare)
    ]
    assert largest[0] < 3.0
    assert largest[1] > 90.0


def test_euler_poinsot_flips():
    """Spun about the middle axis the body turns it over every 90.67 s, half a period of it."""
    scenario = numeric(CONFIG / 'euler_poinsot.yaml')
    t_s = np.arange(0.0, 400.0, 0.1)
    middle = scenario.motion().at(t_s).omega_bi_b[:, 1]
    assert np.count_nonzero(middle[1:] * middle[:-1] < 0.0) == 4


def test_the_aggregator_groups_the_constellation():
    """A group for each satellite of the file, which takes what its node reports and no other."""
    text = (CONFIG / 'diagnostics' / 'constellation.yaml').read_text()
    groups = yaml.safe_load(text)['analyzers']['ros__parameters']
    assert groups.pop('path') == 'Constellation'
    satellites = ParameterFile.read([CONFIG / 'constellation.yaml']).satellites
    for group in groups.values():
        assert group['type'] == 'diagnostic_aggregator/GenericAnalyzer'
    beginnings = [begin for group in groups.values() for begin in group['startswith']]
    assert [f'/{begin}' for begin in beginnings] == satellites

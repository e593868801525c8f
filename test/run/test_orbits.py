"""Scenarios on orbits of states, element sets and ephemerides: what they fly and report."""

import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose
from run.test_one_mind import EPHEMERIS

from satdyn_ros.orbits import KeplerOrbit, TabledOrbit
from satdyn_ros.run.requests import try_out
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

ELEMENTS = KeplerOrbit(eccentricity=0.01, semi_major_axis=7e6, inclination=0.5, true_anomaly=1.0)
LINES = (
    '1 28057U 03049A   06177.78615833  .00000060  00000-0  35940-4 0  1836',
    '2 28057  98.4283 247.6961 0000884  88.1964 271.9322 14.35478080140550',
)
R_I, V_I = (tuple(x.tolist()) for x in ELEMENTS.position_velocity(0.0))
STATE = {'orbit.type': 'state', 'orbit.position': R_I, 'orbit.velocity': V_I}
TLE = {'orbit.type': 'tle', 'orbit.tle': LINES}
OEM = {'orbit.type': 'oem', 'orbit.file': EPHEMERIS, 'time.epoch': '2026-03-01T12:00:00'}


def file_of(directory, orbit):
    path = directory / 'scenario.yaml'
    path.write_text(f'/**:\n  ros__parameters:\n    orbit: {orbit}\n')
    return path


def test_a_state_is_the_ellipse_through_it():
    """A kepler orbit in all respects; the elements lose some digits of the state's sixteen."""
    orbit = Scenario(STATE).system.orbit
    assert isinstance(orbit, KeplerOrbit)
    for found, given in zip(orbit.position_velocity(0.0), (R_I, V_I), strict=True):
        assert_allclose(found, given, rtol=1e-12, atol=1e-12 * np.linalg.norm(given))


def test_j2_makes_a_table_that_begins_as_the_ellipse():
    """Elements are osculating at tick 0; without j2 nothing changes."""
    orbit = Scenario(STATE | {'orbit.j2': 1e-3}).system.orbit
    assert isinstance(orbit, TabledOrbit)
    assert_allclose(orbit.position_velocity(0.0)[0], R_I, rtol=0.0, atol=1e-3)


@pytest.mark.parametrize('given', [STATE, TLE, OEM])
def test_what_is_written_loads_again(given):
    """With all texts: a bag stands alone."""
    scenario = Scenario(given)
    assert Scenario.from_yaml_text(scenario.to_yaml()) == scenario


def test_what_is_not_given_is_not_written():
    """The text of a scenario on an orbit of today stays as it is."""
    assert not {'position', 'velocity', 'tle', 'file', 'j2'} & {
        line.partition(':')[0].strip() for line in Scenario().to_yaml().splitlines()
    }


@pytest.mark.parametrize('text', ['\n'.join(LINES), '\r\n'.join(LINES) + '\r\n\r\n'])
def test_an_element_set_is_read_beside_the_parameter_file(tmp_path, monkeypatch, text):
    """Its text is then the value, wherever the process works, and written it loads again."""
    pytest.importorskip('sgp4')
    (tmp_path / 'cbers.tle').write_bytes(text.encode())
    monkeypatch.chdir('/')
    scenario = Scenario.from_yaml(file_of(tmp_path, "{type: 'tle', tle: ['cbers.tle']}"))
    assert '\n'.join(scenario['orbit.tle']).split() == ' '.join(LINES).split()
    assert Scenario.from_yaml_text(scenario.to_yaml()) == scenario


def test_an_ephemeris_is_read_beside_the_parameter_file(tmp_path):
    """As an element set."""
    (tmp_path / 'orbit.oem').write_text(EPHEMERIS)
    scenario = Scenario.from_yaml(file_of(tmp_path, '{type: oem, file: orbit.oem}'))
    assert scenario['orbit.file'] == EPHEMERIS


@pytest.mark.parametrize('mark', [b'', b'\xef\xbb\xbf'])
def test_files_are_read_with_a_byte_order_mark_and_without(tmp_path, mark):
    """The parameter file, and those that it names."""
    pytest.importorskip('sgp4')
    for name, text in (('a.oem', EPHEMERIS), ('a.tle', '\n'.join(LINES))):
        (tmp_path / name).write_bytes(mark + text.encode())
    for orbit in ('{type: oem, file: a.oem}', '{type: tle, tle: [a.tle]}'):
        path = file_of(tmp_path, orbit)
        path.write_bytes(mark + path.read_bytes())
        assert Scenario.from_yaml(path)['orbit.type'] in orbit


def test_a_name_in_a_dictionary_is_seen_from_the_working_directory(tmp_path, monkeypatch):
    """What has a line break is the text itself."""
    (tmp_path / 'orbit.oem').write_text(EPHEMERIS)
    monkeypatch.chdir(tmp_path)
    for given in ('orbit.oem', EPHEMERIS):
        scenario = Scenario.from_dict({'orbit': {'type': 'oem', 'file': given}})
        assert scenario['orbit.file'] == EPHEMERIS
    with pytest.raises(ValueError, match=r'orbit\.file .*none\.oem cannot be read'):
        Scenario.from_dict({'orbit': {'type': 'oem', 'file': 'none.oem'}})


def test_an_ephemeris_that_leaves_is_reported_by_its_key():
    """Of no key that was not given."""
    with pytest.raises(ValueError, match=r'^orbit.file is no ellipse at tick 0: 20000 m/s at'):
        Scenario(OEM | {'orbit.file': EPHEMERIS.replace('0 7.5 0', '0 20 0')}).motion()


def test_a_file_that_is_not_there(tmp_path):
    """One sentence names key and file."""
    with pytest.raises(ValueError, match=r'orbit\.file .*none\.oem cannot be read'):
        Scenario.from_yaml(file_of(tmp_path, '{type: oem, file: none.oem}'))


@pytest.mark.parametrize(
    ('given', 'sentence'),
    [
        ({'orbit.type': 'state'}, 'orbit.position is the attracting centre'),
        (STATE | {'orbit.velocity': (0.0, 2e4, 0.0)}, 'orbit.velocity is 20000 m/s'),
        (STATE | {'orbit.velocity': (*R_I[:2], 0.0)}, 'orbit.velocity'),
        ({'orbit.type': 'tle'}, 'orbit.type is tle, and orbit.tle is not given'),
        ({'orbit.type': 'oem', 'orbit.file': 'x.oem'}, 'orbit.file: this is not'),
        ({'orbit.tle': LINES}, 'orbit.tle is given; with orbit.type circular'),
        (TLE | {'orbit.mu': 4e14}, r'orbit.mu is 4e\+14; with orbit.type tle'),
        (TLE | {'orbit.j2': 1e-3}, 'orbit.j2 is 0.001; with orbit.type tle'),
        (TLE | {'orbit.tle': LINES[::-1]}, 'orbit.tle has its second line first'),
        (TLE | {'orbit.tle': (LINES[0][:-1] + '1', LINES[1])}, 'orbit.tle ends with the checksum'),
    ],
)
def test_refused(given, sentence):
    """In one sentence that names the key."""
    with pytest.raises(ValueError, match=sentence):
        Scenario(given)


def test_without_an_instant_there_is_no_orbit():
    """Until tick 0 has one, for what begins at the wall clock."""
    pytest.importorskip('sgp4')
    scenario = Scenario(TLE)
    assert 'tle' in repr(scenario)
    with pytest.raises(ValueError, match=r'orbit\.type tle needs the instant of tick 0'):
        scenario.motion()
    assert isinstance(scenario.with_epoch(1151370000 * 10**9).system.orbit, TabledOrbit)


def test_an_old_element_set_is_reported():
    """A scenario warns of elements more than two weeks from tick 0."""
    pytest.importorskip('sgp4')
    (warning,) = Scenario(TLE | {'time.epoch': '2006-08-01T00:00:00'}).warnings
    assert 'orbit.tle' in warning
    assert Scenario(TLE | {'time.epoch': '2006-06-27T00:00:00'}).warnings == ()


def test_what_is_not_used_is_not_loaded():
    """A scenario without an element set loads neither the library nor what reads them."""
    code = (
        'import sys; from satdyn_ros import Scenario; Scenario().system; '
        "print({'sgp4', 'erfa', 'satdyn_ros.orbits.tle'} & set(sys.modules))"
    )
    found = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True, timeout=60
    )
    assert found.stdout.strip() == 'set()'


def test_a_run_ends_with_its_ephemeris():
    """It may begin near the end, and comes to a halt after the last tick that has a position."""
    scenario = Scenario(OEM | {'publish.rate': 1.0, 'time.epoch': '2026-03-01T12:02:50'})
    try_out(scenario, 0)
    simulation = Simulation(scenario)
    _, samples = simulation.advance(100)
    assert len(samples) == 11
    _, samples = simulation.advance(1)
    assert len(samples) == 0 == len(samples.states.r_i)
    assert 'no position after 2026-03-01T12:03:00' in str(simulation.halted)

"""Element sets of a file fly, one chosen or all."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from satdyn_ros.base.nanoseconds import stamp_ns
from satdyn_ros.cli.main import main
from satdyn_ros.environment.earth import teme_to_gcrs
from satdyn_ros.run.parameter_file import ParameterFile
from satdyn_ros.run.scenario import Scenario

api = pytest.importorskip('sgp4.api')
omm = pytest.importorskip('sgp4.omm')

COUNT = 100
TICK_0 = '2026-02-27T05:33:06'


def fields(i):
    """Return the mean elements of the i-th satellite of a shell of a hundred, made up."""
    return {
        'OBJECT_NAME': f'SHELL-{i}',
        'OBJECT_ID': '2026-001A',
        'EPOCH': '2026-02-27T05:33:05.250000',
        'MEAN_MOTION': 15.06 + 1e-4 * i,
        'ECCENTRICITY': 0.0005,
        'INCLINATION': 53.05,
        'RA_OF_ASC_NODE': 3.6 * i,
        'ARG_OF_PERICENTER': 347.9,
        'MEAN_ANOMALY': 36.0 * (i % 10),
        'EPHEMERIS_TYPE': 0,
        'CLASSIFICATION_TYPE': 'U',
        'NORAD_CAT_ID': 143_700 + i,
        'ELEMENT_SET_NO': 999,
        'REV_AT_EPOCH': 1,
        'BSTAR': 0.0002,
        'MEAN_MOTION_DOT': 3e-05,
        'MEAN_MOTION_DDOT': 0,
    }


def by_sgp4(i, epoch):
    """Return where the package sgp4 has the i-th at an epoch, turned to inertial axes [m]."""
    satellite = api.Satrec()
    known = {key: str(value) for key, value in fields(i).items()}
    # It knows five digits and a letter alone, and does not use them.
    omm.initialize(satellite, known | {'NORAD_CAT_ID': '0'})
    days = 2440587.5 + stamp_ns(f'{epoch[:10]}T00:00:00') // (86400 * 10**9)
    part = (stamp_ns(epoch) - stamp_ns(f'{epoch[:10]}T00:00:00')) / 86400e9
    error, r_km, _ = satellite.sgp4(days, part)
    assert error == 0
    return teme_to_gcrs(stamp_ns(epoch)) @ np.array(r_km) * 1e3


@pytest.fixture(scope='module')
def fleet(tmp_path_factory):
    """Return the parameter file of a hundred, beside a folder with the file of their sets."""
    directory = tmp_path_factory.mktemp('fleet')
    (directory / 'sets').mkdir()
    (directory / 'sets' / 'gp.json').write_text(json.dumps([fields(i) for i in range(COUNT)]))
    path = directory / 'fleet.yaml'
    assert main(['constellation', str(directory / 'sets' / 'gp.json'), '-o', str(path)]) == 0
    return path


def test_a_hundred_fly_where_sgp4_has_them(fleet):
    """From a whole second after the epochs on; the table is SGP4 to a millimetre."""
    file = ParameterFile.read([fleet])
    assert len(file.satellites) == COUNT
    for i in range(COUNT):
        scenario = Scenario(file.flown(f'/shell_{i}/satdyn'))
        assert scenario.epoch_ns == stamp_ns(TICK_0)
        r_i, _ = scenario.system.orbit.position_velocity(0.0)
        np.testing.assert_allclose(r_i, by_sgp4(i, TICK_0), rtol=0.0, atol=1e-3)


def test_they_are_simulated(fleet, tmp_path, capsys):
    """Each to a bag of its own, by one command."""
    names = [word for i in range(3) for word in ('--satellite', f'/shell_{i}')]
    out = str(tmp_path / 'bags')
    assert main(['simulate', str(fleet), *names, '--duration', '0.01', '-o', out]) == 0
    assert sorted(path.name for path in Path(out).iterdir()) == ['shell_0', 'shell_1', 'shell_2']


@pytest.mark.parametrize('word', ['143742', 'shell-42'])
def test_one_is_chosen_beside_the_parameter_file(fleet, tmp_path, word):
    """By number or name; the bag's scenario has its elements alone."""
    path = fleet.parent / 'one.yaml'
    path.write_text(
        '/**:\n  ros__parameters:\n    orbit:\n      type: tle\n'
        f"      tle: [sets/gp.json, '{word}']\n    time: {{epoch: '{TICK_0}Z'}}\n"
    )
    scenario = Scenario.from_yaml(path)
    r_i, _ = scenario.system.orbit.position_velocity(0.0)
    np.testing.assert_allclose(r_i, by_sgp4(42, TICK_0), rtol=0.0, atol=1e-3)
    assert 'SHELL-41' not in scenario.to_yaml()
    assert Scenario.from_yaml_text(scenario.to_yaml()) == scenario


def test_names_are_chosen_by_a_pattern(fleet, tmp_path):
    """In either case; names that are the same in a namespace get what distinguishes them."""
    sets = tmp_path / 'gp.json'
    named = ['a b', 'A-B', 'a b', '7', '']
    sets.write_text(
        json.dumps([fields(i) | {'OBJECT_NAME': name} for i, name in enumerate(named)])
    )
    out = tmp_path / 'all.yaml'
    assert main(['constellation', str(sets), '-o', str(out)]) == 0
    assert ParameterFile.read([out]).satellites == [
        f'/{name}/satdyn'
        for name in ('a_b_143700', 'a_b_143701', 'a_b_143702', 'sat_7', 'sat_143704')
    ]
    assert main(['constellation', str(sets), '--name', 'A?B', '-o', str(out)]) == 0
    assert len(ParameterFile.read([out]).satellites) == 3


@pytest.mark.parametrize(
    ('text', 'arguments', 'sentence'),
    [
        ('[{"EPOCH": 1},\n', (), 'gp.json: line 2: its JSON is damaged'),
        (
            json.dumps([fields(0)]),
            ('--name', 'x*'),
            r"no set with a name like 'x\*', of 143700 SHELL-0",
        ),
        (json.dumps([fields(0), fields(0)]), (), "it holds 2 sets of '143700'"),
        (json.dumps([fields(0) | {'BSTAR': ''}]), (), 'the set of line 1: .* it has no BSTAR'),
        (
            json.dumps([fields(0) | {'NORAD_CAT_ID': '', 'OBJECT_NAME': ''}]),
            (),
            'line 1 has neither a number nor a name',
        ),
    ],
)
def test_what_is_wrong_is_said_with_file_and_line(tmp_path, capsys, text, arguments, sentence):
    """In one sentence, with the exit code of wrong input; nothing is written."""
    path, out = tmp_path / 'gp.json', tmp_path / 'fleet.yaml'
    path.write_text(text)
    assert main(['constellation', str(path), *arguments, '-o', str(out)]) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1
    assert re.search(sentence, said)
    assert not out.exists()


@pytest.mark.parametrize(
    ('tle', 'sentence'),
    [
        ("[sets/gp.json, 'x']", "orbit.tle sets/gp.json: it holds no set of 'x', but of 143700"),
        ("[none.json, '1']", r'orbit\.tle .*none\.json cannot be read'),
        ('[sets/gp.json]', 'it holds 100 element sets; orbit.tle: .FILE'),
        ('[sets/gp.json, 143742]', 'a text that ROS takes for true, false or a number must be'),
    ],
)
def test_a_choice_that_fails_is_said(fleet, tle, sentence):
    """With the key and the file."""
    path = fleet.parent / 'bad.yaml'
    path.write_text(f'/**:\n  ros__parameters:\n    orbit: {{type: tle, tle: {tle}}}\n')
    with pytest.raises(ValueError, match=sentence):
        Scenario.from_yaml(path)


def test_a_folder_that_is_a_link_or_is_not_there(tmp_path, capsys):
    """The new file names the sets from where it is; without a folder nothing is written."""
    (tmp_path / 'deep' / 'er').mkdir(parents=True)
    (tmp_path / 'link').symlink_to(tmp_path / 'deep' / 'er')
    sets = tmp_path / 'gp.json'
    sets.write_text(json.dumps([fields(0)]))
    assert main(['constellation', str(sets), '-o', str(tmp_path / 'link' / 'fleet.yaml')]) == 0
    assert Scenario.from_yaml(tmp_path / 'link' / 'fleet.yaml')['orbit.type'] == 'tle'
    assert main(['constellation', str(sets), '-o', str(tmp_path / 'none' / 'fleet.yaml')]) == 2
    assert 'none: there is no such folder' in capsys.readouterr().err

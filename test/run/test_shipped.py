import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from satdyn_ros.run import shipped
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.sweep.plan import Plan

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize('name', shipped.names())
def test_every_shipped_scenario_is_found_by_name(name):
    """The name is that of its file, and the file is a scenario."""
    assert shipped.scenario_path(name) == ROOT / 'config' / f'{name}.yaml'
    assert Scenario.from_yaml(name) == Scenario.from_yaml(ROOT / 'config' / f'{name}.yaml')


def test_shipped_sweeps_are_found_by_name(tmp_path, monkeypatch):
    """Also where a folder of that name holds the results."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'capture').mkdir()
    assert {'capture', 'monte_carlo', 'smelt'} <= {*shipped.names('sweep')}
    for name in shipped.names('sweep'):
        assert len(Plan.from_yaml(shipped.sweep_path(name))) > 1
    with pytest.raises(ValueError, match=r'the sweep smelled is neither .*smelt'):
        shipped.sweep_path('smelled')


def test_a_path_is_taken_as_it_is(tmp_path, monkeypatch):
    """A file of the same name comes first, and what looks like a path is one."""
    (tmp_path / 'default').write_text('/**: {ros__parameters: {publish: {rate: 7.0}}}')
    monkeypatch.chdir(tmp_path)
    assert Scenario.from_yaml('default')['publish.rate'] == 7.0
    for given in ('no.yaml', 'no/such', '/no/such'):
        with pytest.raises(ValueError, match='cannot be read'):
            Scenario.from_yaml(given)
    with pytest.raises(ValueError, match=r'no such file; one of this name is shipped: cubesat$'):
        Scenario.from_yaml('config/cubesat.yaml')


def test_an_unknown_name_is_answered_by_which_there_are():
    """One sentence with the names."""
    with pytest.raises(ValueError, match=r'the scenario defualt is neither a file nor .*default'):
        Scenario.from_yaml('defualt')


def test_an_installed_package_finds_its_scenarios(tmp_path):
    """As pip lays it out: the package in site-packages, the files in share."""
    site = tmp_path / 'lib/python3/site-packages'
    shutil.copytree(
        ROOT / 'satdyn_ros', site / 'satdyn_ros', ignore=shutil.ignore_patterns('__pycache__')
    )
    config = tmp_path / 'share/satdyn_ros/config'
    config.mkdir(parents=True)
    (config / 'mine.yaml').write_text('/**: {ros__parameters: {}}')
    program = 'from satdyn_ros.run import shipped; print(shipped.scenario_path("mine"))'
    found = subprocess.run(
        [sys.executable, '-c', program],
        cwd=tmp_path,
        env={'PYTHONPATH': str(site), 'PATH': '/usr/bin'},
        capture_output=True,
        text=True,
    )
    assert found.stdout.strip() == str(config / 'mine.yaml'), found.stderr

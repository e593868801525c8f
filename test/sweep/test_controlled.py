"""Runs of a sweep with a controller in each, side by side and one by one, and as a bag."""

import json

import numpy as np
import pytest
import yaml

pytest.importorskip('pyarrow')

import pyarrow.parquet as pq

from satdyn_ros.bag.verify import verify
from satdyn_ros.cli.main import main
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.run import sweep

from .sweeps import rows_of, write

MAGNETIC = {
    'body': {'inertia': [0.058, 0.062, 0.025], 'dipole': [0.006, -0.004, 0.005]},
    'rotor': {'mode': 'none'},
    'magnetorquer': {'max_dipole': [0.2, 0.2, 0.2]},
    'orbit': {'type': 'kepler', 'semi_major_axis': 6.9e6, 'inclination': 1.7},
    'environment': {'magnetic_field': 'igrf'},
    'sensors': {'names': ['magnetometer'], 'magnetometer': {'noise': 5e-8}},
    'initial': {'frame': 'inertial'},
    'publish': {'rate': 1.0, 'topics': ['attitude']},
    'time': {'epoch': '2026-01-01T00:00:00Z'},
}
VARY = {
    'initial.attitude': 'sphere',
    'initial.angular_velocity': {'normal': [[0, 0, 0], [0.05, 0.05, 0.05]]},
    'body.inertia.x': {'uniform': [0.05, 0.06]},
}
CONTROLLER = """
import numpy as np


class Damper:
    period_s = 2.0
    vectorized = {vectorized}

    def __init__(self, gain=1e5, fails_at=None):
        self.gain, self.fails_at = gain, fails_at

    def reset(self, scenario, seed):
        self.last = None

    def command(self, sample):
        if np.max(sample.tick) == self.fails_at:
            raise ZeroDivisionError('nothing to divide by')
        B = np.array(sample.measured['magnetometer'])
        last, self.last = self.last, B
        return {{}} if last is None else {{'dipole_b': self.gain / 2.0 * (last - B)}}
"""


def written(folder, vectorized=True, **changes):
    """Write a sweep of magnetic satellites with a controller in a file; return its path."""
    (folder / 'damper.py').write_text(CONTROLLER.format(vectorized=vectorized))
    given = {'controller': 'damper.py:Damper', 'duration_s': 200, 'interval_s': 20, 'runs': 9}
    return write(folder, MAGNETIC, **{'vary': VARY, **given, **changes})


def test_side_by_side_they_are_what_they_are_one_by_one(tmp_path):
    """Every column; each run has noise of its own."""
    tables = []
    for vectorized in (True, False):
        folder = tmp_path / str(vectorized)
        folder.mkdir()
        plan = Plan.from_yaml(written(folder, vectorized, samples=True))
        tables.append(rows_of(plan, range(9)))
    assert tables[0] == tables[1]
    assert [row['failure'] for row in tables[0]] == 9 * [None]
    assert len({plan.scenario_of_run(run)['sensors.seed'] for run in range(9)}) == 9


def test_with_a_slow_bias_they_fly_one_by_one(tmp_path):
    """Runs in step have none, those of a controller that takes columns may: then each is alone."""
    sensors = {
        'names': ['magnetometer'],
        'magnetometer': {'noise': 5e-8, 'bias_instability': 1e-8},
    }
    path = written(tmp_path, runs=2)
    scenario = tmp_path / 'scenario.yaml'
    sections = yaml.safe_load(scenario.read_text())
    sections['/**']['ros__parameters']['sensors'] = sensors
    scenario.write_text(yaml.safe_dump(sections))
    assert [row['failure'] for row in rows_of(Plan.from_yaml(path), range(2))] == [None, None]


def test_the_controller_acts(tmp_path):
    """Against the same runs with a gain of zero: they turn otherwise, and end slower."""
    path = written(tmp_path, duration_s=2000, runs=4)
    ended = {}
    for gain in (0.0, 1e5):
        plan = Plan.from_yaml(
            path, controller=f'{tmp_path}/damper.py:Damper', controller_parameters=[f'gain={gain}']
        )
        ended[gain] = [np.linalg.norm(row['omega_bi_b']) for row in rows_of(plan, range(4))]
    assert np.all(np.array(ended[1e5]) < np.array(ended[0.0]))


def test_a_bag_of_a_run_is_the_run(tmp_path):
    """It verifies without the controller, and ends where the table says."""
    table = sweep(written(tmp_path, bags=[3]), tmp_path / 'out', workers=1)
    row = pq.read_table(table).to_pylist()[3]
    bag = tmp_path / 'out' / 'bags' / 'run_000003'
    (tmp_path / 'damper.py').unlink()
    assert verify(bag).is_true
    assert 'drift_energy' not in {name for name, x in row.items() if x is not None}
    assert row['captured'] is None


def test_a_controller_that_fails_fails_its_runs(tmp_path):
    """Each has the sentence with file and line, the sweep goes on."""
    for vectorized in (True, False):
        path = written(tmp_path, vectorized, controller_parameters={'fails_at': 4})
        rows = rows_of(Plan.from_yaml(path), range(3))
        for row in rows:
            assert 'damper.py, line 17' in row['failure']
            assert 'ZeroDivisionError: nothing to divide by' in row['failure']


REFUSED = {
    'an interval between ticks': ({'interval_s': 0.5, 'duration_s': 10}, 'interval_s is 0.5'),
    'no such class': ({'controller': 'damper.py:Other'}, 'Other'),
    'no parameter of it': ({'controller_parameters': {'size': 1}}, 'size'),
    'parameters that are none': ({'controller_parameters': 'gain'}, 'it must map names'),
}


@pytest.mark.parametrize(('changes', 'why'), REFUSED.values(), ids=REFUSED)
def test_what_is_wrong_is_refused(tmp_path, changes, why):
    """In one sentence, before anything is flown."""
    with pytest.raises(ValueError, match=why):
        Plan.from_yaml(written(tmp_path, **changes))


def test_another_controller_does_not_go_on(tmp_path, capsys):
    """A sweep that was begun with one is not finished with another of the same name."""
    path = written(tmp_path, runs=2)
    plan = Plan.from_yaml(path)
    (tmp_path / 'damper.py').write_text(CONTROLLER.format(vectorized=False))
    with pytest.raises(ValueError, match='is not the one with which the sweep began'):
        Plan.from_text(plan.to_text())


def test_the_command_takes_a_controller(tmp_path, capsys):
    """In place of that of the file; what it was is in sweep.json."""
    path, out = written(tmp_path, runs=2, controller=''), tmp_path / 'out'
    named = f'{tmp_path}/damper.py:Damper'
    given = ['sweep', path, '-o', out, '--controller', named, '--controller-parameter', 'gain=2.0']
    assert main([*map(str, given), '--workers', '1']) == 0
    assert '2 runs, 0 failed' in capsys.readouterr().out
    found = json.loads((out / 'sweep.json').read_text())
    assert (found['controller'], found['controller_parameters']) == (named, ['gain=2.0'])

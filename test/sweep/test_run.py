"""Sweeps give the same table wherever the runs are done and however often interrupted."""

import json
import signal

import numpy as np
import pyarrow.parquet as pq
import pytest
from rosbags.highlevel import AnyReader

from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.sweep import outcome
from satdyn_ros.sweep.batches import batches
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.run import sweep

from .sweeps import rows_of, start, wait_for_parts, write


@pytest.mark.long
def test_two_cores(many, tmp_path):
    """Two processes give the table of one."""
    path, expected = many
    assert sweep(path, tmp_path / 'two', workers=2).read_bytes() == expected


@pytest.mark.long
@pytest.mark.parametrize('how', [signal.SIGINT, signal.SIGKILL], ids=['SIGINT', 'SIGKILL'])
def test_interrupted_and_resumed(many, tmp_path, how):
    """Finished batches stay, are not done again, and the table is that of one go."""
    path, expected = many
    directory = tmp_path / 'interrupted'
    process = start(path, directory)
    wait_for_parts(directory, 3)
    process.send_signal(how)
    # The workers hold stderr open: it ends when they have ended too.
    process.communicate(timeout=60)
    assert process.returncode != 0
    assert not (directory / 'table.parquet').exists()
    before = {part.name: part.stat().st_mtime_ns for part in directory.glob('parts/*.parquet')}
    assert 3 <= len(before) < 19
    again = start(path, directory)
    wait_for_parts(directory, len(before) + 1)
    after = {part.name: part.stat().st_mtime_ns for part in directory.glob('parts/*.parquet')}
    assert before.items() <= after.items()
    assert again.wait(60) == 0
    assert (directory / 'table.parquet').read_bytes() == expected


def test_finished_is_not_done_again(tmp_path):
    """The same command on a finished directory leaves the table as it is."""
    table = tmp_path / 'done' / 'table.parquet'
    small = write(tmp_path)
    sweep(small, table.parent, workers=1)
    written = table.stat().st_mtime_ns
    assert sweep(small, table.parent, workers=1) == table
    assert table.stat().st_mtime_ns == written


@pytest.mark.long
def test_another_sweep_is_not_mixed_in(tmp_path):
    """A directory with another sweep, or with something else, is refused."""
    path = write(tmp_path)
    sweep(path, tmp_path / 'out', workers=1)
    other = write(tmp_path, seed=2)
    with pytest.raises(ValueError, match='holds another sweep'):
        sweep(other, tmp_path / 'out')
    with pytest.raises(ValueError, match='holds no sweep and is not empty'):
        sweep(other, tmp_path)


def test_rows_hold_what_the_runs_came_to(tmp_path):
    """The final state is that of a propagation of the drawn scenario; extremes bound it."""
    path = write(tmp_path)
    plan = Plan.from_yaml(path)
    rows = pq.read_table(sweep(path, tmp_path / 'out', workers=1)).to_pylist()
    assert [row['run'] for row in rows] == list(range(12))
    for row in rows:
        values = plan.values(row['run'])
        assert tuple(row['initial.attitude']) == values['initial.attitude']
        scenario = plan.scenario_of(values)
        states = Propagation(scenario.system, scenario.initial_state).at(12000.0)
        # Side by side or alone, a propagation differs by rounding.
        assert row['q_ib'] == pytest.approx(states.q_ib[0].tolist(), abs=1e-12)
        assert row['omega_bi_b'] == pytest.approx(states.omega_bi_b[0].tolist(), abs=1e-12)
        rate = np.linalg.norm(states.omega_bi_b[0])
        assert row['rate_min_rad_s'] - 1e-12 <= rate <= row['rate_max_rad_s'] + 1e-12
        angle = rotation.angle_between(rotation.IDENTITY, states.q_lb[0])
        assert row['lvlh_angle_min_rad'] - 1e-12 <= angle <= row['lvlh_angle_max_rad'] + 1e-12
        assert row['drift_jacobi'] < 1e-10
        assert row['failure'] is None


def test_long_runs_go_fewer_together(tmp_path, monkeypatch):
    """However many fly side by side, for the memory's sake, their rows are the same."""
    plan = Plan.from_yaml(write(tmp_path))
    together = rows_of(plan, range(12))
    monkeypatch.setattr(outcome, '_SAMPLES_AT_ONCE', 5 * len(plan.t_s))
    monkeypatch.setattr(outcome, '_SAMPLES_IN_CACHE', 2 * len(plan.t_s))
    assert rows_of(plan, range(12)) == together


@pytest.mark.long
def test_captured_or_tumbling(tmp_path):
    """At rest at LVLH or upside down: captured from the start; turning fast: tumbling."""
    upright, upside_down = [0.0, 0.01, 0.0, 0.99995], [0.99995, 0.0, 0.01, 0.0]
    vary = {
        'initial.attitude': {'values': [upright, upside_down]},
        'initial.angular_velocity.y': {'values': [0.0, 0.02]},
    }
    scenario = {'rotor': {'mode': 'none'}, 'initial': {}}
    path = write(tmp_path, scenario, vary=vary, runs=1)
    rows = pq.read_table(sweep(path, tmp_path / 'out', workers=1)).to_pylist()
    assert [row['captured'] for row in rows] == [True, False, True, False]
    assert [row['capture_s'] for row in rows] == [0.0, None, 0.0, None]


def test_a_run_that_fails_is_a_row(tmp_path):
    """An inertia that no body has ends that run alone, and the row says why."""
    vary = {'body.inertia.x': {'values': [800.0, 5000.0, 700.0]}}
    path = write(tmp_path, vary=vary, runs=1)
    rows = pq.read_table(sweep(path, tmp_path / 'out', workers=1)).to_pylist()
    assert [row['body.inertia.x'] for row in rows] == [800.0, 5000.0, 700.0]
    assert 'body.inertia is [5000, 900, 600]' in rows[1]['failure']
    assert rows[1]['q_ib'] is None
    assert [rows[k]['failure'] for k in (0, 2)] == [None, None]


@pytest.mark.long
def test_samples_and_fixed_direction(tmp_path):
    """Without an orbit there is no angle to LVLH; samples are in the table where asked for."""
    scenario = {'orbit': {'type': 'fixed'}, 'initial': {}, 'rotor': {'mode': 'none'}}
    vary = {'initial.angular_velocity.z': {'values': [0.1]}}
    path = write(
        tmp_path, scenario, vary=vary, runs=1, duration_s=10.0, interval_s=1.0, samples=True
    )
    (row,) = pq.read_table(sweep(path, tmp_path / 'out', workers=1)).to_pylist()
    assert row['lvlh_angle_max_rad'] is None
    assert row['captured'] is None
    np.testing.assert_allclose(row['samples_omega_bi_b'], [[0.0, 0.0, 0.1]] * 11, atol=1e-15)
    assert row['samples_q_ib'][-1] == row['q_ib']


def test_bags_of_chosen_runs(tmp_path):
    """Another program reads the bag of a run; it holds the run's ticks."""
    path = write(tmp_path, bags=[3])
    sweep(path, tmp_path / 'out', workers=1)
    assert [bag.name for bag in (tmp_path / 'out' / 'bags').iterdir()] == ['run_000003']
    with AnyReader([tmp_path / 'out' / 'bags' / 'run_000003']) as reader:
        assert reader.message_count == 1200


def test_batches_cover_the_runs(tmp_path):
    """Every run is in one batch, none twice."""
    plan = Plan.from_yaml(write(tmp_path, runs=1111))
    assert [run for first, last in batches(plan) for run in range(first, last)] == [*range(3333)]


def test_bad_workers(tmp_path):
    """No sweep without a process."""
    with pytest.raises(ValueError, match='--workers is 0; it must be an integer of at least 1'):
        sweep(write(tmp_path), tmp_path / 'out', workers=0)


def test_another_version_does_not_go_on(tmp_path):
    """The versions are written down, and a table does not come from two of them."""
    path, directory = write(tmp_path), tmp_path / 'out'
    sweep(path, directory, workers=1)
    written = json.loads((directory / 'sweep.json').read_text())
    assert {'satdyn_ros', 'numba', 'numpy', 'processor', 'sources'} <= set(written['versions'])
    written['versions']['numba'] = '0.1'
    (directory / 'sweep.json').write_text(json.dumps(written))
    sweep(path, directory, workers=1)
    (directory / 'table.parquet').unlink()
    with pytest.raises(ValueError, match=r'was begun with numba 0\.1, not'):
        sweep(path, directory, workers=1)

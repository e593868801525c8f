"""Captured: the axis of least inertia stays on one side of the local horizontal."""

from itertools import permutations
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from satdyn_ros import Scenario
from satdyn_ros.kernel import rotation
from satdyn_ros.run.many import part_of
from satdyn_ros.sweep.capture import capture_times, judged_axis
from satdyn_ros.sweep.extrema import extrema_of
from satdyn_ros.sweep.outcome import columns
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.table import keep, table, write_part

from .sweeps import rows_of, write

CONFIG = Path(__file__).parents[2] / 'config'
# Along track, opposite to the orbit normal, to nadir.
AXES = np.eye(3)
PERIOD_S = float(2.0 * np.pi / Scenario().system.orbit.mean_motion)


def rows(folder, scenario, vary, **changes):
    """Return the rows of a small sweep."""
    plan = Plan.from_yaml(write(folder, scenario, vary=vary, runs=1, **changes))
    return rows_of(plan, range(len(plan)))


def test_a_cylinder_that_librates(tmp_path):
    """NASA's cylinder, along x, swings by 5 deg about nadir: it has been captured all along."""
    path = tmp_path / 'sweep.yaml'
    path.write_text(
        f'scenario: {CONFIG / "nasa_cylinder.yaml"}\n'
        'duration_s: 20000\n'
        'vary: {initial.angular_velocity.x: {values: [0.0]}}\n'
    )
    (row,) = rows_of(Plan.from_yaml(path), range(1))
    assert (row['captured'], row['capture_s']) == (True, 0.0)
    assert np.rad2deg(row['nadir_angle_max_rad']) == pytest.approx(5.0, abs=0.1)


def test_the_table_says_what_captured_means(tmp_path):
    """Another reader finds the definition with the column."""
    plan = Plan.from_yaml(write(tmp_path))
    path = tmp_path / 'part.parquet'
    write_part(path, plan, table(plan, columns(plan, range(1))))
    keep(path)
    meaning = pq.read_schema(path).field('captured').metadata[b'description']
    assert b'does not cross the local horizontal during at least the last orbit' in meaning


def labellings():
    """Return the 24 rotations that give the axes of a body other names."""
    signs = [np.diag(s) for s in np.array(np.meshgrid(*[[1, -1]] * 3)).reshape(3, -1).T]
    matrices = [AXES[list(order)] @ sign for order in permutations(range(3)) for sign in signs]
    return [R for R in matrices if np.linalg.det(R) > 0.0]


@pytest.mark.long
def test_relabelling_the_axes_changes_no_outcome(tmp_path):
    """Bodies with another axis long, or skew in their axes, come to what the first one does."""
    rng = np.random.default_rng(3)
    starts = rotation.normalise(rng.normal(size=(4, 4)))
    rates = rng.normal(scale=1.5e-3, size=(4, 3))
    found = []
    for R in (*labellings()[::5], rotation.matrix(rotation.about([0.6, 0.0, 0.8], 0.7))):
        to_old = rotation.conjugate(rotation.from_matrix(R))
        inertia = R @ np.diag([900.0, 910.0, 300.0]) @ R.T
        vary = {
            'initial.attitude': {'values': rotation.multiply(starts, to_old).tolist()},
            'initial.angular_velocity': {'values': (rates @ R.T).tolist()},
        }
        scenario = {
            'rotor': {'mode': 'none'},
            'body': {'inertia': inertia.ravel().tolist()},
            'initial': {},
        }
        found.append(rows(tmp_path, scenario, vary, duration_s=3.0 * PERIOD_S))
    names = 'nadir_angle_min_rad', 'nadir_angle_max_rad', 'rate_min_rad_s', 'rate_max_rad_s'
    captured = [row['captured'] for row in found[0]]
    assert set(captured) == {True, False}
    for other in found[1:]:
        assert [row['captured'] for row in other] == captured
        for old, new in zip(found[0], other, strict=True):
            assert new['capture_s'] == old['capture_s']
            # The steps differ; over three orbits of a tumbling body so do the ends, by 1e-9.
            assert [new[k] for k in names] == pytest.approx([old[k] for k in names], abs=1e-8)


@pytest.mark.parametrize('upside_down', [False, True])
def test_either_end_to_nadir(tmp_path, upside_down):
    """At rest at LVLH a long body is captured, its one end to nadir or the other."""
    attitude = [1.0, 0.0, 0.0, 0.0] if upside_down else [0.0, 0.0, 0.0, 1.0]
    vary = {'initial.attitude': {'values': [attitude]}}
    (row,) = rows(tmp_path, {'rotor': {'mode': 'none'}, 'initial': {}}, vary)
    assert (row['captured'], row['capture_s']) == (True, 0.0)


def test_a_tumble_in_step_with_the_samples(tmp_path):
    """Once round between two samples, a body looks at rest in them; it is not captured."""
    rate = 2.0 * np.pi / 100.0
    vary = {'initial.angular_velocity.y': {'values': [0.0, rate]}}
    scenario = {'rotor': {'mode': 'none'}, 'body': {'inertia': [900.0, 900.0 + 1e-9, 899.0]}}
    still, fast = rows(tmp_path, scenario, vary, duration_s=6000.0, interval_s=100.0)
    assert still['captured'] is True
    assert fast['nadir_angle_max_rad'] < 0.5
    assert (fast['captured'], fast['capture_s']) == (False, None)


def test_another_axis_is_named(tmp_path):
    """While the long axis swings about nadir, the axis ahead goes below and above the horizon."""
    vary = {'initial.pitch': {'values': [0.2]}}
    scenario = {'rotor': {'mode': 'none'}}
    outcomes = {
        axis: rows(tmp_path, scenario, vary, captured_axis=axis)[0] for axis in ('least', 'z', 'x')
    }
    assert {axis: row['captured'] for axis, row in outcomes.items()} == {
        'least': True,
        'z': True,
        'x': False,
    }
    assert outcomes['x']['nadir_angle_max_rad'] == pytest.approx(np.pi / 2.0, abs=0.01)


def test_a_dip_between_two_rows():
    """Rows 4 s apart show the last crossing before each of them as rows 0.025 s apart do."""
    rng = np.random.default_rng(5)
    dips = 0
    for angle in rng.normal(np.pi / 4.0, 0.01, size=200):
        # A cone about an axis at about 45 deg from nadir, which all but touches the horizontal.
        spin = np.array([np.sin(angle), 0.0, np.cos(angle)])
        scenario = Scenario(
            {
                'body.inertia': [900.0, 899.9, 899.8],
                'initial.attitude': rotation.about(spin, rng.uniform(0.0, 2.0 * np.pi)).tolist(),
                'initial.angular_velocity': (0.1 * spin).tolist(),
            }
        )
        axis_b, motion = judged_axis('least', scenario.system.inertia), scenario.motion()
        above = motion.at(0.025 * np.arange(3201)).c_b @ axis_b > 0.0
        changes = np.add.reduceat(np.abs(np.diff(above.astype(int))), 160 * np.arange(20))
        since = np.maximum.accumulate(np.where(changes > 0, np.arange(1, 21), 0))
        states = part_of(motion.at(4.0 * np.arange(21)), None)
        found = []

        def motion_of(row, motion=motion):
            return motion

        for k in range(20):
            rows = states.rows(slice(k + 2))
            passed = extrema_of(rows, axis_b)
            found += capture_times(rows, passed, axis_b, np.zeros(1), motion_of).tolist()
        assert found == (4.0 * since).tolist()
        dips += np.sum(changes == 2)
    # Else the rows alone would do.
    assert dips > 5


@pytest.mark.parametrize(
    ('name', 'moments', 'axis'),
    [
        ('least', [800.0, 900.0, 600.0], [0, 0, 1]),
        ('least', [300.0, 900.0, 800.0], [1, 0, 0]),
        ('y', [800.0, 900.0, 600.0], [0, 1, 0]),
        ('least', [600.0, 600.0, 900.0], None),
        ('least', [600.0, 600.0, 600.0], None),
    ],
)
def test_the_axis_that_is_judged(name, moments, axis):
    """The least axis where there is one, or the one that is named."""
    found = judged_axis(name, np.diag(moments))
    assert np.all(np.isnan(found)) if axis is None else found.tolist() == axis

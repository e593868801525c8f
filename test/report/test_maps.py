"""The maps of the shipped sweeps, at low resolution, against linear theory and Beletsky."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from matplotlib import pyplot as plt
from scipy.integrate import solve_ivp

from satdyn_ros.report import maps
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.run import sweep
from satdyn_ros.theory.stability import small_motion, smelt_moments

SWEEPS = Path(__file__).parents[2] / 'config' / 'sweeps'


@pytest.fixture(autouse=True)
def no_window(monkeypatch):
    """Draw into memory, and leave no figure open."""
    plt.switch_backend('Agg')
    yield
    plt.close('all')


def table(folder, name, vary, **changes):
    """Return the table of a shipped sweep that varies less, and its plan."""
    given = yaml.safe_load((SWEEPS / f'{name}.yaml').read_text())
    assert set(vary) == set(given['vary'])
    scenario = str((SWEEPS / given['scenario']).resolve())
    path = folder / f'{name}.yaml'
    changed = given | {'scenario': scenario, 'vary': vary} | changes
    path.write_text(yaml.safe_dump(changed, sort_keys=False))
    return sweep(path, folder / name, workers=1), Plan.from_yaml(path)


def labels(figure):
    """Return the labels of all axes of a figure, colour bars too, once it is drawn."""
    figure.canvas.draw()
    return [
        text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text
    ]


@pytest.mark.parametrize('path', sorted(SWEEPS.glob('*.yaml')), ids=lambda path: path.stem)
def test_shipped_sweeps_are_valid(path):
    """Every shipped sweep is accepted, and its first line says what one sees."""
    text = path.read_text()
    assert text.startswith('# ')
    if '/**:' not in text:
        assert len(Plan.from_yaml(path)) > 40


@pytest.mark.long
def test_smelt_map(tmp_path):
    """Off the boundaries propagation is bounded where all eigenvalues are imaginary alone."""
    points = [-0.75, -0.42, -0.05, 0.3, 0.65]
    vary = {'smelt.k_R': {'values': points}, 'smelt.k_Y': {'values': points}}
    path, _ = table(tmp_path, 'smelt', vary)
    found = []
    for row in pq.read_table(path).to_pylist():
        k_R, k_Y = row['smelt.k_R'], row['smelt.k_Y']
        if k_R == k_Y:
            continue
        stable = small_motion(*smelt_moments(k_R, k_Y), 1.0).is_stable
        # It starts 0.1 deg away: bounded motion stays within a few times that, growth passes 10.
        assert row['lvlh_angle_max_rad'] < np.deg2rad(2.0) or not stable, (k_R, k_Y)
        assert row['lvlh_angle_max_rad'] > np.deg2rad(10.0) or stable, (k_R, k_Y)
        found.append(stable)
    assert found.count(True) == 3
    assert labels(maps.smelt_map(path))[:2] == [
        '$k_Y = (I_n - I_t) / I_r$ (yaw)',
        '$k_R = (I_n - I_r) / I_t$ (roll)',
    ]


def test_theory_of_the_smelt_map():
    """The regions are where they are published: Lagrange's triangle, DeBra and Delp's sliver."""
    k_Y, k_R = np.array([-0.5, 0.25, 0.75]), np.array([-0.5, -0.05, 0.5])
    assert maps.theory(k_Y, k_R).tolist() == [[0, 0, 0], [2, 0, 0], [0, 1, 0]]


def test_capture_map(tmp_path):
    """A strong rotor of either sign holds the body up, a weak one or too high a rate does not."""
    vary = {
        'rotor.momentum': {'linspace': [-8.0, 8.0, 3]},
        'initial.angular_velocity.x': {'linspace': [-0.005, 0.005, 5]},
    }
    path, _ = table(tmp_path, 'capture', vary)
    rows = pq.read_table(path, columns=['captured']).to_pydict()['captured']
    captured = np.reshape(rows, (3, 5))
    assert captured[0].tolist() == captured[2].tolist() == [False, True, True, True, False]
    assert not captured[1, [0, 1, 3, 4]].any()
    assert labels(maps.capture_map(path)) == [
        'rotor momentum along body y [N m s]',
        'initial roll rate relative to LVLH [mrad/s]',
        'largest angle to LVLH [deg]',
    ]


@pytest.mark.long
def test_stroboscopic_map(tmp_path):
    """The strobes are those of Beletsky's equation; neighbours part in the sea, not in islands."""
    island, sea, orbits = 0.0001, 0.0008, 40
    rates = [island, island + 1e-9, sea, sea + 1e-9]
    vary = {'initial.angular_velocity.y': {'values': rates}}
    period_s = 9952.014050491189
    path, plan = table(tmp_path, 'beletsky_map', vary, duration_s=orbits * period_s)
    orbit = plan.scenario.system.orbit
    e, at_pericentre = orbit.eccentricity, orbit.rate(0.0)

    def beletsky(f, y):
        # The pitch turns about the opposite of the orbit normal: theta = -pitch.
        pitch, rate = y
        force = 2.0 * e * np.sin(f) * (1.0 - rate) + 1.5 * np.sin(pitch) * np.cos(pitch)
        return rate, -force / (1.0 + e * np.cos(f))

    strobes = list(maps.strobes(path))
    turns = 2.0 * np.pi * np.arange(orbits + 1)
    for (pitch, rate), start, last in zip(strobes, rates, [orbits, orbits, 10, 10], strict=True):
        solution = solve_ivp(
            beletsky,
            (0.0, turns[last]),
            [0.0, start / at_pericentre],
            'DOP853',
            turns[: last + 1],
            rtol=1e-12,
            atol=1e-13,
        )
        # In the sea ten orbits multiply the rounding and the tolerances by thousands.
        away = pitch[: last + 1] - solution.y[0]
        np.testing.assert_allclose(np.sin(away), 0.0, atol=1e-6)
        np.testing.assert_allclose(rate[: last + 1] / at_pericentre, solution.y[1], atol=1e-6)
    apart = [np.abs(np.sin(strobes[k + 1][0] - strobes[k][0])).max() for k in (0, 2)]
    # The starts differ by 1.5e-6 in the unit of the map.
    assert apart[0] < 1e-3 < 1e-1 < apart[1]
    figure = maps.stroboscopic_map(path, at_pericentre)
    assert labels(figure) == [
        'pitch at the pericentre, upside down or not [deg]',
        'pitch rate at the pericentre [rad per rad of true anomaly]',
    ]

"""The picture of any sweep: a map of a grid, histograms of draws."""

import pyarrow.parquet as pq
import pytest
from matplotlib.patches import Rectangle

from satdyn_ros.cli.main import main
from satdyn_ros.report.outcomes import draw_sweep
from satdyn_ros.sweep.run import sweep

from ..sweep.sweeps import write


@pytest.mark.long
def test_draws_become_histograms(tmp_path):
    """Every run with a value is counted, the captured ones apart."""
    table = sweep(write(tmp_path, runs=10), tmp_path / 'out', workers=1)
    figure = draw_sweep(table, ['rate_max_rad_s'])
    (axes,) = figure.axes
    assert axes.get_xlabel() == 'rate_max_rad_s'
    heights = [patch.get_height() for patch in axes.patches if isinstance(patch, Rectangle)]
    assert sum(heights) == len(pq.read_table(table)) == 30


def test_a_grid_becomes_a_map(tmp_path):
    """The result of a run of the grid is the colour at its two numbers."""
    vary = {
        'rotor.momentum': {'linspace': [-6.0, 6.0, 3]},
        'initial.angular_velocity.x': {'linspace': [-0.005, 0.005, 5]},
    }
    path = write(tmp_path, vary=vary, runs=1)
    table = sweep(path, tmp_path / 'out', workers=1)
    figure = draw_sweep(table, ['lvlh_angle_max_rad'])
    mesh = figure.axes[0].collections[0].get_array()
    assert mesh is not None
    expected = pq.read_table(table)['lvlh_angle_max_rad'].to_numpy().reshape(3, 5)
    assert mesh.reshape(5, 3).T.tolist() == expected.tolist()
    assert (figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()) == tuple(vary)


def test_the_command(tmp_path, capsys):
    """A sweep reports its results, plot draws them, and says what it cannot draw."""
    path, directory = write(tmp_path), tmp_path / 'out'
    assert main(['sweep', str(path), '-o', str(directory), '--workers', '1']) == 0
    captured = pq.read_table(directory / 'table.parquet')['captured'].to_pylist().count(True)
    said = capsys.readouterr().out
    assert said.startswith(f'{directory}/table.parquet: 12 runs, 0 failed, {captured} of 12')
    picture = tmp_path / 'out.png'
    assert main(['plot', str(directory), '-o', str(picture)]) == 0
    assert picture.read_bytes().startswith(b'\x89PNG')
    assert main(['plot', str(directory), '-o', str(picture), '--what', 'colour']) == 2
    assert 'the column is colour; allowed:' in capsys.readouterr().err


@pytest.mark.parametrize('state', ['begun', 'nothing'])
def test_a_sweep_that_has_not_finished(tmp_path, capsys, state):
    """Without a table there is nothing to draw."""
    if state == 'begun':
        (tmp_path / 'sweep.json').write_text('')
    assert main(['plot', str(tmp_path), '-o', str(tmp_path / 'x.png')]) == 2
    expected = 'its sweep has not finished' if state == 'begun' else 'is not a bag'
    assert expected in capsys.readouterr().err

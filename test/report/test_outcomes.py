"""The picture of any sweep: a map of a grid, histograms of draws."""

import shutil

import numpy as np
import pyarrow as pa
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


def test_one_bar_is_said_in_words(tmp_path):
    """A column of one value has no histogram: its panel says which, and of how many runs."""
    table = tmp_path / 'table.parquet'
    rows = {'run': [0, 1, 2], 'rate_max_rad_s': [0.25] * 3, 'captured': [True, False, True]}
    pq.write_table(pa.table(rows), table)
    (axes,) = draw_sweep(table, ['rate_max_rad_s']).axes
    assert not axes.patches
    (says,) = axes.texts
    assert says.get_text() == '0.25\nin all 3 runs\n(2 captured, 1 not captured)'
    pq.write_table(pa.table(rows).drop_columns(['captured']), table)
    (says,) = draw_sweep(table, ['rate_max_rad_s']).axes[0].texts
    assert says.get_text() == '0.25\nin all 3 runs'


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


@pytest.fixture(scope='module')
def grid(tmp_path_factory):
    """Return the directory of a sweep over a grid."""
    folder = tmp_path_factory.mktemp('grid')
    vary = {
        'rotor.momentum': {'linspace': [-6.0, 6.0, 3]},
        'initial.angular_velocity.x': {'linspace': [-0.005, 0.005, 3]},
    }
    return sweep(write(folder, vary=vary, runs=1), folder / 'out', workers=1).parent


def written_again(grid, folder, change):
    """Return a copy of a sweep's directory whose table another program has changed."""
    directory = folder / 'again'
    shutil.copytree(grid, directory)
    table = pq.read_table(directory / 'table.parquet')
    pq.write_table(change(table), directory / 'table.parquet')
    return directory


def bare(table):
    """Return a table without what its columns say of themselves."""
    return pa.table({name: table[name] for name in table.column_names})


def test_columns_without_descriptions_are_drawn_as_before(grid, tmp_path):
    """The map of a grid does not depend on what a column says of itself."""
    directory = written_again(grid, tmp_path, bare)
    assert pq.read_schema(directory / 'table.parquet').field('rotor.momentum').metadata is None
    before, after = (
        draw_sweep(folder / 'table.parquet', ['lvlh_angle_max_rad']).axes[0]
        for folder in (grid, directory)
    )
    assert after.get_xlabel() == before.get_xlabel() == 'rotor.momentum'
    drawn = [np.asarray(axes.collections[0].get_array()) for axes in (before, after)]
    np.testing.assert_array_equal(drawn[1], drawn[0])


@pytest.mark.parametrize(
    ('change', 'labels'),
    [
        (lambda table: table.drop_columns(['captured']), set()),
        (lambda table: as_numbers(table), {'captured', 'not captured'}),
    ],
    ids=['without', 'as numbers'],
)
def test_capture_that_is_not_given_or_otherwise(grid, tmp_path, capsys, change, labels):
    """Every run is counted, captured where a number or a truth value says so; else no legend."""
    directory = written_again(
        grid, tmp_path, lambda table: change(table).drop_columns(['rotor.momentum'])
    )
    (axes,) = draw_sweep(directory / 'table.parquet', ['rate_max_rad_s']).axes
    heights = [patch.get_height() for patch in axes.patches if isinstance(patch, Rectangle)]
    assert sum(heights) == 9
    legend = axes.get_legend()
    assert {text.get_text() for text in (legend.get_texts() if legend else ())} == labels
    assert main(['plot', str(directory), '-o', str(tmp_path / 'x.png')]) == 0
    assert main(['sweep', str(grid.parent / 'sweep.yaml'), '-o', str(directory)]) == 0
    assert '9 runs, 0 failed' in capsys.readouterr().out


def as_numbers(table):
    """Return a table whose truth values are numbers, some captured and some not."""
    index = table.column_names.index('captured')
    return table.set_column(index, 'captured', pa.array([1.0, 0.0, 0.0] * 3))


@pytest.mark.parametrize(
    ('change', 'sentence'),
    [
        (lambda table: table.select(['run', 'failure']), 'has none of the columns rate_max_rad_s'),
        (lambda table: table.slice(0, 0), 'has none of the columns'),
        (
            lambda table: pa.concat_tables([table]).append_column('run', table['run']),
            'cannot be read',
        ),
    ],
    ids=['nothing to draw', 'no rows', 'twice'],
)
def test_a_table_that_cannot_be_drawn(grid, tmp_path, capsys, change, sentence):
    """One sentence says what is missing."""
    directory = written_again(grid, tmp_path, change)
    assert main(['plot', str(directory), '-o', str(tmp_path / 'x.png')]) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count('\n') == 1


@pytest.mark.parametrize('content', [b'', b'PAR1 and something else'])
def test_a_table_that_is_none(tmp_path, capsys, content):
    """A file of this name that is not Parquet is refused in one sentence."""
    (tmp_path / 'sweep.json').touch()
    (tmp_path / 'table.parquet').write_bytes(content)
    assert main(['plot', str(tmp_path), '-o', str(tmp_path / 'x.png')]) == 2
    said = capsys.readouterr().err
    assert 'table.parquet cannot be read' in said
    assert said.count('\n') == 1


@pytest.mark.parametrize('state', ['begun', 'nothing'])
def test_a_sweep_that_has_not_finished(tmp_path, capsys, state):
    """Without a table there is nothing to draw."""
    if state == 'begun':
        (tmp_path / 'sweep.json').write_text('')
    assert main(['plot', str(tmp_path), '-o', str(tmp_path / 'x.png')]) == 2
    expected = 'its sweep has not finished' if state == 'begun' else 'is not a bag'
    assert expected in capsys.readouterr().err

"""Columns of one's own: a function of the states becomes a column, and only when it is named."""

import re

import numpy as np
import pyarrow.parquet as pq
import pytest

from satdyn_ros.cli.main import main
from satdyn_ros.report.outcomes import draw_sweep
from satdyn_ros.sweep.plan import Plan

from .sweeps import ROOT, write

MODULE = """
import numpy as np

def last_rate(states):
    "The length of the rate at the end [rad/s]"
    assert states.q_lb.shape == (*states.omega_bi_b.shape[:2], 4)
    return np.linalg.norm(states.omega_bi_b[:, -1], axis=-1)

def whole(states):
    return states.omega_bi_b

def broken(states):
    raise KeyError('no such thing')

def q_ib(states):
    return 0.0
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Return the name of a module in the working directory, another one in each test."""
    name = f'own_{tmp_path.name}'
    (tmp_path / f'{name}.py').write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    return name


def run(path, outcome):
    """Run the command on a sweep."""
    return main(['sweep', str(path), '-o', 'out', '--workers', '2', '--outcome', outcome])


@pytest.mark.parametrize('method', [pytest.param('numeric', marks=pytest.mark.long), 'auto'])
def test_the_function_becomes_a_column(tmp_path, module, method):
    """Side by side and alone, the numbers are those of the table, and they are drawn."""
    path = write(tmp_path, {'motion': {'method': method}})
    assert run(path, f'{module}:last_rate') == 0
    table = pq.read_table(tmp_path / 'out' / 'table.parquet')
    expected = np.linalg.norm(table['omega_bi_b'].to_pylist(), axis=1)
    np.testing.assert_allclose(table['last_rate'].to_numpy(), expected, rtol=1e-15)
    field = table.schema.field('last_rate')
    assert field.metadata[b'description'] == b'The length of the rate at the end [rad/s]'
    drawn = [axes.get_xlabel() for axes in draw_sweep(tmp_path / 'out' / 'table.parquet').axes]
    assert 'last_rate' in drawn


@pytest.mark.parametrize(
    ('outcome', 'said', 'code'),
    [
        ('{}:none', 'has no function none', 2),
        ('no_such_module_here:f', 'cannot be imported: No module named', 2),
        ('{}', 'must be MODULE:FUNCTION', 2),
        ('{}:q_ib', 'the table has a column q_ib already', 2),
        ('{}:whole', r'gives an array \(12, 121, 3\) for states of \(12, 121\); it must', 1),
        ('{}:broken', "broken: KeyError: 'no such thing'", 1),
    ],
)
def test_what_is_wrong_is_one_sentence(tmp_path, module, capsys, outcome, said, code):
    """A path without a function, a name that is taken, a wrong shape, an exception."""
    assert run(write(tmp_path), outcome.format(module)) == code
    (line,) = (x for x in capsys.readouterr().err.splitlines() if 'compil' not in x)
    assert re.search(said, line)


def test_a_changed_function_does_not_go_on(tmp_path, module):
    """A table does not come from two versions of a function."""
    outcomes = [f'{module}:last_rate']
    text = Plan.from_yaml(write(tmp_path), outcomes=outcomes).to_text()
    assert len(Plan.from_text(text)) == 12
    (tmp_path / f'{module}.py').write_text(MODULE + '# changed')
    with pytest.raises(ValueError, match='is not the one with which the sweep began'):
        Plan.from_text(text)


def test_a_file_names_no_code(tmp_path):
    """What is named is run, so that a sweep file cannot name it."""
    path = write(tmp_path, outcomes=['os:getcwd'])
    with pytest.raises(ValueError, match='outcomes is not a key of a sweep'):
        Plan.from_yaml(path)


def test_the_page_has_a_program(tmp_path, monkeypatch):
    """The function on the page gives what its docstring says."""
    page = (ROOT / 'docs' / 'sweeps.md').read_text()
    (program,) = re.findall(r'```python own_columns\.py\n(.*?)```', page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'own_columns.py').write_text(program)
    assert run(write(tmp_path), 'own_columns:rate_rms_rad_s') == 0
    for row in pq.read_table(tmp_path / 'out' / 'table.parquet').to_pylist():
        assert row['rate_min_rad_s'] <= row['rate_rms_rad_s'] <= row['rate_max_rad_s']

"""`satdyn check FILE --duration S` says how far a run is from the truth."""

from pathlib import Path

import numpy as np
import pytest

from satdyn_ros import Scenario
from satdyn_ros.cli.accuracy import growth
from satdyn_ros.cli.main import main
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation

CONFIG = Path(__file__).parents[2] / 'config'


def test_the_error_is_that_to_the_closed_form():
    """What the finer propagation says of a coarse one is what the closed form says."""
    scenario = Scenario.from_yaml(CONFIG / 'balli_grioli.yaml').with_values(
        {'motion.method': 'numeric', 'motion.tolerance': 1e-9}
    )
    found = growth(scenario, 20000.0)
    finer, closed = found.angle_rad.values()
    assert closed[-1] > 1e-9
    # The finer one is off by a hundredth itself, to within what steps of other lengths make.
    np.testing.assert_allclose(finer, closed, rtol=0.05, atol=1e-11)
    states = Propagation(scenario.system, scenario.initial_state, tolerance=1e-9).at(found.t_s)
    exact = scenario.with_values({'motion.method': 'exact'}).motion().at(found.t_s)
    apart = rotation.angle_between(states.q_ib, exact.q_ib)
    assert closed[-1] == np.max(apart)


def test_the_command(tmp_path, capsys):
    """It prints the growth at ten times and draws it."""
    pytest.importorskip('matplotlib')
    picture = tmp_path / 'growth.png'
    file = str(CONFIG / 'beletsky.yaml')
    assert main(['check', file, '--duration', '3000', '-o', str(picture)]) == 0
    said = capsys.readouterr().out.splitlines()
    times = [float(line.split()[0]) for line in said[3:13]]
    assert times == pytest.approx(np.arange(300.0, 3001.0, 300.0))
    assert 'closed form: planar motion' in said[2]
    assert said[14].startswith('after 3000 s: ')
    assert picture.read_bytes().startswith(b'\x89PNG')


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['no.yaml', '--duration', '10'], 'no.yaml cannot be read'),
        ([str(CONFIG / 'default.yaml')], 'FILE and --duration belong together'),
        (['--duration', '10'], 'FILE and --duration belong together'),
        ([str(CONFIG / 'default.yaml'), '--duration', '-1'], '--duration is -1; it must be'),
        ([str(CONFIG / 'default.yaml'), '--duration', 'day'], '--duration is day; it must be'),
    ],
)
def test_wrong_input(arguments, sentence, capsys):
    """Exit code 2 and one sentence."""
    assert main(['check', *arguments]) == 2
    said = capsys.readouterr()
    assert sentence in said.err
    assert (said.out, said.err.count('\n')) == ('', 1)

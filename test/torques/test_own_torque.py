"""One file adds a torque: flown alone, beside others, in a sweep, refused, recorded, verified."""

import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import plain_equations
import pyarrow.parquet as pq
import pytest
from rosbags.highlevel import AnyReader
from scipy.integrate import solve_ivp

from satdyn_ros import Scenario
from satdyn_ros.bag.export import export
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.dynamics.motion import States
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.messages.packers import packer
from satdyn_ros.report.history import history
from satdyn_ros.report.html import playable
from satdyn_ros.report.plot import draw, plot
from satdyn_ros.run.describe import describe
from satdyn_ros.torques.body_torque import BodyTorque, named

FILE = Path(__file__).with_name('gust.py')
VALUES = {
    'body.inertia': [3.0, 2.0, 4.0],
    'gust.size': 1e-3,
    'gust.kick': [1e-3, -2e-3, 0.0],
    'publish.rate': 10.0,
    'time.epoch_ns': 10**18,
}
TIMES = np.linspace(0.0, 600.0, 61)


@pytest.fixture(scope='module')
def gust(tmp_path_factory):
    """Return the torque, as it is named on the command line: from the working directory."""
    folder = tmp_path_factory.mktemp('own')
    shutil.copy(FILE, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        yield named('gust:Gust')


@pytest.fixture(scope='module')
def scenario(gust):
    return Scenario(VALUES, torques=[gust])


def satdyn(*arguments):
    program = 'import sys; from satdyn_ros.cli.main import main; sys.exit(main())'
    command = [sys.executable, '-c', program, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_alone_it_is_what_scipy_finds(scenario):
    """From each of its stops to the next, within 1e-9 rad."""
    system, state = scenario.system, scenario.initial_state

    def slope(t_s, y):
        found = plain_equations.rates(system, t_s, y[:4], y[4:], np.zeros(0))
        return [*found.q_ib, *found.omega_bi_b]

    y, t_end = np.array([*state.q_ib, *state.omega_bi_b]), TIMES[-1]
    for begin_s, end_s in pairwise([0.0, 50.0, 60.0, t_end]):
        # less a rounding, so that the jump at the end is not seen
        span = begin_s, end_s * (1.0 - 1e-15)
        y = solve_ivp(slope, span, y, 'DOP853', rtol=1e-13, atol=1e-16).y[:, -1]
    found = scenario.motion().at(t_end)
    assert rotation.angle_between(found.q_ib[0], rotation.normalise(y[:4])) < 1e-9


def test_beside_others_it_is_as_alone(scenario, gust):
    """Eight motions with gusts of other sizes and begins."""
    others = [
        Scenario({**VALUES, 'gust.size': 1e-4 * i, 'gust.begin_s': 40.0 + i}, [gust])
        for i in range(8)
    ]
    motions = [other.motion() for other in others]
    assert all(isinstance(motion, Propagation) for motion in motions)
    for other, states in zip(others, propagate_all(motions, TIMES), strict=True):
        assert isinstance(states, States)
        alone = other.motion().at(TIMES)
        assert np.max(rotation.angle_between(states.q_ib, alone.q_ib)) < 1e-9


def test_theory_does_not_speak_of_it(scenario):
    """What is said of equilibria would be of the body without the torque."""
    described = describe(scenario)
    assert described['steady_motions'] == []
    assert described['why_not'] == 'closed forms do not know the torque gust'


def test_no_closed_form_is_taken_for_it(gust):
    """Asked for one, the scenario names the torque."""
    with pytest.raises(ValueError, match='closed forms do not know the torque gust'):
        Scenario({**VALUES, 'motion.method': 'exact'}, [gust])


def test_its_keys_are_checked_as_all(gust):
    """And are unknown where the torque is not given."""
    with pytest.raises(ValueError, match=r'gust\.rate is -1; it must be a number above 0 rad/s'):
        Scenario({**VALUES, 'gust.rate': -1}, [gust])
    with pytest.raises(ValueError, match=r'gust\.size is not a parameter'):
        Scenario(VALUES)


def test_a_bag_of_it_verifies_and_says_what_it_needs(scenario, tmp_path):
    """By the command that names the torque; without it, the sentence names it."""
    for _ in simulate(scenario, '60', tmp_path / 'bag'):
        pass
    assert verify(tmp_path / 'bag').same_bytes
    named = satdyn('verify', tmp_path / 'bag', '--torque', 'gust:Gust')
    assert (named.returncode, 'the same byte for byte' in named.stdout) == (0, True), named.stderr
    unnamed = satdyn('verify', tmp_path / 'bag')
    assert unnamed.returncode == 2
    assert 'has the torque gust:Gust; name it by --torque gust:Gust' in unnamed.stderr


@pytest.fixture(scope='module')
def published(scenario, tmp_path_factory):
    """Return a bag of a run that publishes its topic."""
    bag = tmp_path_factory.mktemp('published') / 'bag'
    given = scenario.with_values({'publish.topics': ['attitude', 'gust_torque']})
    for _ in simulate(given, '60', bag):
        pass
    return bag


def test_its_topic_is_the_torque_that_acts(published, scenario):
    """In messages that another program reads: the function itself, in plain Python, at each."""
    (torque,) = scenario.system.torques
    states = scenario.motion().at(np.arange(600) * 0.1)
    expected = [
        torque.torque(t, np.zeros(3), np.zeros(3), q, omega, torque.constants)
        for t, q, omega in zip(states.t_s, states.q_ib, states.omega_bi_b, strict=True)
    ]
    with AnyReader([published]) as reader:
        found: list[Any] = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic == '/gust_torque'
        ]
    assert {message.header.frame_id for message in found} == {'base_link'}
    axes = 'x', 'y', 'z'
    published_b = [[getattr(message.wrench.torque, axis) for axis in axes] for message in found]
    # The compiled function may fuse a product and a sum: a rounding of values up to 2e-3.
    assert np.max(np.abs(np.array(published_b) - np.array(expected))) < 1e-18
    assert np.abs(published_b).max() > 1e-3


def test_its_topic_verifies_and_has_columns_and_a_panel(published, tmp_path):
    """Title and unit are the class's, and its bounds are there for the bands of dense curves."""
    assert verify(published).same_bytes
    export(published, tmp_path / 'table.npz')
    table = np.load(tmp_path / 'table.npz')
    columns = np.stack([table[f'gust_torque_b_{axis}_n_m'] for axis in 'xyz'], axis=-1)
    run = history(published, 100)
    assert run.panels['gust_torque'][:2] == ('gust torque', 'N m')
    rows = [*range(0, len(columns), 6), len(columns) - 1]
    assert np.array_equal(run.shown['gust_torque'], columns[rows])
    assert np.array_equal(run.most['gust_torque'].max(axis=0), columns.max(axis=0))
    labels = [axes.get_ylabel() for axes in draw(run).axes]
    assert 'gust torque [mN m]' in labels
    page = playable(run)
    assert page['description']['panels'][-1] == {
        'name': 'gust_torque',
        'title': 'gust torque',
        'unit': 'N m',
        'lines': ['x', 'y', 'z'],
    }
    assert page['table']['columns']['gust_torque']['width'] == 3
    plot(published, tmp_path / 'gust.svg', ['gust_torque'])


def test_its_topic_is_offered_where_it_acts(gust):
    """Not without the torque, and not where the torque does not act; names stay one topic's."""

    class Idle(BodyTorque):
        name = 'idle'

        class Constants(NamedTuple):
            pass

        @classmethod
        def of(cls, values):
            return None

    class Tf(Idle):
        name, topic = 'tf', 'tf'

        class Constants(NamedTuple):
            pass

    changes = {'publish.topics': ['idle_torque']}
    with pytest.raises(ValueError, match=r'publish\.topics is .*; it must be a list of attitude'):
        Scenario(changes, [gust])
    scenario = Scenario(changes, [gust, Idle])
    with pytest.raises(ValueError, match='idle_torque and the torque idle does not act'):
        packer('idle_torque', scenario)
    with pytest.raises(ValueError, match='tf is the topic of the torque tf and of another'):
        Scenario({}, [Tf])


def test_a_bag_says_that_the_source_has_changed(scenario, tmp_path, monkeypatch):
    """Which alone would not be seen, where the change changes nothing."""
    for _ in simulate(scenario, '1', tmp_path / 'bag'):
        pass
    (tmp_path / 'gust.py').write_text(FILE.read_text() + '# one more line\n')
    monkeypatch.chdir(tmp_path)
    named = satdyn('verify', tmp_path / 'bag', '--torque', 'gust:Gust')
    assert 'gust:Gust' in named.stdout


@pytest.mark.long
def test_a_sweep_varies_its_keys(scenario, gust, tmp_path):
    """In processes of their own, to which the name of the torque goes."""
    (tmp_path / 'kick.yaml').write_text(scenario.to_yaml())
    (tmp_path / 'sweep.yaml').write_text(
        '{scenario: kick.yaml, duration_s: 600, interval_s: 10, '
        'vary: {gust.size: {values: [0.0, 1.0e-3]}, gust.kick.x: {values: [0.0]}}}'
    )
    arguments = tmp_path / 'sweep.yaml', '-o', tmp_path / 'runs', '--torque', 'gust:Gust'
    done = satdyn('sweep', *arguments)
    assert done.returncode == 0, done.stderr
    table = pq.read_table(tmp_path / 'runs' / 'table.parquet').to_pylist()
    changes = {'gust.size': 1e-3, 'gust.kick': [0.0, -2e-3, 0.0]}
    alone = Scenario({**VALUES, **changes}, [gust]).motion().at(600.0)
    assert rotation.angle_between(np.array(table[1]['q_ib']), alone.q_ib[0]) < 1e-12
    assert table[0]['q_ib'] != table[1]['q_ib']


@pytest.mark.parametrize(
    ('name', 'sentence'),
    [
        ('gust:Nothing', 'cannot be loaded'),
        ('nowhere:Gust', 'cannot be loaded'),
        ('gust', 'is not a BodyTorque; give MODULE:CLASS'),
        ('math:sin', 'is not a BodyTorque'),
    ],
)
def test_a_wrong_name_is_one_sentence(gust, name, sentence):
    """Exit code 2, no traceback."""
    refused = satdyn('describe', 'default', '--torque', name)
    assert refused.returncode == 2
    assert refused.stderr.count('\n') == 1
    assert sentence in refused.stderr

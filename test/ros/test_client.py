"""Asking a running node from the command line."""

import subprocess
import sys

import pytest
from ros.live import ENVIRONMENT

from satdyn_ros.cli.main import main
from satdyn_ros.ros.client import Answer, Client, assignment


@pytest.fixture
def asked(live, capfd):
    """Return a live node's participant, and a function that asks as `satdyn request` does."""
    node, participant = live({'publish.topics': ['attitude', 'angular_velocity']})

    def ask(*arguments):
        command = ['request', '--node', f'{node.namespace}/satdyn', '--timeout', '30', *arguments]
        code = main(command)
        return code, capfd.readouterr().out.strip()

    return participant, ask


@pytest.mark.long
def test_new_initial_conditions(asked):
    """What is asked for is in force, and integers are taken as numbers."""
    participant, ask = asked
    rates = participant.listen('angular_velocity')
    values = ['initial.frame=inertial', 'initial.angular_velocity=[0, 0, 1]']
    code, answer = ask(*values, 'initial.attitude=[0, 0, 0, 1]')
    assert code == 0
    assert answer.startswith('restarted with initial.frame = inertial')
    assert list(participant.get('initial.angular_velocity')) == [0.0, 0.0, 1.0]
    participant.wait_until(lambda: rates and rates[-1].velocity.angular.z > 0.9, 'the rate')


@pytest.mark.long
def test_a_refusal_is_reported(asked):
    """The node's own sentence is printed, and the exit code is 1."""
    _, ask = asked
    code, answer = ask('initial.attitude=[0, 0, 0, 2]')
    assert code == 1
    assert answer.startswith('no: initial.attitude is')
    assert 'of norm 2; it must be a unit quaternion' in answer
    code, answer = ask('body.inertia=[1, 1, 1]')
    assert code == 1
    assert answer.startswith('no: body.inertia cannot be requested')


def test_pause_step_resume_reset(asked):
    """Each flag calls its service; a step is refused while the node runs."""
    _, ask = asked
    assert ask('--step')[0] == 1
    code, paused = ask('--pause')
    assert (code, paused[:17]) == (0, 'paused after tick')
    tick = int(paused.split()[-1])
    assert ask('--step') == (0, f'now after tick {tick + 1}')
    assert ask('--step', '10') == (0, f'now after tick {tick + 11}')
    assert ask('--step', '0')[0] == 2
    assert ask('--step', str(10**30))[0] == 2
    assert ask('--step') == (0, f'now after tick {tick + 21}')
    assert ask('--resume') == (0, 'running')
    assert ask('--reset')[0] == 0


@pytest.mark.long
def test_parameters_and_bags(asked):
    """What `ros2 param` and `ros2 service` do: set, get, record; a refusal is the node's own."""
    _, ask = asked
    assert ask('--set', 'time.factor=2') == (0, 'time.factor = 2')
    assert ask('--get', 'time.factor') == (0, '2.0')
    assert ask('--set', 'step.ticks=3') == (0, 'step.ticks = 3')
    code, answer = ask('--set', 'step.ticks=0')
    assert code == 1
    assert 'out of range' in answer
    assert ask('--set', 'publish.topics=[attitude]')[0] == 0
    assert ask('--get', 'publish.topics') == (0, "['attitude']")
    code, answer = ask('--set', 'publish.rate=5')
    assert code == 1
    assert 'publish.rate' in answer
    assert ask('--get', 'no.such')[0] == 1
    assert ask('--record', 'on')[1].startswith('recording ')
    assert ask('--record', 'off')[1].startswith('closed ')


def test_a_condition_is_asked_for_once(capfd):
    """Of two values for one key neither is asked for."""
    twice = ['initial.frame=lvlh', 'initial.frame=inertial']
    assert main(['request', *twice]) == 2
    said = 'satdyn request: initial.frame is given twice; it may be given once\n'
    assert capfd.readouterr().err == said


def test_nobody_answers(capfd):
    """Where there is no such node, the answer is no, in one sentence."""
    assert main(['request', '--reset', '--node', '/nowhere/satdyn', '--timeout', '0.5']) == 1
    assert capfd.readouterr().out == (
        'no: no node /nowhere/satdyn found within 0.5 s; start one with satdyn node '
        '--params-file default\n'
    )


@pytest.mark.parametrize(
    'wrong', [['--timeout', '-1'], ['--timeout', 'nan'], ['--node', '//x'], ['--node', 'a-b']]
)
def test_what_cannot_be_asked(wrong, capfd):
    """A wait that never ends or begins, and what is no name, are refused in one sentence."""
    assert main(['request', '--reset', *wrong]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f'satdyn request: {wrong[0]} is ')


def test_numbers_without_digits_on_one_side_are_asked_for_as_numbers():
    """As rcl reads them on its own command line."""
    given = assignment('initial.angular_velocity=[0, -.5, +1.]')
    assert given == ('initial.angular_velocity', [0.0, -0.5, 1.0])


def test_texts_with_units_are_asked_for_without_quotes():
    """A list with its unit is no YAML; a 0 beside texts is one, since ROS has no list of both."""
    key = 'initial.angular_velocity'
    assert assignment(f'{key}=[0, 0, 6] deg/s') == (key, '[0, 0, 6] deg/s')
    assert assignment(f'{key}=[0, 0, 6 deg/s]') == (key, ['0', '0', '6 deg/s'])
    assert assignment('torque.timeout=2 min') == ('torque.timeout', '2 min')


def test_from_python_and_from_a_shell(live):
    """The client in Python gives answers as data; the command works in a process of its own."""
    node, _ = live({'publish.topics': ['attitude']})
    name = f'{node.namespace}/satdyn'
    with Client(name, timeout_s=30.0) as client:
        answer = client.set_initial_conditions({'initial.frame': 'inertial'})
        assert answer == Answer(True, 'restarted with initial.frame = inertial')
        assert client.pause().success
    result = subprocess.run(
        [sys.executable, '-m', 'satdyn_ros.cli.main', 'request', '--node', name, '--step'],
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith('now after tick')

"""Pause, step, the factor of time, recording, and the end of the process."""

import signal
import time

import pytest
from ros.live import EPOCH_NS, expected, stamp_ns

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag


def ticks(messages, rate=100):
    return [(stamp_ns(message) - EPOCH_NS) * rate // 10**9 for message in messages]


def test_while_paused_ticks_pass_by_steps_alone(live):
    """A step is step.ticks ticks and is over when it replies; stamps run on without a gap."""
    _, participant = live()
    heard = participant.listen('attitude')
    participant.hear(heard, 5)
    assert participant.trigger('step') == (
        False,
        'the node is not paused; ~/step needs a paused node (call ~/pause)',
    )
    paused, sentence = participant.switch('pause', True)
    last = int(sentence.removeprefix('paused after tick '))
    participant.wait_until(lambda: ticks(heard)[-1] == last)
    participant.spin(0.3)
    assert (paused, ticks(heard)[-1]) == (True, last)

    assert participant.trigger('step') == (True, f'now after tick {last + 1}')
    assert participant.set({'step.ticks': 40}) == [(True, '')]
    assert participant.trigger('step') == (True, f'now after tick {last + 41}')
    participant.wait_until(lambda: ticks(heard)[-1] == last + 41)
    # A request made while paused acts at the next step.
    assert participant.request(
        {'initial.frame': 'inertial', 'initial.attitude': [0.6, 0.0, 0.0, 0.8]}
    )[0]
    participant.spin(0.2)
    assert ticks(heard)[-1] == last + 41
    assert participant.set({'step.ticks': 1}) == [(True, '')]
    assert participant.trigger('step')[0]
    participant.wait_until(lambda: ticks(heard)[-1] == last + 42)
    assert heard[-1].quaternion.x == 0.6

    assert participant.switch('pause', False) == (True, 'running')
    participant.hear(heard, 20)
    assert ticks(heard) == list(range(ticks(heard)[0], ticks(heard)[-1] + 1))


def test_after_a_pause_ticks_do_not_hurry(live):
    """What did not pass meanwhile is not made up for: 50 ticks of 0.01 s take half a second."""
    _, participant = live()
    heard = participant.listen('attitude')
    participant.hear(heard, 5)
    last = int(participant.switch('pause', True)[1].removeprefix('paused after tick '))
    # Less than the second of lag after which ticks begin anew in any case.
    participant.spin(0.6)
    begin_s = time.monotonic()
    assert participant.switch('pause', False) == (True, 'running')
    participant.wait_until(lambda: ticks(heard)[-1] >= last + 51)
    assert time.monotonic() - begin_s >= 0.5


@pytest.mark.long
def test_the_factor_changes_while_running_without_gap_or_repeat(live, tmp_path):
    """
    From a tenth of real time to as fast as possible and back, every tick comes once.

    The bag has them all: no subscriber in Python keeps up with the fastest.
    """
    node, participant = live(
        {'publish.rate': 20.0, 'publish.topics': ['attitude'], 'record.enabled': True}
    )
    heard = participant.listen('attitude')
    participant.hear(heard, 5)
    for factor in (0.1, 1000.0, 0, 7.5, 1.0):
        assert participant.set({'time.factor': factor}) == [(True, '')]
        assert participant.get('time.factor') == factor
        participant.hear(heard, 3 if 0.0 < factor < 100.0 else 500)
    assert participant.set({'time.factor': -1.0})[0][0] is False
    assert participant.get('time.factor') == 1.0
    assert node.end()[0] == 0
    (directory,) = tmp_path.glob('satdyn_*_*')
    times_ns = Bag(directory).messages(f'{node.namespace}/attitude').log_times_ns
    assert len(times_ns) > 1000
    assert times_ns.tolist() == [EPOCH_NS + k * 10**9 // 20 for k in range(len(times_ns))]


@pytest.mark.parametrize(
    'number', [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)]
)
def test_a_signal_completes_the_bag(live, tmp_path, number):
    """The node ends with exit code 0, and its bag has every tick from the first one on."""
    node, participant = live({'record.enabled': True, 'publish.topics': ['attitude']})
    heard = participant.listen('attitude')
    participant.hear(heard, 60)
    code, errors = node.end(number)
    assert code == 0, errors
    assert 'Traceback' not in errors
    (directory,) = tmp_path.glob('satdyn_*_*')
    assert (directory / 'metadata.yaml').exists()
    recorded = Bag(directory).messages(f'{node.namespace}/attitude')
    packed = expected(node.scenario, 'attitude', len(recorded.data))
    assert recorded.log_times_ns.tolist() == list(packed)
    assert [bytes(row) for row in recorded.data] == list(packed.values())
    assert stamp_ns(heard[-1]) <= recorded.log_times_ns[-1]


def test_bags_are_begun_and_completed_by_request(live, tmp_path):
    """The reply names the bag; begun in mid-run, with requests in it, it can be run again."""
    _, participant = live({'publish.topics': ['attitude', 'imu']})
    heard = participant.listen('attitude')
    participant.hear(heard, 10)
    assert participant.switch('record', False) == (False, 'no bag is open')
    names = []
    for _ in range(2):
        done, sentence = participant.switch('record', True)
        assert done
        names.append(sentence.removeprefix('recording '))
        assert participant.switch('record', True) == (False, f'{names[-1]} is open already')
        participant.hear(heard, 20)
        assert participant.request({'initial.angular_velocity': [0.01, 0.0, 0.0]})[0]
        participant.hear(heard, 20)
        assert participant.set({'publish.topics': ['attitude']}) == [(True, '')]
        participant.hear(heard, 10)
        assert participant.set({'publish.topics': ['attitude', 'rotor']}) == [(True, '')]
        participant.hear(heard, 20)
        assert participant.switch('record', False) == (True, f'closed {names[-1]}')
        assert (tmp_path / names[-1] / 'metadata.yaml').exists()
    assert len(set(names)) == 2
    for name in names:
        verdict = verify(tmp_path / name)
        assert verdict.same_bytes, verdict
        assert verdict.message_count > 100


@pytest.mark.long
def test_a_directory_without_permission_is_said_so(live, tmp_path):
    """The service refuses with the system's reason, and the run continues."""
    (tmp_path / 'file').write_text('')
    _, participant = live({'record.directory': str(tmp_path / 'file')})
    done, sentence = participant.switch('record', True)
    assert not done
    assert 'cannot be created' in sentence
    participant.hear(participant.listen('attitude'), 5)

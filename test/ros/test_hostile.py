"""What nobody should send: the node answers in one sentence, and keeps running."""

import signal
import struct

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from ros.live import EPOCH_NS, stamp_ns
from ros.test_diagnostics import ERROR, health, values
from std_srvs.srv import Trigger

from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.run.events import Halt, TorquesDropped
from satdyn_ros.run.ticks import LAST_STAMP_NS

SERVICES = [
    (SetParameters, 'satdyn/set_parameters'),
    (SetParametersAtomically, 'satdyn/set_parameters_atomically'),
    (SetParametersAtomically, 'satdyn/set_initial_conditions'),
]


def answers(participant, messages):
    """Return what each service that takes parameters says of them."""
    for kind, name in SERVICES:
        answer = participant.call(kind, name, kind.Request(parameters=messages))
        yield from answer.results if hasattr(answer, 'results') else [answer.result]


def test_parameters_of_every_type_are_refused_where_they_do_not_fit(live):
    """Types that do not exist, byte arrays, long texts: one line of at most 500 characters."""
    _, participant = live()
    heard = participant.listen('attitude')
    for number in [*range(1, 12), 255]:
        for name in ('publish.topics', 'initial.angular_velocity', 'no\nsuch', ''):
            message = ParameterMessage(name=name)
            message.value.type = number
            message.value.byte_array_value = [b'1', b'2', b'3']
            message.value.string_value = 'line\n' * 5000
            message.value.string_array_value = ['line\n' * 5000]
            message.value.bool_array_value = [True, False]
            message.value.integer_array_value = [1, 2]
            message.value.double_array_value = [0.5, 0.5]
            for result in answers(participant, [message]):
                assert not result.successful
                assert 0 < len(result.reason) <= 500
                assert '\n' not in result.reason
    message = ParameterMessage(name='publish.topics')
    message.value.type = 10
    (first, *_) = answers(participant, [message])
    assert first.reason == 'publish.topics is of type 10; it must be a type of 0 to 9'
    participant.hear(heard, 20)


@pytest.mark.long
@pytest.mark.parametrize('topics', [[], ['tf']])
def test_a_node_that_publishes_nothing_flies_on(live, topics):
    """No topic, or only one whose type is not installed: ticks pass, services answer."""
    _, participant = live({'publish.topics': topics, 'step.ticks': 7})
    _, sentence = participant.switch('pause', True)
    tick = int(sentence.removeprefix('paused after tick '))
    assert participant.trigger('step')[1] == f'now after tick {tick + 7}'
    assert participant.set({'publish.topics': ['attitude']}) == [(True, '')]
    assert participant.get('publish.topics') == ['attitude']
    heard = participant.listen('attitude')
    assert participant.switch('pause', False)[0]
    participant.hear(heard, 5)
    unset = ParameterMessage(name='publish.topics')
    unset.value.type = ParameterType.PARAMETER_NOT_SET
    (result,) = participant.call(
        SetParameters, 'satdyn/set_parameters', SetParameters.Request(parameters=[unset])
    ).results
    assert result.successful
    assert participant.switch('pause', True)[0]
    participant.spin(0.2)
    silent = len(heard)
    assert participant.trigger('step')[0]
    participant.spin(0.2)
    assert len(heard) == silent


def test_what_is_no_message_costs_that_message_alone(live):
    """A torque with invalid text, or cut off, is reported; the next one is accepted."""
    node, participant = live({'torque.timeout': 0.0, 'initial.angular_velocity': [0.0] * 3})
    heard = participant.listen('angular_velocity')
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)
    participant.wait_until(lambda: publisher.get_subscription_count() == 1)
    head = struct.pack('<4BiII', 0, 1, 0, 0, 0, 0, 4)
    publisher.publish(head + b'\xff\xfe\xff\0' + bytes(48))
    publisher.publish(head + b'ab')
    publisher.publish(b'\0\1\0\0')
    rest = participant.hear(heard, 5)[-1].velocity.angular.x
    message = WrenchStamped()
    message.wrench.torque.x = 100.0
    publisher.publish(message)
    participant.wait_until(lambda: heard[-1].velocity.angular.x > rest + 0.01)
    stamps = [stamp_ns(message) for message in heard]
    assert stamps == list(range(stamps[0], stamps[-1] + 1, 10**7))
    code, errors = node.end()
    assert code == 0
    assert 'Traceback' not in errors


@pytest.mark.long
def test_what_would_take_forever_is_refused_or_dropped(live, tmp_path):
    """A request is refused, a torque dropped; services answer, and the bag proves itself."""
    node, participant = live({'publish.topics': ['attitude'], 'record.enabled': True})
    heard = participant.listen('attitude')
    participant.hear(heard, 5)
    for rate in (1e300, 1e20, 9e7):
        done, reason = participant.request({'initial.angular_velocity': [rate, 1.0, 0.0]})
        assert not done
        assert 'it must be at most 1e+08 rad/s' in reason or 'no motion can start' in reason
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)
    participant.wait_until(lambda: publisher.get_subscription_count() == 1)
    for torque in (1e30, 1e300):
        message = WrenchStamped()
        message.wrench.torque.x = torque
        publisher.publish(message)
        participant.hear(heard, 20)
    assert participant.trigger('reset')[0]
    participant.hear(heard, 5)
    code, errors = node.end()
    assert code == 0
    assert errors.count('the torques that acted are dropped: ') == 2
    (directory,) = tmp_path.glob('satdyn_*_*')
    events = RecordedRun(directory).events
    assert sum(isinstance(event, TorquesDropped) for event in events) == 2
    assert verify(directory).same_bytes


@pytest.mark.long
def test_a_run_that_halts_says_so_and_ends_when_asked(live):
    """At the last stamp of ROS: ERROR in the diagnostics, services answer, a signal ends it."""
    node, participant = live({'time.epoch_ns': LAST_STAMP_NS - 5 * 10**7})
    until = health(participant)
    report = until(node.namespace, lambda r: r['pacing'].level == ERROR)
    assert report['pacing'].message.startswith('halted after tick 5: the next tick comes after')
    for name in ('step', 'reset'):
        done, reason = participant.trigger(name)
        assert not done
        assert 'the last stamp of ROS, 2147483647 s' in reason
    assert participant.switch('pause', False)[0] is False
    code, errors = node.end()
    assert code == 0
    assert 'Traceback' not in errors


# For one tick, a torque of 3e12 N m spins the body up so far that the next tick would need
# 1.6e6 steps; with half of it, each tick that follows needs 8e5, about a second.
SPIN = {'publish.topics': ['angular_velocity'], 'torque.timeout': 0.01, 'record.enabled': True}
HALTING, SLOWING = 3e12, 1.5e12


def spin_up(participant, torque):
    """Let a torque [N m] act for one tick; return the list of rates, which fills."""
    heard = participant.listen('angular_velocity')
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)
    participant.wait_until(lambda: heard and publisher.get_subscription_count())
    message = WrenchStamped()
    message.wrench.torque.z = torque
    publisher.publish(message)
    participant.wait_until(lambda: heard[-1].velocity.angular.z > 1e7, 'the fast spin')
    return heard


def last_tick_ns(report):
    """Return the stamp of the last tick that a report has [ns]."""
    return EPOCH_NS + int(values(report['pacing'])['tick']) * 10**7


@pytest.mark.long
def test_a_halt_by_step_count_is_an_error_until_a_request_or_a_reset(live, tmp_path):
    """No tick passes while it halts, each of both resumes it, and the bag proves itself."""
    node, participant = live(SPIN)
    until = health(participant)

    def halt(after_ns):
        """Return what is heard, the report of a halt after a time, and the time of the halt."""
        heard = spin_up(participant, HALTING)
        report = until(
            node.namespace,
            lambda r: r['pacing'].level == ERROR and last_tick_ns(r) > after_ns,
        )
        participant.wait_until(lambda: stamp_ns(heard[-1]) >= last_tick_ns(report))
        return heard, report, last_tick_ns(report)

    heard, report, halted_ns = halt(0)
    assert 'more than 1000000 steps are needed' in report['pacing'].message
    assert stamp_ns(heard[-1]) == halted_ns
    done, reason = participant.trigger('step')
    assert not done
    assert reason.startswith('no tick can follow until a request or a reset: ')
    assert participant.switch('pause', False)[0] is False

    assert participant.trigger('reset')[0]
    participant.hear(heard, 5)
    resumed = [message for message in heard if stamp_ns(message) > halted_ns]
    assert stamp_ns(resumed[0]) == halted_ns + 10**7
    assert resumed[0].velocity.angular.z < 1e-3

    heard, _, halted_ns = halt(halted_ns)
    asked = {'initial.frame': 'inertial', 'initial.angular_velocity': [0.0, 0.0, 0.25]}
    assert participant.request(asked)[0]
    participant.wait_until(lambda: stamp_ns(heard[-1]) > halted_ns)
    resumed = [message for message in heard if stamp_ns(message) > halted_ns]
    assert resumed[0].velocity.angular.z == 0.25

    code, errors = node.end()
    assert code == 0
    assert 'Traceback' not in errors
    (directory,) = tmp_path.glob('satdyn_*_*')
    assert sum(isinstance(event, Halt) for event in RecordedRun(directory).events) == 2
    verdict = verify(directory)
    assert verdict.is_true, str(verdict)
    assert verdict.same_bytes


@pytest.mark.long
@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_in_a_slow_tick_ends_the_node_without_it(live, tmp_path, number):
    """The tick that is being computed is given up; the bag holds all that were heard."""
    node, participant = live(SPIN)
    heard = spin_up(participant, SLOWING)
    code, errors = node.end(number)
    assert code == 0
    assert 'Traceback' not in errors
    (directory,) = tmp_path.glob('satdyn_*_*')
    topic = f'{node.namespace}/angular_velocity'
    stamps_ns = Bag(directory).messages(topic).log_times_ns.astype(np.int64)
    participant.wait_until(lambda: stamp_ns(heard[-1]) == stamps_ns[-1])
    assert set(np.diff(stamps_ns).tolist()) == {10**7}


@pytest.mark.long
def test_all_services_answer_during_a_step(live):
    """A second step is refused; requests act; a pause ends it, and its reply counts the ticks."""
    _, participant = live({'publish.topics': ['attitude'], 'step.ticks': 10**9})
    heard = participant.listen('attitude')
    participant.hear(heard, 1)
    begin = int(participant.switch('pause', True)[1].removeprefix('paused after tick '))
    client = participant.node.create_client(Trigger, 'satdyn/step')
    participant.wait_until(client.service_is_ready)
    participant.wait_until_known('satdyn')
    step = client.call_async(Trigger.Request())
    participant.hear(heard, 20)
    assert participant.trigger('step') == (False, 'a step is already in progress; ~/pause ends it')
    asked = {'initial.frame': 'inertial', 'initial.attitude': [0.6, 0.0, 0.0, 0.8]}
    assert participant.request(asked)[0]
    assert participant.trigger('reset')[0]
    assert participant.get('step.ticks') == 10**9
    assert participant.switch('record', True)[0]
    assert not step.done()
    end = int(participant.switch('pause', True)[1].removeprefix('paused after tick '))
    participant.wait_until(step.done, 'the end of the step')
    assert step.result().success is False
    assert step.result().message == (
        f'{end - begin} of 1000000000 ticks passed, now after tick {end}'
    )

"""On-times of thrusters that come in on their topic."""

import math
import time

import pytest
from builtin_interfaces.msg import Duration
from rclpy.qos import QoSProfile
from ros.test_diagnostics import health, values
from ros.test_inputs import matched
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from satdyn_ros.actuators import Command
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify

PAIR = {
    'orbit.type': 'fixed',
    'body.inertia': [2.0, 1.5, 1.0],
    'initial.attitude': [0.0, 0.0, 0.0, 1.0],
    'publish.rate': 10.0,
    'publish.topics': ['angular_velocity', 'thruster', 'thruster_wrench'],
    'torque.timeout': 0.2,
    'thruster.names': ['a', 'b'],
    'thruster.a.position': [0.0, 0.5, 0.0],
    'thruster.a.thrust': 3.0,
    'thruster.a.min_on_time': 0.005,
    'thruster.a.specific_impulse': 50.0,
    'thruster.b.position': [0.0, -0.5, 0.0],
    'thruster.b.thrust': 2.0,
}


def on_times(**given):
    point = JointTrajectoryPoint(positions=list(given.values()))
    return JointTrajectory(joint_names=list(given), points=[point])


def test_a_pulse_has_its_impulse_and_is_recorded(live, tmp_path):
    """
    What turns the body, what is published and what the bag holds are thrust times on-time.

    A pulse outlasts torque.timeout, and one that is too short is counted in the diagnostics.
    """
    node, participant = live(PAIR | {'record.enabled': True})
    publisher = matched(participant, JointTrajectory, 'thruster_command')
    rates, thrusters = participant.listen('angular_velocity'), participant.listen('thruster')
    wrenches, until = participant.listen('thruster_wrench'), health(participant)
    participant.hear(rates, 3)
    publisher.publish(on_times(a=1.03, b=0.0301))
    participant.wait_until(lambda: thrusters[-1].effort[0] == 3.0, 'the thrust')
    participant.wait_until(lambda: thrusters[-1].effort[0] == 0.0, 'the end of the pulse')
    publisher.publish(on_times(a=0.001))
    report = until(
        node.namespace, lambda r: values(r['inputs'])['lengthened to min_on_time'] == '1'
    )
    assert values(report['inputs'])['accepted'] == '2'
    participant.hear(rates, 3)
    assert node.end()[0] == 0
    impulses = 3.0 * (1.03 + 0.005), 2.0 * 0.0301
    expected = 0.5 * (impulses[0] - impulses[1]) / 2.0
    assert rates[-1].velocity.angular.x == pytest.approx(expected, rel=1e-12)
    assert list(thrusters[-1].name) == ['a', 'b']
    used, unknown = thrusters[-1].position
    assert used == pytest.approx(impulses[0] / (9.80665 * 50.0), rel=1e-12)
    assert math.isnan(unknown)
    found = {(w.wrench.force.z, w.wrench.torque.x) for w in wrenches}
    assert (3.0, 1.5) in found
    assert (0.0, 0.0) in found
    (directory,) = tmp_path.glob('satdyn_*_*')
    assert verify(directory).same_bytes
    commands = [e for e in RecordedRun(directory).events if isinstance(e, Command)]
    assert [(e.value, e.until_tick) for e in commands] == [
        ({'a': 1.03, 'b': 0.0301}, None),
        ({'a': 0.001}, None),
    ]


def test_what_is_no_on_time_is_refused_in_one_sentence(live):
    """By its name, its size or its form; the body stays at rest."""
    node, participant = live(PAIR)
    publisher = matched(participant, JointTrajectory, 'thruster_command')
    until = health(participant)
    no_point, with_effort, late = on_times(a=1.0), on_times(a=1.0), on_times(a=1.0)
    no_point.points = []
    with_effort.points[0].effort = [1.0]
    late.points[0].time_from_start = Duration(sec=2)
    lacking = on_times(a=1.0)
    lacking.joint_names = ['a', 'b']
    twice = on_times(a=1.0)
    twice.joint_names, twice.points[0].positions = ['a', 'a'], [1.0, 2.0]
    wrong = {
        'there is no thruster c; thruster.names has a, b': on_times(c=1.0),
        'on-time of the thruster a is -1.0; it must be a number at least 0': on_times(a=-1.0),
        'on-time of the thruster a is nan; it must be a number': on_times(a=math.nan),
        'on-time of the thruster b is inf; it must be a number': on_times(b=math.inf),
        'on-time of the thruster b is 86401.0; it must be': on_times(b=86401.0),
        'thruster_command has 0 points; it must have one': no_point,
        'thruster_command has 2 names and 1 positions; it must have one position': lacking,
        'thruster_command names a thruster twice: a, a': twice,
        'thruster_command has effort; its point must have only positions': with_effort,
        'thruster_command has a time_from_start of 2 s; it must be 0': late,
    }
    for number, (sentence, message) in enumerate(wrong.items(), 1):
        publisher.publish(message)
        report = until(
            node.namespace, lambda r, n=number: values(r['inputs'])['refused'] == str(n)
        )
        assert sentence in report['inputs'].message
    rates = participant.listen('angular_velocity')
    participant.hear(rates, 3)
    assert rates[-1].velocity.angular.x == 0.0
    assert node.end()[0] == 0


def test_five_thousand_commands_a_second(live, tmp_path):
    """As many as were published are in the bag, in their order, and it verifies."""
    node, participant = live(PAIR | {'record.enabled': True})
    matched(participant, JointTrajectory, 'thruster_command')
    rates = participant.listen('angular_velocity')
    publisher = participant.node.create_publisher(
        JointTrajectory, 'thruster_command', QoSProfile(depth=5000)
    )
    participant.wait_until(lambda: publisher.get_subscription_count() == 1)
    until, sent = health(participant), []
    begin_s = time.monotonic()
    for number in range(5000):
        sent.append(0.001 + 1e-6 * (number % 1000))
        publisher.publish(on_times(a=sent[-1]))
        time.sleep(max(0.0, begin_s + number / 5000.0 - time.monotonic()))
    report = until(
        node.namespace,
        lambda r: (
            int(values(r['inputs'])['accepted']) + int(values(r['inputs'])['lost on the way'])
            >= 5000
        ),
    )
    assert values(report['inputs'])['lost on the way'] == '0'
    # What came last acts at the next tick.
    participant.hear(rates, 3)
    assert node.end()[0] == 0
    (directory,) = tmp_path.glob('satdyn_*_*')
    assert verify(directory).same_bytes
    commands = [e for e in RecordedRun(directory).events if isinstance(e, Command)]
    assert [command.value['a'] for command in commands] == sent

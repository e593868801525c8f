"""Torques that come in on topics."""

import math

import numpy as np
import pytest
from commands import dipole_command, motor_command, torque_command
from geometry_msgs.msg import Vector3Stamped, WrenchStamped
from ros.live import EPOCH_NS, Participant, stamp_ns
from ros.test_diagnostics import health, values
from scipy.integrate import solve_ivp
from sensor_msgs.msg import JointState

from satdyn_ros.actuators import Command
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.run.events import RotorLimited, Timeout
from satdyn_ros.watch.listener import Listener

FREE = {
    'orbit.type': 'fixed',
    'body.inertia': [800.0, 900.0, 600.0],
    'initial.attitude': [0.0, 0.0, 0.0, 1.0],
    'initial.angular_velocity': [0.01, 0.02, 0.03],
}


def wrench(torque, frame=''):
    message = WrenchStamped()
    message.header.frame_id = frame
    message.wrench.torque.x, message.wrench.torque.y, message.wrench.torque.z = torque
    return message


def matched(participant, kind, topic):
    """Return a publisher that the live node hears."""
    publisher = participant.node.create_publisher(kind, topic, 10)
    participant.wait_until(lambda: publisher.get_subscription_count() == 1, topic)
    return publisher


def test_a_torque_acts_from_a_tick_on_until_the_next_or_the_timeout(live, tmp_path):
    """
    The rates are those of Euler's equations with the recorded torques, integrated by SciPy.

    The bag holds each torque at the stamp of the tick where it acts, and the end of the last.
    """
    node, participant = live(
        FREE
        | {'publish.topics': ['angular_velocity'], 'record.enabled': True}
        | {'torque.timeout': 0.2}
    )
    publisher = matched(participant, WrenchStamped, 'torque')
    heard, inertia = participant.listen('angular_velocity'), np.array(FREE['body.inertia'])
    participant.hear(heard, 10)

    def acting():
        """Return the torque between the last two ticks, to the 0.5 N m of the gyroscopic one."""
        before, now = (
            np.array([m.velocity.angular.x, m.velocity.angular.y, m.velocity.angular.z])
            for m in heard[-2:]
        )
        return inertia * (now - before) / 0.01

    publisher.publish(wrench((5.0, 0.0, 0.0), node.body_frame))
    participant.wait_until(lambda: acting()[0] > 4.0, 'the first torque')
    publisher.publish(wrench((0.0, -8.0, 3.0), node.body_frame))
    participant.wait_until(lambda: acting()[1] < -7.0, 'the second torque')
    participant.wait_until(lambda: np.abs(acting()).max() < 1.0, 'the timeout')
    participant.hear(heard, 5)
    assert node.end()[0] == 0

    (directory,) = tmp_path.glob('satdyn_*_*')
    assert verify(directory).same_bytes
    events = [
        event for event in RecordedRun(directory).events if isinstance(event, Command | Timeout)
    ]
    torques = [event for event in events if isinstance(event, Command)]
    assert [event.value for event in torques] == [(5.0, 0.0, 0.0), (0.0, -8.0, 3.0)]
    # On a busy machine the first may have ended before the second came.
    assert isinstance(events[-1], Timeout)
    assert events[-1].tick == torques[-1].tick + 20

    rates = {(stamp_ns(m) - EPOCH_NS) // 10**7: m.velocity.angular for m in heard}
    omega, tick, torque = np.array(FREE['initial.angular_velocity']), 0, (0.0, 0.0, 0.0)
    for event in (*events, Timeout(max(rates), 'torque')):
        until = event.tick
        solution = solve_ivp(
            lambda t, w, torque=torque: (np.array(torque) - np.cross(w, inertia * w)) / inertia,
            (0.0, (until - tick) * 0.01),
            omega,
            method='DOP853',
            rtol=1e-12,
            atol=1e-14,
        )
        omega, tick, torque = solution.y[:, -1], until, getattr(event, 'value', (0.0, 0.0, 0.0))
        if until in rates:
            rate = rates[until]
            # SciPy's relative tolerance over a few dozen steps.
            np.testing.assert_allclose([rate.x, rate.y, rate.z], omega, rtol=1e-10)
    assert max(rates) in rates


def test_a_controller_and_a_disturbance_act_together(live, tmp_path):
    """
    Two publishers on topics of their own: what acts is the sum, and each ends by itself.

    Diagnostics and bag distinguish them, the live page hears both, and the bag verifies.
    """
    node, participant = live(
        FREE
        | {'publish.topics': ['angular_velocity'], 'record.enabled': True}
        | {'torque.names': ['control', 'drag'], 'torque.timeout': 2.0}
    )
    # The page polls: its node is in no executor.
    page = Participant(node.namespace)
    listener, came_in = Listener(page.node), {}
    topics = {'torque/control', 'torque/drag'}
    participant.wait_until(lambda: topics <= listener.look(f'{node.namespace}/satdyn').keys())
    control, drag = (
        participant.node.create_publisher(WrenchStamped, topic, 10) for topic in sorted(topics)
    )
    for publisher in (control, drag):
        participant.wait_until(lambda p=publisher: p.get_subscription_count() == 2)
    until, heard = health(participant), participant.listen('angular_velocity')
    control.publish(wrench((5.0, 0.0, 0.0)))
    participant.hear(heard, 20)
    drag.publish(wrench((0.0, -8.0, 3.0)))
    participant.wait_until(
        lambda: came_in.update(dict(listener.commands())) or came_in.keys() == topics
    )
    assert came_in['torque/control'].wrench.torque.x == 5.0
    assert came_in['torque/drag'].wrench.torque.y == -8.0
    page.close()

    def reported(report):
        texts = values(report['inputs'])
        return [texts[f'{name} that acts [N m]'] for name in ('torque', *sorted(topics))]

    both = ['(5.0, -8.0, 3.0)', '(5.0, 0.0, 0.0)', '(0.0, -8.0, 3.0)']
    until(node.namespace, lambda report: reported(report) == both)
    until(node.namespace, lambda report: reported(report) == 3 * ['(0.0, 0.0, 0.0)'])
    assert node.end()[0] == 0

    (directory,) = tmp_path.glob('satdyn_*_*')
    assert verify(directory).same_bytes
    acted = RecordedRun(directory).events
    begins = {event.topic: event.tick for event in acted if isinstance(event, Command)}
    assert list(begins) == ['torque/control', 'torque/drag']
    assert acted[2:] == [Timeout(tick + 200, topic) for topic, tick in begins.items()]


@pytest.mark.long
def test_what_cannot_be_a_torque_is_refused_and_changes_nothing(live):
    """Another frame, a force, no finite number: a warning of each, the motion is as before."""
    node, participant = live(FREE | {'body.inertia': [1.0, 1.0, 1.0]})
    publisher = matched(participant, WrenchStamped, 'torque')
    heard = participant.listen('angular_velocity')
    participant.hear(heard, 5)
    for _ in range(3):
        publisher.publish(wrench((1.0, 0.0, 0.0), 'lvlh'))
        publisher.publish(wrench((math.nan, 0.0, 0.0)))
        with_force = wrench((1.0, 0.0, 0.0))
        with_force.wrench.force.x = 2.0
        publisher.publish(with_force)
    participant.hear(heard, 30)
    rate = heard[-1].velocity.angular
    # A sphere without torque keeps its rate, to the tolerance.
    np.testing.assert_allclose([rate.x, rate.y, rate.z], [0.01, 0.02, 0.03], rtol=1e-12)
    _, errors = node.end()
    for sentence in (
        f'torque is given in the frame lvlh; it must be {node.body_frame} or empty',
        'torque is nan, 0, 0; it must be finite [N m]',
        'torque has a force of 2, 0, 0; the force must be zero',
    ):
        assert errors.count(sentence) == 1


def test_a_dipole_is_cut_held_and_recorded(live, tmp_path):
    """
    The diagnostics say what acts and what was cut; the bag has what was sent, and verifies.

    Another frame and a number that is not finite are refused, in one sentence each.
    """
    node, participant = live(
        {'magnetorquer.max_dipole': [0.2, 0.2, 0.0], 'torque.timeout': 2.0}
        | {'publish.topics': ['angular_velocity'], 'record.enabled': True}
    )
    publisher, until = (
        matched(participant, Vector3Stamped, 'magnetorquer_command'),
        health(participant),
    )
    for frame, dipole in (
        ('lvlh', (0.1, 0.0, 0.0)),
        ('', (0.1, math.inf, 0.0)),
        (node.body_frame, (0.5, -0.1, 0.3)),
    ):
        message = Vector3Stamped()
        message.header.frame_id = frame
        message.vector.x, message.vector.y, message.vector.z = dipole
        publisher.publish(message)

    def reported(report):
        texts = values(report['inputs'])
        names = 'dipole that acts [A m^2]', 'cut to max_dipole', 'accepted', 'refused'
        return [texts[name] for name in names]

    until(node.namespace, lambda report: reported(report) == ['(0.2, -0.1, 0.0)', '1', '1', '2'])
    until(node.namespace, lambda report: reported(report) == ['(0.0, 0.0, 0.0)', '1', '1', '2'])
    code, errors = node.end()
    assert code == 0
    for sentence in (
        f'magnetorquer_command is given in the frame lvlh; it must be {node.body_frame} or empty',
        'magnetorquer_command is 0.1, inf, 0; it must be finite [A m^2]',
    ):
        assert errors.count(sentence) == 1

    (directory,) = tmp_path.glob('satdyn_*_*')
    assert verify(directory).same_bytes
    command, end = RecordedRun(directory).events
    assert command == dipole_command(command.tick, (0.5, -0.1, 0.3), command.tick + 200)
    assert end == Timeout(command.tick + 200, 'magnetorquer_command')


def test_a_motor_turns_the_rotor(live):
    """J (s' + a . omega') = tau: the axial momentum of the rotor grows by tau t."""
    _, participant = live(
        FREE
        | {'rotor.mode': 'motor', 'rotor.axis': [0.0, 0.0, 1.0], 'rotor.inertia': 2.0}
        | {'publish.topics': ['rotor', 'angular_velocity'], 'torque.timeout': 0.0}
    )
    publisher = matched(participant, JointState, 'rotor_command')
    rotors = participant.listen('rotor')
    rates = participant.listen('angular_velocity')
    participant.hear(rotors, 5)
    publisher.publish(JointState(name=['rotor'], effort=[0.5]))

    def driven():
        axial_rate = {stamp_ns(m): m.velocity.angular.z for m in rates}
        at_both = [m for m in rotors if m.effort[0] == 0.5 and stamp_ns(m) in axial_rate]
        momentum = [2.0 * (m.velocity[0] + axial_rate[stamp_ns(m)]) for m in at_both]
        return [stamp_ns(m) for m in at_both], momentum

    participant.wait_until(lambda: len(driven()[0]) > 40, 'a driven rotor')
    stamps_ns, momentum = driven()
    t_s = (np.array(stamps_ns) - stamps_ns[0]) * 1e-9
    # The momentum is of order 0.1 and the tolerance of a step 1e-12.
    np.testing.assert_allclose(momentum, momentum[0] + 0.5 * t_s, rtol=1e-10, atol=1e-12)


def test_a_speed_is_followed_until_its_timeout_and_recorded(live, tmp_path):
    """It nears the command like exp(-k t), by s' = k (s_c - s), the body being heavy."""
    gain, wanted = 4.0, 100.0
    wheel = {'mode': 'motor', 'axis': [0.6, 0.8, 0.0], 'inertia': 1e-3, 'speed': 10.0}
    # Friction that is not felt, so that the compiled equations are those of test_speed_commands.
    wheel |= {'speed_gain': gain, 'max_torque': 1.0}
    wheel |= {'friction': 1e-15, 'coulomb_friction': 1e-15, 'friction_speed': 0.2}
    node, participant = live(
        {f'rotor.{name}': value for name, value in wheel.items()}
        | {'body.inertia': FREE['body.inertia'], 'torque.timeout': 2.0}
        | {'publish.topics': ['rotor'], 'record.enabled': True}
    )
    publisher, until = matched(participant, JointState, 'rotor_command'), health(participant)
    rotors = participant.listen('rotor')
    participant.hear(rotors, 5)
    publisher.publish(JointState(name=['rotor'], velocity=[wanted]))
    until(node.namespace, lambda report: values(report['inputs'])['accepted'] == '1')
    participant.hear(rotors, 300)
    assert node.end()[0] == 0

    (directory,) = tmp_path.glob('satdyn_*_*')
    assert verify(directory).same_bytes
    command, end = RecordedRun(directory).events
    assert command == motor_command(command.tick, {}, command.tick + 200, {'rotor': wanted})
    assert end == Timeout(command.tick + 200, 'rotor_command.rotor')
    t_s = np.array([(stamp_ns(m) - EPOCH_NS) * 1e-9 for m in rotors])
    passed = np.clip(t_s - command.tick / 100.0, 0.0, 2.0)
    speeds = [m.velocity[0] for m in rotors]
    assert t_s[-1] > end.tick / 100.0
    # The body takes up 1e-3 / 800 of it, the gravity gradient less.
    np.testing.assert_allclose(speeds, wanted - 90.0 * np.exp(-gain * passed), atol=1e-3)


def test_a_speed_is_refused_beside_a_torque_and_where_no_drive_follows_it(live):
    """Both are counted, with a sentence each, and no torque acts."""
    node, participant = live(FREE | {'rotor.mode': 'motor', 'rotor.inertia': 2.0})
    until = health(participant)
    publisher = matched(participant, JointState, 'rotor_command')
    publisher.publish(JointState(name=['rotor'], effort=[0.5], velocity=[3.0]))
    publisher.publish(JointState(name=['rotor'], velocity=[3.0]))
    found = until(node.namespace, lambda r: values(r['inputs'])['refused'] == '2')
    assert values(found['inputs'])['accepted'] == '0'
    _, errors = node.end()
    assert 'rotor_command has efforts and velocities; one of both must be empty' in errors
    assert 'a speed of the rotor rotor is given and rotor.speed_gain is 0; it must be' in errors


@pytest.mark.long
def test_limits_in_a_live_bag_verify(live, tmp_path):
    """A command is cut to max_torque and ends at max_speed: a re-run finds both again."""
    wheel = {'mode': 'motor', 'inertia': 1e-3, 'max_torque': 0.01, 'max_speed': 1.0}
    values = {'rotor.names': ['a', 'b'], 'rotor.b.axis': [0.0, 0.0, 1.0], 'torque.timeout': 0.0}
    values |= {f'rotor.{name}.{key}': value for name in 'ab' for key, value in wheel.items()}
    node, participant = live(FREE | values | {'publish.topics': ['rotor'], 'record.enabled': True})
    publisher = matched(participant, JointState, 'rotor_command')
    rotors = participant.listen('rotor')
    participant.hear(rotors, 5)
    publisher.publish(JointState(name=['b', 'a'], effort=[-0.002, 0.5]))
    participant.wait_until(
        lambda: max(map(abs, rotors[-1].effort)) < 1e-3 and rotors[-1].velocity[1] <= -1.0,
        'both at their limits',
    )
    assert node.end()[0] == 0
    (directory,) = tmp_path.glob('satdyn_*_*')
    verdict = verify(directory)
    assert verdict.is_true, str(verdict)
    assert verdict.same_bytes
    happened = [e for e in RecordedRun(directory).events if isinstance(e, RotorLimited)]
    assert [(event.rotor, event.limit) for event in happened] == [
        ('a', 'max_torque'),
        ('a', 'max_speed'),
        ('b', 'max_speed'),
    ]


@pytest.mark.long
def test_of_the_torques_that_come_in_a_pause_the_last_acts(live, tmp_path):
    """A controller that talks on meanwhile leaves one torque behind, at the tick of the step."""
    node, participant = live(FREE | {'record.enabled': True})
    until = health(participant)
    publisher = matched(participant, WrenchStamped, 'torque')
    last = int(participant.switch('pause', True)[1].removeprefix('paused after tick '))
    for torque in (1.0, 2.0, 3.0):
        publisher.publish(wrench((torque, 0.0, 0.0)))
    until(node.namespace, lambda r: values(r['inputs'])['accepted'] == '3')
    assert participant.trigger('step')[0]
    assert node.end()[0] == 0
    (directory,) = tmp_path.glob('satdyn_*_*')
    assert verify(directory).same_bytes
    one = torque_command(last + 1, (3.0, 0.0, 0.0), until_tick=last + 101)
    assert RecordedRun(directory).events == [one]

"""What the node reports about its health, and the meaning of each level."""

import re
import signal

import pytest
from commands import motor_command
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import QuaternionStamped, WrenchStamped
from sensor_msgs.msg import JointState

from satdyn_ros.ros.diagnostics import InputsReport
from satdyn_ros.ros.inputs import InputCounts
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


def health(participant):
    """Return a function that waits for the next report and returns it by part."""
    heard: list[DiagnosticArray] = []
    participant.node.create_subscription(DiagnosticArray, '/diagnostics', heard.append, 10)

    def of(namespace):
        own = f'{namespace.strip("/")}/satdyn: '
        return [
            {s.name.removeprefix(own): s for s in m.status}
            for m in heard
            if m.status[0].name.startswith(own)
        ]

    def until(namespace, condition):
        participant.wait_until(lambda: any(map(condition, of(namespace))), 'the report')
        return next(report for report in of(namespace) if condition(report))

    return until


def values(status):
    return {pair.key: pair.value for pair in status.values}


def test_a_healthy_node_is_ok(live):
    """Five parts report, in diagnostic_updater's form, with what they count."""
    node, participant = live(
        # Half a second late is later than a busy machine makes a tick.
        {'rotor.mode': 'constant_momentum', 'record.enabled': True, 'publish.rate': 2.0}
    )
    until = health(participant)
    report = until(
        node.namespace,
        lambda r: (
            all(s.level == OK for s in r.values())
            and int(values(r['recorder'])['messages']) > 0
            # The first report counts the time before tick 0 too.
            and float(values(r['pacing'])['factor reached']) > 0.4
        ),
    )
    assert list(report) == ['propagation', 'pacing', 'recorder', 'inputs', 'connections']
    satellite = f'{node.namespace[1:]}/satdyn'
    assert {status.hardware_id for status in report.values()} == {satellite}
    propagation = values(report['propagation'])
    assert propagation['tolerance'] == '1e-13'
    assert abs(float(propagation['relative drift of jacobi'])) < 1e-10
    assert values(report['recorder'])['bag'].startswith('satdyn_')
    assert int(values(report['recorder'])['bytes']) > 0


@pytest.mark.long
def test_a_coarse_propagation_is_warned_of(live):
    """At a tolerance of 1e-3 a tumbling body drifts by more than a thousandth."""
    node, participant = live(
        {'motion.tolerance': 1e-3, 'orbit.type': 'fixed', 'time.factor': 1000.0}
        | {'publish.rate': 1.0, 'initial.angular_velocity': [0.3, 0.2, 0.4]}
    )
    until = health(participant)
    report = until(node.namespace, lambda r: r['propagation'].level != OK)
    assert report['propagation'].message.endswith('above 1e-03')


@pytest.mark.long
def test_what_the_limits_of_a_motor_take_is_counted(live):
    """A command of 0.5 N m is cut once, and once limited when the rotor reaches its speed."""
    node, participant = live(
        {'rotor.mode': 'motor', 'rotor.inertia': 1e-3, 'torque.timeout': 0.0}
        | {'rotor.max_torque': 0.01, 'rotor.max_speed': 1.0, 'publish.rate': 50.0}
    )
    until = health(participant)
    publisher = participant.node.create_publisher(JointState, 'rotor_command', 10)
    participant.wait_until(lambda: publisher.get_subscription_count() > 0)
    publisher.publish(JointState(name=['rotor'], effort=[0.5]))
    report = until(
        node.namespace, lambda r: values(r['inputs'])['limited at max_speed'] not in ('0', '')
    )
    inputs = values(report['inputs'])
    assert (inputs['cut to max_torque'], inputs['limited at max_speed']) == ('1', '1')
    assert float(inputs['rotor torques that act [N m]'].strip('(,)')) == 0.0


def test_torques_reported_are_those_of_the_last_tick_published():
    """The run is computed ahead of what is published, by another thread than that of reports."""
    scenario = Scenario.from_dict(
        {'rotor': {'mode': 'motor', 'inertia': 1e-3, 'speed_gain': 0.5}, 'publish': {'rate': 10.0}}
    )
    simulation = Simulation(scenario, [motor_command(0, speeds={'rotor': 9.0})])
    _, samples = simulation.advance(50)
    report = InputsReport(InputCounts(), simulation, lambda: (samples, 4))
    simulation.rewind(5)
    simulation.advance(2)
    _, _, reported = report()
    assert reported['rotor torques that act [N m]'] == tuple(samples.rotor_torque[4])


@pytest.mark.long
def test_a_machine_that_cannot_keep_up_is_warned_of(live):
    """A million ticks per second are too many: the factor reached is said."""
    node, participant = live({'publish.rate': 1000.0, 'time.factor': 1000.0})
    until = health(participant)
    report = until(node.namespace, lambda r: r['pacing'].level == WARN)
    assert 'ticks came late, the factor reached is' in report['pacing'].message
    assert float(values(report['pacing'])['factor reached']) < 1000.0


@pytest.mark.long
def test_each_tick_is_late_once(live):
    """Inputs that come between two ticks do not make more ticks; their lateness counts ticks."""
    node, participant = live({'publish.rate': 25.0})
    until = health(participant)
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)
    participant.wait_until(lambda: publisher.get_subscription_count() == 1)

    # A command in each gap between ticks.
    participant.node.create_subscription(
        QuaternionStamped, 'attitude', lambda _: publisher.publish(WrenchStamped()), 10
    )
    report = until(node.namespace, lambda r: int(values(r['inputs'])['accepted']) > 100)
    pacing = values(report['pacing'])
    late = sum(int(count) for key, count in pacing.items() if key.startswith('ticks late up to'))
    assert 0 < late <= int(pacing['tick']) + 1


def test_a_refused_input_is_warned_of_and_a_pause_is_said(live):
    """The reason of the refusal is the sentence of the log."""
    node, participant = live()
    until = health(participant)
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)
    participant.wait_until(lambda: publisher.get_subscription_count() == 1)
    message = WrenchStamped()
    message.header.frame_id = 'map'
    publisher.publish(message)
    report = until(node.namespace, lambda r: r['inputs'].level == WARN)
    assert report['inputs'].message == (
        f'1 refused: torque is given in the frame map; it must be {node.body_frame} or empty'
    )
    assert participant.switch('pause', True)[0]
    until(node.namespace, lambda r: r['pacing'].message.startswith('paused after tick'))


@pytest.mark.long
def test_the_torque_that_acts_ends_with_its_timeout(live):
    """The display follows the torque: it is there while it acts, and zero once it has ended."""
    node, participant = live({'torque.timeout': 0.5, 'publish.rate': 10.0, 'step.ticks': 4})
    until = health(participant)
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 10)

    def reported_at(tick):
        """Return what acts by the first report of a tick, with how many were accepted."""
        report = until(
            node.namespace,
            lambda r: (
                values(r['pacing'])['tick'] == tick and values(r['inputs'])['accepted'] == '1'
            ),
        )
        return values(report['inputs'])['torque that acts [N m]']

    until(node.namespace, lambda r: values(r['connections'])['publishers of torque'] == '1')
    paused = participant.switch('pause', True)[1].removeprefix('paused after tick ')
    message = WrenchStamped()
    message.wrench.torque.z = 0.25
    publisher.publish(message)
    assert reported_at(paused) == '(0.0, 0.0, 0.0)'
    # It acts from the first of four ticks, and ends five ticks later.
    first = participant.trigger('step')[1].removeprefix('now after tick ')
    assert reported_at(first) == '(0.0, 0.0, 0.25)'
    second = participant.trigger('step')[1].removeprefix('now after tick ')
    assert reported_at(second) == '(0.0, 0.0, 0.0)'


@pytest.mark.long
def test_messages_lost_on_the_way_are_counted(live):
    """A publisher that keeps one message floods a node that stands still: the rest is lost."""
    node, participant = live({'publish.rate': 10.0})
    until = health(participant)
    publisher = participant.node.create_publisher(WrenchStamped, 'torque', 1)
    until(node.namespace, lambda r: values(r['connections'])['publishers of torque'] == '1')
    node.process.send_signal(signal.SIGSTOP)
    for _ in range(5000):
        publisher.publish(WrenchStamped())
    node.process.send_signal(signal.SIGCONT)
    report = until(node.namespace, lambda r: values(r['inputs'])['lost on the way'] != '0')
    inputs = values(report['inputs'])
    assert 0 < int(inputs['lost on the way']) <= 5000 - int(inputs['accepted'])
    assert (report['inputs'].level, report['inputs'].message) == (
        WARN,
        f'{inputs["lost on the way"]} lost on the way',
    )


@pytest.mark.long
def test_a_bag_that_cannot_be_written_is_an_error_and_the_node_flies_on(live):
    """
    No file may be larger than 5 MB: one sentence in the log, the diagnostics and the answer.

    The exit code reports it too.
    """
    node, participant = live(
        {'record.enabled': True, 'record.compression': 'none', 'time.factor': 20.0},
        file_limit_bytes=5_000_000,
    )
    until = health(participant)
    report = until(node.namespace, lambda r: r['recorder'].level == ERROR)
    assert 'can no longer be written' in report['recorder'].message
    heard = participant.listen('attitude')
    participant.hear(heard, 100)
    closed, sentence = participant.switch('record', False)
    assert not closed
    assert sentence == report['recorder'].message
    code, errors = node.end()
    assert code == 1
    assert errors.count('can no longer be written') == 1


@pytest.mark.long
def test_lateness_is_reported_each_second_and_at_the_end(live):
    """Percentiles and a histogram of all ticks with deadlines, on /diagnostics and as a line."""
    node, participant = live({'publish.rate': 100.0})
    until = health(participant)
    report = until(
        node.namespace, lambda r: int(values(r['pacing']).get('ticks late up to 1 ms', 0)) > 0
    )
    pacing = values(report['pacing'])
    names = (
        'lateness 50 % [s]',
        'lateness 99 % [s]',
        'lateness 99.9 % [s]',
        'largest lateness [s]',
    )
    lags_s = [float(pacing[name]) for name in names]
    assert 0.0 < lags_s[0]
    assert lags_s == sorted(lags_s)
    counts = [int(count) for name, count in pacing.items() if name.startswith('ticks late ')]
    assert 1 <= sum(counts) <= int(pacing['tick']) + 1
    code, errors = node.end()
    assert code == 0
    assert re.search(r'lateness of \d+ ticks: 50 % within .*, at most .*; \d+ up to ', errors)
    assert 'rosout' not in errors


@pytest.mark.long
def test_a_node_that_follows_no_clock_says_so(live):
    """With use_sim_time and without a /clock, the diagnostics are stamped by the wall clock."""
    node, participant = live({}, ros_args=['-p', 'use_sim_time:=true'])
    heard: list[DiagnosticArray] = []
    participant.node.create_subscription(DiagnosticArray, '/diagnostics', heard.append, 10)
    own = f'{node.namespace.strip("/")}/satdyn: '
    participant.wait_until(lambda: any(m.status[0].name.startswith(own) for m in heard))
    (first, *_) = [m for m in heard if m.status[0].name.startswith(own)]
    # Whatever the date, it is no time since the start of a simulation.
    assert first.header.stamp.sec > 1_600_000_000
    assert node.end()[1].count('use_sim_time is true, but there is no /clock') == 1

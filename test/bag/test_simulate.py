"""Runs without ROS and without a clock: which ticks, which messages, from where."""

import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import dipole_command, motor_command, torque_command
from flights import GYROSTAT, sequence
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from run.test_one_mind import EPHEMERIS

from satdyn_ros.actuators.wheels import Motor
from satdyn_ros.bag import continuation, run_recorder, simulate
from satdyn_ros.bag.export import Options, export
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.run_recorder import RunRecorder
from satdyn_ros.bag.verify import verify
from satdyn_ros.bag.write_run import Recording
from satdyn_ros.base import nanoseconds
from satdyn_ros.base.interruption import Terminated, interruptible
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.run import events
from satdyn_ros.run.events import Request, Reset, Timeout, Topics
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

EPOCH_NS = 1_700_000_000 * 10**9
ORBITING = Scenario(
    {
        'rotor.mode': 'constant_momentum',
        'rotor.momentum': -5.0,
        'initial.angular_velocity': [0.01, 0.02, -0.015],
        'publish.rate': 20.0,
        'publish.topics': ['attitude', 'angular_velocity'],
        'time.epoch_ns': EPOCH_NS,
    }
)

# The field needs the instant of tick 0, and turns a body with magnetorquers.
IN_A_FIELD = Scenario(
    {
        'body.inertia': [0.04, 0.04, 0.01],
        'magnetorquer.max_dipole': [0.2, 0.2, 0.2],
        'orbit.type': 'circular',
        'environment.magnetic_field': 'dipole',
        'publish.rate': 10.0,
        'publish.topics': ['angular_velocity', 'markers'],
        'time.epoch_ns': EPOCH_NS,
    }
)


def recorded(scenario, duration_s, directory, happening=(), begin=None):
    """Run to the end and return the bag's directory."""
    for _ in simulate.simulate(scenario, duration_s, directory, happening, begin):
        pass
    return directory


def read(bag):
    """Return stamps, q_ib and omega_bi_b of a bag, decoded by rosbags."""
    stamps, q_ib, omega_bi_b = [], [], []
    with AnyReader([Path(bag)], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        for connection, log_time_ns, data in reader.messages():
            # Of a class made from the definition in the bag.
            message: Any = reader.deserialize(data, connection.msgtype)
            if connection.topic == '/attitude':
                q = message.quaternion
                stamps.append(log_time_ns)
                q_ib.append((q.x, q.y, q.z, q.w))
            else:
                omega = message.velocity.angular
                omega_bi_b.append((omega.x, omega.y, omega.z))
    return np.array(stamps), np.array(q_ib), np.array(omega_bi_b)


@pytest.mark.parametrize(
    ('rate', 'duration_s', 'count'),
    [
        (10.0, '0.3', 3),
        (10.0, '0.300000000000000001', 4),
        (10.0, 0.3, 3),
        (3.0, '1', 3),
        (3.0, '1/3', 1),
        (1 / 3, '9', 3),
        (1 / 3, '9.5', 4),
        (1000.0, '1e-9', 1),
    ],
)
def test_the_ticks_are_those_before_the_end(rate, duration_s, count):
    """Ticks k with k / rate < S, in exact arithmetic, S as it is written."""
    scenario = ORBITING.with_values({'publish.rate': rate})
    assert simulate.tick_count(scenario, duration_s) == count


@pytest.mark.parametrize('duration_s', ['0', '-1', 'long', 'nan', 'inf', '1/0', ''])
def test_a_duration_is_a_number_above_0(duration_s):
    """Anything else is refused in one sentence."""
    with pytest.raises(ValueError, match='it must be a number above 0 s'):
        simulate.tick_count(ORBITING, duration_s)


def test_a_bag_ends_before_the_stamps_do():
    """The seconds of a stamp are an int32: what ends after 2^31 s would wrap to -2^31."""
    last_s = 2**31 - 1_700_000_000
    simulate.tick_count(ORBITING, last_s)
    with pytest.raises(ValueError, match='the last stamp of ROS'):
        simulate.tick_count(ORBITING, last_s + 1)


def test_a_bag_ends_before_its_ephemeris_does():
    """A run longer than what is known of the orbit is refused before it begins."""
    scenario = Scenario(
        {
            'orbit.type': 'oem',
            'orbit.file': EPHEMERIS,
            'time.epoch': '2026-03-01T12:00:00',
            'publish.rate': 1.0,
        }
    )
    assert simulate.tick_count(scenario, 181) == 181
    with pytest.raises(
        ValueError, match=r'182 s, and orbit\.file has no position after 2026-03-01T12:03:00: '
    ):
        simulate.tick_count(scenario, 182)


def test_the_bag_holds_the_motion(tmp_path):
    """Another program reads exactly the stamps and states that Python's front door gives."""
    stamps, q_ib, omega_bi_b = read(recorded(ORBITING, 300, tmp_path / 'bag'))
    states = ORBITING.motion().at(np.arange(6000) / 20.0)
    np.testing.assert_array_equal(stamps, EPOCH_NS + np.arange(6000) * 50_000_000)
    np.testing.assert_array_equal(q_ib, states.q_ib)
    np.testing.assert_array_equal(omega_bi_b, states.omega_bi_b)


def test_blocks_do_not_show(tmp_path, monkeypatch):
    """However a run is cut into blocks, its bag has the same messages in the same order."""
    happening = [torque_command(77, (0.0, 0.1, 0.0), 150), Request(200, {'rotor.speed': 3.0})]
    whole = recorded(GYROSTAT, 10, tmp_path / 'whole', happening)
    monkeypatch.setattr(RunRecorder, 'most', 13)
    parts = recorded(GYROSTAT, 10, tmp_path / 'parts', happening)
    assert sequence(whole) == sequence(parts)


def test_events_are_in_the_bag(tmp_path):
    """A run with events verifies, and its bag has them as they happened."""
    happening = [
        torque_command(20, (0.0, 0.1, 0.0), until_tick=40),
        Request(60, {'initial.angular_velocity': [0.0, 0.0, 0.1]}),
        Topics(80, ('imu',)),
    ]
    bag = recorded(GYROSTAT, 5, tmp_path / 'bag', happening)
    verdict = verify(bag)
    assert verdict.is_true
    assert verdict.same_bytes
    happened = [(type(event).__name__, event.tick) for event in RecordedRun(bag).events]
    assert happened == [('Command', 20), ('Timeout', 40), ('Request', 60), ('Topics', 80)]


def test_what_a_scenario_refuses_leaves_no_bag(tmp_path):
    """A request, torque or topic that is not allowed is refused before a directory is made."""
    refused = [Request(10, {'initial.attitude': [0.0, 0.0, 0.0, 2.0]})]
    with pytest.raises(ValueError, match=r'the event Request at tick 10: initial\.attitude'):
        recorded(ORBITING, 5, tmp_path / 'bag', refused)
    exact = Scenario({'initial.attitude': [0, 0, 0, 1], 'motion.method': 'exact'})
    with pytest.raises(ValueError, match=r'the event torque at tick 10: motion\.method is exact'):
        recorded(exact, 5, tmp_path / 'bag', [torque_command(10, (0.0, 0.0, 1.0))])
    fixed = Scenario({'orbit.type': 'fixed'})
    with pytest.raises(ValueError, match='no LVLH'):
        recorded(fixed, 5, tmp_path / 'bag', [Topics(10, ('attitude_lvlh',))])
    assert list(tmp_path.iterdir()) == []


def test_an_epoch_of_0_is_the_wall_clock(tmp_path):
    """The bag holds the microsecond at which it began, and runs again from it."""
    scenario = ORBITING.with_values({'time.epoch_ns': 0})
    before_ns = time.time_ns()
    bag = recorded(scenario, 1, tmp_path / 'bag')
    epoch_ns = RecordedRun(bag).scenario.epoch_ns
    assert before_ns - 500 <= epoch_ns <= time.time_ns()
    assert epoch_ns % 1000 == 0
    assert verify(bag).same_bytes


def test_a_run_that_is_broken_off_leaves_a_complete_bag(tmp_path):
    """A run stopped between blocks leaves all ticks up to there, and metadata.yaml."""
    run = simulate.simulate(ORBITING, 1e6, tmp_path / 'bag')
    done = next(run)
    run.close()
    assert (tmp_path / 'bag/metadata.yaml').exists()
    assert len(sequence(tmp_path / 'bag')) == 2 * done
    assert verify(tmp_path / 'bag').is_true


def test_a_run_that_is_interrupted_while_its_bag_begins_leaves_a_complete_bag(
    tmp_path, monkeypatch
):
    """The interruption waits until the bag has its scenario."""

    def interrupted(*arguments, **named):
        signal.raise_signal(signal.SIGTERM)
        return Recording(*arguments, **named)

    path = tmp_path / 'bag'
    monkeypatch.setattr(run_recorder, 'Recording', interrupted)
    with pytest.raises(Terminated), interruptible():
        list(simulate.simulate(GYROSTAT, '1', path))
    verification = verify(path)
    assert verification.is_true
    assert verification.message_count == 0


@pytest.mark.parametrize(
    'scenario',
    [
        ORBITING,
        ORBITING.with_values({'orbit.type': 'kepler', 'orbit.eccentricity': 0.1}),
        ORBITING.with_values(
            {
                'rotor.mode': 'free',
                'rotor.momentum': 0.0,
                'rotor.inertia': 0.5,
                'rotor.speed': 20.0,
                'orbit.argument_of_periapsis': 0.7,
            }
        ),
        Scenario(
            {
                'orbit.type': 'fixed',
                'orbit.gradient': 3e-6,
                'initial.angular_velocity': [0.1, 0.0, 0.2],
                'publish.topics': ['attitude', 'angular_velocity'],
                'publish.rate': 20.0,
                'time.epoch_ns': EPOCH_NS,
            }
        ),
    ],
    ids=['circular', 'kepler', 'free rotor', 'fixed'],
)
def test_a_run_goes_on_where_a_bag_is(scenario, tmp_path):
    """From a bag at S, with a request on the way, its messages are those of the longer run."""
    happening = [Request(500, {'initial.angular_velocity': [0.02, -0.01, 0.03]})]
    bag = recorded(scenario, 300, tmp_path / 'bag', happening)
    onward, begin = continuation.begun_in_bag(scenario, bag, '100')
    again = recorded(onward, 200, tmp_path / 'onward', begin=begin)
    begin_ns = EPOCH_NS + 100 * 10**9
    assert sequence(again) == [message for message in sequence(bag) if message[1] >= begin_ns]
    assert verify(again).same_bytes


@pytest.mark.parametrize('rate', [29.97, 33.3, 7.77, 3.0])
def test_ticks_go_on_at_any_rate(rate, tmp_path):
    """
    From the first tick at or after S, stamps, held torques, sensors and topics are the bag's.

    Torque and command were given before S and end after it; a continuation goes on likewise.
    """

    def ticks(bag):
        """Return the messages but for the mountings, which each bag begins with."""
        return [message for message in sequence(bag) if message[0] != '/tf_static']

    scenario = GYROSTAT.with_values(
        {
            'publish.rate': rate,
            'publish.topics': ['attitude', 'rotor'],
            'torque.timeout': 0.0,
            'sensors.names': ['gyro', 'star_tracker'],
            'sensors.gyro.noise_density': 1e-4,
            'sensors.gyro.bias_random_walk': 1e-5,
            'sensors.star_tracker.latency': 2,
        }
    )
    happening = [
        torque_command(4, (0.1, 0.0, 0.2), until_tick=60),
        motor_command(5, {'rotor': 0.01}, until_tick=58),
        Topics(6, ('attitude', 'imu')),
        Request(9, {'rotor.speed': 3.0}),
    ]
    bag, first = recorded(scenario, 80 / rate, tmp_path / 'bag', happening), 41
    # Half a tick before it: the first tick at or after S.
    onward, begin = continuation.begun_in_bag(scenario, bag, (first - 0.5) / rate)
    again = recorded(onward, 30 / rate, tmp_path / 'onward', [Reset(65)], begin)
    begin_ns, end_ns = (onward.epoch_ns + round(k * 10**9 / onward.rate) for k in (first, 65))
    assert onward.epoch_ns == scenario.epoch_ns
    assert [m for m in ticks(again) if m[1] < end_ns] == [
        m for m in ticks(bag) if begin_ns <= m[1] < end_ns
    ]
    # The reset is to the speed that was requested before.
    assert read_rotor_speed(again, 65) == 3.0
    later, begin = continuation.begun_in_bag(scenario, again, 50 / rate)
    third = recorded(later, 10 / rate, tmp_path / 'third', begin=begin)
    assert set(ticks(third)) < set(ticks(bag))
    assert all(verify(path).same_bytes for path in (bag, again, third))


def read_rotor_speed(bag, tick):
    """Return the speed of the rotor at a tick of a bag's run."""
    simulation = RecordedRun(bag).simulation()
    while simulation.tick < tick:
        simulation.advance(tick + 1 - simulation.next_tick)
    return simulation.state.rotor_speed[0]


def test_another_body_goes_on_in_the_state_of_the_bag(tmp_path):
    """What the file changes is new at that tick, and the state and the torques go on."""
    bag = recorded(
        GYROSTAT, 3, tmp_path / 'bag', [torque_command(30, (0.1, 0.0, 0.0), until_tick=70)]
    )
    other = GYROSTAT.with_values({'body.inertia': [700.0, 800.0, 500.0], 'time.epoch_ns': 0})
    onward, begin = continuation.begun_in_bag(other, bag, 2)
    simulation = Simulation.from_snapshot(onward, begin)
    run = RecordedRun(bag).simulation()
    while run.tick < 60:
        run.advance(61 - run.next_tick)
    happened, samples = simulation.advance(50)
    assert (samples.first_tick, int(samples.stamps_ns[0])) == (60, run.ticks.stamp_ns(60))
    for name in ('q_ib', 'omega_bi_b', 'rotor_speed', 'rotor_angle'):
        np.testing.assert_array_equal(getattr(samples.states[0], name), getattr(run.state, name))
    np.testing.assert_array_equal(samples.system.torque_b, [0.1, 0.0, 0.0])
    assert (happened, simulation.advance(1)[0]) == ([], [Timeout(70, 'torque')])


def test_a_commanded_speed_goes_on_where_the_wheel_can_follow_it(tmp_path):
    """Without a speed gain nothing acts any more; a wheel beyond its limit is refused."""
    wheel = {
        'orbit.type': 'fixed',
        'publish.rate': 10.0,
        'rotor.names': ['w'],
        'rotor.w.mode': 'motor',
        'rotor.w.inertia': 0.01,
        'rotor.w.speed': 50.0,
        'rotor.w.max_torque': 0.05,
        'rotor.w.speed_gain': 0.1,
    }
    scenario = Scenario(wheel)
    commanded = events.from_yaml_text('[{tick: 1, rotor_speed: {w: 90.0}, until_s: 18}]', scenario)
    bag = recorded(scenario, 15, tmp_path / 'bag', commanded)
    strong = scenario.with_values({'rotor.w.max_torque': 0.5})
    without = scenario.with_values({'rotor.w.speed_gain': 0.0})
    acting = []
    for n, other in enumerate((scenario, strong, without)):
        onward, begin = continuation.begun_in_bag(other, bag, 5)
        acting.append(Simulation.from_snapshot(onward, begin).acting['rotor_command.w'])
        assert verify(recorded(onward, 5, tmp_path / str(n), begin=begin)).same_bytes
    assert acting == [Motor(0.0, 90.0), Motor(0.0, 90.0), Motor(0.0)]
    slow = scenario.with_values({'rotor.w.max_speed': 60.0})
    with pytest.raises(ValueError, match='max_speed of the rotor w is 60 rad/s; the run contin'):
        continuation.begun_in_bag(slow, bag, 5)


def test_torques_with_names_go_on_from_a_bag(tmp_path):
    """
    Each to its own end, in files of the bag as in a continuation; verify runs them again.

    Where the file has other names, those that it has too go on, in a motion that begins anew.
    """
    scenario = GYROSTAT.with_values(
        {'torque.names': ['control', 'drag'], 'record.max_duration_s': 1.0}
    )
    happening = [
        torque_command(15, (0.0, 0.1, 0.0), 30, 'torque/control'),
        torque_command(25, (0.2, 0.0, 0.0), 75, 'torque/drag'),
        torque_command(45, (0.0, 0.1, 0.0), 70, 'torque/control'),
    ]
    bag = recorded(scenario, 4, tmp_path / 'bag', happening)
    assert {'/torque/control', '/torque/drag'} <= {topic for topic, _, _ in sequence(bag)}
    assert RecordedRun(bag).snapshot is not None
    onward, begin = continuation.begun_in_bag(scenario, bag, '1.6')
    again = recorded(onward, 2.4, tmp_path / 'onward', begin=begin)
    begin_ns = scenario.epoch_ns + 16 * 10**8
    assert sequence(again) == [m for m in sequence(bag) if m[1] >= begin_ns]
    assert all(verify(path).same_bytes for path in (bag, again))

    with pytest.raises(ValueError, match='topic is torque; allowed: torque/control, torque/drag'):
        recorded(scenario, 4, tmp_path / 'none', [torque_command(3, (0.1, 0.0, 0.0))])

    other = scenario.with_values({'torque.names': ['drag', 'jet']})
    onward, begin = continuation.begun_in_bag(other, bag, '1.6')
    simulation = Simulation.from_snapshot(onward, begin)
    _, samples = simulation.advance(27)
    np.testing.assert_array_equal(samples.system.torque_b, [0.2, 0.0, 0.0])
    assert simulation.advance(1)[0] == [Timeout(75, 'torque/drag')]


def test_a_dipole_goes_on_from_a_bag(tmp_path):
    """
    To its end, in files of the bag, through a reset and in a continuation; verify runs it again.

    Where the file has weaker magnetorquers, they have what they can; where it has none, none acts.
    """
    scenario = IN_A_FIELD.with_values({'record.max_duration_s': 1.0})
    happening = [dipole_command(5, (0.5, 0.0, -0.1), until_tick=45), Reset(30)]
    bag = recorded(scenario, 5, tmp_path / 'bag', happening)
    run = RecordedRun(bag)
    assert run.events == [*happening, Timeout(45, 'magnetorquer_command')]
    onward, begin = continuation.begun_in_bag(scenario, bag, '2.6')
    again = recorded(onward, 2.4, tmp_path / 'onward', [Reset(30)], begin)
    begin_ns = scenario.epoch_ns + 26 * 10**8
    assert sequence(again) == [m for m in sequence(bag) if m[1] >= begin_ns]
    assert all(verify(path).same_bytes for path in (bag, again))

    weak = scenario.with_values({'magnetorquer.max_dipole': [0.1, 0.1, 0.1]})
    onward, begin = continuation.begun_in_bag(weak, bag, '2.6')
    simulation = Simulation.from_snapshot(onward, begin)
    assert simulation.acting['magnetorquer_command'] == (0.1, 0.0, -0.1)
    simulation.advance(19)
    assert simulation.advance(1)[0] == [Timeout(45, 'magnetorquer_command')]
    none = scenario.with_values({'magnetorquer.max_dipole': [0.0, 0.0, 0.0]})
    onward, begin = continuation.begun_in_bag(none, bag, '2.6')
    simulation = Simulation.from_snapshot(onward, begin)
    assert 'magnetorquer_command' not in simulation.acting
    # In another field a motion begins anew, in the state of the bag.
    still = scenario.with_values({'environment.magnetic_field': 'none'})
    onward, begin = continuation.begun_in_bag(still, bag, '2.6')
    simulation, before = Simulation.from_snapshot(onward, begin), run.simulation()
    simulation.advance(1)
    while before.tick < 26:
        before.advance(27 - before.next_tick)
    np.testing.assert_array_equal(simulation.state.omega_bi_b, before.state.omega_bi_b)
    with pytest.raises(ValueError, match='magnetorquer_command at tick 50: its topic is'):
        recorded(none, 5, tmp_path / 'none', [dipole_command(50, (0.1, 0.0, 0.0))])


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        ({'publish.rate': 10.0}, r'publish\.rate is 10\.0; the run in .* continues with 20\.0'),
        ({'time.epoch_ns': 5}, r'time\.epoch_ns is 5; the run in .* continues with 17'),
    ],
)
def test_a_run_goes_on_with_its_own_ticks(changes, sentence, tmp_path):
    """Another rate or epoch is refused, and an event before the tick where it goes on."""
    bag = recorded(ORBITING, 10, tmp_path / 'bag')
    with pytest.raises(ValueError, match=sentence):
        continuation.begun_in_bag(ORBITING.with_values(changes), bag, '5')
    onward, begin = continuation.begun_in_bag(ORBITING, bag, '5')
    with pytest.raises(
        ValueError, match='the event Reset at tick 99: the run continues at tick 10'
    ):
        recorded(onward, 1, tmp_path / 'onward', [Reset(99)], begin)


def test_a_bag_has_no_state_beyond_its_end(tmp_path):
    """An instant that the bag does not reach, and a word that is none, are refused."""
    bag = recorded(ORBITING, 10, tmp_path / 'bag')
    with pytest.raises(ValueError, match=r'no state at 10 s; it goes from 0 to 9\.95 s'):
        continuation.begun_in_bag(ORBITING, bag, '10')
    with pytest.raises(ValueError, match='the instant is soon'):
        continuation.begun_in_bag(ORBITING, bag, 'soon')


def test_a_run_goes_on_from_an_attitude_message(tmp_path):
    """Exported with rates and begun at one of its rows, a run goes on as before."""
    bag = recorded(ORBITING, 20, tmp_path / 'bag')
    message = tmp_path / 'bag.aem'
    export(bag, message, Options(with_rates=True))
    epoch = nanoseconds.epoch(ORBITING.epoch_ns + 10 * 10**9)
    begun = continuation.begun_in_aem(ORBITING.with_values({'time.epoch_ns': 0}), message, epoch)
    assert begun.epoch_ns == ORBITING.epoch_ns + 10 * 10**9
    stamps_ns, q_ib, omega_bi_b = read(bag)
    (row,) = np.flatnonzero(stamps_ns == begun.epoch_ns)
    np.testing.assert_allclose(begun.initial_state.q_ib, q_ib[row], rtol=0.0, atol=1e-15)
    # Sixteen digits in deg/s.
    np.testing.assert_allclose(begun.initial_state.omega_bi_b, omega_bi_b[row], rtol=1e-14)
    # The given epoch wins; the orbit begins as the scenario says.
    assert continuation.begun_in_aem(ORBITING, message, epoch).epoch_ns == ORBITING.epoch_ns


def test_without_rates_in_the_message_the_scenario_gives_the_rate(tmp_path):
    """Relative to its frame: a body at rest in LVLH turns once per orbit."""
    message = tmp_path / 'bag.aem'
    export(recorded(ORBITING, 1, tmp_path / 'bag'), message)
    epoch = nanoseconds.epoch(ORBITING.epoch_ns)
    resting = Scenario({'initial.frame': 'lvlh', 'orbit.inclination': 0.9})
    state = continuation.begun_in_aem(resting, message, epoch).initial_state
    rate_i = rotation.rotate(state.q_ib, state.omega_bi_b)
    orbit = resting.system.orbit
    assert isinstance(orbit, KeplerOrbit)
    np.testing.assert_allclose(rate_i, orbit.mean_motion * orbit.normal, rtol=0.0, atol=1e-17)
    rate_b = (0.1, -0.2, 0.3)
    turning = Scenario({'initial.frame': 'inertial', 'initial.angular_velocity': rate_b})
    state = continuation.begun_in_aem(turning, message, epoch).initial_state
    np.testing.assert_array_equal(state.omega_bi_b, rate_b)


def test_the_rate_of_lvlh_is_that_of_the_instant_in_the_message(tmp_path):
    """Surroundings that need the instant of tick 0 have it from there, or from the scenario."""
    message = tmp_path / 'bag.aem'
    export(recorded(ORBITING, 1, tmp_path / 'bag'), message)
    without = Scenario({'initial.frame': 'lvlh', 'environment.magnetic_field': 'dipole'})
    epoch = nanoseconds.epoch(ORBITING.epoch_ns)
    begun = continuation.begun_in_aem(without, message, epoch)
    assert begun == continuation.begun_in_aem(
        without.with_values({'time.epoch': epoch}), message, epoch
    )


@pytest.mark.long
def test_memory_stays_flat(tmp_path):
    """A day at 10 Hz takes less than 50 MB more than a minute does."""
    program = f"""
import resource
from satdyn_ros.bag import simulate
from satdyn_ros.run.scenario import Scenario
scenario = Scenario({{'publish.rate': 10.0, 'publish.topics': ['attitude', 'imu']}})
peaks = []
for duration_s in (60, 86400):
    for _ in simulate.simulate(scenario, duration_s, f'{tmp_path}/{{duration_s}}'):
        pass
    peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
print((peaks[1] - peaks[0]) / 1024)
"""
    root = Path(__file__).parents[2]
    grown_mb = subprocess.check_output([sys.executable, '-c', program], cwd=root, text=True)
    assert float(grown_mb) < 50.0

"""Limits of motors follow from the run: torques cut at commands, torques that end at a speed."""

import re
from collections.abc import Callable

import numpy as np
import pytest
import yaml
from commands import motor_command, torque_command
from environment import truth
from flights import difference, sequence, summary, written

from satdyn_ros.bag.continuation import begun_in_bag
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.bag.write_run import Recording
from satdyn_ros.dynamics.motion import Halted
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.rosbag2.recover import recover
from satdyn_ros.rosbag2.scan import Block, scan
from satdyn_ros.run.events import (
    Event,
    Request,
    Reset,
    RotorLimited,
    Timeout,
    Topics,
    from_yaml_text,
)
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.segment import MOST_STEPS_A_TICK
from satdyn_ros.run.simulation import Simulation

CASES = {case['name']: case for case in truth.cases('gravity_gradient')}
WHEEL = {
    'mode': 'motor',
    'inertia': 1e-3,
    'friction': 1e-4,
    'max_torque': 0.01,
    'max_speed': 5.0,
}
SCENARIO = Scenario.from_dict(
    {
        'body': {'inertia': [0.05, 0.06, 0.04]},
        'rotor': {
            'names': ['a', 'b'],
            'a': {**WHEEL, 'axis': [1.0, 0.0, 0.0]},
            'b': {**WHEEL, 'axis': [0.0, 0.0, 1.0]},
        },
        'publish': {'rate': 50.0, 'topics': ['attitude', 'angular_velocity', 'rotor']},
        'torque': {'timeout': 0.0},
        'time': {'epoch_ns': 10**18},
    }
)
CUT, FAST = 'max_torque', 'max_speed'


def run(events, ticks=200, block=64):
    """Return the events applied, and at each tick the speeds and the motor torques (N, 2)."""
    simulation, applied, speeds, torques = Simulation(SCENARIO, events), [], [], []
    while simulation.next_tick < ticks:
        new, samples = simulation.advance(min(block, ticks - simulation.next_tick))
        applied += new
        speeds.append(samples.states.rotor_speed)
        torques.append(samples.rotor_torque)
    return applied, np.concatenate(speeds), np.concatenate(torques)


def test_a_torque_is_cut_to_max_torque():
    """Either way; what is within the limit acts as given, and the other rotor keeps its own."""
    command, opposite = motor_command(10, {'a': 0.5, 'b': -0.01}), motor_command(20, {'a': -0.5})
    applied, _, torques = run([command, opposite], ticks=30)
    assert applied == [
        command,
        RotorLimited(10, 'a', CUT),
        opposite,
        RotorLimited(20, 'a', CUT),
    ]
    expected = [[0.0, 0.0]] * 10 + [[0.01, -0.01]] * 10 + [[-0.01, -0.01]] * 10
    np.testing.assert_array_equal(torques, expected)


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_a_rotor_stays_at_max_speed_as_long_as_it_is_commanded(sign):
    """
    It reaches the limit between ticks, and stays there by the torque that friction takes.

    That is reported once, at the first tick after it; when the torque times out the rotor slows.
    """
    applied, speeds, torques = run(
        [motor_command(0, {'a': sign * 0.01, 'b': sign * 1e-3}, until_tick=150)]
    )
    (limited,) = (event for event in applied if isinstance(event, RotorLimited))
    tick, speeds = limited.tick, sign * speeds[:, 0]
    assert limited == RotorLimited(tick, 'a', FAST)
    assert speeds[tick - 1] < 5.0
    np.testing.assert_allclose(speeds[tick:150], 5.0, rtol=1e-12)
    assert (sign * torques[:tick, 0] == 0.01).all()
    # J a . omega', which the reaction on the body by the other wheel gives, is a tenth of it.
    np.testing.assert_allclose(sign * torques[tick:150, 0], 5e-4, rtol=0.1)
    assert (torques[150:] == 0.0).all()
    assert (sign * torques[:150, 1] == 1e-3).all()
    assert (np.diff(speeds[150:]) < 0.0).all()


def test_at_max_speed_a_command_acts_only_where_it_slows():
    """Less than the friction takes, or the other way: the rotor leaves its limit at once."""
    first = motor_command(0, {'a': 0.01})
    (limited,) = (event for event in run([first])[0] if isinstance(event, RotorLimited))
    tick = limited.tick + 5
    for torque in (0.0004, -0.002):
        applied, speeds, torques = run([first, motor_command(tick, {'a': torque})], tick + 3)
        assert applied == [first, limited, motor_command(tick, {'a': torque})]
        assert (torques[tick:, 0] == torque).all()
        assert (np.diff(speeds[tick - 1 :, 0]) < 1e-15).all()


@pytest.mark.parametrize('rate', [1e3, -3e3, 1.1e4, -2.3e4])
def test_a_rotor_leaves_its_limit_on_a_body_that_turns_fast(rate):
    """Its speed is a difference of large numbers there, whose rounding is no way back."""
    begin = Request(0, {'initial.angular_velocity': [0.0, 0.0, rate], 'rotor.b.speed': 5.0})
    _, speeds, _ = run([begin, motor_command(0, {'b': 0.0004})], ticks=3)
    assert (np.diff(speeds[:, 1]) < 0.0).all()


def test_a_rotor_that_meets_its_limit_ever_again_ends_the_motion():
    """As often as it does in each turn of a body of 3e7 rad/s: it halts after a second's work."""
    begin = SCENARIO.with_values({'initial.angular_velocity': [0.0, 2.7e7, 2.7e6]})
    system = begin.system.driven(rotor_torque=np.array([0.0, 0.01]))
    motion = Propagation(system, begin.initial_state, most_steps=MOST_STEPS_A_TICK)
    motion.at(0.0)
    with pytest.raises(
        Halted, match=r'limits more than \d+ times before the next sample'
    ) as halted:
        motion.at(0.02)
    (times,) = re.findall(r'more than (\d+) times', str(halted.value))
    assert 0 < int(times) <= MOST_STEPS_A_TICK / 200


def test_states_at_a_limit_are_those_of_the_reference():
    """To the bound of the case, and the same to rounding at 1, 10 and 100 Hz."""
    case, flown = CASES['wheel_limit_1hz'], []
    t_s = truth.column(case['states'], 't')
    for rate in (1, 10, 100):
        scenario = Scenario.from_dict(case['scenario'] | {'publish': {'rate': float(rate)}})
        events = from_yaml_text(yaml.safe_dump(case['events']), scenario)
        simulation, rows = Simulation(scenario, events), []
        while simulation.next_tick <= rate * t_s[-1]:
            _, samples = simulation.advance(int(rate * t_s[-1]) + 1 - simulation.next_tick)
            states = samples.states
            rows.append(np.hstack([states.q_ib, states.omega_bi_b, states.rotor_speed]))
        flown.append(np.concatenate(rows)[(rate * t_s).astype(int)])
        assert simulation.tick == rate * t_s[-1]
    q_ib, omega, speed = (
        truth.column(case['states'], each) for each in ('q_xyzw', 'omega', 'rotor_speed')
    )
    for rows in flown:
        assert np.max(rotation.angle_between(rows[:, :4], q_ib)) < case['bound']
        np.testing.assert_allclose(rows[:, 4:7], omega, rtol=0.0, atol=case['bound'])
        np.testing.assert_allclose(rows[:, 7:], speed, rtol=1e-12)
        np.testing.assert_allclose(rows, flown[0], rtol=1e-12, atol=1e-12)


def test_a_body_that_moves_a_rotor_beyond_its_limit_is_not_helped():
    """
    A torque slows the body about the axis, so that the rotor turns ever faster relative to it.

    The motor gives nothing meanwhile, and holds the rotor again when it is back at its limit.
    """
    command = motor_command(0, {'a': 0.01})
    slower, faster = torque_command(100, (-0.05, 0.0, 0.0)), torque_command(120, (0.05, 0.0, 0.0))
    applied, speeds, torques = run([command, slower, faster], ticks=200)
    beyond = speeds[:, 0] > 5.0 + 1e-9
    assert beyond[101:121].all()
    assert not beyond[:101].any()
    assert (torques[101:120, 0] == 0.0).all()
    again = [event.tick for event in applied if event == RotorLimited(event.tick, 'a', FAST)]
    assert len(again) == 2
    assert not beyond[again[1] :].any()


@pytest.mark.parametrize('rules', [0, 1, 2])
def test_by_earlier_rules_a_limit_of_speed_acts_where_the_bag_tells_it(rules):
    """It drops the torque at its tick after all else, and nothing else limits the speed."""
    first, met = motor_command(0, {'a': 0.01, 'b': 0.02}), RotorLimited(80, 'a', FAST)
    events: list[Event] = [first, RotorLimited(0, 'b', CUT), met, motor_command(80, {'a': 0.005})]
    simulation, applied, torques = Simulation(SCENARIO, events, rules), list[Event](), []
    while simulation.next_tick < 200:
        happened, samples = simulation.advance(200 - simulation.next_tick)
        applied += happened
        torques += [samples.system.rotor_torque] * len(samples)
    assert applied == [first, RotorLimited(0, 'b', CUT), motor_command(80, {'a': 0.005}), met]
    assert [tuple(torque) for torque in torques] == [(0.01, 0.01)] * 80 + [(0.0, 0.01)] * 120
    assert min(simulation.state.rotor_speed) > 5.0


EVENTS: list[Event] = [
    motor_command(3, {'a': 0.02, 'b': 0.007}),
    motor_command(90, {'a': -0.02}, until_tick=170),
    Reset(120),
]


@pytest.mark.parametrize('block', [1, 7])
def test_limits_follow_from_the_run(block):
    """However it is cut into blocks; limits that are given beforehand change nothing."""
    applied, speeds, torques = run(EVENTS)
    given = [event for event in applied if not isinstance(event, Timeout)]
    again = run([*given, RotorLimited(5, 'b', FAST)], block=block)
    assert {event.limit for event in applied if isinstance(event, RotorLimited)} == {CUT, FAST}
    assert again[0] == applied
    np.testing.assert_array_equal(again[1], speeds)
    np.testing.assert_array_equal(again[2], torques)


def recorded(directory, scenario=SCENARIO):
    """Record four seconds in which two torques are cut and two rotors come to their limits."""
    for _ in simulate(scenario, 4.0, directory, EVENTS):
        pass
    return directory


def test_a_bag_with_limits_verifies(tmp_path):
    """Run again from its bag alone, the run comes to the same limits and the same bytes."""
    verdict = verify(recorded(tmp_path / 'bag'))
    assert verdict.is_true
    assert verdict.same_bytes


def limits(applied):
    return [event for event in applied if isinstance(event, RotorLimited)]


def test_limits_are_the_same_from_any_tick_on():
    """
    A snapshot holds what limits depend on: resumed anywhere, the run goes on with the same bits.

    Also at and beside the ticks where a torque is cut or a limit reported.
    """
    whole, speeds, torques = run(EVENTS)
    begins = {tick + by for tick in {event.tick for event in limits(whole)} for by in (-1, 0, 1)}
    assert len(begins) > 8
    for begin in begins:
        simulation = Simulation(SCENARIO, EVENTS)
        while simulation.next_tick <= begin:
            simulation.advance(begin + 1 - simulation.next_tick)
        later = [event for event in EVENTS if event.tick > begin]
        resumed = Simulation.from_snapshot(SCENARIO, simulation.snapshot(begin), later)
        applied = []
        for tick in range(begin, 200):
            new, samples = resumed.advance(1)
            applied += new
            np.testing.assert_array_equal(samples.states.rotor_speed[0], speeds[tick])
            np.testing.assert_array_equal(samples.rotor_torque[0], torques[tick])
        assert applied == [event for event in whole if event.tick > begin]


@pytest.mark.parametrize('duration_s', [0.1, 0.33])
def test_each_file_of_a_split_bag_with_limits_verifies(tmp_path, duration_s):
    """Each begins from its own snapshot, one of them where a limit acts."""
    scenario = SCENARIO.with_values({'record.max_duration_s': duration_s})
    files = sorted(recorded(tmp_path / 'bag', scenario).glob('*.mcap'))
    assert len(files) > 10
    for file in files:
        verdict = verify(file)
        assert verdict.is_true, str(verdict)
        assert verdict.same_bytes


def test_a_limit_at_every_tick_ends_no_chunk(tmp_path):
    """A controller beyond max_torque costs its bag no more than the records; they verify."""
    commands = [motor_command(tick, {'a': (-1) ** tick * (1.0 + tick)}) for tick in range(1, 300)]
    bag = tmp_path / 'bag'
    list(simulate(SCENARIO, 6.0, bag, commands))
    statistics = summary(next(bag.glob('*.mcap'))).statistics
    assert statistics is not None
    assert statistics.chunk_count == 1
    reported = RecordedRun(bag).events
    cut = [RotorLimited(tick, 'a', CUT) for tick in range(1, 300)]
    assert sorted(reported, key=str) == sorted([*commands, *cut], key=str)
    assert [event.tick for event in reported] == sorted(event.tick for event in reported)
    assert verify(bag).same_bytes


def test_a_writer_that_dies_between_a_limit_and_its_command_leaves_a_true_bag(tmp_path):
    """The record of a limit stands before the chunk with the command that meets it."""
    commands = [motor_command(tick, {'a': (-1) ** tick * 1.0}) for tick in range(1, 100)]
    bag = tmp_path / 'bag'
    recording, simulation = (
        Recording(bag, SCENARIO, SCENARIO.topics),
        Simulation(SCENARIO, commands),
    )
    for tick in written(recording, simulation, 100, block=1):
        if tick == 50:
            recording.flush()
    recording.close()
    file = next(bag.glob('*.mcap'))
    last_chunk = [found for found in scan(file) if isinstance(found.item, Block)][-1]
    file.write_bytes(file.read_bytes()[: last_chunk.start])
    (bag / 'metadata.yaml').unlink()
    recover(bag)
    reported = limits(RecordedRun(bag).events)
    assert {event.tick for event in reported} > {49, 50, 51, 99}
    verdict = verify(bag)
    assert verdict.is_true, str(verdict)
    assert verdict.same_bytes


def without(limited, monkeypatch):
    """Let recordings leave out the events of one limit."""
    write = Recording.event

    def event(self, event, log_time_ns):
        if event != limited:
            write(self, event, log_time_ns)

    monkeypatch.setattr(Recording, 'event', event)


@pytest.mark.parametrize('limit', [CUT, FAST])
def test_a_limit_that_the_bag_does_not_tell_is_a_difference(limit, tmp_path, monkeypatch):
    """The run comes to its limits again, and verify compares them with those of the bag."""
    missing = next(event for event in limits(run(EVENTS)[0]) if event.limit == limit)
    without(missing, monkeypatch)
    verdict = verify(recorded(tmp_path / 'bag'))
    assert difference(verdict).tick == missing.tick
    assert 'RotorLimited' in str(verdict)


def test_a_run_goes_on_from_a_bag_with_limits(tmp_path):
    """
    Where both rotors are at their limits, and where one has just come there: the same speeds.

    The speed may be above its limit in the last digits, which no initial speed may be.
    """
    bag = recorded(tmp_path / 'bag')
    fast = next(event.tick for event in limits(run(EVENTS)[0]) if event.limit == FAST)
    for tick, end in ((60, 90), (fast, fast + 5)):
        scenario, begin = begun_in_bag(SCENARIO, bag, tick / 50.0)
        for _ in simulate(scenario, (end - tick) / 50.0, tmp_path / str(tick), begin=begin):
            pass
        assert verify(tmp_path / str(tick)).same_bytes
        last_ns = SCENARIO.epoch_ns + (end - 1) * 20_000_000
        assert sequence(tmp_path / str(tick)) == [
            message
            for message in sequence(bag)
            if SCENARIO.epoch_ns + tick * 20_000_000 <= message[1] <= last_ns
        ]


# -- computed ahead, and computed anew ------------------------------------------------------------


def test_a_limit_that_was_computed_ahead_is_undone():
    """A command that comes before the tick is published acts there as if nothing had been."""
    scenario = SCENARIO.with_values({'rotor.a.speed': 4.7})
    first, second = motor_command(0, {'a': 0.01}), motor_command(1, {'a': -0.01})
    simulation = Simulation(scenario, [first])
    assert len(simulation.advance(9)[1]) == 2
    assert limits(simulation.advance(9)[0]) == [RotorLimited(2, 'a', FAST)]
    simulation = Simulation(scenario, [first])
    simulation.advance(9)
    simulation.rewind(1)
    simulation.schedule(second)
    happened, samples = simulation.advance(9)
    assert happened == [second]
    assert samples.rotor_torque[0, 0] == -0.01
    straight = Simulation(scenario, [first, second])
    straight.advance(1)
    _, same = straight.advance(9)
    np.testing.assert_array_equal(samples.states.rotor_speed, same.states.rotor_speed)


@pytest.mark.parametrize('seed', range(8))
def test_a_run_computed_ahead_is_the_run_that_knew(seed):
    """
    What comes while ticks are computed ahead acts as if it had been known from the start.

    Commands, torques, requests, resets and topics, several to a tick, at wheels near their limits.
    """
    draw = np.random.default_rng(seed)
    kinds: list[Callable[[int], Event]] = [
        Reset,
        lambda tick: Request(tick, {'rotor.b.speed': draw.uniform(-5.0, 5.0)}),
        lambda tick: motor_command(tick, {'a': draw.choice([0.02, -0.02, 0.0])}, tick + 9),
        lambda tick: motor_command(tick, {'b': draw.choice([0.005, -0.005])}),
        lambda tick: torque_command(tick, (1e-4 * draw.normal(), 0.0, 0.0), tick + 4),
        lambda tick: Topics(tick, ('attitude',)),
    ]
    live, reported, came = Simulation(SCENARIO), list[Event](), list[Event]()
    speeds = []
    while live.next_tick < 120:
        first = live.next_tick
        happened, samples = live.advance(int(draw.integers(1, 12)))
        published = int(draw.integers(0, len(samples) + 1))
        if published:
            reported += happened
            speeds.append(samples.states.rotor_speed[:published])
        live.rewind(first + published)
        for kind in draw.choice(len(kinds), draw.integers(0, 3)):
            came.append(kinds[kind](live.next_tick))
            live.schedule(came[-1])
    straight = run(came, live.next_tick)
    assert reported == [event for event in straight[0] if event.tick < live.next_tick]
    np.testing.assert_array_equal(np.concatenate(speeds), straight[1][: live.next_tick])

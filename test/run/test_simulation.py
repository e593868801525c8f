"""Scenario and events to samples: the engine of the node, stepped without ROS."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from commands import motor_command, torque_command
from hypothesis import given, settings
from hypothesis import strategies as st

from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.run.events import Event, Request, Reset, Timeout, Topics, TorquesDropped
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

COLUMNS = ('q_ib', 'omega_bi_b', 'r_i', 'v_i')
GYROSTAT = Scenario.from_dict(
    {
        'rotor': {'mode': 'motor', 'inertia': 0.5, 'speed': 20.0},
        'publish': {'rate': 50.0},
        'torque': {'timeout': 0.0},
    }
)


def run(scenario, events=(), ticks=200, block=64):
    """Return the events applied and the states' columns over ticks, advanced in blocks."""
    simulation, applied, blocks = Simulation(scenario, events), [], []
    while simulation.next_tick < ticks:
        new, samples = simulation.advance(min(block, ticks - simulation.next_tick))
        applied += new
        blocks.append(samples)
    table = {
        name: np.concatenate([getattr(block.states, name) for block in blocks]) for name in COLUMNS
    }
    table['stamps_ns'] = np.concatenate([block.stamps_ns for block in blocks])
    return applied, table


EVENTS: list[Event] = [
    torque_command(20, (0.1, -0.2, 0.3), until_tick=90),
    motor_command(40, {'rotor': 0.05}),
    Request(60, {'initial.angular_velocity': [0.0, 0.0, 0.05], 'rotor.speed': 5.0}),
    motor_command(110, {'rotor': 0.0}),
    Reset(130),
    Topics(150, ('attitude',)),
]


@pytest.mark.parametrize('block', [1, 7, 1000])
def test_blocks_do_not_matter(block):
    """However the run is cut into blocks, its bits are the same."""
    _, truth = run(GYROSTAT, EVENTS)
    applied, table = run(GYROSTAT, EVENTS, block=block)
    for name, column in truth.items():
        np.testing.assert_array_equal(table[name], column)
    assert Timeout(90, 'torque') in applied
    assert len(applied) == len(EVENTS) + 1


def test_orbit_is_a_function_of_the_tick_alone():
    """Requests, resets and torques leave the orbit's bits as they are."""
    _, quiet = run(GYROSTAT)
    _, busy = run(GYROSTAT, EVENTS)
    for name in ('r_i', 'v_i', 'stamps_ns'):
        np.testing.assert_array_equal(quiet[name], busy[name])


def test_steps_are_the_blocks():
    """Stepping gives the states of the samples, bit for bit."""
    _, table = run(GYROSTAT, ticks=30)
    simulation = Simulation(GYROSTAT)
    assert np.array_equal(simulation.state.q_ib, table['q_ib'][0])
    for k in range(1, 30):
        state = simulation.step()
        assert simulation.tick == k
        assert np.array_equal(state.q_ib, table['q_ib'][k])
        assert np.array_equal(state.omega_bi_b, table['omega_bi_b'][k])


@pytest.mark.parametrize('torque_b', [(1.0, 2.0), (np.nan, 0.0, 0.0), (0.0, 0.0, np.inf)])
def test_torque_of_a_step_is_three_numbers(torque_b):
    """What is refused changes nothing, and the sentence says what was given."""
    simulation = Simulation(Scenario.from_dict({}))
    before = simulation.step()
    with pytest.raises(ValueError, match=r'^torque is .*; it must be a list of 3 numbers N m$'):
        simulation.step(torque_b=torque_b)
    assert simulation.tick == 1
    assert np.array_equal(simulation.state.q_ib, before.q_ib)


def test_torque_of_a_step_holds_during_it():
    """One step's torque acts from the tick before to the tick after it, and no longer."""
    torque, k = (0.3, -0.1, 0.2), 10
    simulation = Simulation(GYROSTAT)
    for _ in range(k):
        before = simulation.step()
    after = simulation.step(torque_b=torque)
    free = simulation.step()
    system = replace(GYROSTAT.system, torque_b=np.array(torque))
    dt = float(1 / GYROSTAT.rate)
    driven = Propagation(system, before, k * dt).at(dt)
    np.testing.assert_array_equal(after.omega_bi_b, driven.omega_bi_b[0])
    coasting = Propagation(GYROSTAT.system, after, (k + 1) * dt).at(dt)
    np.testing.assert_array_equal(free.omega_bi_b, coasting.omega_bi_b[0])
    events = [torque_command(k, torque), torque_command(k + 1, (0.0, 0.0, 0.0))]
    _, table = run(GYROSTAT, events, ticks=k + 3)
    np.testing.assert_array_equal(table['omega_bi_b'][k + 2], free.omega_bi_b)


def test_request_restarts_exactly():
    """The first tick after a request carries exactly the requested state; the rest follows."""
    q = rotation.normalise([0.1, 0.2, 0.3, 0.9])
    simulation = Simulation(GYROSTAT)
    for _ in range(5):
        simulation.step()
    simulation.request(
        {
            'initial.frame': 'inertial',
            'initial.attitude': list(q),
            'initial.angular_velocity': [0.0, 0.01, 0.0],
            'rotor.speed': -3.0,
        }
    )
    state = simulation.step()
    assert simulation.tick == 6
    assert np.array_equal(state.q_ib, q)
    assert np.array_equal(state.omega_bi_b, [0.0, 0.01, 0.0])
    assert state.rotor_speed == -3.0
    later = [simulation.step() for _ in range(20)][-1]
    truth = Propagation(GYROSTAT.system, state, 6 / 50).at(20 / 50)
    np.testing.assert_array_equal(later.q_ib, truth.q_ib[0])


def test_request_refers_to_lvlh_at_its_tick():
    """An attitude to LVLH is the one at the tick of the restart, though LVLH has turned on."""
    scenario = GYROSTAT.with_values({'publish.rate': 0.01})
    simulation = Simulation(scenario, [Reset(20)])
    for _ in range(20):
        state = simulation.step()
    q_il = scenario.system.orbit.lvlh(2000.0)
    q_lb = rotation.multiply(rotation.conjugate(q_il), state.q_ib)
    # Two products of unit quaternions round to a few 1e-16.
    assert rotation.angle_between(q_lb, scenario['initial.attitude']) < 1e-15


def test_keys_not_given_stay_in_force():
    """A request changes what it names; the rest is that of the last file or request."""
    simulation = Simulation(GYROSTAT)
    simulation.request({'initial.angular_velocity': [0.0, 0.0, 0.2]})
    simulation.request({'rotor.speed': 7.0})
    assert simulation.conditions['initial.angular_velocity'] == (0.0, 0.0, 0.2)
    assert simulation.conditions['initial.attitude'] == GYROSTAT['initial.attitude']


@pytest.mark.parametrize(
    ('values', 'sentence'),
    [
        ({'initial.attitude': [0, 0, 0, 2]}, 'initial.attitude is .* of norm 2; it must be a un'),
        ({'initial.angular_velocity': [0, float('nan'), 0]}, 'initial.angular_velocity is .*nan'),
        ({'publish.rate': 5.0}, 'publish.rate cannot be requested'),
        ({'nonsense': 1}, 'nonsense cannot be requested'),
        ({'rotor.momentum': 1.0}, 'rotor.momentum is 1.0; with rotor.mode motor only'),
    ],
)
def test_refused_request_changes_nothing(values, sentence):
    """A refusal says why in one sentence, and the run continues unchanged."""
    simulation, undisturbed = Simulation(GYROSTAT), Simulation(GYROSTAT)
    simulation.step(), undisturbed.step()
    with pytest.raises(ValueError, match=sentence) as refusal:
        simulation.request({'initial.frame': 'inertial'} | values)
    assert '\n' not in str(refusal.value)
    assert simulation.conditions == GYROSTAT
    assert np.array_equal(simulation.step().q_ib, undisturbed.step().q_ib)


def test_an_event_changes_initial_conditions_alone():
    """A program's events are refused as an events file's are: the body and the ticks stay."""
    simulation = Simulation(GYROSTAT, [Request(1, {'body.inertia': [1.0, 2.0, 3.0]})])
    simulation.advance(1)
    with pytest.raises(ValueError, match=r'body\.inertia cannot be requested; allowed: '):
        simulation.advance(1)
    assert simulation.tick == 0


def test_a_snapshot_copy_leaves_the_motion_alone():
    """A file that begins in mid-run is written while the motion walks on in another thread."""
    simulation = Simulation(GYROSTAT.with_values({'publish.rate': 0.1}))
    simulation.advance(64)
    taken, kept = simulation.snapshot(10), simulation.snapshot_copy()
    simulation.advance(64)
    assert isinstance(simulation.motion, Propagation)
    steps, state = simulation.motion.steps, simulation.state
    assert kept.snapshot(10) == taken
    assert simulation.motion.steps == steps > 0
    np.testing.assert_array_equal(simulation.state.q_ib, state.q_ib)


def test_snapshot_goes_on_with_the_same_bits():
    """A run resumed from a snapshot midway gives the bits of the whole run."""
    _, table = run(GYROSTAT, EVENTS)
    for begin in (10, 30, 75, 120, 140):
        simulation = Simulation(GYROSTAT, EVENTS)
        while simulation.next_tick <= begin:
            simulation.advance(begin + 1 - simulation.next_tick)
        snapshot = simulation.snapshot(begin)
        later = [event for event in EVENTS if event.tick > begin]
        resumed = Simulation.from_snapshot(GYROSTAT, snapshot, later)
        q_ib = []
        while resumed.next_tick < 200:
            q_ib.append(resumed.advance(200 - resumed.next_tick)[1].states.q_ib)
        np.testing.assert_array_equal(np.concatenate(q_ib), table['q_ib'][begin:])


@pytest.mark.parametrize('rate', [3.0, 1.0 / 3.0, 100.0, 1000.0, 0.1, 7.3, 1234.5678, 10000.0])
def test_stamps_are_exact(rate):
    """Tick k is at k / rate, rounded once to the nanosecond, at any rate and for decades."""
    ticks = Simulation(Scenario.from_dict({'publish.rate': rate, 'time.epoch_ns': 10**18})).ticks
    exact = Fraction(rate).limit_denominator(1000)
    exact = exact if float(exact) == rate else Fraction(rate)
    for first in (0, 1, 10**6 + 1, 10**8 + 7):
        stamps = ticks.stamps_ns(first, first + 5)
        truth = [10**18 + round(k * 10**9 / exact) for k in range(first, first + 5)]
        assert stamps.tolist() == truth
        assert [ticks.tick_of(stamp) for stamp in truth] == list(range(first, first + 5))


NAMED = GYROSTAT.with_values({'torque.names': ['c', 'a', 'b']})


def named(tick, name, torque_b, until_tick=None):
    return torque_command(tick, torque_b, until_tick, f'torque/{name}')


def test_torques_with_names_are_held_each_by_itself_and_summed():
    """The same as one torque that somebody adds up, at each tick where one begins or ends."""
    happening = [
        named(10, 'a', (0.1, 0.0, 0.2), until_tick=70),
        named(30, 'b', (0.3, -0.2, 0.0)),
        named(50, 'a', (0.2, 0.0, 0.0), until_tick=90),
        Reset(60),
        named(100, 'b', (0.0, 0.0, 0.0)),
    ]
    applied, table = run(NAMED, happening)
    assert [event for event in applied if isinstance(event, Timeout)] == [Timeout(90, 'torque/a')]
    added = [
        torque_command(10, (0.1, 0.0, 0.2)),
        torque_command(30, (0.1 + 0.3, -0.2, 0.2)),
        torque_command(50, (0.2 + 0.3, -0.2, 0.0)),
        Reset(60),
        torque_command(90, (0.3, -0.2, 0.0)),
        torque_command(100, (0.0, 0.0, 0.0)),
    ]
    _, truth = run(GYROSTAT, added)
    for name, column in truth.items():
        np.testing.assert_array_equal(table[name], column)


@given(st.tuples(*3 * [st.floats(-1.0, 1.0)]), st.sampled_from('abc'))
@settings(max_examples=20, deadline=None)
def test_one_of_several_torques_is_the_one_torque(torque_b, name):
    """Bit for bit, whichever is commanded alone: what is not commanded adds nothing."""
    _, alone = run(GYROSTAT, [torque_command(3, torque_b, 9)], ticks=12)
    _, table = run(NAMED, [named(3, name, torque_b, 9)], ticks=12)
    assert {k: x.tobytes() for k, x in table.items()} == {k: x.tobytes() for k, x in alone.items()}


def test_torques_are_added_in_the_order_of_their_names():
    """Not in that of their coming: 0.1 + (0.2 + 0.3) has other last digits."""
    torques = {'a': 0.2, 'b': 0.3, 'c': 0.1}
    happening = [named(1, name, (0.0, 0.0, z)) for name, z in torques.items()]
    simulation = Simulation(NAMED, happening)
    simulation.advance(1), simulation.advance(1)
    assert simulation.system.torque_b[2] == (0.1 + 0.2) + 0.3 != 0.1 + (0.2 + 0.3)


def test_torques_that_are_too_large_together_are_dropped():
    """Each is a number, their sum is none; all of them end, and the run goes on."""
    happening = [named(5, name, (1.5e308, 0.0, 0.0), until_tick=20) for name in 'ab']
    applied, _ = run(NAMED, happening, ticks=30)
    assert TorquesDropped(6) in applied
    assert not any(isinstance(event, Timeout) for event in applied)


def test_a_step_gives_torques_by_name():
    """What it names holds during it alone, what it does not name goes on."""
    scenario = NAMED.with_values({'torque.names': ['a', 'b']})
    simulation = Simulation(scenario, [named(2, 'b', (0.0, 0.3, 0.0))])
    for k in range(8):
        state = simulation.step(torque_b={'a': (0.1, 0.0, 0.0)} if 3 <= k < 6 else None)
    _, table = run(
        GYROSTAT,
        [
            torque_command(2, (0.0, 0.3, 0.0)),
            torque_command(3, (0.1, 0.3, 0.0)),
            torque_command(6, (0.0, 0.3, 0.0)),
        ],
        ticks=9,
    )
    np.testing.assert_array_equal(state.omega_bi_b, table['omega_bi_b'][8])
    for torque_b, sentence in (
        ((0.0, 0.0, 1.0), 'with torque.names torques are given by name'),
        ({'c': (0.0, 0.0, 1.0)}, 'there is no torque c; torque.names has a, b'),
        ({'a': (0.0, 0.0, np.nan)}, 'torque/a is .*; it must be a list of 3 numbers N m'),
    ):
        with pytest.raises(ValueError, match=sentence):
            simulation.step(torque_b=torque_b)
    with pytest.raises(ValueError, match=r'without torque\.names it must be a list of 3 numbers'):
        Simulation(GYROSTAT).step(torque_b={'a': (0.0, 0.0, 1.0)})

"""Limits of motors act at ticks and follow from the run: torques cut, torques dropped."""

import numpy as np
import pytest

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.run.events import Reset, RotorCommand, RotorLimited, Timeout
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

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
CUT, DROPPED = 'max_torque', 'max_speed'


def run(events, ticks=200, block=64):
    """Return the events applied, and at each tick the speeds and the motor torques (N, 2)."""
    simulation, applied, speeds, torques = Simulation(SCENARIO, events), [], [], []
    while simulation.next_tick < ticks:
        new, samples = simulation.advance(min(block, ticks - simulation.next_tick))
        applied += new
        speeds.append(samples.states.rotor_speed)
        torques.append(np.tile(samples.system.rotor_torque, (len(samples), 1)))
    return applied, np.concatenate(speeds), np.concatenate(torques)


def test_a_torque_is_cut_to_max_torque():
    """Either way; what is within the limit acts as given, and the other rotor keeps its own."""
    command, opposite = RotorCommand(10, {'a': 0.5, 'b': -0.01}), RotorCommand(20, {'a': -0.5})
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
def test_a_torque_is_dropped_at_max_speed_until_the_next_command(sign):
    """Once, at the first tick at the limit; friction then slows the wheel and nothing chatters."""
    applied, speeds, torques = run([RotorCommand(0, {'a': sign * 0.01, 'b': sign * 1e-3})])
    (limited,) = (event for event in applied if isinstance(event, RotorLimited))
    tick, speeds = limited.tick, sign * speeds[:, 0]
    assert limited == RotorLimited(tick, 'a', DROPPED)
    assert speeds[tick - 1] < 5.0 <= speeds[tick]
    assert (sign * torques[:tick, 0] == 0.01).all()
    assert (torques[tick:, 0] == 0.0).all()
    assert (sign * torques[:, 1] == 1e-3).all()
    assert (np.diff(speeds[tick:]) < 0.0).all()


def test_at_max_speed_a_command_acts_only_where_it_slows():
    """One that would raise the speed further is dropped at its tick; one that lowers it acts."""
    first = RotorCommand(0, {'a': 0.01})
    (limited,) = (event for event in run([first])[0] if isinstance(event, RotorLimited))
    drop = limited.tick
    more, less = RotorCommand(drop, {'a': 0.002}), RotorCommand(drop + 1, {'a': -0.002})
    applied, _, torques = run([first, more, less], ticks=drop + 3)
    assert applied[1:] == [more, RotorLimited(drop, 'a', DROPPED), less]
    np.testing.assert_array_equal(torques[-4:, 0], [0.01, 0.0, -0.002, -0.002])


def test_a_dropped_torque_has_no_timeout():
    """The end of a torque that a limit has dropped is no event any more."""
    applied, _, _ = run([RotorCommand(0, {'a': 0.01, 'b': 1e-3}, until_tick=150)])
    assert Timeout(150, 'rotor_command.b') in applied
    assert Timeout(150, 'rotor_command.a') not in applied


EVENTS = [
    RotorCommand(3, {'a': 0.02, 'b': 0.007}),
    RotorCommand(90, {'a': -0.02}, until_tick=170),
    Reset(120),
]


@pytest.mark.parametrize('block', [1, 7])
def test_limits_follow_from_the_run(block):
    """However it is cut into blocks; limits that are given beforehand change nothing."""
    applied, speeds, torques = run(EVENTS)
    given = [event for event in applied if not isinstance(event, Timeout)]
    again = run([*given, RotorLimited(5, 'b', DROPPED)], block=block)
    assert {event.limit for event in applied if isinstance(event, RotorLimited)} == {CUT, DROPPED}
    assert again[0] == applied
    np.testing.assert_array_equal(again[1], speeds)
    np.testing.assert_array_equal(again[2], torques)


def test_a_bag_with_limits_verifies(tmp_path):
    """Run again from its bag alone, the run comes to the same limits and the same bytes."""
    for _ in simulate(SCENARIO, 4.0, tmp_path / 'bag', EVENTS):
        pass
    verdict = verify(tmp_path / 'bag')
    assert verdict.is_true
    assert verdict.same_bytes

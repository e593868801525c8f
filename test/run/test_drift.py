"""The drift along a run against that of each motion alone."""

import numpy as np
import pytest
from commands import motor_command, torque_command

from satdyn_ros.dynamics.integrals import relative_drift
from satdyn_ros.dynamics.motion import joined
from satdyn_ros.run.drift import Drift
from satdyn_ros.run.events import Event, Request, Reset
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

GYROSTAT = Scenario.from_dict(
    {
        'rotor': {'mode': 'motor', 'inertia': 0.5, 'speed': 20.0},
        'publish': {'rate': 50.0},
        'torque': {'timeout': 0.0},
    }
)
NAMES = ('energy_balance', 'jacobi', 'rotor_momentum')


def flown(scenario, events, ticks, block=300):
    """Return motions and their samples, as a run gives them."""
    simulation, parts = Simulation(scenario, events), []
    while simulation.next_tick < ticks:
        _, samples = simulation.advance(min(block, ticks - simulation.next_tick))
        parts.append((simulation.motion, samples))
    return parts


def measured(parts):
    """Return what is measured of them."""
    drift = Drift()
    found = [one for motion, samples in parts for one in drift.take(motion, samples)]
    return found + drift.close()


def column(found, name):
    """Return the drift of an integral in all rows, nan where it is not one."""
    return np.concatenate([one.drift.get(name, np.full(len(one.states), np.nan)) for one in found])


def test_each_motion_drifts_since_it_began():
    """Under torques, restarts and commands, over blocks of any length, and in order."""
    random = np.random.default_rng(1)
    events: list[Event] = []
    for tick in np.cumsum(random.integers(1, 60, 300)).tolist():
        choices: list[Event] = [
            torque_command(tick, tuple(random.normal(size=3))),
            torque_command(tick, (0.0, 0.0, 0.0)),
            Reset(tick),
            Request(tick, {'initial.angular_velocity': [0.0, 0.01, 0.2]}),
            motor_command(tick, {'rotor': float(random.normal())}),
            motor_command(tick, {'rotor': 0.0}),
        ]
        events.append(choices[random.integers(6)])
    parts = flown(GYROSTAT, events, 12000)
    found = measured(parts)
    assert [part for one in found for part in one.parts] == [samples for _, samples in parts]
    alone: dict[int, list] = {}
    for motion, samples in parts:
        alone.setdefault(id(motion), []).append(samples)
    begin = 0
    names: set[str] = set()
    for some in alone.values():
        states = joined([samples.states for samples in some])
        rows = slice(begin, begin + len(states))
        begin = rows.stop
        # One row cannot drift.
        if len(states) > 1:
            expected = relative_drift(some[0].system, states)
            names |= expected.keys()
            for name in NAMES:
                np.testing.assert_array_equal(
                    column(found, name)[rows], expected.get(name, np.full(len(states), np.nan))
                )
    assert names == set(NAMES)


@pytest.mark.parametrize(
    ('event', 'name'),
    [
        (lambda tick: torque_command(tick, (0.01 * (1 + tick % 6), 0.0, 0.0)), 'energy_balance'),
        (lambda tick: Request(tick, {'initial.angular_velocity': [0.0, 0.0, 1e-3]}), 'jacobi'),
    ],
    ids=['torques', 'requests'],
)
def test_many_motions_are_measured_at_once(event, name):
    """A motion of a few ticks costs no measurement of its own."""
    parts = flown(GYROSTAT, [event(tick) for tick in range(5, 8000, 20)], 8000)
    assert len(parts) > 390
    found = measured(parts)
    assert len(found) <= 3
    assert name in found[1].drift


def test_motions_of_one_system_may_conserve_different_things():
    """A body is symmetric about x while its rotor along y is at rest, and not while it turns."""
    scenario = Scenario.from_dict(
        {
            'body': {'inertia': [2.0, 1.5, 1.0]},
            'orbit': {'type': 'fixed'},
            'rotor': {'mode': 'motor', 'inertia': 0.5, 'axis': [0.0, 1.0, 0.0]},
            'initial': {'frame': 'inertial', 'angular_velocity': [0.3, 0.0, 0.2]},
        }
    )
    commands = [motor_command(50, {'rotor': 1.0}), motor_command(60, {'rotor': 0.0})]
    found = measured(flown(scenario, [*commands, Reset(100)], 200))
    # The last two motions, apart from each other in what they conserve, are measured at once.
    assert [len(one.states) for one in found] == [50, 10, 140]
    rate = column(found, 'axial_rate')
    at_rest = np.r_[:50, 100:200]
    assert np.abs(rate[at_rest]).max() < 1e-12
    assert np.isnan(rate[50:100]).all()

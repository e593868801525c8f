"""A simulation that records itself: its bag holds the run without the program that drove it."""

import pytest

from satdyn_ros import Scenario, Simulation
from satdyn_ros.actuators import Command
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.run.events import Request, RotorLimited

SCENARIO = Scenario(
    {
        'publish.rate': 50.0,
        'time.epoch_ns': 10**18,
        'rotor.mode': 'motor',
        'rotor.inertia': 1e-3,
        'rotor.max_torque': 0.01,
        'sensors.names': ['gyro'],
        'sensors.seed': 3,
        'record.max_duration_s': 0.7,
    }
)


def test_what_a_program_commands_is_in_the_bag(tmp_path):
    """Each command at its tick, requests and cuts; of several files each verifies alone."""
    with Simulation(SCENARIO, record=tmp_path / 'bag') as simulation:
        for k in range(40):
            simulation.step(rotor_torque={'rotor': 3e-3 * (k % 5)}, torque_b=(0.0, 0.0, k % 3))
        simulation.request({'initial.angular_velocity': [0.0, 0.0, 0.1]})
        for _ in range(20):
            last = simulation.step()
    events = RecordedRun(tmp_path / 'bag').events
    torques = [e for e in events if isinstance(e, Command) and e.topic == 'torque']
    # Those that change what acts, at the tick where the step begins; then back to none.
    assert [(e.tick, e.value[2]) for e in torques[:4]] == [(1, 1), (2, 2), (3, 0), (4, 1)]
    cut = [event.tick for event in events if isinstance(event, RotorLimited)]
    assert cut == [*range(4, 40, 5)]
    assert [event.tick for event in events if isinstance(event, Request)] == [41]
    for path in (tmp_path / 'bag', *sorted((tmp_path / 'bag').glob('*.mcap'))):
        verdict = verify(path)
        assert verdict.same_bytes, str(verdict)
    assert RecordedRun(tmp_path / 'bag').last_tick() == last.tick == 60


def test_a_bag_ends_where_it_is_closed(tmp_path):
    """The run goes on without it; of blocks as of steps each tick is there once."""
    simulation = Simulation(SCENARIO, record=tmp_path / 'bag')
    simulation.command(rotor_torque={'rotor': 1e-3})
    simulation.advance(30)
    simulation.rewind(20)
    simulation.step(torque_b=(0.0, 0.0, 0.1))
    simulation.close()
    simulation.step()
    assert simulation.tick == 21
    verdict = verify(tmp_path / 'bag')
    assert verdict.same_bytes, str(verdict)
    assert RecordedRun(tmp_path / 'bag').last_tick() == 20


def test_a_bag_that_is_there_is_not_overwritten(tmp_path):
    """It is refused before anything moves."""
    Simulation(SCENARIO, record=tmp_path / 'bag').close()
    with pytest.raises(OSError, match='bag'):
        Simulation(SCENARIO, record=tmp_path / 'bag')

"""A motion ends where what it needs ends, and is refused only for what comes before its end."""

import numpy as np
import pytest
from run.test_one_mind import EPHEMERIS

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.run.events import Halt, Reset
from satdyn_ros.run.requests import try_out
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import RunHalted, Simulation

# The IGRF is from 1900 to 2030, and goes on for five years.
TO_2035 = Scenario(
    {
        'orbit.altitude': 4e5,
        'orbit.inclination': 1.7,
        'environment.magnetic_field': 'igrf',
        'time.epoch': '2034-12-31T23:59:50',
        'publish.rate': 1.0,
        'publish.topics': ['attitude'],
    }
)
MAGNETISED = TO_2035.with_values({'body.dipole': (0.006, -0.004, 0.007)})
MAGNETOMETER = TO_2035.with_values(
    {'sensors.names': ['field'], 'sensors.field.type': 'magnetometer'}
)
EACH = pytest.mark.parametrize('scenario', [TO_2035, MAGNETISED, MAGNETOMETER])


@EACH
@pytest.mark.parametrize('block', [1, 3, 100])
def test_a_run_goes_up_to_the_last_instant_of_the_igrf(scenario, block):
    """Whether the field turns the body, a sensor measures it, or neither does."""
    try_out(scenario, 0)
    simulation, ticks = Simulation(scenario), 0
    while not simulation.halted:
        happened, samples = simulation.advance(block)
        ticks += len(samples)
    # Tick 10 is at 2035-01-01T00:00:00.
    assert (ticks, happened) == (11, [Halt(11)])
    assert '2035-01-01 is outside the IGRF' in simulation.halted
    simulation.reset()
    assert [type(event) for event in simulation.advance(block)[0]][:1] == [Reset]
    assert simulation.halted


@pytest.mark.parametrize('rate', [0.3, 3.0, 7.0, 0.7, 1.0 / 3.0])
def test_the_tick_at_the_very_end_comes_whatever_the_rounding(rate):
    """The time of the tick there may be rounded to after that of the end."""
    scenario = MAGNETISED.with_values({'publish.rate': rate, 'time.epoch': ''})
    ticks = Simulation(scenario.with_values({'time.epoch_ns': 10**18})).ticks
    # So that tick 7 is the last.
    epoch_ns = MAGNETISED.epoch_ns + 10 * 10**9 - (ticks.stamp_ns(7) - 10**18)
    simulation = Simulation(scenario.with_values({'time.epoch_ns': epoch_ns}))
    assert len(simulation.advance(100)[1]) == 8


def test_a_longer_run_has_the_ticks_before_the_end(tmp_path):
    """It exits with the model's sentence, and what it left is true; one up to the end is whole."""
    list(simulate(MAGNETISED, 11, tmp_path / 'whole'))
    with pytest.raises(RunHalted, match=r'2035-01-01 is outside the IGRF.*has 11 ticks'):
        list(simulate(MAGNETISED, 20, tmp_path / 'longer'))
    for bag in tmp_path.iterdir():
        assert verify(bag).is_true


def test_a_closed_form_ends_with_the_ephemeris_of_its_orbit():
    """A body of equal moments turns freely, and yet has no position after the last row."""
    scenario = Scenario(
        {
            'orbit.type': 'oem',
            'orbit.file': EPHEMERIS,
            'time.epoch': '2026-03-01T12:02:50',
            'body.inertia': (3.0, 3.0, 3.0),
            'motion.method': 'auto',
            'publish.rate': 1.0,
        }
    )
    simulation = Simulation(scenario)
    assert simulation.motion.name != 'propagation'
    assert len(simulation.advance(100)[1]) == 11
    assert simulation.advance(100)[0] == [Halt(11)]
    assert 'no position at 2026-03-01T12:03:01' in str(simulation.halted)
    simulation.reset()
    simulation.advance(100)
    assert 'no position' in str(simulation.halted)


def test_a_start_is_tried_no_further_than_its_run():
    """A wheel whose narrow friction halts the motion after 10 s may fly for 10 s."""
    scenario = Scenario(
        {
            'body.inertia': (3.0, 2.0, 4.0),
            'publish.rate': 1.0,
            'rotor.mode': 'motor',
            'rotor.inertia': 0.01,
            'rotor.speed': 1.0,
            'rotor.coulomb_friction': 0.001,
            'rotor.friction_speed': 1e-9,
            'time.epoch': '2008-09-20T12:30:00',
        }
    )
    try_out(scenario, 0, last_tick=10)
    with pytest.raises(ValueError, match='no motion can start from these values'):
        try_out(scenario, 0, last_tick=11)
    simulation = Simulation(scenario)
    assert len(simulation.advance(5)[1]) == 5
    assert np.all(np.isfinite(simulation.state.q_ib))

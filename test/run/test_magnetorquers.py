"""Magnetorquers: a commanded dipole in the field of the Earth."""

import numpy as np
import pytest
from commands import dipole_command
from environment import truth
from numpy.testing import assert_allclose, assert_array_equal

from satdyn_ros.run.events import Event, Request, Timeout
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.run.topics import TOPICS

(CASE,) = (case for case in truth.cases('gravity_gradient') if case['name'] == 'igrf_sso')
RESIDUAL = Scenario.from_dict(
    CASE['scenario'] | {'publish': {'rate': 1.0}, 'torque': {'timeout': 0.0}}
)
SCENARIO = RESIDUAL.with_values({'magnetorquer.max_dipole': [0.2, 0.0, 0.1]})
# No torque acts on it but the gradient's.
WITHOUT_FIELD = Scenario({'magnetorquer.max_dipole': [0.2, 0.2, 0.2]})


def shown(name, samples):
    """Return what a topic shows of samples."""
    return TOPICS[name].shows[0].of(samples)


def test_a_commanded_dipole_turns_the_body_as_a_residual_one():
    """Held from tick 0 on it gives the states of the residual dipole, bit for bit."""
    dipole = RESIDUAL['body.dipole']
    commanded = RESIDUAL.with_values(
        {'body.dipole': [0.0, 0.0, 0.0], 'magnetorquer.max_dipole': [10.0, 10.0, 10.0]}
    )
    _, expected = Simulation(RESIDUAL).advance(50)
    _, found = Simulation(commanded, [dipole_command(0, dipole)]).advance(50)
    assert np.ptp(found.states.omega_bi_b, axis=0).min() > 0.0
    assert_array_equal(found.states.omega_bi_b, expected.states.omega_bi_b)
    assert_array_equal(found.states.q_ib, expected.states.q_ib)


def test_a_command_is_cut_along_each_axis_and_ends():
    """
    The torque is (residual + commanded) x B: a sign of its own each axis, none without a torquer.

    A request in between changes nothing of the command; it ends at its tick.
    """
    events: list[Event] = [
        dipole_command(3, (-0.5, 0.7, 0.04), until_tick=8),
        Request(5, {'initial.angular_velocity': [0.0, 0.0, 0.01]}),
    ]
    simulation, happened = Simulation(SCENARIO, events), list[Event]()
    while simulation.next_tick < 12:
        some, samples = simulation.advance(12 - simulation.next_tick)
        happened += some
        acts = 3 <= samples.first_tick < 8
        dipole = np.array(SCENARIO['body.dipole']) + acts * np.array([-0.2, 0.0, 0.04])
        expected = np.cross(dipole, shown('magnetic_field', samples))
        # Of the rounding of three products.
        assert_allclose(shown('magnetic_torque', samples), expected, rtol=0.0, atol=1e-20)
    assert happened == [*events, Timeout(8, 'magnetorquer_command')]


def test_a_dipole_of_a_step_holds_for_that_step():
    """As a torque of a step does; what is in force is back afterwards."""
    simulation = Simulation(SCENARIO)
    simulation.step(dipole_b=(0.1, 0.0, -0.5))
    assert simulation.acting['magnetorquer_command'] == (0.1, 0.0, -0.1)
    simulation.step()
    assert simulation.acting['magnetorquer_command'] == (0.0, 0.0, 0.0)
    with pytest.raises(ValueError, match=r'magnetorquer is .*; it must be a list of 3 num'):
        simulation.step(dipole_b=(0.1, np.nan, 0.0))


def test_without_a_field_magnetorquers_do_nothing_and_say_so():
    """A warning names the key; commands are taken, held and end."""
    sentence = (
        'magnetorquer.max_dipole is given, but without environment.magnetic_field it has no effect'
    )
    assert sentence in WITHOUT_FIELD.warnings
    simulation = Simulation(WITHOUT_FIELD, [dipole_command(0, (0.1, 0.1, 0.1), until_tick=9)])
    simulation.advance(9)
    assert simulation.advance(1)[0] == [Timeout(9, 'magnetorquer_command')]
    expected = Scenario().motion().at(0.09)
    # The motions begin at 0 s and at 0.09 s, in steps of their own.
    assert_allclose(simulation.state.omega_bi_b, expected.omega_bi_b[0], rtol=1e-12)

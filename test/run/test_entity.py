"""The satellite as an entity: its state in one frame, and a state that is asked for."""

import numpy as np
import pytest
from flights import GYROSTAT
from scipy.spatial.transform import Rotation

from satdyn_ros.run.entity import (
    EntityState,
    accelerations,
    matching,
    restarted,
    touches,
    why_not_reset,
)
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation


def test_a_state_is_in_inertial_axes():
    """The rate is that in body axes turned by SciPy's rotation; the others are the orbit's."""
    states = GYROSTAT.motion().at([0.0, 100.0, 250.0])
    for row in (1, -1):
        entity = EntityState.of(states, row)
        turned = Rotation.from_quat(states.q_ib[row]).apply(states.omega_bi_b[row])
        # Some roundings of a rate of hundredths.
        np.testing.assert_allclose(entity.rate, turned, rtol=0.0, atol=1e-16)
        assert np.linalg.norm(entity.rate - states.omega_bi_b[row]) > 1e-3
        np.testing.assert_array_equal(entity.q_ib, states.q_ib[row])
        np.testing.assert_array_equal(entity.position, states.r_i[row])
        np.testing.assert_array_equal(entity.velocity, states.v_i[row])


def test_a_state_that_is_asked_for_is_where_the_motion_restarts():
    """What is read at an instant and set again gives the same attitude and rate, on any orbit."""
    states = GYROSTAT.motion().at([0.0, 250.0])
    entity = EntityState.of(states, 1)
    state = GYROSTAT.with_values(entity.request()).state_at(77.0)
    np.testing.assert_allclose(state.q_ib, states.q_ib[1], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(state.omega_bi_b, states.omega_bi_b[1], rtol=0.0, atol=1e-16)


@pytest.mark.parametrize(
    ('scope', 'why'),
    [
        (2, ''),
        *((n, 'the time never') for n in (0, 1, 3, 255)),
        (4, 'the scope 4'),
        (6, 'the scope 6'),
    ],
)
def test_the_state_can_be_reset_and_the_time_cannot(scope, why):
    """Bits 1 time, 2 state, 4 what was spawned; 0 and 255 all of it."""
    assert why_not_reset(scope).startswith(why)
    assert bool(why_not_reset(scope)) == bool(why)


ECCENTRIC = {'orbit.type': 'kepler', 'orbit.eccentricity': 0.3, 'orbit.true_anomaly': 1.0}
SPUN = {'initial.angular_velocity': [0.02, -0.05, 0.03], 'initial.frame': 'inertial'}


@pytest.mark.parametrize('orbit', [{}, ECCENTRIC], ids=['circular', 'kepler'])
@pytest.mark.parametrize('row', [0, 1, 2])
def test_the_acceleration_is_that_of_the_motion(orbit, row):
    """Newton's law gives the linear one, differences of the turned rate the angular one."""
    scenario = Scenario(orbit | SPUN)
    times_s = np.array([0.0, 2.0, 1500.0])
    linear, angular = accelerations(scenario.system, scenario.motion().at(times_s), row)
    states = scenario.motion().at(times_s[row] + 0.01 * np.arange(5))
    r = states.r_i[0]
    gravity = -scenario['orbit.mu'] * r / np.linalg.norm(r) ** 3
    # Roundings of 7.6 km/s in differences over a second.
    np.testing.assert_allclose(linear, gravity, rtol=0.0, atol=1e-9)
    rates = np.array([EntityState.of(states, i).rate for i in range(5)])
    # Roundings of 0.06 rad/s in differences over 10 ms, and h^4 / 5 of the fifth derivative.
    by_differences = np.array([-25, 48, -36, 16, -3]) / 0.12 @ rates
    np.testing.assert_allclose(angular, by_differences, rtol=0.0, atol=1e-12)
    assert np.linalg.norm(angular) > 1e-6


def test_without_an_orbit_only_the_rate_accelerates():
    """A torque of 3 N m about an axis of 600 kg m^2, from rest."""
    scenario = Scenario({'orbit.type': 'fixed', 'initial.attitude': [0.0, 0.0, 0.0, 1.0]})
    system = scenario.system.driven(torque_b=np.array([0.0, 0.0, 3.0]))
    linear, angular = accelerations(system, scenario.motion().at(5.0), 0)
    assert linear.tolist() == [0.0, 0.0, 0.0]
    np.testing.assert_allclose(angular, [0.0, 0.0, 0.005], rtol=1e-15, atol=1e-15)


def test_a_restart_is_seen_before_its_tick():
    """At the instant of the last tick, with the stamp and the torques of that."""
    simulation = Simulation(GYROSTAT.with_values({'time.epoch_ns': 10**18}))
    _, samples = simulation.advance(4)
    conditions = simulation.scenario.with_values(SPUN)
    now = restarted(conditions, samples, 2)
    assert now.stamps_ns.tolist() == samples.stamps_ns[2:3].tolist()
    assert now.first_tick == 2
    np.testing.assert_array_equal(now.states.omega_bi_b[0], SPUN['initial.angular_velocity'])
    np.testing.assert_array_equal(now.states.r_i[0], samples.states.r_i[2])
    np.testing.assert_array_equal(now.system.torque_b, samples.system.torque_b)


def test_a_sphere_holds_a_point():
    """Its edge belongs to it; one that is none is refused."""
    centre, position = np.array([0.0, 3.0, 0.0]), np.array([4.0, 0.0, 0.0])
    assert touches(position, centre, 5.0)
    assert not touches(position, centre, 4.999)
    for wrong in (-1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match=r'^the sphere has the radius .* at least 0$'):
            touches(position, centre, wrong)
    with pytest.raises(ValueError, match=r'the centre \[nan'):
        touches(position, centre * np.nan, 1.0)


def test_a_filter_is_a_regular_expression():
    """An empty one finds all; one that is none is refused in a sentence."""
    assert matching('satdyn', '') == matching('satdyn', '^sat.*n$') == ['satdyn']
    assert matching('satdyn', 'other') == []
    with pytest.raises(ValueError, match=r"filter '\(' is not a regular expression"):
        matching('satdyn', '(')

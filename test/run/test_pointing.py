"""The initial attitude by 3-2-1 angles and by what points where."""

import math

import numpy as np
import pytest

from satdyn_ros.kernel import rotation
from satdyn_ros.run.events import Request
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

EPOCH = {'time.epoch': '2026-03-20T14:46:00Z', 'environment.sun': 'ephemeris'}
INCLINED = {'orbit.inclination': '51.6 deg', 'orbit.raan': '40 deg', 'publish.rate': '1 Hz'}


def test_angles_are_yaw_then_pitch_then_roll():
    """A yaw of 90 deg puts body x on y of the frame; the pitch then tips x down about new y."""
    given = {'initial.roll_pitch_yaw': ['0 deg', '30 deg', '90 deg'], 'initial.frame': 'inertial'}
    scenario = Scenario.from_dict(given)
    x_i = rotation.rotate(scenario['initial.attitude'], [1.0, 0.0, 0.0])
    assert x_i == pytest.approx([0.0, math.cos(math.pi / 6), -0.5], abs=1e-15)
    assert scenario['initial.roll_pitch_yaw'] == ()
    assert scenario == Scenario.from_yaml_text(scenario.to_yaml())


@pytest.mark.parametrize('frame', ['lvlh', 'inertial'])
def test_nadir_points_to_the_centre_and_the_second_axis_along_the_velocity(frame):
    """On an ellipse the velocity is not level: the axis has its level part's direction."""
    given = {**INCLINED, 'orbit.type': 'kepler', 'orbit.eccentricity': 0.2}
    given |= {'orbit.true_anomaly': '70 deg', 'initial.frame': frame}
    given |= {'initial.pointing': 'nadir', 'initial.pointing_axis': [0.0, 1.0, 0.0]}
    scenario = Scenario.from_dict(given | {'initial.second_axis': [0.0, 1.0, 1.0]})
    r_i, v_i = scenario.system.orbit.position_velocity(0.0)
    q_ib = scenario.initial_state.q_ib
    down_i = -r_i / np.linalg.norm(r_i)
    ahead_i = v_i - down_i * np.dot(v_i, down_i)
    # Rounding of products of unit vectors.
    assert rotation.rotate(q_ib, [0, 1, 0]) == pytest.approx(down_i, abs=1e-14)
    ahead = ahead_i / np.linalg.norm(ahead_i)
    assert rotation.rotate(q_ib, [0, 0, 1]) == pytest.approx(ahead, abs=1e-14)


def test_the_sun_is_where_the_equinox_says():
    """At the equinox of 2026, 20 March 14:46 UTC, it is along +X; the other axis: normal."""
    given = {**EPOCH, **INCLINED, 'initial.pointing': 'sun', 'initial.pointing_axis': [0, 1, 0]}
    scenario = Scenario.from_dict(given)
    q_ib = scenario.initial_state.q_ib
    to_sun_i = rotation.rotate(q_ib, [0.0, 1.0, 0.0])
    # Equinoxes are those of date: precession since J2000 is 50.3" a year, and the minute is
    # rounded.
    assert to_sun_i == pytest.approx([1.0, 0.0, 0.0], abs=math.radians(26 * 50.3 / 3600.0) * 1.05)
    normal_i = np.cross(*scenario.system.orbit.position_velocity(0.0))
    across = normal_i - to_sun_i * np.dot(normal_i, to_sun_i)
    near = across / np.linalg.norm(across)
    assert rotation.rotate(q_ib, [1.0, 0.0, 0.0]) == pytest.approx(near, abs=1e-12)


def test_a_request_points_at_the_tick_where_it_acts():
    """LVLH has turned since tick 0; what is recorded is the attitude."""
    given = {**EPOCH, **INCLINED, 'publish.rate': '0.01 Hz'}
    simulation = Simulation(Scenario.from_dict(given))
    for _ in range(20):
        simulation.step()
    simulation.request({'initial.pointing': 'sun', 'initial.frame': 'lvlh'})
    happened, samples = simulation.advance(1)
    assert samples.states.sun_direction_b[0] == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
    assert isinstance(happened[0], Request)
    assert set(happened[0].values) == {'initial.attitude', 'initial.frame'}


def test_without_an_instant_the_sun_is_looked_for_when_there_is_one():
    """A node has its epoch after its parameters."""
    scenario = Scenario.from_dict({'initial.pointing': 'sun', 'environment.sun': 'ephemeris'})
    assert scenario['initial.pointing'] == 'sun'
    assert scenario == Scenario.from_yaml_text(scenario.to_yaml())
    later = scenario.with_values({'publish.rate': 5.0}).with_epoch(1_774_017_960 * 10**9)
    direct = Scenario.from_dict(
        {'time.epoch_ns': 1_774_017_960 * 10**9, 'initial.pointing': 'sun', 'publish.rate': 5.0}
        | {'environment.sun': 'ephemeris'}
    )
    assert later == direct
    assert not later['initial.pointing']


def test_a_direction_along_the_normal_leaves_a_turn_that_is_chosen():
    """Every turn about it is as near; the one chosen takes the axis to the direction."""
    given = {'initial.pointing': 'inertial', 'initial.direction': [0.0, 0.0, 2.0]}
    scenario = Scenario.from_dict({**given, 'initial.pointing_axis': [0.0, 3.0, 0.0]})
    q_ib = scenario.initial_state.q_ib
    assert rotation.rotate(q_ib, [0.0, 1.0, 0.0]) == pytest.approx([0.0, 0.0, 1.0], abs=1e-15)
    fixed = Scenario.from_dict({**given, 'orbit.type': 'fixed'})
    assert rotation.rotate(fixed['initial.attitude'], [0, 0, 1]) == pytest.approx([0, 0, 1])


@pytest.mark.parametrize(
    ('given', 'says'),
    [
        ({'pointing': 'up'}, 'empty or one of nadir, sun, inertial'),
        ({'pointing': 'nadir', 'attitude': [0, 0, 0, 1]}, 'only one of the two'),
        ({'pointing': 'nadir', 'roll_pitch_yaw': [0, 0, 0]}, 'only one of the two'),
        ({'roll_pitch_yaw': [0, 0, 0], 'attitude': [0, 0, 0, 1]}, 'only one of the two'),
        ({'pointing': 'sun'}, 'environment.sun'),
        ({'pointing': 'inertial'}, 'direction'),
        ({'pointing': 'nadir', 'direction': [1, 0, 0]}, 'must not be given'),
        ({'second_axis': [0, 1, 0]}, 'initial.pointing is not given'),
        ({'pointing': 'nadir', 'pointing_axis': [1, 0, 0]}, 'not the same'),
        ({'pointing': 'nadir', 'second_axis': [0, 0, 0]}, 'a direction'),
        ({'roll_pitch_yaw': ['5 deg', '1 Hz', '0']}, 'another dimension'),
        ({'roll_pitch_yaw': [1, 2]}, 'empty or a list of 3'),
    ],
)
def test_what_does_not_suit_is_refused(given, says):
    """In one sentence that names the key."""
    with pytest.raises(ValueError, match=rf'initial\..*{says}'):
        Scenario.from_dict({'initial': given})


def test_nadir_needs_an_orbit():
    """A fixed direction has no velocity."""
    with pytest.raises(ValueError, match='with orbit'):
        Scenario.from_dict({'initial.pointing': 'nadir', 'orbit.type': 'fixed'})

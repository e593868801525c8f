"""Steps by numbers alone: what a command changes, bit by bit as a motion that begins anew."""

import copy
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.run.stepper import Stepper

AXES = {'x': [1.0, 0.0, 0.0], 'y': [0.0, 0.6, 0.8], 'z': [0.0, 0.0, 1.0]}
WHEELS = {
    f'rotor.{name}.{key}': value
    for name, axis in AXES.items()
    for key, value in {
        'mode': 'motor', 'axis': axis, 'inertia': 1e-4, 'speed': 10.0, 'max_torque': 5e-3,
    }.items()
}  # fmt: skip
TRACKED = {'sensors.names': ['star_tracker'], 'sensors.star_tracker.divisor': 3, 'sensors.seed': 3}
SCENARIO = Scenario(WHEELS | TRACKED | {'publish.rate': 50.0, 'rotor.names': [*AXES]})
ORBITS: dict[str, dict[str, Any]] = {
    'circular': {},
    'kepler': {'orbit.type': 'kepler', 'orbit.eccentricity': 0.1},
    'fixed': {'orbit.type': 'fixed', 'initial.frame': 'inertial'},
    'limited': {
        f'rotor.{name}.{key}': value
        for name in AXES
        for key, value in {'max_speed': 10.5, 'speed_gain': 2.0, 'coulomb_friction': 1e-6}.items()
    },
    # Of valves that open and close in and between steps.
    'firing': {
        'publish.rate': 10.0,
        'thruster.names': ['a', 'b'],
        'thruster.a.position': [0.0, 0.3, 0.0],
        'thruster.a.thrust': 2.0,
        'thruster.a.min_on_time': 0.01,
        'thruster.b.position': [0.4, 0.0, 0.1],
        'thruster.b.direction': [0.0, 1.0, 1.0],
        'thruster.b.thrust': 1.0,
        'thruster.b.delay': 0.13,
        'thruster.b.time_constant': 0.05,
    },
    'flexible': {
        'flexible.names': ['panel'],
        'flexible.panel.frequency': 3.0,
        'flexible.panel.damping': 0.01,
        'flexible.panel.coupling': [3.0, 9.0, -2.0],
        'flexible.panel.displacement': 0.1,
    },
    # Of which tables are known for some minutes each, as long as a few ticks.
    'tabled': {
        'orbit.type': 'tle',
        'orbit.tle': [
            '1 25544U 98067A   26060.50000000  .00012345  00000-0  22222-3 0  9997',
            '2 25544  51.6400 123.4567 0004321  45.6789 314.4321 15.50000000123459',
        ],
        'time.epoch': '2026-03-01T12:00:00Z',
        'environment.magnetic_field': 'igrf',
        'body.dipole': [0.1, 0.0, 0.05],
        'magnetorquer.max_dipole': [0.2, 0.2, 0.2],
        'publish.rate': 0.02,
    },
}
torques = st.floats(-1e-2, 1e-2)
commands = st.fixed_dictionaries(
    {},
    optional={
        'rotor_torque': st.dictionaries(st.sampled_from([*AXES]), torques, min_size=1),
        'torque_b': st.tuples(torques, torques, torques),
    },
)
speeds = st.fixed_dictionaries(
    {'rotor_speed': st.dictionaries(st.sampled_from([*AXES]), st.floats(-12.0, 12.0), min_size=1)}
)
on_times = st.sampled_from([0.0, 0.005, 0.03, 0.1, 0.25, 1.0])
pulses = st.fixed_dictionaries(
    {'thrusters': st.dictionaries(st.sampled_from('ab'), on_times, min_size=1)}
)
dipoles = st.fixed_dictionaries({'dipole_b': st.tuples(*3 * [st.floats(-0.3, 0.3)])})


class TickByTick(Simulation):
    """A simulation in which a motion is made for each command, in the lane of the last one."""

    def advance(self, count):
        self.last = super().advance(count)
        return self.last

    def _new_stepper(self):
        return None


class AnewEachTime(TickByTick):
    """A simulation in which each motion begins in a lane of its own."""

    def advance(self, count):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Propagation, '_taken_lane', lambda self: None)
            return super().advance(count)


@pytest.mark.parametrize('orbit', ORBITS)
@settings(max_examples=15, deadline=None)
@given(st.data())
def test_steps_have_the_bits_of_motions_that_begin_anew(orbit, data):
    """States, measurements and snapshots, and what goes on from a copy and from a snapshot."""
    scenario = SCENARIO.with_values(ORBITS[orbit])
    more = {'tabled': dipoles, 'limited': speeds, 'firing': pulses}.get(orbit, commands)
    some = more | commands
    given_ = data.draw(st.lists(some, min_size=3, max_size=25))
    mine, other, in_one_lane = Simulation(scenario), AnewEachTime(scenario), TickByTick(scenario)
    asked = data.draw(st.integers(0, len(given_) - 1))
    for i, each in enumerate(given_):
        a, b, c = (simulation.step(**each) for simulation in (mine, other, in_one_lane))
        assert_same(a, b)
        assert_same(c, b)
        assert_same_rows(in_one_lane.last, other.last)
        if i == asked:
            assert mine.snapshot(mine.tick) == other.snapshot(other.tick)
            mine = copy.deepcopy(mine)
            again = Simulation.from_snapshot(scenario, other.snapshot(other.tick))
            again.advance(1)
            assert_same(again.sample, b)
    for _ in range(3):
        assert_same(mine.step(), other.step())


def assert_same_rows(a, b):
    (happened_a, samples_a), (happened_b, samples_b) = a, b
    assert happened_a == happened_b
    for name in ('q_ib', 'rotor_speed', 'work', 'rotor_torque', 'met_limit'):
        np.testing.assert_array_equal(
            getattr(samples_a.states, name), getattr(samples_b.states, name)
        )


def assert_same(a, b):
    for name in ('q_ib', 'omega_bi_b', 'rotor_speed', 'rotor_angle'):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    assert a.inner == b.inner
    assert (a.tick, a.stamp_ns, a.measured.keys()) == (b.tick, b.stamp_ns, b.measured.keys())
    for name, measured in a.measured.items():
        np.testing.assert_array_equal(measured, b.measured[name])
        assert measured.stamp_ns == b.measured[name].stamp_ns


def test_wheels_in_torque_go_by_numbers_alone():
    """No motion is made for a command: the one at which the steps began is the last."""
    simulation = Simulation(SCENARIO)
    for k in range(20):
        simulation.step(rotor_torque={'x': 1e-4 * (k % 7 + 1)})
    assert isinstance(simulation._stepper, Stepper)
    begun = simulation._stepper
    simulation.step(rotor_torque={'y': 1e-4})
    assert simulation._stepper is begun


def test_an_event_ends_the_steps_at_its_tick():
    """A request between steps acts at the next tick, with what is commanded at that step."""
    simulation, other = Simulation(SCENARIO), AnewEachTime(SCENARIO)
    for each in (simulation, other):
        for _ in range(5):
            each.step(torque_b=(1e-3, 0.0, 0.0))
        each.request({'initial.angular_velocity': [0.0, 0.0, 0.1]})
        each.step(torque_b=(0.0, 1e-3, 0.0))
        each.step()
    assert simulation.tick == other.tick == 7
    assert_same(simulation.sample, other.sample)


def test_a_sample_has_what_the_scenario_has():
    """By attribute, in body axes; what there is not is said."""
    scenario = Scenario(
        {
            'publish.rate': 1.0,
            'orbit.inclination': 1.7,
            'environment.magnetic_field': 'dipole',
            'environment.sun': 'ephemeris',
            'body.dipole': [0.1, 0.0, 0.0],
            'time.epoch': '2026-03-01T00:00:00Z',
            'sensors.names': ['magnetometer'],
            'sensors.magnetometer.divisor': 2,
        }
    )
    simulation = Simulation(scenario)
    odd, even = simulation.step(), simulation.step()
    assert (odd.tick, odd.t_s, even.stamp_ns - odd.stamp_ns) == (1, 1.0, 10**9)
    assert (odd.measured, [*even.measured]) == ({}, ['magnetometer'])
    np.testing.assert_allclose(even.measured['magnetometer'], even.magnetic_field_b, atol=1e-4)
    torque_b = np.cross([0.1, 0.0, 0.0], even.magnetic_field_b)
    np.testing.assert_allclose(even.torques_b['magnetic_torque'], torque_b, rtol=1e-12)
    assert {*even.torques_b} == {'gravity_gradient', 'magnetic_torque'}
    assert np.linalg.norm(even.sun_b) == pytest.approx(1.0, abs=1e-15)
    assert even.sunlight >= 0.0
    # Along the orbit by v dt, of one second.
    np.testing.assert_allclose(even.r_i - odd.r_i, even.v_i, rtol=0, atol=10.0)
    with pytest.raises(AttributeError, match=r'environment\.magnetic_field'):
        _ = Simulation(SCENARIO).step().magnetic_field_b

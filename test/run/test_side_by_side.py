"""Runs in step: each has the bits that it has alone, whatever the others do."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from run.test_stepper import AXES, ORBITS, WHEELS

from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.side_by_side import SideBySide
from satdyn_ros.run.simulation import Simulation

WHEELED = Scenario(WHEELS | {'publish.rate': 50.0, 'rotor.names': [*AXES]})
SENSORS = {
    'sensors.names': ['gyro', 'magnetometer', 'star_tracker', 'sun_sensor', 'coarse_sun_sensor'],
    'sensors.gyro.noise_density': 1e-4,
    'sensors.gyro.bias_random_walk': 1e-6,
    'sensors.gyro.initial_bias': [1e-3, 0.0, -1e-3],
    'sensors.gyro.divisor': 2,
    'sensors.magnetometer.noise': 1e-7,
    'sensors.magnetometer.bias_random_walk': 1e-9,
    'sensors.magnetometer.resolution': 1e-8,
    'sensors.star_tracker.cross_boresight': 1e-4,
    'sensors.star_tracker.latency': 3,
    'sensors.star_tracker.divisor': 2,
    'sensors.star_tracker.max_rate': 0.02,
    'sensors.sun_sensor.noise': 1e-3,
    'sensors.sun_sensor.field_of_view': 1.0,
    'sensors.coarse_sun_sensor.noise': 10.0,
}
ENVIRONMENT = {
    'time.epoch': '2026-03-01T12:00:00Z',
    'environment.magnetic_field': 'igrf',
    'environment.sun': 'ephemeris',
    'magnetorquer.max_dipole': [0.2, 0.2, 0.0],
}
KINDS: dict[str, dict[str, Any]] = {
    **{name: ORBITS[name] for name in ('circular', 'kepler', 'fixed', 'limited')},
    'sensing': {**ENVIRONMENT, **SENSORS, 'body.dipole': [0.1, 0.0, 0.05]},
    # With parts that move inside.
    'inner': {
        **ENVIRONMENT,
        'flexible.names': ['panel'],
        'flexible.panel.frequency': 3.0,
        'flexible.panel.damping': 0.01,
        'flexible.panel.coupling': [0.1, 0.3, -0.1],
        'flexible.panel.displacement': 0.1,
        'hysteresis.names': ['rod'],
        'hysteresis.rod.volume': 1e-5,
        'hysteresis.rod.coercive_force': 12.0,
        'hysteresis.rod.remanence': 0.1,
        'hysteresis.rod.saturation': 0.4,
    },
    # Of which tables are known for some minutes each, as long as a few ticks.
    'tabled': {
        **ENVIRONMENT,
        'orbit.type': 'tle',
        'orbit.tle': [
            '1 25544U 98067A   26060.50000000  .00012345  00000-0  22222-3 0  9997',
            '2 25544  51.6400 123.4567 0004321  45.6789 314.4321 15.50000000123459',
        ],
        'publish.rate': 0.02,
    },
}
# More than a group of lanes.
RUNS = 9


def scenarios(kind, seed):
    """Return scenarios that differ in where they begin, in their noise and in their bodies."""
    rng = np.random.default_rng(seed)
    base = WHEELED.with_values(KINDS[kind])
    return [
        base.with_values(
            {
                'body.inertia': (np.array([0.8, 0.9, 1.0]) * (1.0 + 0.01 * run)).tolist(),
                'initial.angular_velocity': (0.01 * rng.normal(size=3)).tolist(),
                'sensors.seed': seed + run + 1,
            }
        )
        for run in range(RUNS)
    ]


def drawn_commands(kind, rng):
    """Return commands in columns, some of which are those of before or none."""
    commands: dict[str, Any] = {}
    if rng.random() < 0.7:
        commands['torque_b'] = 1e-3 * rng.normal(size=(RUNS, 3)) * (rng.random((RUNS, 1)) < 0.7)
    if rng.random() < 0.7:
        names = rng.choice([*AXES], rng.integers(1, 3), replace=False)
        commands['rotor_torque'] = {name: 6e-3 * rng.normal(size=RUNS) for name in names}
    elif kind == 'limited':
        commands['rotor_speed'] = {'y': 12.0 * rng.normal(size=RUNS)}
    if 'magnetorquer.max_dipole' in KINDS[kind]:
        commands['dipole_b'] = 0.3 * rng.normal(size=(RUNS, 3))
    return commands


def of_run(commands, run):
    return {
        word: {name: x[run] for name, x in given.items()}
        if isinstance(given, dict)
        else given[run]
        for word, given in commands.items()
    }


def alone(scenario):
    simulation = Simulation(scenario)
    simulation.advance(1)
    return simulation


def stepped(simulation, commands):
    """Return the sample of a run alone whose commands hold until the next ones."""
    simulation._of_step = frozenset()
    return simulation.step(**commands)


def assert_row_is(columns, run, sample):
    for name in ('q_ib', 'omega_bi_b', 'rotor_speed', 'rotor_angle', 'r_i', 'v_i'):
        np.testing.assert_array_equal(getattr(columns, name)[run], getattr(sample, name))
    assert (columns.tick[run], columns.stamp_ns[run]) == (sample.tick, sample.stamp_ns)
    assert columns.t_s[run] == sample.t_s
    for name, values in columns.measured.items():
        if name in sample.measured:
            np.testing.assert_array_equal(values[run], sample.measured[name])
            assert values.stamp_ns[run] == sample.measured[name].stamp_ns
        else:
            assert np.isnan(values[run]).all()
    assert sample.measured.keys() <= columns.measured.keys()


@pytest.mark.parametrize('kind', KINDS)
@settings(max_examples=4, deadline=None)
@given(st.integers(0, 2**32))
def test_each_run_has_the_bits_that_it_has_alone(kind, seed):
    """Under drawn commands; two runs begin anew on the way, with other bodies."""
    rng = np.random.default_rng(seed)
    flown, others = scenarios(kind, seed), scenarios(kind, seed + 100)
    runs, singles = SideBySide(flown), [alone(each) for each in flown]
    for run, single in enumerate(singles):
        assert_row_is(runs.sample, run, single.sample)
    anew = int(rng.integers(1, 20))
    for k in range(20):
        commands = drawn_commands(kind, rng)
        runs.act(**commands)
        columns = runs.step()
        for run, single in enumerate(singles):
            assert_row_is(columns, run, stepped(single, of_run(commands, run)))
        if k == anew:
            runs.begin({run: others[run] for run in (1, 8)})
            for run in (1, 8):
                singles[run] = alone(others[run])
                assert_row_is(runs.sample, run, singles[run].sample)


def test_a_run_that_begins_anew_may_wait():
    """At its tick 0, while others go on, for any number of ticks."""
    first = Scenario({'publish.rate': 10.0, 'initial.angular_velocity': [0.1, 0.2, 0.3]})
    other = first.with_values({'initial.angular_velocity': [0.2, 0.0, 0.1]})
    runs = SideBySide([first, first])
    for _ in range(3):
        runs.step()
    runs.begin({1: other})
    for _ in range(20):
        runs.step(np.array([True, False]))
    single = alone(other)
    assert_row_is(runs.sample, 1, single.sample)
    assert_row_is(runs.step(), 1, single.step())


def test_what_is_along_the_orbits_is_that_of_each_run():
    """Field, Sun and torques, where the runs are on orbits of their own."""
    base = Scenario({**ENVIRONMENT, 'body.dipole': [0.1, 0.0, 0.0], 'orbit.type': 'kepler'})
    flown = [base.with_values({'orbit.inclination': 0.3 * run}) for run in range(4)]
    runs = SideBySide(flown)
    dipoles = np.linspace(-0.1, 0.1, 12).reshape(4, 3)
    runs.act(dipole_b=dipoles)
    columns = runs.step()
    for run, scenario in enumerate(flown):
        sample = alone(scenario).step(dipole_b=dipoles[run])
        for name in ('magnetic_field_b', 'sun_b', 'sunlight'):
            np.testing.assert_array_equal(getattr(columns, name)[run], getattr(sample, name))
        assert columns.torques_b.keys() == sample.torques_b.keys() == {
            'gravity_gradient', 'magnetic_torque',
        }  # fmt: skip
        for name, torque_b in sample.torques_b.items():
            np.testing.assert_array_equal(columns.torques_b[name][run], torque_b)


def test_a_sample_stays_what_it_was():
    """Its torques, where they are first looked at when other commands act and time has passed."""
    base = Scenario({**ENVIRONMENT, 'publish.rate': 0.1, 'orbit.inclination': 0.9})
    runs = SideBySide([base, base.with_values({'orbit.inclination': 0.3})])
    runs.act(dipole_b=[0.1, 0.0, 0.0])
    columns = runs.step()
    runs.act(dipole_b=[0.0, 0.2, 0.0])
    runs.step()
    runs.begin({0: base})
    for run, B_b in enumerate(columns.magnetic_field_b):
        torque_b = columns.torques_b['magnetic_torque'][run]
        np.testing.assert_allclose(torque_b, np.cross([0.1, 0.0, 0.0], B_b), rtol=1e-12)


def test_a_run_that_ends_lets_the_others_go_on():
    """A body that is made to turn too fast stays where it was, and why is said."""
    base = Scenario({'publish.rate': 1.0, 'orbit.type': 'fixed'})
    runs = SideBySide([base] * 3)
    torques_b = np.zeros((3, 3))
    torques_b[1] = 1e300
    runs.act(torque_b=torques_b)
    columns = runs.step()
    assert runs.halted.keys() == {1}
    assert 'halt' in runs.halted[1]
    assert columns.tick.tolist() == [1, 0, 1]
    runs.act(torque_b=np.ones((3, 3)))
    assert runs.step().tick.tolist() == [2, 0, 2]
    runs.begin({1: base})
    assert runs.halted == {}
    assert runs.step().tick.tolist() == [3, 1, 3]


REFUSED = {
    'a rate of its own': ({'publish.rate': 3.0}, 'publish.rate'),
    'a limit of its own': ({'rotor.x.max_torque': 1.0}, 'limits of their actuators'),
    'a drive': ({'rotor.x.speed_gain': 1.0}, 'one kind'),
    'a closed form': ({'motion.method': 'auto'}, 'motion.method numeric'),
    'another sensor': ({'sensors.names': ['gyro'], 'sensors.seed': 1}, 'sensors'),
}


@pytest.mark.parametrize(('changes', 'why'), REFUSED.values(), ids=REFUSED)
def test_runs_of_different_kinds_are_refused(changes, why):
    """In one sentence; a run that is asked to begin as one goes on as it was."""
    other = WHEELED.with_values(changes)
    with pytest.raises(ValueError, match=why):
        SideBySide([WHEELED, other])
    runs = SideBySide([WHEELED, WHEELED])
    runs.step()
    with pytest.raises(ValueError, match=why):
        runs.begin({0: WHEELED, 1: other})
    assert runs.step().tick.tolist() == [2, 2]


def test_a_gyro_that_integrates_is_refused():
    """Turns are counted in a run alone."""
    scenario = Scenario({'sensors.names': ['gyro'], 'sensors.gyro.integrating': True})
    with pytest.raises(ValueError, match='integrating'):
        SideBySide([scenario])


BAD: dict[str, tuple[dict[str, Any], str]] = {
    'a number that is none': ({'torque_b': [[0, 0, np.nan]] * 2}, 'torque of run 0'),
    'another count': ({'torque_b': np.zeros((3, 3))}, r'\(3, 3\).*\(2, 3\)'),
    'a rotor that is not there': ({'rotor_torque': {'w': np.zeros(2)}}, 'no rotor w'),
    'a speed without a drive': ({'rotor_speed': {'x': np.zeros(2)}}, 'speed_gain'),
    'no name': ({'rotor_torque': np.zeros(2)}, 'by name'),
    'no torquers': ({'dipole_b': np.zeros((2, 3))}, 'max_dipole'),
    'a unit': ({'torque_b': '[1, 2, 3] mN m'}, r'^torque is .* numbers of the shape \(2, 3\)'),
    'rows of two lengths': ({'torque_b': [[1, 2, 3], [1, 2]]}, 'numbers of the shape'),
    'a number beyond any': ({'rotor_torque': {'x': [1, 10**400]}}, r'of x is .* the shape \(2,\)'),
    'a table': ({'rotor_torque': np.zeros((2, 3))}, r'is \[\[0\. 0\. 0\.\] \[0.*by name'),
}


@pytest.mark.parametrize(('commands', 'why'), BAD.values(), ids=BAD)
def test_bad_commands_are_refused(commands, why):
    """In one sentence."""
    with pytest.raises(ValueError, match=why):
        SideBySide([WHEELED, WHEELED]).act(**commands)


def test_a_word_that_is_none_is_refused():
    """With those that there are."""
    with pytest.raises(TypeError, match='there is no command thrust; there are torque_b'):
        SideBySide([WHEELED]).act(thrust=1.0)

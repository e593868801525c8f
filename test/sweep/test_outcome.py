"""Runs propagated and measured together give the same results as alone."""

import re

import numpy as np
import pytest

from satdyn_ros.dynamics.motion import Halted
from satdyn_ros.run.checks import BELONGS
from satdyn_ros.run.in_place import OF_ATTITUDE
from satdyn_ros.run.rotors import OF_THE_ONE, belongs
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.sweep import outcome
from satdyn_ros.sweep.plan import Plan

from .sweeps import rows_of, write

UPRIGHT = [0.0, 0.02, 0.0, 0.9998]
SWEEPS = {
    'starts': {
        'initial.attitude': 'sphere',
        'initial.angular_velocity': {'normal': [[0.0, 0.0, 0.0], [1e-3, 1e-3, 1e-3]]},
    },
    'angles': {'initial.pitch': {'linspace': [-0.3, 0.3, 3]}, 'initial.roll': {'values': [0.1]}},
    'rotors': {
        'rotor.momentum': {'linspace': [-6.0, 6.0, 3]},
        'rotor.axis': {'values': [[0.0, 1.0, 0.0], [0.0, 3.0, 4.0]]},
    },
    'wheels': {
        'rotor.a.speed': {'values': [-40.0, 60.0, 101.0]},
        'rotor.a.inertia': {'values': [0.5, 590.0, 700.0]},
        'rotor.a.axis.x': {'values': [0.0, 0.5]},
        'rotor.b.momentum': {'uniform': [-6.0, 6.0]},
        'rotor.c.friction': {'values': [0.0, 1e-3]},
    },
    'modes': {
        'rotor.mode': {'values': ['none', 'constant_momentum', 'free']},
        'initial.angular_velocity.x': {'values': [0.0, 1e-3]},
    },
    'bodies': {
        'body.inertia': {
            'values': [
                [800.0, 900.0, 600.0],
                [700.0, 700.0, 700.0],
                [600.0, 800.0, 800.0],
                [800.0, 900.0, 600.0, 20.0, -30.0, 10.0],
                [800.0, 20.0, 0.0, 20.0, 900.0, 0.0, 0.0, 0.0, 600.0],
                [1.0, 1.0, 3.0],
            ]
        },
        'initial.angular_velocity.y': {'values': [0.0, 1e-3]},
    },
    'smelt': {
        'smelt.k_R': {'linspace': [-0.5, 0.5, 3]},
        'smelt.k_Y': {'linspace': [-0.5, 0.5, 3]},
    },
    'orbits': {
        'orbit.type': {'values': ['kepler']},
        'orbit.eccentricity': {'values': [0.0, 0.1, 0.3]},
        'orbit.semi_major_axis': {'values': [7e6, 9e6]},
        'orbit.inclination': {'uniform': [0.0, 3.0]},
        'orbit.true_anomaly': {'uniform': [0.0, 6.0]},
        'orbit.argument_of_periapsis': {'uniform': [0.0, 6.0]},
    },
    'oblate': {
        'initial.angular_velocity.y': {'values': [0.0, 1e-3]},
    },
    'magnets': {
        'body.dipole': {'values': [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 2.0, 1.0]]},
        'initial.angular_velocity.y': {'values': [0.0, 1e-3]},
    },
    'methods': {
        'motion.method': {'values': ['numeric', 'auto']},
        'motion.tolerance': {'values': [1e-13, 1e-11]},
    },
    'fixed': {
        'orbit.type': {'values': ['fixed']},
        'initial.frame': {'values': ['inertial', 'lvlh']},
        'orbit.gradient': {'values': [0.0, 3.6e-6]},
        'body.weight_moment.z': {'values': [0.0, 1e-4]},
        'initial.angular_velocity.z': {'values': [0.0, 0.01, -1e300]},
    },
    # The first is not symmetric about its rotor, and has no rate that would be conserved.
    'resting': {
        'orbit.type': {'values': ['fixed']},
        'initial.frame': {'values': ['inertial']},
        'body.inertia': {'values': [[600.0, 800.0, 800.0], [800.0, 600.0, 800.0]]},
    },
}


# The lanes of each of these have to be compiled: full matrices, rotors, ellipses.
LONG = 'wheels', 'bodies', 'orbits', 'magnets'


@pytest.mark.parametrize(
    'name', [pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in SWEEPS]
)
def test_together_as_alone(tmp_path, monkeypatch, name):
    """Each kind of quantity: the same rows to rounding, refusals in the same sentences."""
    mode = 'none' if name in ('fixed', 'bodies', 'modes', 'methods') else 'constant_momentum'
    parameters = {
        'rotor': {'mode': mode, 'momentum': 0.0},
        'initial': {'frame': 'lvlh', 'attitude': UPRIGHT},
    }
    if name == 'oblate':
        parameters['orbit'] = {'inclination': 0.9, 'j2': 1e-3}
    if name == 'magnets':
        parameters |= {'time': {'epoch': '2026-03-01T00:00:00Z'}, 'orbit': {'inclination': 0.9}}
        parameters['environment'] = {'magnetic_field': 'dipole'}
    if name == 'modes':
        parameters['rotor'] = {}
    if name == 'resting':
        parameters['rotor'] = {'mode': 'free', 'inertia': 2.0, 'speed': 8.0}
    if name == 'wheels':
        parameters['rotor'] = {
            'names': ['a', 'b', 'c'],
            'a': {'mode': 'motor', 'axis': [0.0, 0.0, 1.0], 'inertia': 0.5, 'max_speed': 100.0},
            'b': {'mode': 'constant_momentum'},
            'c': {'mode': 'free', 'inertia': 50.0, 'speed': 0.1},
        }
    path = write(tmp_path, parameters, vary=SWEEPS[name], runs=2, samples=name == 'starts')
    plan = Plan.from_yaml(path)
    runs = range(len(plan))
    together = rows_of(plan, runs)
    fly_alone(monkeypatch)
    assert_same(together, rows_of(plan, runs))


def fly_alone(monkeypatch):
    """Let each run go by itself."""

    def none_together(*given):
        return np.zeros(len(given[3]), bool)

    def one_after_the_other(motions, t_s):
        return [one(motion, t_s) for motion in motions]

    def one(motion, t_s):
        try:
            return motion.at(t_s)
        except Halted as error:
            return error

    monkeypatch.setattr(outcome, '_propagate_together', none_together)
    monkeypatch.setattr(outcome, 'propagate_all', one_after_the_other)


def one_by_one(*given):
    """Stand for _propagate_one_by_one where all runs are to go together."""
    raise AssertionError('a run goes by itself')


def assert_same(together, alone):
    """Assert that rows are the same to rounding, refusals in the same sentences."""
    for one, other in zip(together, alone, strict=True):
        assert one['failure'] == other['failure']
        for column, value in other.items():
            if isinstance(value, float):
                # Angles near a right one and drifts are sensitive to the last digits.
                assert one[column] == pytest.approx(value, rel=1e-6, abs=1e-9), column
            elif isinstance(value, list):
                np.testing.assert_allclose(one[column], value, rtol=0.0, atol=1e-9, err_msg=column)
            else:
                assert one[column] == value, column


# A body with two rotors, so that every key has a meaning on some orbit.  Friction and an oblique
# axis in all runs: the same compiled code flies them.
ONE_KEY = {
    'rotor': {
        'names': ['a', 'b'],
        'a': {'mode': 'constant_momentum', 'momentum': -5.0},
        'b': {
            'mode': 'motor',
            'axis': [0.0, 0.6, 0.8],
            'inertia': 0.5,
            'speed': 40.0,
            'friction': 1e-4,
        },
    },
    'initial': {'attitude': UPRIGHT},
}
# Of such rotors only the steps are taken side by side.
STEPS_ALONE = '.coulomb_friction', '.static_imbalance', '.dynamic_imbalance'
# Rotors with these have equations of their own, which are compiled for one of the orbits alone.
OWN_EQUATIONS = (*STEPS_ALONE, '.max_speed', '.speed_gain')
# What does not vary between 0.1 and 0.3.
VALUES: dict[str, list] = {
    'body.inertia': [[700.0, 900.0, 600.0], [800.0, 850.0, 600.0]],
    'body.inertia.x': [700.0, 800.0],
    'body.inertia.y': [700.0, 800.0],
    'body.inertia.z': [700.0, 800.0],
    'body.weight_moment': [[0.0, 0.0, 1e-3], [1e-3, 0.0, 0.0]],
    'body.dipole': [[0.0, 0.0, 0.1], [0.1, 0.0, 0.0]],
    'body.box': [[0.1, 0.1, 0.3], [0.2, 0.1, 0.3]],
    'body.box_centre': [[0.0, 0.0, 0.1], [0.1, 0.0, 0.0]],
    'rotor.axis': [[0.0, 3.0, 4.0], [1.0, 2.0, 2.0]],
    'rotor.max_speed': [100.0, 200.0],
    'rotor.position': [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]],
    'orbit.mu': [3.9e14, 4.0e14],
    'orbit.semi_major_axis': [7e6, 8e6],
    'orbit.gradient': [1e-6, -1e-6],
    'initial.attitude': [UPRIGHT, [0.6, 0.0, 0.0, 0.8]],
    'initial.angular_velocity': [[0.0, 0.0, 1e-3], [1e-3, 0.0, 0.0]],
    'motion.tolerance': [1e-13, 1e-12],
}


def names_alone(scenario):
    """Return the numbers that a sweep of a scenario can vary: keys, components, angles, ratios."""
    chosen_elsewhere = {
        name
        for name, chooser, choices in (*BELONGS, *belongs(scenario['rotor.names']))
        if scenario[chooser] not in choices
    }
    keys = [
        key
        for name, key in scenario.keys.items()
        if name.split('.')[0] in ('body', 'rotor', 'orbit', 'initial', 'motion')
        and key.kind in ('double', 'double_array')
        and name not in (*chosen_elsewhere, *OF_THE_ONE, *OF_ATTITUDE)
        and name not in ('orbit.j2', 'orbit.reference_radius')
    ]
    components = [f'{key.name}.{c}' for key in keys if 3 in key.lengths for c in 'xyz']
    others = 'initial.roll', 'initial.pitch', 'initial.yaw', 'smelt.k_R', 'smelt.k_Y'
    return [*(key.name for key in keys), *components, *others]


@pytest.mark.long
@pytest.mark.parametrize('kind', ['circular', 'kepler', 'fixed'])
def test_each_number_alone(tmp_path, monkeypatch, kind):
    """Whichever number varies, all others being single: rows as of the runs by themselves."""
    orbit = {'type': kind} | ({'eccentricity': 0.1} if kind == 'kepler' else {})
    write(tmp_path, ONE_KEY | {'orbit': orbit})
    scenario = Scenario.from_yaml(tmp_path / 'scenario.yaml')
    names = [
        name
        for name in names_alone(scenario)
        if kind == 'circular' or not name.endswith(OWN_EQUATIONS)
    ]
    assert {'circular': 'orbit.raan', 'kepler': 'orbit.eccentricity', 'fixed': 'orbit.gradient'}[
        kind
    ] in names
    for name in names:
        values = VALUES.get(name.replace('.a.', '.').replace('.b.', '.'), [0.1, 0.3])
        vary = {name: {'values': values}}
        path = write(tmp_path, ONE_KEY | {'orbit': orbit}, vary=vary, runs=1, duration_s=6000.0)
        plan = Plan.from_yaml(path)
        with monkeypatch.context() as patched:
            if not name.endswith(STEPS_ALONE):
                patched.setattr(outcome, '_propagate_one_by_one', one_by_one)
            together = rows_of(plan, range(2))
        with monkeypatch.context() as patched:
            fly_alone(patched)
            assert_same(together, rows_of(plan, range(2)))


@pytest.mark.parametrize(
    'name', ['orbit.inclination', 'orbit.raan', 'orbit.argument_of_periapsis']
)
def test_one_angle_of_the_orbit(tmp_path, name):
    """
    The orbit turned by one angle: at the end the body is where a single run with that angle is.

    Relative to LVLH the motion on a circle does not depend on the orbit's plane: the angles to
    LVLH, too, are those of the first row.
    """
    angles = [0.0, 0.4, 2.0]
    parameters = {'rotor': {}, 'initial': {'attitude': UPRIGHT}}
    plan = Plan.from_yaml(write(tmp_path, parameters, vary={name: {'values': angles}}, runs=1))
    rows = rows_of(plan, range(3))
    for row, angle in zip(rows, angles, strict=True):
        scenario = plan.scenario.with_values({name: angle})
        states = scenario.motion().at(plan.t_s[-1])
        assert row['failure'] is None
        # Side by side or alone, a propagation differs by rounding.
        np.testing.assert_allclose(row['q_ib'], states.q_ib[0], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(row['omega_bi_b'], states.omega_bi_b[0], rtol=0.0, atol=1e-12)
        largest = rows[0]['lvlh_angle_max_rad']
        assert row['lvlh_angle_max_rad'] == pytest.approx(largest, abs=1e-9)


def test_a_key_of_no_rotor_is_refused_in_its_row(tmp_path):
    """With names, a key of the rotor without one is allowed at its default alone."""
    rotor = {'names': ['a'], 'a': {'mode': 'constant_momentum', 'momentum': -5.0}}
    vary = {'rotor.speed': {'values': [0.0, 5.0]}}
    path = write(tmp_path, {'rotor': rotor}, vary=vary, runs=1)
    rows = rows_of(Plan.from_yaml(path), range(2))
    assert rows[0]['failure'] is None
    assert rows[1]['failure'].startswith('rotor.speed is 5.0; with rotor.names only its default')


def test_a_refused_run_says_what_its_scenario_says(tmp_path):
    """Runs on both sides of rules, among others of what is given in place of another key."""
    vary = {
        'orbit.altitude': {'normal': [2e5, 2e5]},
        'body.inertia.x': {'values': [800.0, 1500.1, 0.0]},
        'initial.angular_velocity.z': {'values': [0.0, 2e5]},
    }
    plan = Plan.from_yaml(write(tmp_path, vary=vary, runs=5, duration_s=600.0))
    rows = rows_of(plan, range(len(plan)))
    for row in rows:
        changes = {
            'orbit.altitude': row['orbit.altitude'],
            'body.inertia': (row['body.inertia.x'], 900.0, 600.0),
            'initial.angular_velocity': (0.0, 0.0, row['initial.angular_velocity.z']),
        }
        if row['failure'] is None:
            plan.scenario.with_values(changes)
        else:
            with pytest.raises(ValueError, match=f'^{re.escape(row["failure"])}$'):
                plan.scenario.with_values(changes)
    said = {row['failure'] and row['failure'].split(' ')[0] for row in rows}
    assert said == {None, 'orbit.altitude', 'body.inertia', 'initial.angular_velocity'}


def test_together_is_what_happens(tmp_path, monkeypatch):
    """Runs that differ only in numbers are propagated together: none alone."""
    plan = Plan.from_yaml(write(tmp_path))

    monkeypatch.setattr(outcome, '_propagate_one_by_one', one_by_one)
    assert len(rows_of(plan, range(12))) == 12


@pytest.mark.long
def test_rotors_with_names_have_columns_of_their_own(tmp_path, monkeypatch):
    """
    Their speeds at the end go as arrays too; the one without a name has its column as ever.

    With nothing but friction on a wheel far smaller than its body, the speed decays as
    exp(-b t / J): 100 rad/s over 12 000 s with b / J = 1e-4 1/s.  The body's rate and the wheel's
    share of the inertia count for 1e-6 of it.
    """
    wheel = {'mode': 'free', 'inertia': 1e-4, 'friction': 1e-8, 'speed': 100.0}
    parameters = {
        'rotor': {'names': ['a', 'b'], 'a': wheel, 'b': {'mode': 'constant_momentum'}},
        'orbit': {'type': 'fixed'},
        'initial': {'frame': 'inertial'},
    }
    path = write(tmp_path, parameters, vary={'rotor.a.speed': {'values': [100.0, -50.0]}}, runs=1)

    monkeypatch.setattr(outcome, '_propagate_one_by_one', one_by_one)
    first, second = rows_of(Plan.from_yaml(path), range(2))
    assert first['rotor_speed_a'] == pytest.approx(100.0 * np.exp(-1.2), rel=1e-5)
    assert second['rotor_speed_a'] == pytest.approx(-50.0 * np.exp(-1.2), rel=1e-5)
    assert first['rotor_angle_a'] == pytest.approx(1e6 * (1.0 - np.exp(-1.2)), rel=1e-5)
    assert first['rotor_speed_b'] is None
    assert 'rotor_speed' not in first

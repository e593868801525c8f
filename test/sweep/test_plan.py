"""Sweep files: what they vary, and the sentence for what is not allowed."""

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation
from scipy.stats import kstest, norm, uniform

from satdyn_ros.kernel import rotation
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.theory.stability import smelt_parameters

from .sweeps import SWEEP, write


def plan_of(folder, parameters=None, **changes):
    return Plan.from_yaml(write(folder, parameters, **changes))


def draws(folder, name, how, count=2000):
    """Return what count runs draw for one quantity."""
    plan = plan_of(folder, vary={name: how}, runs=count)
    return np.array([plan.values(run)[name] for run in range(count)])


def test_grids_go_through_every_combination(tmp_path):
    """The first grid is the slowest and every point has its runs."""
    vary = {'rotor.momentum': {'linspace': [0, 2, 3]}, 'body.inertia.x': {'values': [700, 800]}}
    plan = plan_of(tmp_path, vary=vary, runs=2)
    expected = [(h, x) for h in (0.0, 1.0, 2.0) for x in (700.0, 800.0) for _ in range(2)]
    assert [tuple(plan.values(run).values()) for run in range(len(plan))] == expected


def test_values_reach_the_scenario(tmp_path):
    """Keys, components, angles and Smelt parameters end up where they belong."""
    vary = {
        'rotor.momentum': {'values': [3.0]},
        'initial.angular_velocity.y': {'values': [0.1]},
        'initial.roll': {'values': [0.2]},
        'initial.yaw': {'values': [-0.3]},
        'smelt.k_R': {'values': [0.6]},
        'smelt.k_Y': {'values': [0.25]},
    }
    plan = plan_of(tmp_path, vary=vary, runs=1)
    scenario = plan.scenario_of(plan.values(0))
    assert scenario['rotor.momentum'] == 3.0
    assert scenario['initial.angular_velocity'] == (0.0, 0.1, 0.0)
    angles = rotation.roll_pitch_yaw(scenario['initial.attitude'])
    np.testing.assert_allclose(angles, [0.2, 0.0, -0.3], atol=1e-15)
    I_t, I_n, I_r = scenario['body.inertia']
    np.testing.assert_allclose(smelt_parameters(I_r, I_t, I_n), (0.6, 0.25), rtol=1e-14)
    assert I_t + I_n + I_r == pytest.approx(2300.0, rel=1e-14)


@pytest.mark.parametrize('pitch', [0.4, np.pi / 2.0, 2.0, -3.0])
@pytest.mark.parametrize('order', ['roll pitch yaw', 'yaw pitch roll', 'pitch yaw roll'])
def test_angles_that_vary_together_are_those_of_the_run(tmp_path, order, pitch):
    """R = Rz Ry Rx, in any order; beyond 90 deg of pitch an attitude has other angles."""
    angles = {'roll': 0.3, 'pitch': pitch, 'yaw': -0.7}
    vary = {f'initial.{name}': {'values': [angles[name]]} for name in order.split()}
    plan = plan_of(tmp_path, vary=vary, runs=1)
    q_lb = plan.scenario_of(plan.values(0))['initial.attitude']
    expected = Rotation.from_euler('ZYX', [angles[name] for name in ('yaw', 'pitch', 'roll')])
    assert (Rotation.from_quat(q_lb).inv() * expected).magnitude() < 1e-15
    at_once = plan.changed({name: np.array(x) for name, x in plan.values_of([0]).items()})
    np.testing.assert_array_equal(at_once['initial.attitude'], [q_lb])


def test_a_part_varies_after_its_whole(tmp_path):
    """Then a run has both; the other way round the part would have no effect."""
    vary = {
        'initial.roll_pitch_yaw': {'values': [[0.1, 0.2, 0.3]]},
        'initial.roll': {'values': [0.4]},
        'body.inertia': {'values': [[3.0, 4.0, 5.0]]},
        'body.inertia.x': {'values': [3.5]},
    }
    plan = plan_of(tmp_path, vary=vary, runs=1)
    scenario = plan.scenario_of(plan.values(0))
    angles = rotation.roll_pitch_yaw(scenario['initial.attitude'])
    np.testing.assert_allclose(angles, [0.4, 0.2, 0.3], atol=1e-15)
    assert scenario['body.inertia'] == (3.5, 4.0, 5.0)


def test_an_angle_without_bounds_is_refused_in_a_whole_sentence(tmp_path):
    """It does not end in a comma."""
    with pytest.raises(ValueError, match=r'initial\.roll is nan; it must be an angle in radians$'):
        plan_of(tmp_path, vary={'initial.roll': {'values': [float('nan')]}})


def test_attitudes_are_uniform_on_the_sphere(tmp_path):
    """The angle of a uniform rotation has the distribution (angle - sin angle) / pi (Haar)."""
    q = draws(tmp_path, 'initial.attitude', 'sphere')
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-15)
    angle = rotation.angle_between(rotation.IDENTITY, q)
    assert kstest(angle, lambda a: (a - np.sin(a)) / np.pi).pvalue > 0.01
    # The image of any axis is uniform on its sphere: each component is uniform from -1 to 1.
    for component in rotation.rotate(q, [0.0, 0.6, 0.8]).T:
        assert kstest(component, uniform(-1.0, 2.0).cdf).pvalue > 0.01


def test_draws_have_their_distributions(tmp_path):
    """Normal and uniform draws, scalars and vectors component by component."""
    how = {'normal': [[0.0, 1.0, 2.0], [1.0, 0.5, 0.0]]}
    x, y, z = draws(tmp_path, 'initial.angular_velocity', how).T
    assert kstest(x, norm(0.0, 1.0).cdf).pvalue > 0.01
    assert kstest(y, norm(1.0, 0.5).cdf).pvalue > 0.01
    assert np.all(z == 2.0)
    momenta = draws(tmp_path, 'rotor.momentum', {'uniform': [-3.0, 1.0]})
    assert kstest(momenta, uniform(-3.0, 4.0).cdf).pvalue > 0.01


def test_a_draw_depends_on_seed_and_run_alone(tmp_path):
    """A run's values do not depend on how many runs there are; another seed gives others."""
    few, many = plan_of(tmp_path, runs=2), plan_of(tmp_path, runs=50)
    assert few.values(1) == many.values(1)
    assert plan_of(tmp_path, seed=2).values(1) != few.values(1)
    assert many.values(1)['initial.attitude'] != many.values(0)['initial.attitude']


def test_samples_end_with_the_duration(tmp_path):
    """A duration that is no multiple of the interval still has its end among the samples."""
    t_s = plan_of(tmp_path, duration_s=250.0).t_s
    assert t_s.tolist() == [0.0, 100.0, 200.0, 250.0]


def test_text_gives_the_same_plan(tmp_path):
    """What a worker reads has the runs of what the file says, to the last bit."""
    plan = plan_of(tmp_path, parameters={'orbit': {'inclination': 0.1 + 0.2}})
    again = Plan.from_text(plan.to_text())
    assert again.scenario == plan.scenario
    assert [again.values(run) for run in range(12)] == [plan.values(run) for run in range(12)]


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        (
            {'vary': {'initial.roll': {'values': [0.1]}, 'initial.attitude': 'sphere'}},
            'initial.attitude varies after initial.roll, which is a part of it; the whole must',
        ),
        (
            {
                'vary': {
                    'initial.yaw': {'values': [0.1]},
                    'initial.roll_pitch_yaw': {'values': [[0, 0, 0]]},
                }
            },
            'initial.roll_pitch_yaw varies after initial.yaw, which is a part of it; the whole',
        ),
        (
            {'vary': {'smelt.k_R': {'values': [0.1]}, 'body.inertia.x': {'values': [900]}}},
            'smelt.k_R and body.inertia.x vary; only one of the two may',
        ),
        ({'sed': 1}, 'sed is not a key of a sweep'),
        ({'scenario': 'none.yaml'}, 'none.yaml cannot be read'),
        ({'scenario': 3}, 'it must be the path of a scenario'),
        ({'duration_s': -1.0}, 'duration_s is -1.0; it must be a number above 0'),
        ({'duration_s': 'long'}, "duration_s is 'long'"),
        ({'interval_s': 1e6}, 'interval_s is 1e+06; it must be at most duration_s'),
        ({'runs': 0}, 'runs is 0; it must be an integer at least 1'),
        ({'seed': -1}, 'seed is -1'),
        ({'samples': 1}, 'samples is 1; it must be true or false'),
        ({'bags': [12]}, 'bags is [12]; it must be a list of runs, integers from 0 to 11'),
        ({'bags': 'all'}, 'bags is all'),
        ({'vary': {}}, 'vary is {}'),
        ({'vary': {'publish.rate': {'values': [1.0]}}}, 'publish.rate in vary'),
        ({'vary': {'rotor.momentun': {'values': [1.0]}}}, 'rotor.momentun in vary'),
        ({'vary': {'rotor.momentum': 'sphere'}}, 'rotor.momentum in vary is sphere'),
        ({'vary': {'rotor.momentum': 1.0}}, 'it must be one of values, linspace, uniform, normal'),
        ({'vary': {'rotor.momentum': {'values': []}}}, 'a list that is not empty'),
        ({'vary': {'rotor.momentum': {'values': ['a']}}}, "rotor.momentum is 'a'"),
        ({'vary': {'rotor.momentum': {'linspace': [0.0, 1.0]}}}, 'it must be a list of 3'),
        ({'vary': {'rotor.momentum': {'linspace': [0.0, 1.0, 0]}}}, 'count of linspace is 0'),
        ({'vary': {'rotor.momentum': {'uniform': [1.0, 0.0]}}}, 'the lower bound comes first'),
        ({'vary': {'rotor.momentum': {'normal': [1.0, -1.0]}}}, 'standard deviation'),
        ({'vary': {'rotor.mode': {'uniform': [0.0, 1.0]}}}, 'a quantity that is not a number'),
        ({'vary': {'orbit.eccentricity': {'values': [1.5]}}}, 'orbit.eccentricity is 1.5'),
        ({'vary': {'orbit.eccentricity': {'values': [0.1]}}}, 'with orbit.type circular'),
        ({'vary': {'smelt.k_R': {'linspace': [-1.0, 1.0, 3]}}}, 'smelt.k_R is -1.0'),
    ],
)
def test_bad_files_are_refused_in_one_sentence(tmp_path, changes, sentence):
    """Every mistake is reported before the first run, by what was given and what is allowed."""
    with pytest.raises(ValueError) as refusal:
        plan_of(tmp_path, **changes)
    assert sentence in str(refusal.value)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize('name', ['scenario', 'vary', 'duration_s'])
def test_what_every_sweep_needs(tmp_path, name):
    """A file without one of the three is refused by its name."""
    path = write(tmp_path)
    kept = {key: value for key, value in SWEEP.items() if key != name}
    path.write_text(str(kept))
    with pytest.raises(ValueError, match=f'has no {name}'):
        Plan.from_yaml(path)


def test_a_satellite_of_several(tmp_path):
    """It is asked for where the scenario has several."""
    path = write(tmp_path)
    alone, scenario = Plan.from_yaml(path).scenario, tmp_path / SWEEP['scenario']
    own = yaml.safe_load(scenario.read_text())['/**']
    scenario.write_text(yaml.safe_dump({'/a/satdyn': own, '/b/satdyn': {}}))
    # In a namespace it has frames of its own.
    frames = {'frames.orbital': 'a/lvlh', 'frames.body': 'a/base_link'}
    assert Plan.from_yaml(path, '/a').scenario == alone.with_values(frames)
    with pytest.raises(ValueError, match='has 2 satellites; --satellite must choose'):
        Plan.from_yaml(path)


def test_a_key_given_twice_is_refused(tmp_path):
    """PyYAML would keep the last without a word."""
    path = write(tmp_path)
    path.write_text(f'{path.read_text()}\nruns: 1\nruns: 2\n')
    with pytest.raises(ValueError, match='gives runs twice, again at line'):
        Plan.from_yaml(path)


def test_a_file_that_is_no_mapping(tmp_path):
    """A list is no sweep."""
    path = write(tmp_path)
    path.write_text('- 1')
    with pytest.raises(ValueError, match='is not a sweep file'):
        Plan.from_yaml(path)

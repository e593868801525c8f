"""Runs that are flown and measured together come to what each comes to by itself."""

import numpy as np
import pytest

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
}


@pytest.mark.parametrize('name', SWEEPS)
def test_together_as_alone(tmp_path, monkeypatch, name):
    """Each kind of quantity: the same rows to rounding, refusals in the same sentences."""
    mode = 'none' if name in ('fixed', 'bodies', 'modes', 'methods') else 'constant_momentum'
    parameters = {
        'rotor': {'mode': mode, 'momentum': 0.0},
        'initial': {'frame': 'lvlh', 'attitude': UPRIGHT},
    }
    if name == 'modes':
        parameters['rotor'] = {}
    path = write(tmp_path, parameters, vary=SWEEPS[name], runs=2, samples=name == 'starts')
    plan = Plan.from_yaml(path)
    runs = range(len(plan))
    together = rows_of(plan, runs)
    monkeypatch.setattr(outcome, '_fly_together', lambda *given: np.zeros(len(given[3]), bool))
    alone = rows_of(plan, runs)
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


def test_together_is_what_happens(tmp_path, monkeypatch):
    """Runs that differ in numbers alone are flown together: none goes by itself."""
    plan = Plan.from_yaml(write(tmp_path))

    def alone(*given):
        raise AssertionError('a run goes by itself')

    monkeypatch.setattr(outcome, '_fly_alone', alone)
    assert len(rows_of(plan, range(12))) == 12

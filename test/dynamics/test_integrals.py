"""The drift of a first integral is measured against the size of what it is made of."""

import numpy as np
import pytest

from satdyn_ros.dynamics.integrals import relative_drift
from satdyn_ros.run.scenario import Scenario

# The root of a rounding error, the quarter turn whose sine and cosine are equal.
QUARTER = [2**-0.5, 0.0, 0.0, 2**-0.5]


def drift(values, duration_s=60.0):
    """Return the largest relative drift of each integral of a run about a fixed centre."""
    scenario = Scenario({'orbit.type': 'fixed', **values})
    states = scenario.motion().at(np.linspace(0.0, duration_s, 601))
    found = relative_drift(scenario.system, states)
    return {name: float(np.max(np.abs(values))) for name, values in found.items()}


@pytest.mark.parametrize(
    'values',
    [
        {'orbit.gradient': 0.01, 'initial.angular_velocity': [0.1, 0.0, 0.0]},
        {'orbit.gradient': 0.01, 'initial.attitude': [0.1, 0.3, 0.5, 0.65**0.5]},
        {'orbit.gradient': 0.01, 'initial.attitude': QUARTER},
        {'orbit.gradient': 0.01, 'body.inertia': [80.0, 80.0, 50.0], 'initial.attitude': QUARTER},
        {'body.weight_moment': [0.0, 1.0, 0.0], 'body.inertia': [1.0, 1.0, 0.5]},
        {
            'rotor.mode': 'constant_momentum',
            'rotor.momentum': -90.0,
            'initial.angular_velocity': [0.0, 0.1, 0.0],
        },
        {
            'rotor.mode': 'free',
            'rotor.inertia': 60.0,
            'rotor.speed': 20.0,
            'initial.angular_velocity': [1e-4, 0.0, 2e-4],
        },
    ],
    ids=[
        'area zero',
        'from rest',
        'at rest in the field',
        'symmetric at rest',
        'energy zero',
        'momentum zero',
        'fast rotor in a slow body',
    ],
)
def test_an_integral_that_vanishes_does_not_drift(values):
    """Where the integral or a term of it is zero, its rounding errors are no drift."""
    found = drift(values)
    # Some tens of steps, each true to 1e-12 of the momenta and energies that change.
    assert max(found.values()) < 1e-10, found


def test_a_drift_is_told_in_the_measure_of_the_momentum():
    """A momentum that turns by 1e-6 out of the plane changes the area, zero at first, by 1e-6."""
    scenario = Scenario({'orbit.type': 'fixed', 'initial.angular_velocity': [1.0, 0.0, 0.0]})
    states = scenario.motion().at([0.0, 1.0])
    states.omega_bi_b[1] += 1e-6 * states.c_b[1] * 800.0 / np.diag(scenario.system.inertia)
    found = relative_drift(scenario.system, states)['area'][1]
    assert found == pytest.approx(1e-6, rel=1e-3)

"""Corners that come in pairs within a step, of plates that face the flow or the Sun briefly."""

import numpy as np
import pytest

from satdyn_ros import Scenario
from satdyn_ros.kernel import rotation

T_S = np.linspace(0.0, 3000.0, 301)


def flown(tolerance, plates, omega):
    """Return the attitudes (N, 4) of a tumbling body in air, sunlight and shadow."""
    names = [f'plate_{n}' for n in range(len(plates))]
    surface = {
        name: {'area': 0.05, 'normal': normal.tolist(), 'position': position.tolist()}
        for name, (normal, position) in zip(names, plates, strict=True)
    }
    scenario = Scenario.from_dict(
        {
            'body': {'inertia': [1.0, 1.3, 1.7], 'dipole': [1e-9, 0.0, 0.0]},
            'orbit': {'type': 'kepler', 'semi_major_axis': 6778137.0, 'inclination': 0.5},
            'environment': {
                'magnetic_field': 'igrf',
                'sun': 'ephemeris',
                'atmosphere': 'exponential',
                'density': 1e-11,
                'density_height': 400e3,
                'scale_height': 60e3,
            },
            'surface': {'names': names, **surface},
            'initial': {
                'frame': 'inertial',
                'attitude': [0.5, 0.5, 0.5, 0.5],
                'angular_velocity': omega.tolist(),
            },
            'motion': {'tolerance': tolerance},
            'time': {'epoch': '2024-03-01T00:00:00Z'},
        }
    )
    return scenario.motion().at(T_S).q_ib


def unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def apart(plates, omega):
    """Return the largest angle [rad] between a run and one of a tenth of its tolerance."""
    runs = (flown(tolerance, plates, omega) for tolerance in (1e-13, 1e-14))
    return np.max(rotation.angle_between(*runs))


def draws(count):
    rng = np.random.default_rng(1)
    position = np.array([0.3, 0.5, 0.2])
    return [([(unit(rng), position)], 0.06 * unit(rng)) for _ in range(count)]


# A corner that is missed leaves up to 5e-8, a step across the edge of the shadow 1e-8.
# What is left is what some hundred steps of 1e-13 grow to.
ALLOWED = 1e-9


@pytest.mark.parametrize('count', [20, pytest.param(60, marks=pytest.mark.long)])
def test_of_one_plate_none_is_missed(count):
    """Random plates and rates, the one of draw 16 among them, which grazes the flow."""
    assert max(apart(*draw) for draw in draws(count)) < ALLOWED


@pytest.mark.long
def test_of_six_plates_none_is_missed():
    """As above, ten bodies."""
    rng = np.random.default_rng(2)
    for _ in range(10):
        plates = [(unit(rng), 0.5 * unit(rng)) for _ in range(6)]
        assert apart(plates, 0.06 * unit(rng)) < ALLOWED

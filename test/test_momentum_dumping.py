"""Momentum dumping of examples/: the Sun is held, and the wheels give their momentum away."""

import sys
from pathlib import Path

import numpy as np
import pytest

from satdyn_ros.run.scenario import Scenario

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / 'examples'))

import momentum_dumping  # noqa: E402


def test_the_dipole_takes_momentum_and_the_wheels_turn_to_the_sun():
    """The torque m x B is against h, square to B; off the Sun by 0.1 rad the body turns to it."""
    scenario = Scenario.from_yaml(ROOT / 'config' / 'sun_pointing.yaml')
    controller, field_b = momentum_dumping.Controller(scenario), np.array([1e-5, 2e-5, -2e-5])
    speeds, sun_b = np.array([300.0, -200.0, 250.0]), np.array([0.0, np.sin(0.1), np.cos(0.1)])
    torques, dipole_b = controller.command(np.zeros(3), field_b, sun_b, speeds)
    torque_b, h_b = np.cross(dipole_b, field_b), 1e-5 * speeds
    assert abs(torque_b @ field_b) < 1e-12 * np.linalg.norm(torque_b) * np.linalg.norm(field_b)
    assert torque_b @ h_b < 0.0
    # About -x the z axis goes to +y, where the Sun is; the wheel is driven the other way.
    np.testing.assert_allclose([torques[f'rw_{axis}'] for axis in 'yz'], 0.0, atol=1e-18)
    assert torques['rw_x'] == pytest.approx(0.045 * 0.05**2 * 0.1)


@pytest.mark.long
def test_the_wheels_are_slow_once_the_sun_is_held(monkeypatch):
    """
    After 4500 s the momentum of the start, which is 440 rad/s of a wheel, is mostly gone.

    Off the Sun by up to 1.1 deg: by the friction of the wheels, which the law does not know.
    """
    monkeypatch.setattr(momentum_dumping, 'REPORT_EACH_S', 1500.0)
    scenario = Scenario.from_yaml(ROOT / 'config' / 'sun_pointing.yaml')
    *_, (angle, speed) = momentum_dumping.fly(scenario, 4500.0, lambda line: None)
    assert np.degrees(angle) < 2.0
    assert speed < 150.0

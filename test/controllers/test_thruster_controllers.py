"""The controllers of examples/ that fire thrusters fly config/cold_gas.yaml."""

import sys
from pathlib import Path

import numpy as np
import pytest

from satdyn_ros import Scenario, Simulation, guidance
from satdyn_ros.kernel import rotation
from satdyn_ros.torques.thrust import thrust_of

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / 'examples' / 'controllers'))

from phase_plane import PhasePlane  # noqa: E402
from thruster_damping import ThrusterDamping  # noqa: E402
from thruster_pointing import ThrusterPointing  # noqa: E402
from thruster_pulses import Pulses  # noqa: E402

SCENARIO = Scenario.from_yaml(ROOT / 'config' / 'cold_gas.yaml')


def fly(controller, duration_s):
    """Return the samples of a flight, one a tick, and the propellant used [kg]."""
    simulation = Simulation(SCENARIO, controller=controller)
    found = [simulation.step() for _ in range(round(duration_s * 10.0))]
    used = thrust_of(simulation.system).propellant_used(np.array([duration_s]))
    return found, float(used.sum())


def off_deg(sample):
    """Return angle [deg] and rate [deg/s] by which the body is off nadir."""
    q_ir, omega_r, _ = guidance.nadir(sample)
    q_br = rotation.multiply(rotation.conjugate(sample.q_ib), q_ir)
    slip = sample.omega_bi_b - rotation.rotate(q_br, omega_r)
    angle = rotation.angle_between(q_ir, sample.q_ib)
    return float(np.degrees(angle)), float(np.degrees(np.linalg.norm(slip)))


def test_pulses_make_any_torque():
    """Four thrusters that only push: the sum is what is asked for, none negative or too long."""
    pulses, draw = Pulses(SCENARIO, 1.0), np.random.default_rng(5)
    for wanted in draw.normal(size=(50, 3)) * 1e-4:
        on_times = pulses.on_times(wanted)
        given = pulses.torques_b @ [*on_times.values()]
        # A pulse below the shortest of 5 ms is off by half of it, of at most 3.8 mN m.
        np.testing.assert_allclose(given, wanted, rtol=0.0, atol=4 * 2.5e-3 * 3.8e-3)
        assert all(x == 0.0 or 5e-3 <= x <= 1.0 for x in on_times.values())
    far = pulses.on_times(np.array([0.0, 0.0, 1.0]))
    assert max(far.values()) == pytest.approx(1.0)
    given = pulses.torques_b @ [*far.values()]
    assert np.abs(given[:2]).max() < 1e-12 * given[2]


def test_the_rate_is_taken_away():
    """From 2.7 deg/s to what shortest pulses leave, 0.01 deg/s, in eight seconds, with 0.5 g."""
    samples, used = fly(ThrusterDamping(), 30.0)
    rates = [np.degrees(np.linalg.norm(each.omega_bi_b)) for each in samples]
    assert rates[0] == pytest.approx(2.69, abs=0.05)
    assert max(rates[80:]) < 0.01
    assert 1e-4 < used < 6e-4


@pytest.mark.parametrize(
    ('kind', 'begin_s', 'angle', 'rate', 'most_used'),
    [(ThrusterPointing, 60, 0.15, 0.02, 1.6e-3), (PhasePlane, 120, 0.6, 0.05, 2.4e-3)],
)
def test_the_body_points_to_the_earth(kind, begin_s, angle, rate, most_used):
    """
    From 45 deg off: by pulses within 0.15 deg, about what the shortest turns in a period.

    By the phase plane within its dead band of 0.29 deg an axis, and hardly firing there.
    """
    samples, used = fly(kind(), 180.0)
    assert off_deg(samples[0])[0] > 35.0
    angles, rates = zip(*map(off_deg, samples[begin_s * 10 :]), strict=True)
    assert max(angles) < angle
    assert max(rates) < rate
    assert used < most_used

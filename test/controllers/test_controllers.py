"""The controllers of examples/ fly config/cubesat_adcs.yaml: what each of them reaches."""

import copy
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from satdyn_ros import Scenario, Simulation, guidance
from satdyn_ros.kernel import rotation

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / 'examples' / 'controllers'))

from b_dot import BDot  # noqa: E402
from detumble_then_point import DetumbleThenPoint  # noqa: E402
from dumping import Dumping  # noqa: E402
from inertial import Inertial  # noqa: E402
from nadir import Nadir  # noqa: E402
from sun import Sun  # noqa: E402
from target import Target  # noqa: E402

SCENARIO = Scenario.from_yaml(ROOT / 'config' / 'cubesat_adcs.yaml')
# Ticks cost time: fewer of them, and of the star tracker's samples about as many.
RATE_2 = SCENARIO.with_values({'publish.rate': 2.0, 'sensors.star_tracker.divisor': 2})
RATE_1 = SCENARIO.with_values({'publish.rate': 1.0, 'sensors.star_tracker.divisor': 1})
TUMBLE = {'initial.angular_velocity': (0.06, -0.05, 0.07)}
POINTING = [Nadir, Sun, Inertial, Target]

each_pointing = pytest.mark.parametrize('kind', POINTING, ids=lambda kind: kind.__name__)


def seen(sample):
    """Return what a controller without truth gets of a sample."""
    names = ('measured', 'rotor_speed', 'r_i', 'v_i', 'tick', 't_s', 'stamp_ns')
    return SimpleNamespace(**{name: getattr(sample, name) for name in names})


def fly(controller, scenario, duration_s):
    """Yield a sample at each tick of a closed loop; commands hold until the next of their name."""
    assert not controller.needs_truth
    simulation = Simulation(scenario)
    held: dict[str, Any] = {}
    controller.reset(simulation.scenario, 1)
    rate_hz = float(scenario.rate)
    period = round((controller.period_s or 1.0 / rate_hz) * rate_hz)
    for tick in range(round(duration_s * rate_hz)):
        simulation.advance(1)
        if tick % period == 0:
            held |= controller.command(seen(simulation.sample))
        simulation.command(**held)
        yield simulation.sample


def off_deg(reference, sample):
    """Return the angle [deg] and the rate [deg/s] at which a body is off a reference."""
    q_ir, omega_r, _ = reference(sample)
    q_br = rotation.multiply(rotation.conjugate(sample.q_ib), q_ir)
    slip = sample.omega_bi_b - rotation.rotate(q_br, omega_r)
    angle = rotation.angle_between(q_ir, sample.q_ib)
    return float(np.degrees(angle)), float(np.degrees(np.linalg.norm(slip)))


def rate_deg_s(sample):
    return np.degrees(np.linalg.norm(sample.omega_bi_b))


def momentum(sample):
    """Return that of the wheels of cubesat_adcs [N m s]."""
    return 2e-5 * np.linalg.norm(sample.rotor_speed)


@each_pointing
def test_the_body_comes_to_the_reference(kind):
    """
    After four minutes, from a slow turn: within 0.2 deg and 0.02 deg/s, with wheels at two thirds.

    The star tracker sees no stars at first, half a turn is to be made, the dipole of the body
    turns it off by 0.04 deg at the gains that there are, and gyro and star tracker have noise.
    """
    controller = kind()
    flight = [*fly(controller, RATE_2, 300.0)]
    assert off_deg(controller.reference, flight[0])[0] > 90.0
    angles, slips = zip(*(off_deg(controller.reference, x) for x in flight[-120:]), strict=True)
    assert max(angles) < 0.2
    assert max(slips) < 0.02
    assert max(np.abs(x.rotor_speed).max() for x in flight) < 400.0


@pytest.mark.long
@each_pointing
def test_the_body_stays_at_the_reference_for_a_quarter_of_an_orbit(kind):
    """Within 0.2 deg from the fifth minute on."""
    controller = kind()
    angles = [off_deg(controller.reference, x)[0] for x in fly(controller, RATE_2, 1500.0)]
    assert max(angles[600:]) < 0.2


@pytest.mark.long
def test_nadir_as_the_page_has_it():
    """At the rate of the scenario, which is that of docs/how-to/point_to_nadir.md."""
    angles = [off_deg(guidance.nadir, x)[0] for x in fly(Nadir(), SCENARIO, 600.0)]
    assert max(angles[-1500:]) < 0.2


def test_other_references_are_chosen_by_parameters():
    """Another body axis near the orbit normal, another attitude or position, softer gains."""
    sample = next(iter(fly(Nadir(), SCENARIO, 1.0)))
    for controller, reference in (
        (Sun(second_axis=(0.0, 1.0, 0.0)), guidance.sun((0.0, 1.0, 0.0))),
        (Inertial(q=(0.0, 0.0, 0.0, 1.0)), guidance.inertial((0.0, 0.0, 0.0, 1.0))),
        (Target('10 deg', '20 deg'), guidance.target('10 deg', '20 deg')),
    ):
        found = controller.reference(sample)
        np.testing.assert_array_equal(found.q_ir, reference(sample).q_ir)
    assert Nadir(swing_rad_s=0.05).k == 0.05**2


def test_b_dot_takes_the_tumble():
    """From 6 deg/s less than half is left after 1000 s, by the dipole alone."""
    flight = [*fly(BDot(), RATE_1.with_values(TUMBLE), 1000.0)]
    assert rate_deg_s(flight[0]) > 6.0
    assert rate_deg_s(flight[-1]) < 3.0


@pytest.mark.long
def test_b_dot_ends_with_the_turn_of_the_field():
    """Within an orbit the body is as slow as the field, which turns twice in one: 0.13 deg/s."""
    *_, last = fly(BDot(), RATE_1.with_values(TUMBLE), 5700.0)
    assert rate_deg_s(last) < 0.4


def test_the_wheels_give_their_momentum_away_while_they_point():
    """
    A quarter of it in 600 s, within 0.2 deg of nadir once the bias of the gyro is known.

    Across the field alone, which has turned by little until then.
    """
    begun = RATE_1.with_values(
        {
            'initial.attitude': (0.0, 0.0, 0.0, 1.0),
            'initial.angular_velocity': (0.0, 0.0, 0.0),
            'rotor.rw_x.speed': 400.0,
            'rotor.rw_y.speed': -350.0,
            'rotor.rw_z.speed': 300.0,
        }
    )
    flight = [*fly(Dumping(), begun, 600.0)]
    assert momentum(flight[-1]) < 0.75 * momentum(flight[0])
    assert max(off_deg(guidance.nadir, x)[0] for x in flight[200:]) < 0.2


@pytest.mark.long
def test_most_of_the_momentum_is_gone_after_half_an_orbit():
    """As the orbit turns the field, all of the momentum comes to lie across it."""
    first, *_, last = fly(Dumping(), RATE_1.with_values({'rotor.rw_x.speed': 400.0}), 3500.0)
    assert momentum(last) < 0.3 * momentum(first)
    assert off_deg(guidance.nadir, last)[0] < 0.2


def test_the_wheels_take_over_once_the_tumble_is_slow():
    """
    Here at 5.2 deg/s, which torquers ten times as strong reach soon; then the body points.

    What turns about the field is left to the wheels: until then the orbit has not turned it.
    """
    strong = RATE_2.with_values({**TUMBLE, 'magnetorquer.max_dipole': (2.0, 2.0, 2.0)})
    controller = DetumbleThenPoint(slow_rad_s=0.09)
    flight = [*fly(controller, strong, 300.0)]
    assert controller.is_pointing
    assert rate_deg_s(flight[0]) > 6.0
    assert max(off_deg(guidance.nadir, x)[0] for x in flight[-100:]) < 0.2


@pytest.mark.long
def test_a_tumble_ends_at_nadir():
    """With the torquers that there are, within three quarters of an orbit."""
    *_, last = fly(DetumbleThenPoint(), RATE_1.with_values(TUMBLE), 4000.0)
    assert off_deg(guidance.nadir, last)[0] < 0.2


@pytest.mark.parametrize('kind', [Nadir, BDot, Dumping, DetumbleThenPoint])
def test_a_copy_commands_what_the_original_does(kind):
    """A controller is copied with its run, at any tick."""
    *samples, last = fly(kind(), RATE_1, 60.0)
    controller = kind()
    controller.reset(RATE_1, 1)
    for sample in samples:
        controller.command(seen(sample))
    twin = copy.deepcopy(controller)
    commands = controller.command(seen(last))
    assert commands
    np.testing.assert_equal(twin.command(seen(last)), commands)


def test_without_measurements_nothing_is_commanded():
    """At the ticks between those of the sensors, what acts goes on."""
    sample = seen(next(iter(fly(Nadir(), SCENARIO, 1.0))))
    sample.measured = {}
    for kind in (*POINTING, BDot, Dumping, DetumbleThenPoint):
        controller = kind()
        controller.reset(SCENARIO, 1)
        assert not controller.command(sample).get('rotor_torque')

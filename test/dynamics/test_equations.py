"""The compiled equations are those of plain_equations.py, on states drawn at random."""

import math
from typing import NamedTuple

import numpy as np
import plain_equations
import pytest

from satdyn_ros.dynamics import equations
from satdyn_ros.dynamics.constants import constants_of
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.dynamics.variables import RATE, initial_values
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit
from satdyn_ros.torques.body_torque import BodyTorque

FULL = np.array([[3.0, 0.2, -0.1], [0.2, 2.5, 0.3], [-0.1, 0.3, 3.5]])
AXIS = np.array([0.6, 0.0, 0.8])
WHEELS = (
    Rotor('free', axis=AXIS, inertia=0.1, friction=0.02),
    Rotor('constant_momentum', axis=AXIS, momentum=0.7),
    Rotor('motor', axis=np.array([0.0, 1.0, 0.0]), inertia=0.2),
)


class Wind(BodyTorque):
    """A torque of everything that a torque may depend on."""

    name = 'wind'

    class Constants(NamedTuple):
        size: float
        arm: tuple[float, float]
        shares: np.ndarray

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        x = constants.size * math.sin(0.1 * t_s) * r_i[2]
        y = constants.arm[1] * v_i[0] * q_ib[3] + max(omega_bi_b[0], 0.0)
        z = omega_bi_b[1] * q_ib[0]
        for share in constants.shares:
            z = z - share * v_i[1]
        return x, y, z


class Steady(BodyTorque):
    """One that turns with the orbit, seen from which it is constant."""

    name = 'steady'
    is_steady = True

    class Constants(NamedTuple):
        factor: float

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        return constants.factor * omega_bi_b[2], 0.0, -constants.factor * q_ib[1] * q_ib[1]


WIND = Wind(Wind.Constants(1e-7, (0.0, 2e-5), np.array([1e-5, 3e-5, -2e-5])))
CIRCLE = KeplerOrbit(inclination=0.7, raan=0.4, argument_of_periapsis=0.2, true_anomaly=0.3)
ELLIPSE = KeplerOrbit(eccentricity=0.3, semi_major_axis=1.2e7, inclination=0.7, true_anomaly=2.0)
FIXED = FixedDirection(0.4)
MOMENT = np.array([0.1, -0.2, 0.3])
DRIVEN = {
    'torque_b': np.array([0.1, 0.2, -0.3]),
    'rotor_torque': np.array([0.0, 0.0, 0.05]),
}

SYSTEMS = {
    'fixed': System(FULL, orbit=FIXED, weight_moment=MOMENT),
    'circle': System(np.diag([3.0, 2.5, 3.5]), WHEELS, CIRCLE).driven(**DRIVEN),
    'ellipse': System(FULL, WHEELS, ELLIPSE).driven(**DRIVEN),
    'fixed with a torque': System(FULL, WHEELS, FIXED, torques=(WIND,)).driven(**DRIVEN),
    'circle with a torque': System(FULL, WHEELS, CIRCLE, torques=(WIND,)),
    'ellipse with two': System(FULL, orbit=ELLIPSE, torques=(WIND, Steady(Steady.Constants(0.3)))),
}


@pytest.mark.parametrize('name', SYSTEMS)
def test_rates_are_the_equations(name):
    """Of any system, at any time and state, each derivative to rounding."""
    system, rng = SYSTEMS[name], np.random.default_rng(5)
    turning = len(system.turning_rotors)
    for _ in range(20):
        start_s = rng.uniform(0.0, 1e4)
        q_ib, omega = rotation.normalise(rng.normal(size=4)), rng.normal(size=3)
        speeds = rng.normal(size=len(system.rotors))
        state = State(q_ib, omega, speeds, 0.0 * speeds)
        y = initial_values(system, state)
        if system.integrates_anomaly and isinstance(system.orbit, KeplerOrbit):
            f = system.orbit.anomaly(start_s)
            y[-2:] = np.cos(f), np.sin(f)
        constants = constants_of(system, start_s)
        found = np.array(equations.rates(start_s, tuple(y.tolist()), constants))
        momenta = y[RATE.stop : RATE.stop + turning]
        right = plain_equations.rates(system, start_s, q_ib, omega, momenta)
        # In axes that turn: q' = q_ib' - (Omega, 0) q / 2.
        turn = constants.axes_rate * np.array([*constants.normal, 0.0])
        q_dot = right.q_ib - rotation.multiply(turn, q_ib) / 2.0
        work = right.work if constants.does_work else 0.0
        expected = [*q_dot, *right.omega_bi_b, *right.momenta, *right.angles, work]
        # Each is a sum of some dozen terms of at most some ten.
        np.testing.assert_allclose(found[: len(expected)], expected, rtol=1e-12, atol=3e-13)


def test_a_steady_torque_leaves_the_turning_axes():
    """Whether the axes turn with a circular orbit is what the torques say."""
    steady = Steady(Steady.Constants(0.3))
    assert System(FULL, orbit=CIRCLE, torques=(steady,)).has_turning_axes
    assert not System(FULL, orbit=CIRCLE, torques=(steady, WIND)).has_turning_axes


def test_an_imbalance_pulls_with_the_square_of_the_speed():
    """
    A mass off the axis pulls outward, U_s s^2, where the rotor is; a skew one tilts it, U_d s^2.

    Of a body at rest, to rounding.
    """
    position, U_s, U_d, s, theta = np.array([0.1, -0.2, 0.3]), 2e-4, 3e-5, 40.0, 0.7
    rotor = Rotor(
        'free',
        axis=AXIS,
        inertia=0.1,
        position=position,
        static_imbalance=U_s,
        dynamic_imbalance=U_d,
    )
    system = System(FULL, (rotor,), FixedDirection(0.0), weight_moment=np.zeros(3))
    state = State(np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.array([s]), np.array([theta]))
    y = tuple(initial_values(system, state).tolist())
    found = np.array(equations.rates(0.0, y, constants_of(system, 0.0)))[RATE]
    e_1 = rotor.zero_direction
    outward = math.cos(theta) * e_1 + math.sin(theta) * np.cross(AXIS, e_1)
    torque = s**2 * (U_s * np.cross(position, outward) + U_d * outward)
    expected = np.linalg.solve(FULL - 0.1 * np.outer(AXIS, AXIS), torque)
    np.testing.assert_allclose(found, expected, rtol=1e-13)

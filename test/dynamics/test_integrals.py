"""The first integrals of propagated motions against the values that the references give."""

from dataclasses import replace

import numpy as np
import pytest
from cases import newtonian

from satdyn_ros.dynamics.integrals import first_integrals, relative_drift
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection, KeplerOrbit

ANY = rotation.normalise([0.1, 0.5, 0.7, 0.5])
SKEW = rotation.matrix(rotation.normalise([0.3, -0.2, 0.4, 1.0]))
F2 = [name for name, case in newtonian().items() if 'F2' in case.raw['first_integrals']]


@pytest.mark.parametrize('name', F2)
def test_the_fourth_integral_of_the_references(name):
    """F2 of every case that has it, at the start and along the propagation."""
    case = newtonian()[name]
    expected = float(case.raw['first_integrals']['F2']['value'])
    states = Propagation(case.system, case.start, 0.0, 1e-13).at(case.t_s)
    size = float(np.sum((case.system.inertia @ case.start.omega_bi_b) ** 2)) + abs(expected)
    np.testing.assert_allclose(
        first_integrals(case.system, states)['fourth'], expected, atol=1e-11 * size
    )


@pytest.mark.parametrize('gradient', [2.0, -2.0])
@pytest.mark.parametrize('seed', range(4))
def test_the_fourth_integral_of_generic_starts(gradient, seed):
    """
    Starts with no closed form conserve F2 = |I w|^2 - k (BC g1^2 + CA g2^2 + AB g3^2) alike.

    In any body axes and for either sign of the gradient; the formula here is in principal ones.
    """
    random = np.random.default_rng(seed)
    moments = np.array([1.0, 1.5, 2.0])
    system = System(SKEW @ np.diag(moments) @ SKEW.T, orbit=FixedDirection(gradient))
    start = State(rotation.normalise(random.normal(size=4)), random.normal(size=3))
    states = Propagation(system, start, 0.0, 1e-13).at(np.linspace(0.0, 30.0, 301))
    A, B, C = moments
    momentum, g = states.omega_bi_b @ SKEW * moments, states.c_b @ SKEW
    expected = np.sum(momentum**2, axis=-1) - gradient * g**2 @ [B * C, C * A, A * B]
    fourth = first_integrals(system, states)['fourth']
    np.testing.assert_allclose(fourth, expected, rtol=1e-12, atol=1e-12)
    assert np.ptp(fourth) < 1e-10
    # and it is no function of the others: the motion goes through different momenta
    assert np.ptp(np.sum(momentum**2, axis=-1)) > 0.1


def test_many_rows_are_as_one_by_one():
    """An integral has the same bits alone and among many."""
    case = newtonian()[F2[0]]
    t_s = np.linspace(0.0, 100.0, 10_000)
    states = Propagation(case.system, case.start).at(t_s)
    many = first_integrals(case.system, states)
    assert len(many) > 2
    for i in range(0, len(states), 997):
        for name, value in first_integrals(case.system, states.rows(slice(i, i + 1))).items():
            assert value[0] == many[name][i]


def test_a_rotor_ends_the_fourth_integral():
    """With a rotor F2 is not conserved, and it is not listed."""
    system = System(
        np.diag([1.0, 1.5, 2.0]),
        (Rotor('constant_momentum', np.array([0.6, 0.0, 0.8]), 0.3),),
        FixedDirection(1.0),
    )
    states = Propagation(system, State(ANY, np.array([0.3, -0.2, 0.5]))).at(np.linspace(0, 20, 50))
    assert set(first_integrals(system, states)) == {'energy', 'area'}


@pytest.mark.parametrize('weight', [[0.0, 0.0, 0.4], [0.3, -0.1, 0.2]])
def test_the_axial_rate_of_a_spherical_top(weight):
    """A = B = C with its centre off the point: the rate along the weight's arm is constant."""
    weight = np.array(weight)
    system = System(1.3 * np.eye(3), weight_moment=weight)
    start = State(ANY, np.array([0.3, -0.2, 0.5]))
    states = Propagation(system, start, 0.0, 1e-13).at(np.linspace(0.0, 60.0, 301))
    rate = first_integrals(system, states)['axial_rate']
    arm = weight / np.linalg.norm(weight)
    np.testing.assert_allclose(rate, start.omega_bi_b @ arm, atol=1e-11)
    assert np.max(np.abs(relative_drift(system, states)['axial_rate'])) < 1e-10
    # other components do change
    assert np.ptp(states.omega_bi_b @ np.cross(arm, [0.0, 1.0, 0.0])) > 0.1


def test_the_axial_rate_of_a_sphere_with_a_rotor():
    """Without weight the rate about the rotor's axis is the constant one."""
    rotor = Rotor('constant_momentum', np.array([0.6, 0.0, 0.8]), 0.3)
    system = System(1.3 * np.eye(3), (rotor,), FixedDirection(1.0))
    states = Propagation(system, State(ANY, np.array([0.3, -0.2, 0.5]))).at(np.linspace(0, 60, 99))
    rate = first_integrals(system, states)['axial_rate']
    np.testing.assert_allclose(rate, 0.3 * 0.6 + 0.5 * 0.8, atol=1e-12)


# Of the sum of all that the steps and the interpolation may change an integral by, in the worst of
# directions and each time, honest runs make a tenth at the most: errors of steps differ in sign.
ORBITS = (
    FixedDirection(),
    FixedDirection(1e-3),
    KeplerOrbit(),
    KeplerOrbit(semi_major_axis=2e7, eccentricity=0.6, true_anomaly=3.0),
)


def flown(seed):
    """
    Return a run that a seed draws: its propagation, its states and how far it may drift.

    Bodies from 1e-3 to 1e4 kg m^2 at rest and in motion, with and without torque, motor and
    friction, at each of ORBITS, over some steps or some hundred.
    """
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-3.0, 4.0)
    arms = random.uniform(0.1, 1.0, 3)
    R = rotation.matrix(rotation.normalise(random.normal(size=4)))
    inertia = size * R @ np.diag(np.sum(arms) - arms) @ R.T
    rotor, speed = Rotor(), (np.nan, np.nan)
    if seed % 3 == 0:
        J, axis = 0.01 * size, np.array([0.0, 0.6, 0.8])
        rotor = Rotor('motor', axis, inertia=J, friction=J * random.choice([0.0, 0.1]))
        speed = random.normal(), 0.0
    torque = size * random.normal(size=3) * 10.0 ** random.uniform(-6.0, -1.0)
    omega = random.normal(size=3) * random.choice([0.0, 1e-3, 0.1])
    system = System(
        inertia,
        (rotor,),
        ORBITS[seed % 4],
        torque_b=torque * (seed % 5 > 0),
        rotor_torque=np.array([rotor.inertia * random.normal() * (seed % 2)]),
    )
    fastest = np.linalg.norm(omega) + np.sqrt(np.linalg.norm(torque) / size)
    t_s = np.linspace(0.0, 10.0 ** random.uniform(-1.0, 2.0) / fastest, 200)
    tolerance = 10.0 ** -random.integers(8, 14)
    motion = Propagation(system, State(ANY, omega, *speed), 0.0, tolerance)
    states = motion.at(t_s)
    return motion, states, tolerance * (6.0 * motion.steps + 36.0)


def largest(system, states):
    """Return the largest drift of any integral."""
    return max(np.nanmax(np.abs(values)) for values in relative_drift(system, states).values())


@pytest.mark.parametrize('seed', range(60))
def test_the_drift_is_within_what_the_steps_may_do(seed):
    """From rest under a torque too, where energy and work begin at zero."""
    motion, states, allowed = flown(seed)
    assert largest(motion.system, states) < 0.3 * allowed


@pytest.mark.parametrize('seed', [1, 2, 3, 4, 6, 7, 8, 9, 11])
def test_what_is_not_true_drifts_further(seed):
    """A millionth of the inertia or the torque, and a push of a billionth on the way."""
    motion, states, _ = flown(seed)
    system, half = motion.system, len(states) // 2
    # As at the default tolerance.
    allowed = 1e-13 * (6.0 * motion.steps + 36.0)
    heavier = replace(system, inertia=(1.0 + 1e-6) * system.inertia)
    assert largest(heavier, states) > allowed
    stronger = replace(states, work=(1.0 + 1e-6) * states.work)
    assert largest(system, stronger) > allowed
    omega = states.omega_bi_b.copy()
    omega[half:] *= 1.0 + 1e-9
    assert largest(system, replace(states, omega_bi_b=omega)) > allowed

"""The first integrals of propagated motions against the values that the references give."""

import numpy as np
import pytest
from cases import newtonian

from satdyn_ros.dynamics import rotation
from satdyn_ros.dynamics.integrals import first_integrals, relative_drift
from satdyn_ros.dynamics.orbit import FixedDirection
from satdyn_ros.dynamics.propagator import Propagation
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System

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
    """An integral has the same bits alone and among many, which compiled code computes."""
    case = newtonian()[F2[0]]
    t_s = np.linspace(0.0, 100.0, rotation.MANY)
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

"""What turns as a satellite does, flown by its own equations beside the satellite."""

import numpy as np
import pytest
from scipy.constants import mu_0
from scipy.integrate import solve_ivp

from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact.equivalents import ChargedBody, ConductingFluid
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection

MOMENTS = np.array([1.0, 1.5, 2.2])
START = State(rotation.normalise([0.3, -0.2, 0.4, 1.0]), np.array([0.4, -0.3, 0.6]))
T_S = np.linspace(0.0, 12.0, 25)


def satellite(gradient):
    """Return the propagated states of the satellite in a fixed field."""
    system = System(np.diag(MOMENTS), orbit=FixedDirection(gradient))
    return Propagation(system, START).at(T_S)


def test_a_conducting_fluid_moves_as_a_satellite():
    """
    Ideal magnetohydrodynamics of a linear flow in an ellipsoid gives the satellite's rates and c.

    With velocity U r, field B r and total pressure -density r . P r / 2 the equations of motion
    and induction are U' = -U U + B B / (mu_0 density) + P and B' = U B - B U.  The symmetric P
    keeps the wall a wall: S^-1 U S without symmetric part.  Nothing here knows of moments.
    """
    gradient, density = 2.5, 13.6e3
    fluid = ConductingFluid.of_satellite(MOMENTS, density)
    S = fluid.semi_axes_m
    states = satellite(gradient)
    Omega, beta = fluid.flow(states.omega_bi_b[0], states.c_b[0], gradient)

    def rates(_, y):
        U, B = y.reshape(2, 3, 3)
        free = -U @ U + B @ B / (mu_0 * density)
        # S^-1 (free + P) S has no symmetric part: P_ij (S_j / S_i + S_i / S_j) = -...
        ratio = S / S[:, None]
        P = -(free * ratio + (free * ratio).T) / (ratio + ratio.T)
        return np.concatenate([(free + P).ravel(), (U @ B - B @ U).ravel()])

    start = np.concatenate([fluid.linear(Omega).ravel(), fluid.linear(beta).ravel()])
    flown = solve_ivp(rates, (0.0, T_S[-1]), start, 'DOP853', T_S, rtol=1e-12, atol=1e-13).y.T
    for (U, B), omega_bi_b, c_b in zip(
        flown.reshape(-1, 2, 3, 3), states.omega_bi_b, states.c_b, strict=True
    ):
        omega, c, same = fluid.satellite(fluid.vector(U), fluid.vector(B))
        # 1e-10 of either integration
        np.testing.assert_allclose(omega, omega_bi_b, atol=1e-9)
        np.testing.assert_allclose(c, c_b, atol=1e-9)
        assert same == pytest.approx(gradient, rel=1e-9)
    assert np.ptp(states.omega_bi_b, axis=0).min() > 0.1


def test_the_frozen_fluid_is_the_satellite():
    """Its moments, summed over the ellipsoid, are the satellite's; the flow is along the wall."""
    fluid = ConductingFluid.of_satellite(MOMENTS, 900.0)
    np.testing.assert_allclose(fluid.moments, MOMENTS, rtol=1e-14)
    # Points of the ellipsoid by quadrature: cosines and radii by Gauss, exact for squares.
    x, w = np.polynomial.legendre.leggauss(8)
    phi = np.arange(8) * np.pi / 4.0
    z, r, a = np.meshgrid(x, (x + 1.0) / 2.0, phi, indexing='ij')
    weights = (w[:, None, None] * (w / 2.0)[None, :, None] * r**2) * np.pi / 4.0
    s = np.sqrt(1.0 - z**2)
    positions = fluid.semi_axes_m * np.stack([r * s * np.cos(a), r * s * np.sin(a), r * z], -1)
    masses = 900.0 * np.prod(fluid.semi_axes_m) * weights
    squares = np.einsum('ijk,ijkl->l', masses, positions**2)
    np.testing.assert_allclose(np.sum(squares) - squares, MOMENTS, rtol=1e-13)
    wall = fluid.semi_axes_m * np.array([0.48, -0.6, 0.64])
    normal = wall / fluid.semi_axes_m**2
    across = normal @ fluid.linear(np.array([0.3, 0.7, -0.4])) @ wall
    assert across == pytest.approx(0.0, abs=1e-15)


def test_satellites_that_no_fluid_is_like():
    """A negative gradient, a flat body's moments, no field and no vessel are refused."""
    fluid = ConductingFluid.of_satellite(MOMENTS, 1.0)
    with pytest.raises(ValueError, match=r'gradient is -2\.5'):
        fluid.flow(START.omega_bi_b, np.array([0.0, 0.0, 1.0]), -2.5)
    with pytest.raises(ValueError, match='below the sum of the others'):
        ConductingFluid.of_satellite(np.array([1.0, 1.2, 2.2]), 1.0)
    with pytest.raises(ValueError, match='beta is zero'):
        fluid.satellite(START.omega_bi_b, np.zeros(3))
    with pytest.raises(ValueError, match='all must be positive'):
        ConductingFluid(np.array([1.0, 0.0, 2.0]), 1.0)


@pytest.mark.parametrize(('gradient', 'slope', 's'), [(2.5, 40.0, 0.7), (-2.5, 40.0, 0.0)])
def test_a_charged_body_turns_as_a_satellite(gradient, slope, s):
    """
    Six point charges pulled by the field, each by its own force, turn the body as the satellite.

    On each axis a pair of charges whose moments are those of the map; the map back gives the
    satellite again.
    """
    body = ChargedBody.of_satellite(MOMENTS, gradient, slope, s)
    again, same = body.satellite(slope)
    np.testing.assert_allclose(again, MOMENTS, rtol=0.0)
    assert same == pytest.approx(gradient, rel=1e-12)
    charges = np.repeat((np.sum(body.charge_moments) / 2.0 - body.charge_moments) / 2.0, 2)
    positions = np.repeat(np.eye(3), 2, axis=0) * np.tile([1.0, -1.0], 3)[:, None]

    def rates(_, y):
        omega, c = y[:3], y[3:]
        field = slope * ((positions @ c)[:, None] * c - positions / 3.0)
        torque = np.sum(np.cross(positions, charges[:, None] * field), axis=0)
        omega_dot = (torque - np.cross(omega, MOMENTS * omega)) / MOMENTS
        return [*omega_dot, *np.cross(c, omega)]

    states = satellite(gradient)
    start = [*states.omega_bi_b[0], *states.c_b[0]]
    flown = solve_ivp(rates, (0.0, T_S[-1]), start, 'DOP853', T_S, rtol=1e-12, atol=1e-13).y.T
    np.testing.assert_allclose(flown[:, :3], states.omega_bi_b, atol=1e-9)
    np.testing.assert_allclose(flown[:, 3:], states.c_b, atol=1e-9)


def test_charges_that_no_satellite_is_like():
    """Charge moments that are not linear in those of the mass, and no field."""
    with pytest.raises(ValueError, match='not linear'):
        ChargedBody(MOMENTS, np.array([1.0, 2.0, 2.1])).satellite(1.0)
    with pytest.raises(ValueError, match='slope is 0'):
        ChargedBody.of_satellite(MOMENTS, 1.0, 0.0)

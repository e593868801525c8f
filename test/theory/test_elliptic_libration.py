"""The forced libration on an ellipse, against flight and against Beletsky's equation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.theory.elliptic_libration import elliptic_librations

X, Y, Z = np.eye(3)


def pitch(states, orbit):
    """Return the angle [rad] from the line of the centre to body axis 1, about the normal."""
    axis = rotation.rotate(states.q_ib, X)
    up = orbit.direction(states.t_s)
    return np.arctan2(np.sum(np.cross(up, axis) * orbit.normal, axis=-1), np.sum(up * axis, -1))


@pytest.mark.parametrize(
    ('I_t', 'e'), [(700.0, 0.02), (1100.0, 0.01), (1300.0, 0.05), (620.0, 0.05)]
)
def test_a_satellite_sways_by_the_forced_amplitude(I_t, e):
    """
    Released on the forced solution at the pericentre it stays on it, below and above resonance.

    Propagated in three dimensions for five orbits.  The next order, in the solution and in what
    the rate of the start sets free, is a few times e of the first, besides the cubic term.
    """
    orbit = KeplerOrbit(eccentricity=e)
    system = System(np.diag([600.0, I_t, 900.0]), orbit=orbit)
    rate = np.sqrt(orbit.mu * orbit.semi_latus_rectum) / orbit.radius(0.0) ** 2
    p = 3.0 * (I_t - 600.0) / 900.0
    slope = 2.0 * e / (p - 1.0)
    start = State(rotation.IDENTITY, (1.0 + slope) * rate * Z)
    (found,) = [
        each for each in elliptic_librations(system, start) if abs(each.normal_b @ Z) == 1.0
    ]
    assert found.p == pytest.approx(p, rel=1e-14)
    assert found.amplitude_rad == pytest.approx(abs(slope), rel=1e-13)
    t_s = np.linspace(0.0, 5.0 * 2.0 * np.pi / orbit.mean_motion, 2001)
    theta = pitch(Propagation(system, start).at(t_s), orbit)
    forced = slope * np.sin(orbit.anomaly(t_s))
    missed = 4.5 * e + 3.0 * p * slope**2 / (2.0 * abs(p - 1.0))
    assert np.max(np.abs(theta - forced)) < missed * abs(slope)


@pytest.mark.parametrize('e', [0.001, 0.01, 0.05, 0.1])
def test_the_amplitude_is_within_a_twentieth(e):
    """Wherever it is given, it is that of the periodic solution of Beletsky's equation to 5 %."""
    given = 0
    for p in (0.1, 0.5, 0.8, 0.95, 1.05, 1.5, 2.0, 2.5, 2.9):
        system = System(
            np.diag([600.0, 600.0 + 300.0 * p, 900.0]), orbit=KeplerOrbit(eccentricity=e)
        )
        start = State(rotation.IDENTITY, Z)
        amplitude = next(
            each.amplitude_rad
            for each in elliptic_librations(system, start)
            if abs(each.normal_b @ Z) == 1.0
        )
        if amplitude is None:
            continue
        given += 1

        def flown(slope, p=p):
            def rates(f, y):
                pull = p * np.sin(y[0]) * np.cos(y[0])
                return [y[1], (2.0 * e * np.sin(f) * (y[1] + 1.0) - pull) / (1.0 + e * np.cos(f))]

            f = np.linspace(0.0, np.pi, 201)
            return solve_ivp(rates, (0.0, np.pi), [0.0, slope], 'DOP853', f, rtol=1e-9).y[0]

        # odd and periodic: zero at the apocentre
        near = 2.0 * e / (p - 1.0)
        slope = brentq(lambda slope: flown(slope)[-1], 0.7 * near, 1.3 * near)
        assert np.max(np.abs(flown(slope))) == pytest.approx(amplitude, rel=0.05)
    assert given >= 2


def test_which_axes_may_be_the_normal():
    """All of a rigid body, that of the rotor alone, none of a driven body or on a circle."""
    inertia, start = np.diag([600.0, 800.0, 900.0]), State(rotation.IDENTITY, Z)
    ellipse = KeplerOrbit(eccentricity=0.05)
    found = elliptic_librations(System(inertia, orbit=ellipse), start)
    moments = [np.diagonal(inertia) @ np.abs(each.normal_b) for each in found]
    assert sorted(moments) == [600.0, 800.0, 900.0]
    wheel = Rotor('constant_momentum', Y, momentum=5.0)
    found = elliptic_librations(System(inertia, (wheel,), ellipse), start)
    assert [np.abs(each.normal_b).tolist() for each in found] == [[0.0, 1.0, 0.0]]
    assert found[0].p == pytest.approx(3.0 * 300.0 / 800.0)
    assert elliptic_librations(System(inertia, orbit=KeplerOrbit()), start) == []
    driven = System(inertia, orbit=ellipse, torque_b=1e-6 * X)
    assert elliptic_librations(driven, start) == []


def test_near_resonance_there_is_no_small_amplitude():
    """At p = 1 and beside it the first order says nothing."""
    for I_t in (900.0, 905.0):
        system = System(np.diag([600.0, I_t, 900.0]), orbit=KeplerOrbit(eccentricity=0.01))
        start = State(rotation.IDENTITY, Z)
        amplitudes = [
            each.amplitude_rad
            for each in elliptic_librations(system, start)
            if each.p == pytest.approx((I_t - 600.0) / 300.0)
        ]
        assert None in amplitudes

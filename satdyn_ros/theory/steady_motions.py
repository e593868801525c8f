"""
The steady motions of a system: where each lies and whether it is stable.

Without a field the permanent rotations at the rate of a state; in a field of fixed direction the
rotations at that rate about it, or rest; on a circular orbit the relative equilibria.  All have
the rotor momenta of the state.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..dynamics.system import State, System
from ..kernel import rotation
from .equilibria import direction, permanent_rotations, vertical_axes
from .gyrostat_equilibria import gyrostat_equilibria
from .precession import feels_field, symmetry_axis
from .stability import eigenvalue_squared
from .verdicts import Verdict, small_motion_roots, verdict

# A root, or its real part, below this share of the fastest root counts as zero.
_NO_SHARE = 1e-5


class SteadyMotion(NamedTuple):
    """
    A steady motion, the verdict on it, and the periods of small motion about it.

    Attributes
    ----------
    state : State
        a state of it
    axis_b : (3,), body axes
        unit: that of a permanent rotation, the field's direction, or, on an orbit, the direction
        up
    verdict : Verdict
        on its stability
    periods_s : (M,), s
        of the oscillations of the linear equations, longest first
    """

    state: State
    axis_b: np.ndarray
    verdict: Verdict
    periods_s: np.ndarray


def steady_motions(system: System, state: State, orbit_s: float = 0.0) -> list[SteadyMotion]:
    """
    Return the steady motions of a system with the rotor momenta of a state.

    The principal axes represent a circle of them, where equal moments give one.  There are none on
    an elliptic orbit, and none without a field for a body at rest.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state
    orbit_s : s
        time from the instant of the orbit's elements

    Examples
    --------
    >>> [motion.verdict.stability for motion in steady_motions(system, state)]  # doctest: +SKIP
    ['stable', 'stable', 'unstable', 'unstable', 'stable', 'stable']
    """
    found = []
    for q_ib, omega, axis_b in _attitudes(system, state, orbit_s):
        there = _at(system, state, q_ib, omega)
        roots = _roots(system, there, orbit_s)
        found.append(SteadyMotion(there, axis_b, verdict(system, there, orbit_s), _periods(roots)))
    return found


def _attitudes(system, state, orbit_s):
    """Yield attitude, rate and axis of each steady motion."""
    K, h, orbit = system.carrier_inertia, system.rotor_momentum(state), system.orbit
    rate = float(np.linalg.norm(state.omega_bi_b))
    if not feels_field(system):
        for omega in permanent_rotations(K, rate, h) if rate else ():
            yield state.q_ib, omega, omega / rate
    elif not orbit.has_lvlh:
        down = state.omega_bi_b @ direction(system, state, orbit_s) < 0.0
        W, gradient = -rate if down else rate, float(orbit.gradient_at(orbit_s))
        for c in vertical_axes(system.inertia, K, W, gradient, system.weight_moment, h):
            yield rotation.conjugate(rotation.from_z_to(c)), W * c, c
    elif orbit.is_keplerian and not orbit.is_eccentric:
        axis = symmetry_axis(system, state)
        rate_i, up_l = orbit.lvlh_rate(orbit_s), np.array([0.0, 0.0, -1.0])
        for q_lb in gyrostat_equilibria(system.inertia, K, h, orbit.mean_motion, axis):
            q_ib = rotation.multiply(orbit.lvlh(orbit_s), q_lb)
            omega = rotation.rotate(rotation.conjugate(q_ib), rate_i)
            yield q_ib, omega, rotation.rotate(rotation.conjugate(q_lb), up_l)


def _at(system, state, q_ib, omega):
    """Return the state with the rotor momenta of another at this attitude and rate."""
    speeds = [
        rotor.speed(rotor.axial_momentum(speed, state.omega_bi_b), omega)
        for rotor, speed in zip(system.rotors, system.rotor_speeds(state), strict=True)
    ]
    return replace(state, q_ib=q_ib, omega_bi_b=omega, rotor_speed=np.array(speeds))


def _roots(system, state, orbit_s):
    """Return the eigenvalues [1/s] of small motion about a steady one."""
    if feels_field(system):
        return small_motion_roots(system, state, orbit_s)
    square = eigenvalue_squared(
        system.carrier_inertia, state.omega_bi_b, system.rotor_momentum(state)
    )
    return np.sqrt(np.array([square], complex))


def _periods(roots):
    """Return the periods [s] of the roots that oscillate."""
    fastest = np.max(np.abs(roots))
    swings = (roots.imag > _NO_SHARE * fastest) & (np.abs(roots.real) <= _NO_SHARE * fastest)
    return 2.0 * np.pi / np.sort(roots.imag[swings])

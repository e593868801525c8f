"""How far an exact motion may differ from a propagation, and whether it does."""

import numpy as np
from hypothesis import assume

from satdyn_ros.dynamics.system import State
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation

# Finer than the default: what is compared must not be the propagation's own error.
TOLERANCE = 3e-15
PERTURBATION = 1e-9
# Whatever two axes an instability couples, one of these is not on its decaying side.
ASIDE = np.array([[0.36, 0.48, 0.8], [0.36, -0.48, 0.8], [0.36, 0.48, -0.8]])


def assert_agrees(motion, t_s, rate_scale):
    """
    Assert that a motion agrees with a propagation at t_s (N,) within 1e-9 + 1e-14 G rad.

    G: how much twin propagations, started 1e-9 rad and 1e-9 of the rate_scale [rad/s] away, have
    grown apart by then: rounding of the start grows alike.  Checked up to G = 1e8, and where
    propagations of two tolerances agree better than what is asked of the motion.
    """
    system, start, start_s = motion.system, motion.state, motion.start_s
    truth = Propagation(system, start, start_s, TOLERANCE).at(t_s)
    coarse = Propagation(system, start, start_s, 10.0 * TOLERANCE).at(t_s)
    twins = (Propagation(system, _moved(start, aside, rate_scale), start_s) for aside in ASIDE)
    growth = max(_apart(twin.at(t_s), truth) for twin in twins) / PERTURBATION
    bound = 1e-9 + 1e-14 * growth
    states = motion.at(t_s)
    assert np.all(np.isfinite(states.q_ib))
    assert np.all(np.isfinite(states.omega_bi_b))
    assume(growth <= 1e8 and _apart(coarse, truth) <= 0.3 * bound)
    assert _apart(states, truth) <= bound
    assert np.max(np.abs(states.omega_bi_b - truth.omega_bi_b)) <= 10.0 * bound * rate_scale
    # quaternions of one sign: neither jumps where the other does not
    assert np.all(np.sum(states.q_ib * truth.q_ib, axis=-1) > 0.0)
    if system.has_turning_rotor:
        assert np.max(np.abs(states.rotor_angle - truth.rotor_angle)) <= 10.0 * bound


def _moved(start, aside, rate_scale):
    """Return the state slightly perturbed."""
    small = PERTURBATION * aside
    turn = rotation.normalise([*small / 2.0, 1.0])
    return State(
        rotation.multiply(start.q_ib, turn),
        start.omega_bi_b + rate_scale * small,
        start.rotor_speed,
        start.rotor_angle,
    )


def _apart(states, truth):
    """Return the largest angle between the attitudes [rad]."""
    return np.max(rotation.angle_between(states.q_ib, truth.q_ib))

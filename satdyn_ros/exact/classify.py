"""
The theorem of Balli and Grioli: which gyrostats on a circular orbit rotate about a body axis.

A symmetric gyrostat with constant rotor momentum turns about an axis fixed in it either uniformly
(steady.py) or, with the axis a principal one along the orbit normal and the rotor along it, in
the plane of the orbit (planar.py); there are no other rotations (Balli and Grioli 1979).
"""

from typing import NamedTuple

import numpy as np

from ..dynamics.inertia import ROUNDING, symmetry_axis
from ..dynamics.motion import Motion
from ..dynamics.system import State, System
from ..integrate.propagation import Propagation
from ..theory.equilibria import imbalance
from .planar import Planar
from .steady import Steady

# How far the axis of a propagated rotation may seem to wander over an orbit.
_WANDER = 1e-9


class RotationClass(NamedTuple):
    """Whether a motion is a rotation about a body-fixed axis, whether it is uniform, and why."""

    is_rotation: bool
    is_uniform: bool
    why: str


def rotation_class(system: System, state: State, start_s: float = 0.0) -> RotationClass:
    """
    Return the class of the motion that starts in a state on a circular orbit.

    For a symmetric body, or a known rotation, it is that of the theorem.  For others the axis is
    followed, at the start and over one orbit.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state at start_s
    start_s : s
        time from tick 0

    Raises
    ------
    ValueError
        the orbit is not circular, or a torque is applied

    Examples
    --------
    >>> rotation_class(system, state).why  # doctest: +SKIP
    'the rotor is not along the orbit normal'
    """
    orbit = system.orbit
    if not (orbit.is_keplerian and not orbit.is_eccentric):
        raise ValueError(
            'rotations are classified on circular orbits: orbit.type must be circular'
        )
    if not system.is_newtonian or np.any(system.weight_moment):
        raise ValueError('rotations are classified without an applied torque or weight')
    if Steady.why_not(system, state, start_s) is None:
        return RotationClass(True, True, 'the torque balances the turn of the angular momentum')
    not_planar = Planar.why_not(system, state)
    if not_planar is None:
        why = 'the body swings or tumbles about the orbit normal, a principal axis'
        return RotationClass(True, False, why)
    volterra = not system.has_turning_rotor
    if volterra and _is_spherical(system.inertia):
        why = 'the rotor of a spherical body is not along the axis of rotation'
        return RotationClass(False, False, why)
    if volterra and symmetry_axis([system.inertia]) is not None:
        return RotationClass(False, False, not_planar)
    return _watched(system, state, start_s, not_planar)


def axis_wander(motion: Motion, t_s: np.ndarray) -> float:
    """
    Return how far the axis of rotation leaves a body-fixed line: a sine, 0 to 1.

    It is the largest part of omega across its direction where it is largest, relative to its size
    there.

    Parameters
    ----------
    motion : Motion
        the motion
    t_s : (N,), s
        the times at which the axis is compared
    """
    omega = motion.at(t_s).omega_bi_b
    rates = np.linalg.norm(omega, axis=-1)
    largest = np.argmax(rates)
    if rates[largest] == 0.0:
        return 0.0
    across = np.cross(omega, omega[largest] / rates[largest])
    return float(np.max(np.linalg.norm(across, axis=-1)) / rates[largest])


def _watched(system, state, start_s, not_planar):
    """Return the class by watching the axis, for a body that the theorem does not cover."""
    omega, n = state.omega_bi_b, system.orbit.mean_motion
    omega_dot = np.linalg.solve(system.carrier_inertia, imbalance(system, state, start_s))
    drift = np.linalg.norm(np.cross(omega, omega_dot))
    if drift > _WANDER * (omega @ omega) * n:
        return RotationClass(False, False, not_planar)
    orbit_s = np.linspace(0.0, 2.0 * np.pi / n, 1000)
    motion = Propagation(system, state, start_s)
    if axis_wander(motion, orbit_s) > _WANDER:
        return RotationClass(False, False, not_planar)
    return RotationClass(True, False, 'the axis stays in the body over one orbit')


def _is_spherical(inertia):
    return np.max(np.abs(inertia - inertia[0, 0] * np.eye(3))) <= ROUNDING * inertia[0, 0]

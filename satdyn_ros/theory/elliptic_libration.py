"""
Planar libration on an elliptic orbit: Beletsky's equation and its forced solution.

In the plane of the orbit the angle theta from the line of the centre to the principal axis of the
smaller moment in that plane obeys, in the true anomaly f,

    (1 + e cos f) theta'' - 2 e sin f (theta' + 1) + p sin theta cos theta = 0,

p = 3 (I_t - I_r) / I_n.  There is no equilibrium, as 2 e sin f is none of p sin theta cos theta;
what takes its place is the solution of the period of the orbit, to first order in e

    theta = 2 e / (p - 1) sin f.
"""

from typing import NamedTuple

import numpy as np

from ..dynamics.inertia import ROUNDING, are_parallel, principal_axes
from ..dynamics.system import State, System

# Where the first order misses more of the amplitude than this share, it says too little.
_SMALL = 0.05


class EllipticLibration(NamedTuple):
    """
    The libration about one principal axis, held along the orbit normal.

    Attributes
    ----------
    normal_b : (3,), body axes
        the axis
    p : float
        of Beletsky's equation, 0 to 3 for a rigid body
    amplitude_rad : rad or None
        of the forced libration, 2 e / |p - 1|; None where the next orders are more than a
        twentieth of it: near the resonance p = 1 and for large e
    """

    normal_b: np.ndarray
    p: float
    amplitude_rad: float | None


def elliptic_librations(system: System, state: State) -> list[EllipticLibration]:
    """
    Return the planar librations that a system has on its elliptic orbit.

    There is one about each principal axis along which the momentum of the rotors is.  There are
    none where a torque, a motor or friction acts, and none on a circle or in a fixed field.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state, for the momenta of the rotors
    """
    orbit = system.orbit
    if not orbit.is_keplerian or not orbit.is_eccentric or not system.is_newtonian:
        return []
    found = []
    carrier, momentum = system.carrier_inertia, system.rotor_momentum(state)
    moments, R_bp = principal_axes(system.inertia)
    for k, axis in enumerate(R_bp.T):
        across = np.cross(axis, carrier @ axis)
        if not are_parallel(momentum, axis) or np.max(np.abs(across)) > ROUNDING * moments[-1]:
            continue
        p = 3.0 * abs(moments[k - 1] - moments[k - 2]) / float(axis @ carrier @ axis)
        found.append(EllipticLibration(axis, float(p), _amplitude(p, orbit.eccentricity)))
    return found


def _amplitude(p, e):
    """
    Return the forced amplitude [rad], or None where it is not small.

    The share that it misses is p a^2 / (2 |p - 1|), the cubic term of the sine, and of order e^2.
    """
    if p == 1.0:
        return None
    a = 2.0 * e / abs(p - 1.0)
    missed = p * a * a / (2.0 * abs(p - 1.0)) + 4.0 * e * e
    return float(a) if missed <= _SMALL else None

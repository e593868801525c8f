"""
All attitudes at which a gyrostat rests on a circular orbit.

With the orbit's rate n and normal k, and c from the attracting centre,

    k x (n K k + h) = 3 n c x I c:

a rigid body of three different moments has 24 such attitudes (equilibria.relative_equilibria), a
gyrostat between 4 and 24.  There is no formula for a rotor that is along no principal axis, so
they are found by Newton's method from attitudes spread over all orientations.
"""

import numpy as np

from ..dynamics.inertia import ROUNDING
from ..kernel import rotation
from .stability import cross_matrices

_STARTS, _NEWTON_STEPS, _LONGEST_STEP_RAD = 1000, 40, 0.3
# Results of Newton's method closer together than this count as one.
_SAME_RAD = 1e-5


def gyrostat_equilibria(
    inertia: np.ndarray,
    carrier: np.ndarray,
    h: np.ndarray,
    orbital_rate: float,
    axis: np.ndarray | None = None,
) -> np.ndarray:
    """
    Return the attitudes q_lb (M, 4), body to LVLH, at which a gyrostat rests on a circular orbit.

    Those nearest to LVLH come first.

    Parameters
    ----------
    inertia : (3, 3), kg m^2, body axes
        I, on which the field acts
    carrier : (3, 3), kg m^2, body axes
        K, which turns with the rate
    h : (3,), N m s, body axes
        rotor momentum
    orbital_rate : rad/s
        n
    axis : (3,), body axes, or None
        of symmetry of all three; then one attitude represents all that differ by a turn about it
    """
    n = orbital_rate
    q_lb, arrived = _spread(_STARTS), []
    for _ in range(_NEWTON_STEPS):
        torque, slope, sizes = _torque_and_slope(q_lb, inertia, carrier, h, n)
        balanced = np.linalg.norm(torque, axis=-1) <= ROUNDING * sizes
        # One more step brings it to the last digits.
        step = -(np.linalg.pinv(slope, rcond=1e-9) @ torque[..., None])[..., 0]
        length = np.linalg.norm(step, axis=-1, keepdims=True)
        step *= _LONGEST_STEP_RAD / np.maximum(length, _LONGEST_STEP_RAD)
        turn = np.concatenate([step / 2.0, np.ones_like(length)], axis=-1)
        q_lb = rotation.normalise(rotation.multiply(q_lb, turn))
        arrived.append(q_lb[balanced])
        q_lb = q_lb[~balanced]
    return _different(np.concatenate(arrived), axis)


def _different(q_lb, axis):
    """Return one attitude of each cluster, nearest to LVLH first."""
    left = q_lb[np.argsort(rotation.angle_between(rotation.IDENTITY, q_lb), kind='stable')]
    found = []
    while len(left):
        found.append(left[0])
        if axis is None:
            gaps = rotation.angle_between(left[0], left)
        else:
            pointing = rotation.rotate(left, axis)
            gaps = np.linalg.norm(pointing - pointing[0], axis=-1)
        left = left[gaps > _SAME_RAD]
    return np.array(found).reshape(-1, 4)


def _torque_and_slope(q_lb, inertia, carrier, h, n):
    """Return n k x (n K k + h) - 3 n^2 c x I c, its change with turns of the body, its terms."""
    down, against_normal = np.eye(3)[2], np.eye(3)[1]
    to_body = rotation.conjugate(q_lb)
    c, k = -rotation.rotate(to_body, down), -rotation.rotate(to_body, against_normal)
    H, Ic = n * k @ carrier + h, c @ inertia
    torque = n * np.cross(k, H) - 3.0 * n * n * np.cross(c, Ic)
    # a turn x of the body changes c by c x x
    C, N = cross_matrices(c), cross_matrices(k)
    slope = n * (n * N @ carrier - cross_matrices(H)) @ N
    slope -= 3.0 * n * n * (C @ inertia - cross_matrices(Ic)) @ C
    sizes = n * np.linalg.norm(H, axis=-1) + 3.0 * n * n * np.max(np.abs(inertia))
    return torque, slope, sizes


def _spread(count):
    """Return quaternions (count, 4) spread evenly over all orientations (Alexa 2022)."""
    phi, psi = np.sqrt(2.0), 1.533751168755204288118041
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1.0 - s / count)
    alpha, beta = 2.0 * np.pi * s / phi, 2.0 * np.pi * s / psi
    parts = [inner * np.sin(alpha), inner * np.cos(alpha), outer * np.sin(beta)]
    return np.stack([*parts, outer * np.cos(beta)], axis=-1)

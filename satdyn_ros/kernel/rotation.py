"""
Attitude kinematics: Hamilton quaternions (x, y, z, w), direction cosines, roll, pitch, yaw.

``q_ab`` turns components in frame b into components in frame a: ``v_a = q_ab v_b q_ab*``, and
``q_ac = q_ab q_bc``.  Every function works on the last axis, so arrays of quaternions are shape
(..., 4) and arrays of vectors (..., 3).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import vector
from .rows import components, from_components

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])


def multiply(q: ArrayLike, p: ArrayLike) -> np.ndarray:
    """
    Return the Hamilton product q p, shape (..., 4); i j = k.

    >>> multiply([1, 0, 0, 0], [0, 1, 0, 0])
    array([0., 0., 1., 0.])
    """
    return _of_rows(vector.product, q, p)


def conjugate(q: ArrayLike) -> np.ndarray:
    """Return q*, the inverse of a unit quaternion, shape (..., 4)."""
    return np.asarray(q, float) * np.array([-1.0, -1.0, -1.0, 1.0])


def normalise(q: ArrayLike) -> np.ndarray:
    """Return q / |q|, shape (..., 4)."""
    q = np.asarray(q, float)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def rotate(q_ab: ArrayLike, v_b: ArrayLike) -> np.ndarray:
    """Return v_a = q_ab v_b q_ab*, shape (..., 3)."""
    return _of_rows(vector.rotate, q_ab, v_b)


def _of_rows(of_components, a, b):
    """Apply a function of components to rows (..., k), which broadcast."""
    return from_components(of_components(components(a), components(b)))


def matrix(q_ab: ArrayLike) -> np.ndarray:
    """Return the direction cosines R with v_a = R v_b, shape (..., 3, 3)."""
    x, y, z, w = components(q_ab)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(R: ArrayLike) -> np.ndarray:
    """
    Return the quaternion of the direction cosines R (..., 3, 3), shape (..., 4).

    Shepperd 1978: each row divides by the largest of |x|, |y|, |z|, |w|; w >= 0 is not imposed.
    """
    R = np.asarray(R, float)
    trace = np.trace(R, axis1=-2, axis2=-1)
    four_squares = 1.0 + np.stack([2.0 * R[..., k, k] - trace for k in range(3)] + [trace], -1)
    xx, yy, zz, ww = np.moveaxis(four_squares, -1, 0)
    xy, zw = R[..., 1, 0] + R[..., 0, 1], R[..., 1, 0] - R[..., 0, 1]
    zx, yw = R[..., 0, 2] + R[..., 2, 0], R[..., 0, 2] - R[..., 2, 0]
    yz, xw = R[..., 2, 1] + R[..., 1, 2], R[..., 2, 1] - R[..., 1, 2]
    rows = np.stack(
        [
            np.stack([xx, xy, zx, xw], -1),
            np.stack([xy, yy, yz, yw], -1),
            np.stack([zx, yz, zz, zw], -1),
            np.stack([xw, yw, zw, ww], -1),
        ],
        axis=-2,
    )
    largest = np.argmax(four_squares, axis=-1)[..., None, None]
    return normalise(np.take_along_axis(rows, largest, axis=-2)[..., 0, :])


def about(axis: ArrayLike, angle_rad: ArrayLike) -> np.ndarray:
    """
    Return the rotation by angle_rad (...) about a unit axis (..., 3), shape (..., 4).

    >>> about([0, 0, 1], np.pi)
    array([0.000000e+00, 0.000000e+00, 1.000000e+00, 6.123234e-17])
    """
    half = np.asarray(angle_rad, float)[..., None] / 2.0
    along = np.asarray(axis, float) * np.sin(half)
    q = np.empty((*along.shape[:-1], 4))
    q[..., :3], q[..., 3:] = along, np.cos(half)
    return q


def from_vector(vector_rad: ArrayLike) -> np.ndarray:
    """
    Return the rotation by |v| about v, for rotation vectors v [rad] (..., 3), shape (..., 4).

    >>> from_vector([0, 0, np.pi])
    array([0.000000e+00, 0.000000e+00, 1.000000e+00, 6.123234e-17])
    """
    half = np.asarray(vector_rad, float) / 2.0
    angle = np.linalg.norm(half, axis=-1, keepdims=True)
    # np.sinc(x) is sin(pi x) / (pi x).
    return np.concatenate([half * np.sinc(angle / np.pi), np.cos(angle)], axis=-1)


def to_vector(q: ArrayLike) -> np.ndarray:
    """
    Return the rotation vector of q, at most half a turn long [rad], shape (..., 3).

    >>> to_vector([0, 0, 1, 0])
    array([0.        , 0.        , 3.14159265])
    """
    q = np.asarray(q, float)
    sine, cosine = np.linalg.norm(q[..., :3], axis=-1, keepdims=True), np.abs(q[..., 3:])
    # The angle over its half's sine tends to 2 where there is no rotation.
    per_sine = np.divide(
        2.0 * np.arctan2(sine, cosine), sine, out=np.full_like(sine, 2.0), where=sine > 0.0
    )
    return q[..., :3] * np.where(q[..., 3:] < 0.0, -per_sine, per_sine)


def from_z_to(direction: np.ndarray | Sequence[float]) -> np.ndarray:
    """
    Return the rotation that takes z to the unit vector direction (3,), shape (4,).

    The shortest, or for z < 0 the shortest from -z after half a turn about x.
    """
    x, y, z = direction
    if z >= 0.0:
        return normalise([-y, x, 0.0, 1.0 + z])
    return multiply(normalise([y, -x, 0.0, 1.0 - z]), [1.0, 0.0, 0.0, 0.0])


def angle_between(q: ArrayLike, p: ArrayLike) -> np.ndarray:
    """Return the angle of the rotation from q to p, 0 to pi [rad], shape (...)."""
    d = multiply(conjugate(q), p)
    return 2.0 * np.arctan2(np.linalg.norm(d[..., :3], axis=-1), np.abs(d[..., 3]))


def continuous(q: ArrayLike) -> np.ndarray:
    """Return the quaternions q (N, 4) with the signs that make the sequence continuous."""
    q = np.asarray(q, float)
    turns = np.sum(q[1:] * q[:-1], axis=-1) < 0.0
    signs = np.concatenate([[1.0], np.where(np.cumsum(turns) % 2, -1.0, 1.0)])
    return q * signs[:, None]


def roll_pitch_yaw(q_ab: ArrayLike) -> np.ndarray:
    """
    Return the 3-2-1 angles of frame b relative to frame a [rad], shape (..., 3).

    R_ab = Rz(yaw) Ry(pitch) Rx(roll); roll is 0 where the pitch is +-pi/2.

    >>> roll_pitch_yaw(about([0, 0, 1], 0.5))
    array([0. , 0. , 0.5])
    """
    x, y, z, w = components(q_ab)
    # With the half angle h = pitch / 2: (cos h - sin h) exp(i (yaw + roll) / 2), and
    # (cos h + sin h) exp(i (yaw - roll) / 2); one of them is zero where the pitch is +-pi/2.
    minus, plus = np.hypot(w - y, x + z), np.hypot(w + y, z - x)
    half_sum, half_difference = np.arctan2(x + z, w - y), np.arctan2(z - x, w + y)
    half_sum, half_difference = (
        np.where(minus > 1e-12, half_sum, half_difference),
        np.where(plus > 1e-12, half_difference, half_sum),
    )
    pitch = np.pi / 2.0 - 2.0 * np.arctan2(minus, plus)
    roll, yaw = wrap(half_sum - half_difference), wrap(half_sum + half_difference)
    return np.stack([roll, pitch, yaw], axis=-1)


def from_roll_pitch_yaw(
    roll_rad: ArrayLike, pitch_rad: ArrayLike, yaw_rad: ArrayLike
) -> np.ndarray:
    """Return the quaternion of Rz(yaw) Ry(pitch) Rx(roll), shape (..., 4)."""
    return multiply(
        about([0, 0, 1], yaw_rad),
        multiply(about([0, 1, 0], pitch_rad), about([1, 0, 0], roll_rad)),
    )


def wrap(angle_rad: float | np.ndarray) -> np.ndarray:
    """Return the angle between -pi and pi, shape (...)."""
    return angle_rad - 2.0 * np.pi * np.round(angle_rad / (2.0 * np.pi))

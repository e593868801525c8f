"""Which axes of a body a closed form counts from: the symmetry axis, a principal axis as third."""

import numpy as np

from ..dynamics import rotation
from ..dynamics.inertia import principal_axes

# Relative difference of moments, and sine of an angle, that counts as rounding of the input.
ROUNDING = 1e-12


def parallel(a, b) -> bool:
    """Whether the vectors a and b (3,) are parallel, opposite, or one of them is zero."""
    return bool(np.linalg.norm(np.cross(a, b)) <= ROUNDING * np.linalg.norm(a) * np.linalg.norm(b))


def is_principal(inertia, axis) -> bool:
    """Whether the unit vector axis (3,) is a principal axis of inertia (3, 3)."""
    return bool(np.linalg.norm(np.cross(axis, inertia @ axis)) <= ROUNDING * np.max(inertia))


def is_symmetric(inertia, axis) -> bool:
    """Whether axis (3,) is principal and the two moments across it are equal."""
    if not is_principal(inertia, axis):
        return False
    (first, second, _), _ = principal_axes_about(axis, inertia)
    return bool(first == second)


def symmetry_axis(inertia) -> np.ndarray | None:
    """Return the unit axis (3,) whose moment is apart from two equal ones, None without one."""
    moments, R_bp = principal_axes(inertia)
    apart = [abs(moments[k - 1] - moments[k - 2]) > ROUNDING * np.max(moments) for k in range(3)]
    return R_bp[:, apart.index(False)] if sum(apart) == 2 else None


def principal_axes_about(axis, inertia) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the principal moments (3,) and R_bp (3, 3) whose third column is along +- axis.

    axis: a principal axis of inertia, unit.  The first two columns turn least from body axes; for
    axis along a body axis the columns are body axes in cyclic order.
    """
    k = np.argmax(np.abs(axis))
    axis = axis * np.sign(axis[k])
    # The shortest turn from body axis k.
    turn = rotation.normalise(np.append(np.cross(np.eye(3)[k], axis), 1.0 + axis[k]))
    R = rotation.matrix(turn)[:, [k - 2, k - 1, k]]
    block = R.T @ inertia @ R
    difference, product = block[0, 0] - block[1, 1], block[0, 1]
    if np.hypot(difference, 2.0 * product) <= ROUNDING * np.max(block):
        mean = (block[0, 0] + block[1, 1]) / 2.0
        return np.array([mean, mean, block[2, 2]]), R
    angle = np.arctan2(2.0 * product, difference) / 2.0
    angle -= np.pi / 2.0 * np.rint(angle / (np.pi / 2.0))
    c, s = np.cos(angle), np.sin(angle)
    R = R @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.diagonal(R.T @ inertia @ R).copy(), R

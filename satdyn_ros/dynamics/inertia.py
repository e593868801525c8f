"""The inertia tensor: validation, principal axes, parallel axis, and a catalogue of shapes."""

from itertools import permutations

import numpy as np

from . import rotation

# Rounding of a tensor that came through a rotation or from 15 printed digits; moments that differ
# by less have no principal axes of their own.
_ROUNDING = 1e-13


def tensor(values) -> np.ndarray:
    """
    Return the inertia tensor (3, 3) [kg m^2] of 3, 6 or 9 numbers, validated.

    values: the principal moments; or ixx iyy izz ixy ixz iyz, the entries of the tensor (products
    with the sign they have in the matrix); or its rows.  ValueError: not an inertia of a body.

    >>> tensor([600, 800, 900]).diagonal()
    array([600., 800., 900.])
    """
    numbers = np.ravel(np.asarray(values, float))
    given = f'body.inertia is [{", ".join(f"{x:g}" for x in numbers)}]'
    if len(numbers) not in (3, 6, 9):
        raise ValueError(
            f'{given}; it takes 3 principal moments, the 6 entries ixx iyy izz ixy ixz iyz or '
            'the 9 of a row-major matrix'
        )
    if not np.all(np.isfinite(numbers)):
        raise ValueError(f'{given}; every entry must be finite')
    if len(numbers) == 9:
        rows = numbers.reshape(3, 3)
        if np.max(np.abs(rows - rows.T)) > _ROUNDING * np.max(np.abs(rows)):
            raise ValueError(f'{given}; the matrix must be symmetric')
        inertia = (rows + rows.T) / 2.0
    else:
        inertia = np.diag(numbers[:3])
        if len(numbers) == 6:
            inertia[[0, 0, 1], [1, 2, 2]] = inertia[[1, 2, 2], [0, 0, 1]] = numbers[3:]
    small, middle, large = np.sort(principal_axes(inertia)[0])
    moments = f'{small:g}, {middle:g} and {large:g}'
    if small <= _ROUNDING * large:
        raise ValueError(f'{given}; its principal moments {moments} must be positive')
    if small + middle < large * (1.0 - _ROUNDING):
        raise ValueError(
            f'{given}; of its principal moments {moments} the largest must not exceed the sum of '
            'the others'
        )
    return inertia


def principal_axes(inertia) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the principal moments (3,) and the rotation R_bp (3, 3): inertia = R diag(moments) R^T.

    The columns of R_bp are the principal axes in body axes, right-handed, and of all orders and
    signs (of all pairs, for equal moments) those that turn least from the body axes; a diagonal
    tensor gives its diagonal and the identity.
    """
    inertia = np.asarray(inertia, float)
    if np.all(inertia == np.diag(np.diagonal(inertia))):
        return np.diagonal(inertia).copy(), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    low_equal, high_equal = np.diff(moments) <= _ROUNDING * np.max(np.abs(moments))
    if low_equal and high_equal:
        return np.full(3, np.mean(moments)), np.eye(3)
    if low_equal or high_equal:
        distinct = 2 if low_equal else 0
        return _about_one_axis(moments, axes, distinct)
    candidates = []
    for order in permutations(range(3)):
        R = axes[:, order]
        R = R * np.where(np.diagonal(R) < 0.0, -1.0, 1.0)
        if np.linalg.det(R) < 0.0:
            least = np.argmin(np.diagonal(R))
            R[:, least] = -R[:, least]
        candidates.append((moments[list(order)], R))
    return max(candidates, key=lambda candidate: np.trace(candidate[1]))


def _about_one_axis(moments, axes, distinct):
    """Return the principal axes where the two moments beside the distinct one are equal."""
    axis = axes[:, distinct]
    k = np.argmax(np.abs(axis))
    axis = axis * np.sign(axis[k])
    nearest = np.eye(3)[k]
    # The shortest turn from body axis k: w = cos(angle / 2), (x, y, z) = sin(angle / 2) n.
    q = np.append(np.cross(nearest, axis), 1.0 + axis[k])
    ordered = np.full(3, (np.sum(moments) - moments[distinct]) / 2.0)
    ordered[k] = moments[distinct]
    return ordered, rotation.matrix(rotation.normalise(q))

"""The inertia tensor: which numbers are one, principal axes, parallel axis, moment of an axis."""

from collections.abc import Iterable, Sequence
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike

from ..base.sentences import Checks, distinct_texts, written
from ..kernel import rotation
from ..kernel.rows import length

# Rounding of a tensor that came through a rotation or from 15 printed digits; moments that differ
# by less have no principal axes of their own.
_AS_GIVEN = 1e-13
# What counts as rounding of the input: a relative difference of moments, the sine of an angle, or
# the residual of a balance relative to its terms.
ROUNDING = 1e-12


def checks(numbers: ArrayLike) -> Checks:
    """
    Check that 3, 6 or 9 finite numbers (..., k), as for entries, are the inertia of a body.

    >>> any(checks([600, 800, 900])), any(checks([600, 800, 1500]))
    (False, True)
    """
    numbers = np.asarray(numbers, float)
    given = f'body.inertia is [{", ".join(map(written, numbers))}]' if numbers.ndim == 1 else ''
    if numbers.shape[-1] == 9:
        rows = numbers.reshape(*numbers.shape[:-1], 3, 3)
        skew = np.max(np.abs(rows - np.swapaxes(rows, -1, -2)), axis=(-1, -2))
        if (yield skew > _AS_GIVEN * np.max(np.abs(rows), axis=(-1, -2))):
            raise ValueError(f'{given}; the matrix must be symmetric')
    small, middle, large = np.moveaxis(np.linalg.eigvalsh(entries(numbers)), -1, 0)
    if (yield small <= _AS_GIVEN * large):
        raise ValueError(
            f'{given}; its principal moments {small:g}, {middle:g} and {large:g} must be '
            'positive: a rod has a thickness, use the moments of a cylinder'
        )
    if (yield small + middle < large * (1.0 - _AS_GIVEN)):
        most, found = distinct_texts(small + middle, large)
        raise ValueError(
            f'{given}; the largest of its principal moments, {found}, must not exceed the sum of '
            f'the others, {small:g} and {middle:g}, which is {most}'
        )


def entries(numbers: ArrayLike) -> np.ndarray:
    """
    Return the inertia tensors (..., 3, 3) [kg m^2] of 3, 6 or 9 numbers.

    Parameters
    ----------
    numbers : (..., 3), (..., 6) or (..., 9), kg m^2
        the principal moments; or ixx iyy izz ixy ixz iyz, the entries of the tensor (products with
        the sign they have in the matrix); or its rows

    Examples
    --------
    >>> entries([600, 800, 900]).diagonal()
    array([600., 800., 900.])
    """
    numbers = np.asarray(numbers, float)
    if numbers.shape[-1] == 9:
        rows = numbers.reshape(*numbers.shape[:-1], 3, 3)
        return rows / 2.0 + np.swapaxes(rows, -1, -2) / 2.0
    inertia = numbers[..., :3, None] * np.eye(3)
    if numbers.shape[-1] == 6:
        for (i, j), k in zip(((0, 1), (0, 2), (1, 2)), range(3, 6), strict=True):
            inertia[..., i, j] = inertia[..., j, i] = numbers[..., k]
    return inertia


def principal_axes(inertia: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the principal moments (3,) and the rotation R_bp (3, 3): inertia = R diag(moments) R^T.

    The columns of R_bp are the principal axes in body axes, right-handed.  Among all orders and
    signs (for equal moments, all pairs) they are those turned least from the body axes: a diagonal
    tensor gives its diagonal and the identity.

    Parameters
    ----------
    inertia : (3, 3) or (..., 3, 3), kg m^2
        a tensor, or many, which give as many of both
    """
    inertia = np.asarray(inertia, float)
    moments = np.diagonal(inertia, axis1=-2, axis2=-1).copy()
    if np.all(inertia == moments[..., None] * np.eye(3)):
        return moments, np.broadcast_to(np.eye(3), inertia.shape).copy()
    if inertia.ndim > 2:
        found = [principal_axes(each) for each in inertia.reshape(-1, 3, 3)]
        moments, axes = (np.array(parts) for parts in zip(*found, strict=True))
        return moments.reshape(inertia.shape[:-1]), axes.reshape(inertia.shape)
    moments, axes = np.linalg.eigh(inertia)
    low_equal, high_equal = np.diff(moments) <= _AS_GIVEN * np.max(np.abs(moments))
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


def symmetry_axis(
    inertias: Iterable[np.ndarray], vectors: Iterable[np.ndarray] = ()
) -> np.ndarray | None:
    """
    Return the unit axis (3,) about which all tensors and vectors are symmetric.

    None: there is no such axis, or any axis is one.

    Parameters
    ----------
    inertias : (3, 3) each
        tensors
    vectors : (3,) each
        vectors
    """
    axis = symmetry_axes(inertias, vectors)
    return None if np.any(np.isnan(axis)) else axis


def symmetry_axes(
    inertias: Iterable[np.ndarray], vectors: Iterable[np.ndarray] = ()
) -> np.ndarray:
    """Return symmetry_axis (..., 3) of inertias (..., 3, 3) and vectors (..., 3); nan: none."""
    tensors, along = list(inertias), list(vectors)
    axes = [principal_axes(I) for I in tensors]
    equal = [_equal_pairs(moments) for moments, _ in axes]
    if not all(np.any(pairs) for pairs in equal):
        shapes = *(I.shape[:-2] for I in tensors), *(np.shape(v)[:-1] for v in along)
        return np.full((*np.broadcast_shapes(*shapes), 3), np.nan)
    axis = np.full(3, np.nan)
    # The later ones win: a vector singles out an axis where all tensors are spheres.
    for v in reversed(along):
        with np.errstate(invalid='ignore'):
            axis = np.where(np.any(v, axis=-1)[..., None], v / length(v)[..., None], axis)
    for (_, R_bp), pairs in zip(axes, equal, strict=True):
        for k in range(3):
            is_single = pairs[k] & (sum(pairs) == 1)
            axis = np.where(is_single[..., None], R_bp[..., :, k], axis)
    fits = np.array(True)
    for I in tensors:
        fits = fits & _is_symmetric(I, axis)
    for v in along:
        fits = fits & (length(np.cross(axis, v)) <= ROUNDING * length(v))
    return np.where(fits[..., None], axis, np.nan)


def are_parallel(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether the vectors a and b (3,) are parallel, opposite, or one of them is zero."""
    return bool(np.linalg.norm(np.cross(a, b)) <= ROUNDING * np.linalg.norm(a) * np.linalg.norm(b))


def _equal_pairs(moments):
    """Return, for each principal axis, whether the two other moments (..., 3) are equal."""
    allowed = ROUNDING * np.max(moments, axis=-1)
    return [np.abs(moments[..., k - 1] - moments[..., k - 2]) <= allowed for k in range(3)]


def _is_symmetric(I, axis):
    """Return whether inertias (..., 3, 3) are symmetric about unit axes (..., 3)."""
    along = axis[..., :, None] * axis[..., None, :]
    C = np.sum(along * I, axis=(-2, -1))[..., None, None]
    A = (np.trace(I, axis1=-2, axis2=-1)[..., None, None] - C) / 2.0
    off = np.abs(I - (A * np.eye(3) + (C - A) * along))
    return np.max(off, axis=(-2, -1)) <= ROUNDING * np.max(I, axis=(-2, -1))


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


def ellipsoid(inertia: ArrayLike) -> np.ndarray:
    """
    Return the semi-axes 1 / sqrt(moment) of the inertia ellipsoid x . inertia x = 1, shape (3,).

    They lie along the columns of principal_axes(inertia); a moment of zero has an infinite one.
    """
    with np.errstate(divide='ignore'):
        return 1.0 / np.sqrt(np.maximum(principal_axes(inertia)[0], 0.0))


def ellipsoid_normal(inertia: ArrayLike, omega: ArrayLike) -> np.ndarray:
    """
    Return the unit normal (3,) of the inertia ellipsoid where omega (3,) meets it (42.23).

    It is along inertia omega, the angular momentum: Poinsot's plane is tangent there.
    """
    momentum = np.asarray(inertia, float) @ np.asarray(omega, float)
    return momentum / np.linalg.norm(momentum)


def parallel_axis(inertia_g: ArrayLike, mass: float, offset: ArrayLike) -> np.ndarray:
    """
    Return the inertia (3, 3) about a point.

    Steiner's theorem as a tensor: I_G + m (d.d 1 - d d^T).

    Parameters
    ----------
    inertia_g : (3, 3), kg m^2
        I_G, about the mass centre
    mass : kg
        m
    offset : (3,), m
        d, the point from the mass centre
    """
    d = np.asarray(offset, float)
    return np.asarray(inertia_g, float) + mass * (d @ d * np.eye(3) - np.outer(d, d))


def moment_about(
    inertia_g: np.ndarray,
    axis: Sequence[float] | np.ndarray,
    mass: float = 0.0,
    through: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
) -> float:
    """
    Return the moment [kg m^2] about any axis through a point (textbook, 42.16).

    Parameters
    ----------
    inertia_g : (3, 3), kg m^2
        about the mass centre
    axis : (3,)
        of any length
    mass : kg
        of the body
    through : (3,), m
        the point from the mass centre

    Examples
    --------
    >>> round(moment_about(0.2 * np.eye(3), [0, 0, 1], mass=2.0, through=[0.5, 0, 0]), 12)
    0.7
    """
    e = np.asarray(axis, float) / np.linalg.norm(axis)
    return float(e @ parallel_axis(inertia_g, mass, through) @ e)


def in_space(inertia: np.ndarray, q_ib: np.ndarray) -> np.ndarray:
    """Return the tensor (..., 3, 3) in inertial axes, R I R^T, of a body at q_ib (..., 4)."""
    R = rotation.matrix(q_ib)
    return R @ np.asarray(inertia, float) @ np.swapaxes(R, -1, -2)

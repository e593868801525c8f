"""The body axes in which closed forms are written: the symmetry axis or a principal axis third."""

import numpy as np

from ..dynamics.inertia import ROUNDING
from ..dynamics.system import State, System
from ..kernel import rotation


def is_principal(inertia: np.ndarray, axis: np.ndarray) -> bool:
    """Whether the unit vector axis (3,) is a principal axis of inertia (3, 3)."""
    return bool(np.linalg.norm(np.cross(axis, inertia @ axis)) <= ROUNDING * np.max(inertia))


def is_symmetric(inertia: np.ndarray, axis: np.ndarray) -> bool:
    """Whether axis (3,) is principal and the two moments across it are equal."""
    if not is_principal(inertia, axis):
        return False
    (first, second, _), _ = principal_axes_about(axis, inertia)
    return bool(first == second)


def rotor_axes(system: System, state: State) -> list[np.ndarray]:
    """
    Return the unit axes (3,) of the rotors: of each that turns freely, and of the momentum of all.

    The angle of a free rotor must follow in closed form even where the momentum of all is zero.
    """
    axes = [rotor.axis for rotor in system.rotors if rotor.turns_freely]
    h_b = system.rotor_momentum(state)
    if not np.any(h_b):
        return axes
    # The axis itself where there is only one: it has no rounding error.
    alone = len(system.rotors) == 1
    return [*axes, system.rotors[0].axis if alone else h_b / np.linalg.norm(h_b)]


def principal_axes_about(axis: np.ndarray, inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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

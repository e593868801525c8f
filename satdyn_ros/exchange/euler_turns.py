"""Three turns about axes of the body, in the order of EULER_ROT_SEQ, and their rates."""

import numpy as np

from ..kernel import rotation


def turns(sequence: str, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return turns about three axes, each in those that the one before has turned.

    Parameters
    ----------
    sequence : str
        of the axes, such as ZYX
    angles : (N, 3), rad
        of the turns

    Returns
    -------
    q : (N, 4)
        quaternion of all three
    axes : (N, 3, 3)
        each of the axes, in those in which the last turn ends
    """
    units = [np.eye(3)['XYZ'.index(name)] for name in sequence]
    parts = [rotation.about(unit, angles[:, k]) for k, unit in enumerate(units)]
    last_two = rotation.multiply(parts[1], parts[2])
    axes = [
        rotation.rotate(rotation.conjugate(after), np.broadcast_to(unit, (len(angles), 3)))
        for unit, after in zip(units, (last_two, parts[2], parts[2]), strict=True)
    ]
    return rotation.multiply(parts[0], last_two), np.stack(axes, axis=1)


def angles_of(sequence: str, q: np.ndarray) -> np.ndarray:
    """Return the angles (N, 3) [rad] of turns about three axes that make a quaternion (N, 4)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(q).as_euler(sequence)


def spin_of(sequence: str, angles: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return the rate (N, 3) of the axes in which the last turn ends, of rates of the angles."""
    return np.einsum('nk,nkj->nj', rates, turns(sequence, angles)[1])


def rates_of(sequence: str, angles: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Return the rates (N, 3) of the angles; they have none where two of the axes are one."""
    axes = turns(sequence, angles)[1]
    return np.linalg.solve(axes.swapaxes(-1, -2), spin[..., None])[..., 0]

"""How far the attitudes of a run are from those in another tool's message."""

from pathlib import Path

import numpy as np

from ..base.nanoseconds import epoch
from ..exchange.aem_reader import AttitudeFile
from ..kernel import rotation


def angle_to_message(path: str | Path, stamps_ns: np.ndarray, q_ib: np.ndarray) -> np.ndarray:
    """
    Return the angles (N,) [rad] of the turns from attitudes to those of an AEM.

    An angle is nan where the message has no attitude.

    Parameters
    ----------
    path : str or Path
        the message
    stamps_ns : (N,), ns
        where both are asked for
    q_ib : (N, 4), x, y, z, w
        attitudes, body to inertial

    Raises
    ------
    ValueError
        it has none at any of them, or see AttitudeFile
    """
    others = AttitudeFile(path).attitudes(stamps_ns)
    if np.all(np.isnan(others)):
        raise ValueError(
            f'{path} has no attitude at a tick from {epoch(int(stamps_ns[0]))} to '
            f'{epoch(int(stamps_ns[-1]))}'
        )
    turns = rotation.multiply(rotation.conjugate(q_ib), others)
    # The arc cosine of the scalar part would lose half of the digits.
    return 2.0 * np.arctan2(np.linalg.norm(turns[:, :3], axis=-1), np.abs(turns[:, 3]))

"""The variables of the integration as the columns of a table of states."""

import numpy as np

from ..dynamics.equations import MOMENTUM, OMEGA, Q
from ..dynamics.system import System


def columns(system: System, out: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the columns of States of the wanted variables (..., V, N)."""
    q_ib = out[..., Q:OMEGA, :].swapaxes(-2, -1)
    omega_bi_b = out[..., OMEGA:MOMENTUM, :].swapaxes(-2, -1)
    rows, turning = out[..., 0, :].shape, system.turning_rotors
    speeds = [_repeated(np.nan, rows)] * len(system.rotors)
    angles = speeds.copy()
    for n, (i, rotor) in enumerate(turning):
        speeds[i] = np.asarray(rotor.speed(out[..., MOMENTUM + n, :], omega_bi_b))
        angles[i] = out[..., MOMENTUM + len(turning) + n, :]
    i = MOMENTUM + 2 * len(turning)
    work = out[..., i, :] if out.shape[-2] > i else _repeated(0.0, rows)
    return q_ib, omega_bi_b, _of_rotors(speeds, rows), _of_rotors(angles, rows), work


def wanted_count(system: System, does_work: bool) -> int:
    """Return how many variables are interpolated: not the work if it is none, nor the place."""
    return MOMENTUM + 2 * len(system.turning_rotors) + does_work


def _repeated(value, shape):
    # Of one row, np.broadcast_to costs more than the propagation of a tick.
    return np.ndarray(shape, float, np.float64(value), strides=(0,) * len(shape))


def _of_rotors(columns, rows):
    """Return one column per rotor as a table (..., N, R), without a copy where it can."""
    if len(columns) == 1:
        return columns[0][..., None]
    return np.stack(columns, axis=-1) if columns else np.empty((*rows, 0))

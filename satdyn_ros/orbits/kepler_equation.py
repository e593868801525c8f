"""Kepler's equation, of one number and of arrays."""

import numpy as np
from numpy.typing import ArrayLike

from ..kernel.looped import looped
from ..trace.memory import floats


def true_anomaly_of_one(mean_anomaly: float, e: float) -> float:
    """
    Return the true anomaly f [rad], continuous, of the mean anomaly M [rad] and eccentricity e.

    Kepler's equation E - e sin E = M by Newton's method from Danby's guess.
    """
    if e == 0.0:
        return mean_anomaly
    turns = 2.0 * np.pi * np.rint(mean_anomaly / (2.0 * np.pi))
    M = mean_anomaly - turns
    E = M + np.sign(M) * 0.85 * e
    for _ in range(50):
        correction = (E - e * np.sin(E) - M) / (1.0 - e * np.cos(E))
        E -= correction
        if abs(correction) < 1e-15:
            break
    beta = e / (1.0 + np.sqrt(1.0 - e * e))
    return turns + E + 2.0 * np.arctan2(beta * np.sin(E), 1.0 - beta * np.cos(E))


def true_anomaly(mean_anomaly: ArrayLike, e: ArrayLike) -> np.ndarray:
    """Return it of arrays, which broadcast."""
    both = np.broadcast_arrays(np.asarray(mean_anomaly, float), np.asarray(e, float))
    M, e = map(np.ascontiguousarray, both)
    f = np.empty_like(M)
    _fill(f.size, M.ctypes.data, e.ctypes.data, f.ctypes.data)
    return f.reshape(both[0].shape)[()]


@looped
def _fill(count: int, mean_anomalies_at: int, e_at: int, f_at: int) -> int:
    mean_anomalies, e, f = floats(mean_anomalies_at), floats(e_at), floats(f_at)
    for n in range(count):
        f[n] = true_anomaly_of_one(mean_anomalies[n], e[n])
    return count

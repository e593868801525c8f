"""Kepler's equation: of numbers, in plain Python, and compiled for arrays."""

from functools import cache
from typing import Any

import numpy as np


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


def true_anomaly(mean_anomaly: Any, e: Any) -> Any:
    """Return it of arrays, which broadcast."""
    return _compiled()(mean_anomaly, e)


@cache
def _compiled():
    # Not needed by whoever asks for no table of an ellipse.
    from ..kernel.compile import vectorized

    return vectorized(true_anomaly_of_one)

"""Measures of the states (M, N) of M runs at N times."""

from collections.abc import Sequence

import numpy as np

from ..dynamics.motion import States
from ..dynamics.rotation import components


def length(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths of vectors (..., 3)."""
    x, y, z = components(vectors)
    return np.sqrt(x * x + y * y + z * z)


def angles(name: str, squares_of_tangent: Sequence[np.ndarray], factor: float = 1.0) -> dict:
    """Return the least and the largest of factor times an angle [rad] from those of tan^2 (M,)."""
    least, largest = (factor * np.arctan(np.sqrt(square)) for square in squares_of_tangent)
    return {f'{name}_min_rad': least, f'{name}_max_rad': largest}


def omega_bl_b(states: States) -> np.ndarray:
    """Return the rate relative to LVLH, body axes [rad/s], shape (..., 3)."""
    return states.omega_bi_b - states.lvlh_rate_b


def samples(states: States) -> dict[str, np.ndarray]:
    """Return the attitudes and rates at the samples, relative to LVLH where there is one."""
    if not states.orbit.has_lvlh:
        return {'samples_q_ib': states.q_ib, 'samples_omega_bi_b': states.omega_bi_b}
    return {'samples_q_lb': states.q_lb, 'samples_omega_bl_b': omega_bl_b(states)}

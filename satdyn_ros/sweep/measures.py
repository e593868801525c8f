"""Measures of the states (M, N) of M runs at N times."""

import numpy as np

from ..dynamics.motion import States
from ..dynamics.rotation import components, from_components


def length(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths of vectors (..., 3)."""
    return np.sqrt(dot(vectors, vectors))


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a . b of vectors (..., 3)."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a x b of vectors (..., 3)."""
    (a_x, a_y, a_z), (b_x, b_y, b_z) = components(a), components(b)
    return from_components([a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x])


def extremes(name: str, square_of_tangent: np.ndarray, factor: float = 1.0) -> dict:
    """Return the least and the largest of factor times an angle [rad] from tan^2 (M, N)."""
    return {
        f'{name}_min_rad': factor * np.arctan(np.sqrt(square_of_tangent.min(axis=-1))),
        f'{name}_max_rad': factor * np.arctan(np.sqrt(square_of_tangent.max(axis=-1))),
    }


def lvlh_angles(states: States) -> dict[str, np.ndarray]:
    """Return the extremes of the angle of the rotation from LVLH to the body."""
    q = states.q_lb
    with np.errstate(divide='ignore'):
        return extremes('lvlh_angle', dot(q, q) / q[..., 3] ** 2, 2.0)


def omega_bl_b(states: States) -> np.ndarray:
    """Return the rate relative to LVLH, body axes [rad/s], shape (..., 3)."""
    return states.omega_bi_b - states.lvlh_rate_b


def samples(states: States) -> dict[str, np.ndarray]:
    """Return the attitudes and rates at the samples, relative to LVLH where there is one."""
    if not states.orbit.has_lvlh:
        return {'samples_q_ib': states.q_ib, 'samples_omega_bi_b': states.omega_bi_b}
    return {'samples_q_lb': states.q_lb, 'samples_omega_bl_b': omega_bl_b(states)}

"""How body and flexible parts swing together where nothing holds them."""

import numpy as np
from scipy.linalg import eigvalsh

from ..dynamics.system import System


def free_frequencies(system: System) -> np.ndarray:
    """
    Return the natural frequencies (F,) [rad/s] of small motions of a free body, ascending.

    They are without damping, with rotors that turn by themselves.  The momentum stays constant, so
    that the body moves by omega = -I'^-1 sum d eta', I' the inertia without what rotors have about
    their axes, and eta swings by (1 - d . I'^-1 d) eta'' + W^2 eta = 0, for one mode.

    Parameters
    ----------
    system : System
        a body with flexible parts
    """
    if not system.modes:
        return np.zeros(0)
    D = np.stack([mode.coupling for mode in system.modes], axis=1)
    I = system.carrier_inertia + D @ D.T
    stiffness = np.diag([mode.frequency**2 for mode in system.modes])
    squares = eigvalsh(stiffness, np.eye(len(system.modes)) - D.T @ np.linalg.solve(I, D))
    return np.sqrt(squares)

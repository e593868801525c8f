"""What the limits of rotors leave of motor torques."""

from collections.abc import Mapping

import numpy as np

from ..dynamics.system import System


def within_max_torque(
    system: System, torques: Mapping[str, float]
) -> tuple[np.ndarray, list[str]]:
    """
    Return the motor torques [N m] (R,) with some new, by rotor, and the rotors where it was cut.

    A rotor without a new torque keeps the one that acts.
    """
    acting, cut = system.rotor_torque.copy(), []
    for i, rotor in enumerate(system.rotors):
        torque = torques.get(rotor.label)
        if torque is None:
            continue
        if 0.0 < rotor.max_torque < abs(torque):
            torque = rotor.max_torque if torque > 0.0 else -rotor.max_torque
            cut.append(rotor.label)
        acting[i] = torque
    return acting, cut


def has_max_speed(system: System) -> bool:
    """Whether any rotor has a limit of its speed."""
    return any(rotor.max_speed for rotor in system.rotors)


def is_too_fast(system: System, speeds: np.ndarray) -> np.ndarray:
    """Return of speeds (..., R) [rad/s] which are at their limit while a torque adds to it."""
    most = np.array([rotor.max_speed or np.inf for rotor in system.rotors])
    with np.errstate(invalid='ignore'):
        return (np.abs(speeds) >= most) & (speeds * system.rotor_torque > 0.0)

"""
The equations of motion in plain NumPy, as docs/theory/rigid_bodies.md states them.

They are what the kernel must compute: written to be read, for one state at one time, in inertial
axes, by nothing of the compiled code.
"""

from typing import Any, NamedTuple

import numpy as np

from satdyn_ros.dynamics.system import System
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection


class Rates(NamedTuple):
    """The derivatives: of q_ib, omega_bi_b, each turning rotor's momentum and angle, the work."""

    q_ib: np.ndarray
    omega_bi_b: np.ndarray
    momenta: np.ndarray
    angles: np.ndarray
    work: float


def rates(
    system: System, t_s: float, q_ib: np.ndarray, omega: np.ndarray, momenta: np.ndarray
) -> Rates:
    """Return the derivatives at t_s from tick 0; momenta: p of each turning rotor."""
    orbit, I = system.orbit, system.inertia
    rotors = [(system.rotor_torque[i], rotor) for i, rotor in system.turning_rotors]

    # Each rotor: p = J (s + a . omega), p' = tau - b s.
    speeds = np.array(
        [p / r.inertia - r.axis @ omega for p, (_, r) in zip(momenta, rotors, strict=True)]
    )
    momenta_dot = np.array(
        [tau - r.friction * s for s, (tau, r) in zip(speeds, rotors, strict=True)]
    )

    # The body with its rotors: H = K omega + sum p a + sum h.
    K = I - sum((r.inertia * np.outer(r.axis, r.axis) for _, r in rotors), np.zeros((3, 3)))
    H = K @ omega + sum(
        (p * r.axis for p, (_, r) in zip(momenta, rotors, strict=True)), np.zeros(3)
    )
    for rotor in system.rotors:
        if rotor.mode == 'constant_momentum':
            H = H + rotor.momentum * rotor.axis

    # The field: 3 mu / r^3 c x I c - m x c.
    c = to_body(q_ib, orbit.direction(t_s))
    gradient = orbit.gradient_at(t_s)
    field = gradient * np.cross(c, I @ c) - np.cross(system.weight_moment, c)

    # What else acts, and what the motors and friction take from the body.
    r_i, v_i = orbit.position_velocity(t_s)
    applied = system.torque_b.astype(float)
    for torque in system.torques:
        arguments: tuple[Any, ...] = (t_s, r_i, v_i, q_ib, omega, torque.constants)
        x, y, z = type(torque).torque(*arguments)
        applied = applied + np.array([x, y, z])
    for p_dot, (_, rotor) in zip(momenta_dot, rotors, strict=True):
        applied = applied - p_dot * rotor.axis
    omega_dot = np.linalg.solve(K, np.cross(H, omega) + field + applied)

    return Rates(
        q_ib=rotation.multiply(q_ib, [*omega, 0.0]) / 2.0,
        omega_bi_b=omega_dot,
        momenta=momenta_dot,
        angles=speeds,
        work=applied @ omega + power_of_orbit(system, t_s, q_ib),
    )


def power_of_orbit(system: System, t_s: float, q_ib: np.ndarray) -> float:
    """Return dV/dt of V = (3 mu / 2 r^3) c . I c at a fixed attitude: what the orbit does."""
    orbit, I = system.orbit, system.inertia
    if isinstance(orbit, FixedDirection):
        return 0.0
    c = to_body(q_ib, orbit.direction(t_s))
    r_i, v_i = orbit.position_velocity(t_s)
    normal = np.cross(r_i, v_i) / np.linalg.norm(np.cross(r_i, v_i))
    along = to_body(q_ib, np.cross(normal, orbit.direction(t_s)))
    r_dot_over_r = r_i @ v_i / (r_i @ r_i)
    gradient, V = orbit.gradient_at(t_s), orbit.gradient_at(t_s) / 2.0 * (c @ I @ c)
    return gradient * orbit.rate(t_s) * (c @ I @ along) - 3.0 * r_dot_over_r * V


def to_body(q_ib: np.ndarray, v_i: np.ndarray) -> np.ndarray:
    """Return the components in body axes."""
    return rotation.rotate(rotation.conjugate(q_ib), v_i)

"""
The equations of motion of a gyrostat in a Newtonian field, as on the textbook page.

    q' = q (omega, 0) / 2
    K omega' = (K omega + p a) x omega + (3 mu / r^3) c x I c - m x c + torque - tau a,  p' = tau

I is the inertia, K that of what turns with the body (carrier_inertia of system.py), p a the
rotor's momentum (rotor.py), c the unit vector from the attracting centre and m the weight moment.
With the true anomaly f, c = cos f P + sin f Q and 1 + e cos f =: rho,

    f' = sqrt(mu / l^3) rho^2,    3 mu / r^3 = (3 mu / l^3) rho^3,    l the semi-latus rectum.

A fixed direction is the case f' = 0.  Beside them two quadratures: the rotor's angle, and the
work W by which the energy omega . K omega / 2 + V + m . c changes, V = (3 mu / 2 r^3) c . I c:
that of the applied torques, and with t = -sin f P + cos f Q, the unit vector along track, that
of the orbit, f' (3 mu / r^3) t . I c - 3 (r' / r) V.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from .orbit import FixedDirection
from .system import State, System
from .vector import COMPILED, add, apply, cross, dot, scale, to_body

# The variables of the integration: q_ib (4), omega_bi_b (3), p, rotor angle, work, cos f, sin f.
Q, OMEGA, MOMENTUM, ANGLE, WORK, CENTRE = 0, 4, 7, 8, 9, 10
SIZE = 12


class Parameters(NamedTuple):
    """
    The constants of one motion as plain numbers; matrices are tuples of rows.

    slow_rate [rad/s]: far below the rates at which the field swings the body, for a body at rest.
    """

    inertia: tuple
    carrier_inertia: tuple
    carrier_inverse: tuple
    weight_moment: tuple
    torque_b: tuple
    rotor_axis: tuple
    rotor_torque: float
    rotor_inertia_inverse: float
    eccentricity: float
    anomaly_rate: float
    gradient: float
    to_pericentre: tuple
    ahead: tuple
    does_work: bool
    slow_rate: float


def parameters(system: System) -> Parameters:
    """Return the constants of the equations for a system."""
    orbit, rotor, carrier = system.orbit, system.rotor, system.carrier_inertia
    if isinstance(orbit, FixedDirection):
        eccentricity, anomaly_rate, gradient = 0.0, 0.0, orbit.gradient
        to_pericentre, ahead = orbit.direction(0.0), np.zeros(3)
    else:
        eccentricity = orbit.eccentricity
        anomaly_rate = np.sqrt(orbit.mu / orbit.semi_latus_rectum) / orbit.semi_latus_rectum
        gradient = 3.0 * anomaly_rate**2
        to_pericentre, ahead, _ = orbit.perifocal.T
    weight = np.linalg.norm(system.weight_moment)
    return Parameters(
        inertia=_rows(system.inertia),
        carrier_inertia=_rows(carrier),
        carrier_inverse=_rows(np.linalg.inv(carrier)),
        weight_moment=_row(system.weight_moment),
        torque_b=_row(system.torque_b),
        rotor_axis=_row(rotor.axis),
        rotor_torque=float(system.rotor_torque),
        rotor_inertia_inverse=1.0 / rotor.inertia if rotor.turns_freely else 0.0,
        eccentricity=float(eccentricity),
        anomaly_rate=float(anomaly_rate),
        gradient=float(gradient),
        to_pericentre=_row(to_pericentre),
        ahead=_row(ahead),
        slow_rate=float(1e-3 * np.sqrt(abs(gradient) + weight / np.trace(system.inertia))),
        does_work=bool(eccentricity or np.any(system.torque_b) or system.rotor_torque),
    )


def initial_values(system: System, state: State) -> np.ndarray:
    """Return the variables (SIZE,) of a state; the direction of the centre is left at f = 0."""
    y = np.zeros(SIZE)
    y[Q : Q + 4] = state.q_ib
    y[OMEGA : OMEGA + 3] = state.omega_bi_b
    y[CENTRE] = 1.0
    y[MOMENTUM] = system.rotor.axial_momentum(state.rotor_speed, state.omega_bi_b)
    y[ANGLE] = state.rotor_angle if system.rotor.turns_freely else 0.0
    return y


@njit(inline='always', **COMPILED)
def derivative(y, of, dy):
    """Write dy/dt of the variables y (SIZE,) into dy, for the constants `of`."""
    q, omega = (y[0], y[1], y[2], y[3]), (y[4], y[5], y[6])
    p, cos_f, sin_f = y[7], y[10], y[11]

    rho = 1.0 + of.eccentricity * cos_f
    f_dot = of.anomaly_rate * rho * rho
    gradient = of.gradient * rho * rho * rho
    c = to_body(q, add(scale(cos_f, of.to_pericentre), scale(sin_f, of.ahead)))
    I_c = apply(of.inertia, c)

    gravity = add(scale(gradient, cross(c, I_c)), cross(c, of.weight_moment))
    applied = add(of.torque_b, scale(-of.rotor_torque, of.rotor_axis))
    momentum = add(apply(of.carrier_inertia, omega), scale(p, of.rotor_axis))
    torque = add(add(cross(momentum, omega), gravity), applied)
    omega_dot = apply(of.carrier_inverse, torque)

    dy[0] = 0.5 * (q[3] * omega[0] + q[1] * omega[2] - q[2] * omega[1])
    dy[1] = 0.5 * (q[3] * omega[1] + q[2] * omega[0] - q[0] * omega[2])
    dy[2] = 0.5 * (q[3] * omega[2] + q[0] * omega[1] - q[1] * omega[0])
    dy[3] = -0.5 * (q[0] * omega[0] + q[1] * omega[1] + q[2] * omega[2])
    dy[4], dy[5], dy[6] = omega_dot
    dy[7] = of.rotor_torque
    dy[8] = p * of.rotor_inertia_inverse - dot(of.rotor_axis, omega)
    if of.does_work:
        t = to_body(q, add(scale(-sin_f, of.to_pericentre), scale(cos_f, of.ahead)))
        r_dot_r = of.eccentricity * sin_f * f_dot / rho
        orbital = gradient * (f_dot * dot(I_c, t) - 1.5 * r_dot_r * dot(I_c, c))
        dy[9] = dot(applied, omega) + orbital
    else:
        dy[9] = 0.0
    dy[10] = -f_dot * sin_f
    dy[11] = f_dot * cos_f


def _row(vector):
    return tuple(float(x) for x in vector)


def _rows(M):
    return tuple(_row(row) for row in M)

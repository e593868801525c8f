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

from ..compiled import inlined
from .orbit import FixedDirection
from .system import State, System
from .vector import add, apply, cross, dot, scale, to_body

# The variables of the integration: q_ib (4), omega_bi_b (3), cos f, sin f, p, rotor angle, work.
Q, OMEGA, CENTRE, MOMENTUM, ANGLE, WORK = 0, 4, 7, 9, 10, 11
SIZE = 12


class Parameters(NamedTuple):
    """
    The constants of one motion as plain numbers; matrices are tuples of rows.

    applied [N m]: torque - tau a.  slow_rate [rad/s]: far below the rates at which the field
    swings the body, for a body at rest.
    """

    inertia: tuple
    carrier_inertia: tuple
    carrier_inverse: tuple
    weight_moment: tuple
    applied: tuple
    rotor_axis: tuple
    rotor_torque: float
    rotor_inertia_inverse: float
    eccentricity: float
    anomaly_rate: float
    gradient: float
    to_pericentre: tuple
    ahead: tuple
    slow_rate: float
    does_work: bool


def parameters(system: System) -> Parameters:
    """Return the constants of the equations for a system."""
    constants = _constants(system)
    plain = Parameters(*(_plain(part) for part in constants))
    return plain._replace(does_work=bool(constants.does_work))


def parameters_of_many(system: System, count: int) -> np.ndarray:
    """Return the numbers of the Parameters of so many systems, one after the other, (count, P)."""
    rows = []
    for part, field in zip(_constants(system), _constants(System(np.eye(3))), strict=True):
        size = np.size(field)
        rows.append(np.broadcast_to(np.reshape(part, (-1, size)), (count, size)))
    return np.concatenate(rows, axis=1)


# What overflows here halts the propagation; a warning would come before its sentence.
@np.errstate(over='ignore', invalid='ignore')
def _constants(system):
    """Return the Parameters as arrays, of a system whose own constants may be arrays."""
    orbit, rotor, carrier = system.orbit, system.rotor, system.carrier_inertia
    if isinstance(orbit, FixedDirection):
        eccentricity, anomaly_rate, gradient = 0.0, 0.0, orbit.gradient
        to_pericentre, ahead = orbit.direction(0.0), np.zeros(3)
    else:
        eccentricity = orbit.eccentricity
        anomaly_rate = np.sqrt(orbit.mu / orbit.semi_latus_rectum) / orbit.semi_latus_rectum
        gradient = 3.0 * anomaly_rate**2
        to_pericentre, ahead, _ = np.moveaxis(orbit.perifocal, -1, 0)
    weight = np.linalg.norm(system.weight_moment, axis=-1)
    size = np.trace(system.inertia, axis1=-2, axis2=-1)
    return Parameters(
        inertia=system.inertia,
        carrier_inertia=carrier,
        carrier_inverse=np.linalg.inv(carrier),
        weight_moment=system.weight_moment,
        applied=system.torque_b - system.rotor_torque * rotor.axis,
        rotor_axis=rotor.axis,
        rotor_torque=system.rotor_torque,
        rotor_inertia_inverse=1.0 / rotor.inertia if rotor.turns_freely else 0.0,
        eccentricity=eccentricity,
        anomaly_rate=anomaly_rate,
        gradient=gradient,
        to_pericentre=to_pericentre,
        ahead=ahead,
        slow_rate=1e-3 * np.sqrt(np.abs(gradient) + weight / size),
        does_work=np.any(eccentricity) or np.any(system.torque_b) or system.rotor_torque != 0.0,
    )


def initial_values(system: System, state: State) -> np.ndarray:
    """Return the variables (..., SIZE) of a state, with the direction of the centre at f = 0."""
    y = np.zeros((*np.shape(state.q_ib)[:-1], SIZE))
    y[..., Q : Q + 4] = state.q_ib
    y[..., OMEGA : OMEGA + 3] = state.omega_bi_b
    y[..., CENTRE] = 1.0
    y[..., MOMENTUM] = system.rotor.axial_momentum(state.rotor_speed, state.omega_bi_b)
    y[..., ANGLE] = state.rotor_angle if system.rotor.turns_freely else 0.0
    return y


@inlined
def rates(y, of):
    """Return dy/dt of the variables y, both tuples of SIZE, for the constants `of`."""
    q, omega, cos_f, sin_f, p = y[0:4], y[4:7], y[7], y[8], y[9]

    rho = 1.0 + of.eccentricity * cos_f
    f_dot = of.anomaly_rate * rho * rho
    gradient = of.gradient * rho * rho * rho
    c = to_body(q, add(scale(cos_f, of.to_pericentre), scale(sin_f, of.ahead)))
    I_c = apply(of.inertia, c)

    gravity = cross(c, add(scale(gradient, I_c), of.weight_moment))
    momentum = add(apply(of.carrier_inertia, omega), scale(p, of.rotor_axis))
    torque = add(add(cross(momentum, omega), gravity), of.applied)
    omega_dot = apply(of.carrier_inverse, torque)

    power = 0.0
    if of.does_work:
        t = to_body(q, add(scale(-sin_f, of.to_pericentre), scale(cos_f, of.ahead)))
        r_dot_r = of.eccentricity * sin_f * f_dot / rho
        orbital = gradient * (f_dot * dot(I_c, t) - 1.5 * r_dot_r * dot(I_c, c))
        power = dot(of.applied, omega) + orbital
    return (
        0.5 * (q[3] * omega[0] + q[1] * omega[2] - q[2] * omega[1]),
        0.5 * (q[3] * omega[1] + q[2] * omega[0] - q[0] * omega[2]),
        0.5 * (q[3] * omega[2] + q[0] * omega[1] - q[1] * omega[0]),
        -0.5 * (q[0] * omega[0] + q[1] * omega[1] + q[2] * omega[2]),
        omega_dot[0],
        omega_dot[1],
        omega_dot[2],
        -f_dot * sin_f,
        f_dot * cos_f,
        of.rotor_torque,
        p * of.rotor_inertia_inverse - dot(of.rotor_axis, omega),
        power,
    )


def _plain(part):
    """Return an array as a number or as tuples of numbers."""
    return tuple(_plain(each) for each in part) if np.ndim(part) else float(part)

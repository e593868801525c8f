"""
The equations of motion of a gyrostat in a Newtonian field, as on the textbook page.

    q' = q (omega, 0) / 2 - (Omega, 0) q / 2
    K omega' = (K omega + sum p a + h) x omega + (3 mu / r^3) c x I c - m x c
               + torque - sum p' a
    p' = tau - b s - C tanh(s / s_c),   s = p / J - a . omega          for every turning rotor
    p' = J a . omega'                                        of one that is held (drives.py)
    pi' = -k(eta) - b(eta'),   eta' = pi - d . omega         for every mode of a part inside

I is the inertia, K that of what turns with the body (carrier_inertia of system.py), p, a, tau, b,
C, s and J are the momentum, axis, motor torque, friction, speed and inertia of a rotor with a
speed of its own (rotor.py), h is the momentum of those of constant momentum, c the unit vector
from the attracting centre and m the weight moment.  A mode (inner_mode.py) with its spring k and
its friction b adds pi d to the momentum and -pi' d to the torque, as a rotor does p a and -p' a.

q is the attitude in axes that coincide with the inertial ones at the start and turn with a
circular orbit, at the rate Omega about its normal; in them c stays where it is.  On an ellipse
they do not turn, Omega = 0.  With f in these axes, c = cos f P + sin f Q and 1 + e cos f =: rho,

    v = sqrt(mu / l^3) rho^2,    3 mu / r^3 = (3 mu / l^3) rho^3,    l the semi-latus rectum,

where v is the rate at which c turns.  On an ellipse f is the true anomaly, f' = v; on a circle
f = 0; a fixed direction has v = 0 too.  Where the orbit is a table, c, t, v and r' / r come from
the tabled r and r'.  Two quadratures go with them: each rotor's angle, and the
work W by which the energy omega . K omega / 2 + V + m . c changes, V = (3 mu / 2 r^3) c . I c:
that of the applied torques and of the rotors, of the friction of modes (whose energy pi^2 / 2 and
that of whose springs count), and with t = -sin f P + cos f Q, the unit vector
along track, that of the orbit, v (3 mu / r^3) t . I c - 3 (r' / r) V.
"""

from typing import Any

from ..kernel.functions import cos, divide, sin, sqrt, tanh
from ..kernel.time_table import interpolate_vector
from ..kernel.vector import (
    Vector,
    add,
    apply,
    attitude_rate,
    cross,
    dot,
    scale,
    subtract,
    to_body,
)
from ..orbits.tabled import POSITION, SLOPE, VELOCITY
from ..torques.sums import (
    rates_of_states,
    sum_of_fields,
    sum_of_orbit_powers,
    sum_of_torques,
)
from .constants import Constants
from .variables import Variables

_POSITION, _SLOPE, _VELOCITY = int(POSITION[0]), int(SLOPE[0]), int(VELOCITY[0])


def rotor_speeds(y: Vector, constants: Constants) -> list[Any]:
    """Return s = p / J - a . omega of every turning rotor."""
    parts = Variables.of(constants)
    return [
        p * rotor.inertia_inverse - dot(rotor.axis, y[parts.rate])
        for p, rotor in zip(y[parts.momenta], constants.rotors, strict=True)
    ]


def modal_rates(y: Vector, constants: Constants) -> list[Any]:
    """Return eta' = pi - d . omega of every mode."""
    parts = Variables.of(constants)
    return [
        pi - dot(mode.coupling, y[parts.rate])
        for pi, mode in zip(y[parts.modal_momenta], constants.modes, strict=True)
    ]


def rates(t_s: Any, y: Vector, constants: Constants) -> Vector:
    """Return dy/dt of the variables y, both tuples of the same size; t_s: from tick 0."""
    parts, rotors = Variables.of(constants), constants.rotors
    q, omega = y[parts.attitude], y[parts.rate]
    c_i, t_i, gradient, v, growth_rate = seen_centre(t_s, y, constants)
    c = to_body(q, c_i)

    s = rotor_speeds(y, constants)
    H = add(constants.momentum, apply(constants.carrier_inertia, omega))
    seen = seen_by_torques(t_s, y, constants)
    applied = sum_of_torques(constants.torques, seen)
    H, applied, p_dot = _with_rotors(H, applied, s, y, constants)
    eta_dot = modal_rates(y, constants)
    H, on_body, pi_dot, damped = _with_modes(H, applied, eta_dot, y, constants)
    field = sum_of_fields(constants.torques, c, gradient)
    torque = add(add(on_body, cross(H, omega)), cross(c, field))
    omega_dot = apply(constants.carrier_inverse, torque)

    power = 0.0
    if constants.does_work:
        t = to_body(q, t_i)
        orbit_power = sum_of_orbit_powers(constants.torques, c, t, gradient, v, growth_rate)
        power = dot(applied, omega) + orbit_power
        if constants.modes:
            power = power - damped
    for i, event in enumerate(constants.events):
        p_dot_held = event.held_inertia * dot(rotors[i].axis, omega_dot)
        p_dot[i] = p_dot[i] + p_dot_held
        if constants.does_work:
            power = power - p_dot_held * dot(rotors[i].axis, omega)
    q_dot = attitude_rate(q, omega, scale(constants.axes_rate, constants.normal))
    cos_f, sin_f = cos_and_sin_of_anomaly(y, constants)
    anomaly_dot = (-v * sin_f, v * cos_f) if constants.integrates_anomaly else ()
    return parts.joined(
        attitude=q_dot,
        rate=omega_dot,
        momenta=p_dot,
        angles=s,
        modal_momenta=pi_dot,
        displacements=eta_dot,
        of_torques=rates_of_states(constants.torques, seen),
        work=(power,),
        anomaly=anomaly_dot,
    )


def _with_rotors(H, torque, s, y, constants):
    """Return H and the torque on the body with those of the rotors, and p' of each, not held."""
    parts, rotors, p_dot = Variables.of(constants), constants.rotors, []
    for i, (rotor, p) in enumerate(zip(rotors, y[parts.momenta], strict=True)):
        H = add(H, scale(p, rotor.axis))
        friction = rotor.friction * s[i]
        if constants.coulomb:
            dry = constants.coulomb[i]
            friction = friction + dry.torque * tanh(dry.per_speed * s[i])
        torque = add(torque, scale(friction, rotor.axis))
        p_dot.append(rotor.torque - friction)
    for imbalance, s_i, angle in zip(constants.imbalances, s, y[parts.angles], strict=False):
        turning = add(scale(cos(angle), imbalance.along), scale(sin(angle), imbalance.across))
        torque = add(torque, scale(s_i * s_i, turning))
    return H, torque, p_dot


def _with_modes(H, torque, eta_dot, y, constants):
    """Return H and the torque on the body with those of the modes, pi' of each, and the losses."""
    parts, pi_dot, losses = Variables.of(constants), [], 0.0
    both = zip(y[parts.modal_momenta], y[parts.displacements], strict=True)
    for mode, (pi, eta), rate in zip(constants.modes, both, eta_dot, strict=True):
        H = add(H, scale(pi, mode.coupling))
        friction = mode.friction(rate)
        force = mode.spring(eta) + friction
        torque = add(torque, scale(force, mode.coupling))
        pi_dot.append(-force)
        losses = losses + friction * rate
    return H, torque, pi_dot, losses


def cos_and_sin_of_anomaly(y: Vector, constants: Constants) -> Vector:
    """Return cos f and sin f, which on a circle are those of f = 0."""
    return y[Variables.of(constants).anomaly] if constants.integrates_anomaly else (1.0, 0.0)


def seen_by_torques(t_s: Any, y: Vector, constants: Constants) -> tuple[Any, ...]:
    """Return t_s, r, v, q, omega, axes as in the equations, and what torques have of their own."""
    if constants.table:
        table = constants.table[0].table
        r, v = interpolate_vector(table, _POSITION, t_s), interpolate_vector(table, _VELOCITY, t_s)
    else:
        cos_f, sin_f = cos_and_sin_of_anomaly(y, constants)
        P, Q_ = constants.outward, constants.ahead
        e, l = constants.eccentricity, constants.semi_latus_rectum
        r = scale(divide(l, 1.0 + e * cos_f), add(scale(cos_f, P), scale(sin_f, Q_)))
        v = scale(constants.speed, add(scale(-sin_f, P), scale(e + cos_f, Q_)))
    parts = Variables.of(constants)
    return t_s, r, v, y[parts.attitude], y[parts.rate], y[parts.of_torques]


def seen_centre(t_s: Any, y: Vector, constants: Constants) -> tuple[Any, ...]:
    """Return c, the direction t along track, 3 mu / r^3, v and r' / r, in the equations' axes."""
    if constants.table:
        return _centre_in_table(t_s, *constants.table[0])
    cos_f, sin_f = cos_and_sin_of_anomaly(y, constants)
    P, Q_ = constants.outward, constants.ahead
    rho = 1.0 + constants.eccentricity * cos_f
    v = constants.anomaly_rate * rho * rho
    gradient = constants.gradient * rho * rho * rho
    c = add(scale(cos_f, P), scale(sin_f, Q_))
    t = add(scale(-sin_f, P), scale(cos_f, Q_))
    return c, t, gradient, v, divide(constants.eccentricity * sin_f * v, rho)


def _centre_in_table(t_s, pull, table):
    r = interpolate_vector(table, _POSITION, t_s)
    slope = interpolate_vector(table, _SLOPE, t_s)
    distance = sqrt(dot(r, r))
    c = scale(divide(1.0, distance), r)
    climb = dot(c, slope)
    across = subtract(slope, scale(climb, c))
    speed = sqrt(dot(across, across))
    gradient = divide(pull, distance * distance * distance)
    t = scale(divide(1.0, speed), across)
    return c, t, gradient, divide(speed, distance), divide(climb, distance)

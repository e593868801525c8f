"""
The equations of motion of a gyrostat in a Newtonian field, as on the textbook page.

    q' = q (omega, 0) / 2 - (Omega, 0) q / 2
    K omega' = (K omega + sum p a + h) x omega + (3 mu / r^3) c x I c - m x c
               + torque - sum p' a
    p' = tau - b s - C tanh(s / s_c),   s = p / J - a . omega          for every turning rotor
    p' = J a . omega'                                        of one that is held (drives.py)

I is the inertia, K that of what turns with the body (carrier_inertia of system.py), p, a, tau, b,
C, s and J are the momentum, axis, motor torque, friction, speed and inertia of a rotor with a
speed of its own (rotor.py), h is the momentum of those of constant momentum, c the unit vector
from the attracting centre and m the weight moment.

q is the attitude in axes that coincide with the inertial ones at the start and turn with a
circular orbit, at the rate Omega about its normal; in them c stays where it is.  On an ellipse
they do not turn, Omega = 0.  With f in these axes, c = cos f P + sin f Q and 1 + e cos f =: rho,

    v = sqrt(mu / l^3) rho^2,    3 mu / r^3 = (3 mu / l^3) rho^3,    l the semi-latus rectum,

where v is the rate at which c turns.  On an ellipse f is the true anomaly, f' = v; on a circle
f = 0; a fixed direction has v = 0 too.  Where the orbit is a table, c, t, v and r' / r come from
the tabled r and r'.  Two quadratures go with them: each rotor's angle, and the
work W by which the energy omega . K omega / 2 + V + m . c changes, V = (3 mu / 2 r^3) c . I c:
that of the applied torques and of the rotors, and with t = -sin f P + cos f Q, the unit vector
along track, that of the orbit, v (3 mu / r^3) t . I c - 3 (r' / r) V.
"""

import math
from typing import Any

import numpy as np

from ..kernel.compile import inlined
from ..kernel.simd import broadcast
from ..kernel.time_table import interpolate_vector
from ..kernel.unroll import unrolled_fold, unrolled_map
from ..kernel.vector import add, add_cross, apply, attitude_rate, dot, scale, subtract, to_body
from ..orbits.tabled import POSITION, SLOPE, VELOCITY
from ..torques.sums import add_fields, add_orbit_powers, add_torques
from .constants import Constants
from .system import State, System

_POSITION, _SLOPE, _VELOCITY = int(POSITION[0]), int(SLOPE[0]), int(VELOCITY[0])

# The variables of the integration: q (4), omega_bi_b (3), then p of every turning rotor, the angle
# of every one, the work, and on an ellipse cos f and sin f.
Q, OMEGA, MOMENTUM = 0, 4, 7


def initial_values(system: System, state: State) -> np.ndarray:
    """Return the variables (..., V) of a state at the start, the place as of f = 0."""
    turning = system.turning_rotors
    place = (1.0, 0.0) if system.integrates_place else ()
    size = MOMENTUM + 2 * len(turning) + 1
    y = np.zeros((*np.shape(state.q_ib)[:-1], size + len(place)))
    y[..., Q : Q + 4] = state.q_ib
    y[..., OMEGA : OMEGA + 3] = state.omega_bi_b
    y[..., size:] = place
    for n, (i, rotor) in enumerate(turning):
        p = rotor.axial_momentum(state.rotor_speed[..., i], state.omega_bi_b)
        y[..., MOMENTUM + n] = p
        y[..., MOMENTUM + len(turning) + n] = state.rotor_angle[..., i]
    return y


@unrolled_map
def _speeds(i, rotors, y):
    """Return s = p / J - a . omega."""
    rotor = rotors[i]
    return y[MOMENTUM + i] * rotor.inertia_inverse - dot(rotor.axis, y[4:7])


@unrolled_fold
def _plus_momenta(total, i, rotors, y):
    """Add p a."""
    return add(total, scale(y[MOMENTUM + i], rotors[i].axis))


@unrolled_fold
def _plus_frictions(total, i, rotors, s):
    """Add b s a."""
    return add(total, scale(rotors[i].friction * s[i], rotors[i].axis))


@unrolled_map
def place_of(i: int, place: tuple[float, ...], y: tuple[float, ...]) -> float:
    """Return cos f and sin f among the variables y, on a circle none."""
    return y[len(y) - len(place) + i]


@unrolled_map
def _place_rates(i, place, v, cos_f, sin_f):
    """Return their derivatives."""
    return v * (-sin_f, cos_f)[i]


@unrolled_map
def _momentum_rates(i, rotors, s):
    """Return p' = tau - b s."""
    return rotors[i].torque - rotors[i].friction * s[i]


@unrolled_fold
def _with_coulomb(p_dot, i, coulomb, s):
    """Return p' less Coulomb's friction."""
    return _less_coulomb(coulomb[i].torque, coulomb[i].per_speed, p_dot, s)


@unrolled_map
def _less_coulomb(i, torque, per_speed, p_dot, s):
    return p_dot[i] - torque[i] * math.tanh(per_speed[i] * s[i])


@unrolled_fold
def _plus_coulomb(total, i, coulomb, rotors, s):
    """Add C tanh(s / s_c) a of each rotor."""
    return _plus_dry(total, coulomb[i].torque, coulomb[i].per_speed, rotors, s)


@unrolled_fold
def _plus_dry(total, i, torque, per_speed, rotors, s):
    return add(total, scale(torque[i] * math.tanh(per_speed[i] * s[i]), rotors[i].axis))


@unrolled_fold
def _plus_imbalance(total, i, imbalances, s, y):
    """Add s^2 (cos theta along + sin theta across), which turns with the angle of a rotor."""
    imbalance, angle = imbalances[i], y[MOMENTUM + len(imbalances) + i]
    along = scale(math.cos(angle), imbalance.along)
    across = scale(math.sin(angle), imbalance.across)
    return add(total, scale(s[i] * s[i], add(along, across)))


@unrolled_fold
def _with_held(p_dot, i, drives, rotors, omega_dot):
    """Return p' with that of the rotors that are held at their speed, J a . omega'."""
    return _plus_held(drives[i].watches, rotors, p_dot, omega_dot)


@unrolled_map
def _plus_held(i, watches, rotors, p_dot, omega_dot):
    return p_dot[i] + watches[i].held_inertia * dot(rotors[i].axis, omega_dot)


@unrolled_fold
def _less_held_powers(power, i, drives, rotors, omega, omega_dot):
    """Subtract the work that these rotors take."""
    return _less_held_power(power, drives[i].watches, rotors, omega, omega_dot)


@unrolled_fold
def _less_held_power(power, i, watches, rotors, omega, omega_dot):
    a = rotors[i].axis
    return power - watches[i].held_inertia * dot(a, omega_dot) * dot(a, omega)


@inlined
def place_at(constants: Constants) -> int:
    """Return where among the variables cos f is, on an ellipse."""
    return MOMENTUM + 2 * len(constants.rotors) + 1


@inlined
def seen_by_torques(t_s: float, y: tuple[float, ...], constants: Constants) -> tuple[Any, ...]:
    """Return t_s, r, v, q and omega of the variables y, in the axes of the equations."""
    cos_f, sin_f = place_in_orbit(y, constants)
    P, Q_ = constants.outward, constants.ahead
    distance = constants.semi_latus_rectum / (1.0 + constants.eccentricity * cos_f)
    r = scale(distance, add(scale(cos_f, P), scale(sin_f, Q_)))
    along = add(scale(-sin_f, P), scale(constants.eccentricity + cos_f, Q_))
    r, v = _in_table((r, scale(constants.speed, along)), constants.table, t_s)
    return t_s, r, v, y[0:4], y[4:7]


@unrolled_fold
def _in_table(_, i, tables, t_s):
    """Return r and v of a table in place of those of an ellipse."""
    table = tables[i].table
    return interpolate_vector(table, _POSITION, t_s), interpolate_vector(table, _VELOCITY, t_s)


@inlined
def seen_centre(t_s: float, y: tuple[float, ...], constants: Constants) -> tuple[Any, ...]:
    """Return c, the direction t along track, 3 mu / r^3, v and r' / r, in the equations' axes."""
    cos_f, sin_f = place_in_orbit(y, constants)
    rho = 1.0 + constants.eccentricity * cos_f
    v = constants.anomaly_rate * rho * rho
    gradient = constants.gradient * rho * rho * rho
    P, Q_ = constants.outward, constants.ahead
    c = add(scale(cos_f, P), scale(sin_f, Q_))
    t = add(scale(-sin_f, P), scale(cos_f, Q_))
    growth_rate = constants.eccentricity * sin_f * v / rho
    return _centre_in_table((c, t, gradient, v, growth_rate), constants.table, t_s)


@unrolled_fold
def _centre_in_table(_, i, tables, t_s):
    """Return what seen_centre returns of a table in place of that of an ellipse."""
    r, slope = (
        interpolate_vector(tables[i].table, _POSITION, t_s),
        interpolate_vector(tables[i].table, _SLOPE, t_s),
    )
    distance = math.sqrt(dot(r, r))
    c = scale(1.0 / distance, r)
    climb = dot(c, slope)
    across = subtract(slope, scale(climb, c))
    speed = math.sqrt(dot(across, across))
    gradient = tables[i].pull / (distance * distance * distance)
    return c, scale(1.0 / speed, across), gradient, speed / distance, climb / distance


@inlined
def place_in_orbit(y: tuple[float, ...], constants: Constants) -> tuple[float, float]:
    """Return cos f and sin f, which on a circle are those of f = 0."""
    at_rest = broadcast(1.0, y[0]), broadcast(0.0, y[0])
    return (place_of(constants.place, y) + at_rest)[0:2]


@inlined
def rates(t_s: float, y: tuple[float, ...], constants: Constants) -> tuple[float, ...]:
    """Return dy/dt of the variables y, both tuples of the same size; t_s: from tick 0."""
    q, omega = y[0:4], y[4:7]
    c_i, t_i, gradient, v, growth_rate = seen_centre(t_s, y, constants)
    c = to_body(q, c_i)

    s = _speeds(constants.rotors, y)
    p_dot = _with_coulomb(_momentum_rates(constants.rotors, s), constants.coulomb, s)
    H = add(constants.momentum, apply(constants.carrier_inertia, omega))
    H = _plus_momenta(H, constants.rotors, y)
    nothing = broadcast(0.0, y[0])
    none = nothing, nothing, nothing
    applied = add_torques(none, constants.torques, seen_by_torques(t_s, y, constants))
    applied = _plus_frictions(applied, constants.rotors, s)
    applied = _plus_coulomb(applied, constants.coulomb, constants.rotors, s)
    applied = _plus_imbalance(applied, constants.imbalances, s, y)
    field = add_fields(none, constants.torques, c, gradient)
    torque = add_cross(add_cross(applied, H, omega), c, field)
    omega_dot = apply(constants.carrier_inverse, torque)
    p_dot = _with_held(p_dot, constants.drives, constants.rotors, omega_dot)

    power = nothing
    if constants.does_work:
        t = to_body(q, t_i)
        power = dot(applied, omega)
        power = _less_held_powers(power, constants.drives, constants.rotors, omega, omega_dot)
        power = add_orbit_powers(power, constants.torques, c, t, gradient, v, growth_rate)
    q_dot = attitude_rate(q, omega, scale(constants.axes_rate, constants.normal))
    cos_f, sin_f = place_in_orbit(y, constants)
    place_dot = _place_rates(constants.place, v, cos_f, sin_f)
    return q_dot + omega_dot + p_dot + s + (power,) + place_dot

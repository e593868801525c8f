"""
The equations of motion of a gyrostat in a Newtonian field, as on the textbook page.

    q' = q (omega, 0) / 2
    K omega' = (K omega + sum p a) x omega + (3 mu / r^3) c x I c - m x c + torque - sum p' a
    p' = tau - b s,   s = p / J - a . omega                                   for every rotor

I is the inertia, K that of what turns with the body (carrier_inertia of system.py), p, a, tau, b,
s and J are a rotor's momentum, axis, motor torque, friction, speed and inertia (rotor.py; a
constant momentum has p' = 0), c is the unit vector from the attracting centre and m the weight
moment.
With the true anomaly f, c = cos f P + sin f Q and 1 + e cos f =: rho,

    f' = sqrt(mu / l^3) rho^2,    3 mu / r^3 = (3 mu / l^3) rho^3,    l the semi-latus rectum.

A fixed direction is the case f' = 0.  Two quadratures go with them: each rotor's angle, and the
work W by which the energy omega . K omega / 2 + V + m . c changes, V = (3 mu / 2 r^3) c . I c:
that of the applied torques and of the rotors, and with t = -sin f P + cos f Q, the unit vector
along track, that of the orbit, f' (3 mu / r^3) t . I c - 3 (r' / r) V.
"""

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ..compiled import inlined, replaced
from .orbit import FixedDirection
from .rotor import Rotor
from .system import State, System
from .vector import add, apply, cross, dot, scale, to_body

# The variables of the integration: q_ib (4), omega_bi_b (3), cos f, sin f, then p of every rotor,
# the angle of every rotor, and the work.
Q, OMEGA, CENTRE, MOMENTUM = 0, 4, 7, 9


# Tuples in compiled code, matrices by rows; arrays while they are made from one system or many.
Vector = tuple[float, ...] | np.ndarray
Matrix = tuple[tuple[float, ...], ...] | np.ndarray


class RotorParameters(NamedTuple):
    """The constants of one rotor; inertia_inverse: 1 / J, zero for a constant momentum."""

    axis: Vector
    torque: float
    friction: float
    inertia_inverse: float


class Parameters(NamedTuple):
    """
    The constants of one motion as plain numbers; matrices are tuples of rows.

    applied [N m]: torque - sum tau a.  slow_rate [rad/s]: far below the rates at which the field
    swings the body, for a body at rest.  rotors: at least one, so that the compiler knows the type
    of all; where there is none, one without momentum.  zeros: one per rotor.
    """

    inertia: Matrix
    carrier_inertia: Matrix
    carrier_inverse: Matrix
    weight_moment: Vector
    applied: Vector
    eccentricity: float
    anomaly_rate: float
    gradient: float
    to_pericentre: Vector
    ahead: Vector
    slow_rate: float
    does_work: bool
    rotors: tuple[RotorParameters, ...]
    zeros: tuple[float, ...]


def parameters(system: System) -> Parameters:
    """Return the constants of the equations for a system."""
    undriven = _undriven_parameters(system.undriven)
    rotors = zip(undriven.rotors, system.flown_rotors, strict=True)
    return undriven._replace(
        applied=tuple(_applied(system).tolist()),
        does_work=undriven.does_work or system.is_driven,
        rotors=tuple(
            rotor._replace(torque=float(system.rotor_torque[i])) for rotor, (i, _) in rotors
        ),
    )


# A controller drives the same system anew at every tick.
_known: WeakKeyDictionary[System, Parameters] = WeakKeyDictionary()


def _undriven_parameters(system):
    if system not in _known:
        constants = _constants(system)
        plain = _as_tuples(constants)
        _known[system] = plain._replace(does_work=bool(constants.does_work))
    return _known[system]


def numbers_of_many(system: System, count: int) -> tuple[Parameters, np.ndarray]:
    """
    Return the numbers of the Parameters of count systems, one after the other, (count, P).

    The Parameters returned before them tell the number of rotors and whether work is done, the
    same for all.
    """
    constants = _constants(system)
    rotors = (Rotor('constant_momentum'),) * len(constants.rotors)
    one = parameters(System(np.eye(3), rotors))
    rows = [
        np.broadcast_to(np.reshape(part, (-1, np.size(field))), (count, np.size(field)))
        for part, field in zip(_leaves(constants), _leaves(one), strict=True)
    ]
    return one._replace(does_work=bool(constants.does_work)), np.concatenate(rows, axis=1)


# What overflows in these two halts the propagation; a warning would come before its sentence.
@np.errstate(over='ignore', invalid='ignore')
def _applied(system):
    applied = system.torque_b
    for rotor, torque in zip(system.rotors, system.rotor_torque, strict=True):
        if torque:
            applied = applied - torque * rotor.axis
    return applied


@np.errstate(over='ignore', invalid='ignore')
def _constants(system):
    """Return the Parameters as arrays, of a system whose own constants may be arrays."""
    orbit, flown = system.orbit, system.flown_rotors
    if isinstance(orbit, FixedDirection):
        eccentricity, anomaly_rate, gradient = 0.0, 0.0, orbit.gradient
        to_pericentre, ahead = orbit.direction(0.0), np.zeros(3)
    else:
        eccentricity = orbit.eccentricity
        anomaly_rate = np.sqrt(orbit.mu / orbit.semi_latus_rectum) / orbit.semi_latus_rectum
        gradient = 3.0 * anomaly_rate**2
        to_pericentre, ahead = orbit.perifocal[..., 0], orbit.perifocal[..., 1]
    weight = np.linalg.norm(system.weight_moment, axis=-1)
    size = np.trace(system.inertia, axis1=-2, axis2=-1)
    return Parameters(
        inertia=system.inertia,
        carrier_inertia=system.carrier_inertia,
        carrier_inverse=system.carrier_inverse,
        weight_moment=system.weight_moment,
        applied=_applied(system),
        eccentricity=eccentricity,
        anomaly_rate=anomaly_rate,
        gradient=gradient,
        to_pericentre=to_pericentre,
        ahead=ahead,
        slow_rate=1e-3 * np.sqrt(np.abs(gradient) + weight / size),
        does_work=system.is_driven or bool(np.count_nonzero(eccentricity)),
        rotors=tuple(
            RotorParameters(
                axis=rotor.axis,
                torque=system.rotor_torque[i],
                friction=rotor.friction if rotor.turns_freely else 0.0,
                inertia_inverse=1.0 / rotor.inertia if rotor.turns_freely else 0.0,
            )
            for i, rotor in flown
        ),
        zeros=(0.0,) * len(flown),
    )


def initial_values(system: System, state: State) -> np.ndarray:
    """Return the variables (..., V) of a state, with the direction of the centre at f = 0."""
    flown = system.flown_rotors
    y = np.zeros((*np.shape(state.q_ib)[:-1], MOMENTUM + 2 * len(flown) + 1))
    y[..., Q : Q + 4] = state.q_ib
    y[..., OMEGA : OMEGA + 3] = state.omega_bi_b
    y[..., CENTRE] = 1.0
    for n, (i, rotor) in enumerate(flown):
        if rotor.turns_freely:
            p = rotor.axial_momentum(state.rotor_speed[..., i], state.omega_bi_b)
            y[..., MOMENTUM + n] = p
            y[..., MOMENTUM + len(flown) + n] = state.rotor_angle[..., i]
        else:
            y[..., MOMENTUM + n] = rotor.momentum
    return y


@inlined
def rates(y: tuple[float, ...], constants: Parameters) -> tuple[float, ...]:
    """Return dy/dt of the variables y, both tuples of the same size."""
    q, omega, cos_f, sin_f = y[0:4], y[4:7], y[7], y[8]

    rho = 1.0 + constants.eccentricity * cos_f
    f_dot = constants.anomaly_rate * rho * rho
    gradient = constants.gradient * rho * rho * rho
    P, Q_ = constants.to_pericentre, constants.ahead
    c = to_body(q, add(scale(cos_f, P), scale(sin_f, Q_)))
    I_c = apply(constants.inertia, c)

    momentum, applied = apply(constants.carrier_inertia, omega), constants.applied
    p_dot, speed = constants.zeros, constants.zeros
    for i in range(len(constants.rotors)):
        rotor, p = constants.rotors[i], y[MOMENTUM + i]
        s = p * rotor.inertia_inverse - dot(rotor.axis, omega)
        friction = rotor.friction * s
        momentum = add(momentum, scale(p, rotor.axis))
        applied = add(applied, scale(friction, rotor.axis))
        p_dot = replaced(p_dot, i, rotor.torque - friction)
        speed = replaced(speed, i, s)

    gravity = cross(c, add(scale(gradient, I_c), constants.weight_moment))
    torque = add(add(cross(momentum, omega), gravity), applied)
    omega_dot = apply(constants.carrier_inverse, torque)

    power = 0.0
    if constants.does_work:
        t = to_body(q, add(scale(-sin_f, P), scale(cos_f, Q_)))
        r_dot_r = constants.eccentricity * sin_f * f_dot / rho
        orbital = gradient * (f_dot * dot(I_c, t) - 1.5 * r_dot_r * dot(I_c, c))
        power = dot(applied, omega) + orbital
    q_dot = (
        0.5 * (q[3] * omega[0] + q[1] * omega[2] - q[2] * omega[1]),
        0.5 * (q[3] * omega[1] + q[2] * omega[0] - q[0] * omega[2]),
        0.5 * (q[3] * omega[2] + q[0] * omega[1] - q[1] * omega[0]),
        -0.5 * (q[0] * omega[0] + q[1] * omega[1] + q[2] * omega[2]),
    )
    return q_dot + omega_dot + (-f_dot * sin_f, f_dot * cos_f) + p_dot + speed + (power,)


def _as_tuples(part):
    """Return arrays as numbers or as tuples of numbers; tuples with names keep them."""
    if isinstance(part, tuple):
        inner = map(_as_tuples, part)
        return type(part)(*inner) if hasattr(part, '_fields') else tuple(inner)
    if isinstance(part, np.ndarray) and part.ndim:
        rows = part.tolist()
        return tuple(map(tuple, rows)) if part.ndim > 1 else tuple(rows)
    return float(part)


def _leaves(part):
    """Yield the arrays of Parameters, one after the other."""
    rotors = tuple(each for rotor in part.rotors for each in rotor)
    yield from part[: part._fields.index('rotors')]
    yield from rotors
    yield from part.zeros

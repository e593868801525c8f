"""Tables of torques, of the angular momentum, and of the forms of the inertia."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..kernel.rows import components, from_components, times
from ..orbits.pieces import by_piece, tables_of
from ..torques.body_torque import BodyTorque, pieces_of
from ..torques.sums import sum_of_forces, sum_of_potentials, sum_of_torques
from .motion import States
from .system import State, System


def own_torque(torques: Sequence[BodyTorque], states: States) -> np.ndarray:
    """Return the sum of some torques [N m] in body axes on a table of states, (..., 3)."""
    return _on_rows(sum_of_torques, torques, states, 3)


def own_force(torques: Sequence[BodyTorque], states: States) -> np.ndarray:
    """Return the sum of the forces of some torques [N] in body axes, (..., 3)."""
    return _on_rows(sum_of_forces, torques, states, 3)


def own_potential(torques: Sequence[BodyTorque], states: States) -> np.ndarray:
    """Return the sum of the potentials of some torques [J] on a table of states, (...)."""
    return _on_rows(sum_of_potentials, torques, states)


def with_inner(system: System, state: State, start_s: float) -> State:
    """
    Return a state at start_s from tick 0 with the variables that torques have of their own.

    ValueError: what depends on time alone is not known then.
    """
    inner = dict(state.inner)
    if not any(torque.states for torque in system.torques):
        return state
    for torque in system.torques:
        if {*torque.inner_names} <= inner.keys():
            continue
        values = torque.initial
        if callable(values):
            (r_i,), (v_i,) = system.orbit.position_velocity(np.array([start_s]))
            table_of = tables_of({each: each.piece_at(start_s) for each in torque.pieces.values()})
            vectors = (tuple(x.tolist()) for x in (r_i, v_i, state.q_ib, state.omega_bi_b))
            values = values(start_s, *vectors, torque.constants_with(table_of))
        inner = dict(zip(torque.inner_names, map(float, values), strict=True)) | inner
    return State(state.q_ib, state.omega_bi_b, state.rotor_speed, state.rotor_angle, inner)


def without_number(system: System, state: State, t_s: float) -> BodyTorque | None:
    """Return the first torque of one's own that is no number at t_s from tick 0, or just then."""
    at_s = np.array([t_s, t_s + 1e-9 * max(1.0, abs(t_s))])
    rows = np.full((2, len(system.rotors)), np.nan)
    q_ib, omega_bi_b = (np.tile(x, (2, 1)) for x in (state.q_ib, state.omega_bi_b))
    inner = {name: np.full(2, x) for name, x in state.inner.items()}
    states = States(
        at_s, q_ib, omega_bi_b, rows, rows, np.zeros(2), system.orbit, at_s, inner=inner
    )
    own = (torque for torque in system.torques if not torque.is_shipped())
    return next((t for t in own if not np.isfinite(own_torque((t,), states)).all()), None)


def _on_rows(sum_of: Callable[..., Any], torques, states, *width):
    """Return what the equations take from torques, as columns of a table of states."""
    *rows, _ = states.omega_bi_b.shape
    found = np.zeros((*rows, *width))

    def flat(table, *width):
        return np.broadcast_to(table, (*rows, *width)).reshape(-1, *width)

    t_s = flat(states.orbit_s)
    position, velocity = flat(states.r_i, 3), flat(states.v_i, 3)
    vectors = position, velocity, flat(states.q_ib, 4), flat(states.omega_bi_b, 3)
    # What a live page hears has none.
    names = [name for torque in torques for name in torque.inner_names]
    variables = [flat(states.inner.get(name, np.nan)) for name in names]
    flat_found = found.reshape(-1, *width)
    for chosen, current in by_piece(pieces_of(torques), t_s):
        seen = (
            t_s[chosen],
            *(tuple(components(vector[chosen])) for vector in vectors),
            tuple(own[chosen] for own in variables),
        )
        table_of = tables_of(current)
        constants = tuple(_as_columns(torque.constants_with(table_of)) for torque in torques)
        with np.errstate(all='ignore'):
            total = sum_of(constants, seen)
        if width:
            for i, component in enumerate(total):
                flat_found[chosen, i] = component
        else:
            flat_found[chosen] = total
    return found


def _as_columns(part):
    """Return nested tuples whose numbers divide as columns do, by zero too."""
    if isinstance(part, tuple):
        inner = map(_as_columns, part)
        return type(part)(*inner) if hasattr(part, '_fields') else tuple(inner)
    return np.float64(part) if isinstance(part, float) else part


def element_forces(
    masses: np.ndarray, positions_b: np.ndarray, c_b: np.ndarray, gravity: float, radius_m: float
) -> np.ndarray:
    """
    Return the pull (N, 3) [N] on elements of a body about a fixed point (Beletsky 1957, eq. 1).

    -(g / R) m x - m g c + 3 (g / R) m (c . x) c, to the first order in x / R; the moments x F add
    up to those of eq. 2.

    Parameters
    ----------
    masses : (N,), kg
        m
    positions_b : (N, 3), m, body axes
        x, from the fixed point
    c_b : (3,), body axes
        c, the unit vector from the attracting centre
    gravity : m/s^2
        g, at which a mass falls at the fixed point
    radius_m : m
        R, from the attracting centre to the fixed point
    """
    x, c = np.asarray(positions_b, float), np.asarray(c_b, float)
    along = (x @ c)[:, None] * c
    pull = gravity / radius_m * (3.0 * along - x) - gravity * c
    return np.asarray(masses, float)[:, None] * pull


def angular_momentum(
    system: System,
    omega_bi_b: np.ndarray,
    rotor_speed: np.ndarray,
    inner: Mapping[str, Any] | None = None,
) -> np.ndarray:
    """
    Return H = K omega + sum p a + sum pi d (..., 3) [N m s], in body axes.

    Parameters
    ----------
    system : System
        what moves
    omega_bi_b : (..., 3), rad/s, body axes
        rate
    rotor_speed : (..., R), rad/s
        nan where a rotor has none
    inner : dict of (...)
        inner coordinates, as in States
    """
    momentum = times(system.carrier_inertia, components(omega_bi_b))
    for i, rotor in enumerate(system.rotors):
        speed = rotor_speed[..., i] if rotor.turns_freely else np.nan
        p = rotor.axial_momentum(speed, omega_bi_b)
        axis = components(rotor.axis)
        momentum = [H + p * a for H, a in zip(momentum, axis, strict=True)]
    for mode in system.modes:
        pi = (inner or {}).get(mode.rate_name, 0.0) + mode.along(omega_bi_b)
        d = components(mode.coupling)
        momentum = [H + pi * d_i for H, d_i in zip(momentum, d, strict=True)]
    return from_components(momentum)


def forms_of_components(omega: Sequence, c: Sequence, K: Sequence, I: Sequence) -> tuple:
    """
    Return the components of K omega, |omega|, |K omega|, omega . K omega / 2 and c . I c.

    omega, c: three components; K, I: three rows of three entries.
    """
    x, y, z = omega
    K_x, K_y, K_z = K
    u, v, w = (
        K_x[0] * x + K_x[1] * y + K_x[2] * z,
        K_y[0] * x + K_y[1] * y + K_y[2] * z,
        K_z[0] * x + K_z[1] * y + K_z[2] * z,
    )
    rate, K_omega_size = np.sqrt(x * x + y * y + z * z), np.sqrt(u * u + v * v + w * w)
    kinetic = (x * u + y * v + z * w) / 2.0
    x, y, z = c
    I_x, I_y, I_z = I
    c_I_c = (
        x * (I_x[0] * x + I_x[1] * y + I_x[2] * z)
        + y * (I_y[0] * x + I_y[1] * y + I_y[2] * z)
        + z * (I_z[0] * x + I_z[1] * y + I_z[2] * z)
    )
    return u, v, w, rate, K_omega_size, kinetic, c_I_c

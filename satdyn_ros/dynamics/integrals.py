"""
The first integrals of every system: what a motion conserves, and by how much it fails to.

With K the carrier inertia, H = K omega + sum p a + sum pi d, T = (omega . K omega + sum pi^2) / 2
and the energy of the springs of modes (rotors and modes as in equations.py), c the unit vector
from the attracting centre, m the weight moment, V = (3 mu / 2 r^3) c . I c and nu the orbital rate
(other torques, which have potentials in the axes that are used, add those to energy and jacobi,
and leave no more than these and the momenta of rotors):

    energy          T + V + m . c                                         fixed direction
    area            H . c                                                 fixed direction
    fourth          |I omega|^2 - (3 mu / r^3) c . adj(I) c               rigid, fixed, m = 0
    jacobi          T - nu . H + V                                        circular orbit
    momentum        |H|                                                   no field, or a sphere
    axial_rate      omega . e                                             rigid, symmetric
    rotor_momentum  p; rotor_momentum.NAME of a named one                 no friction, no motor
    energy_balance  energy less the work done and less its first value    driven, or elliptic

Agostinelli 1977, eqs 3-6; Beletsky 1957; Balli and Grioli 1979.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..kernel.rows import components, dot, from_components, length, times
from .inertia import ROUNDING, principal_axes, symmetry_axes
from .motion import States
from .rotor import Rotor
from .system import System
from .torque import forms_of_components, own_potential, own_torque

# A named rotor's momentum has the name of the rotor behind it: rotor_momentum.NAME.
NAMES = (
    'energy',
    'area',
    'fourth',
    'jacobi',
    'momentum',
    'axial_rate',
    'rotor_momentum',
    'energy_balance',
)
_FROM_ROW_0 = np.zeros(1, int)


def first_integrals(system: System, states: States) -> dict[str, np.ndarray]:
    """
    Return what a motion conserves, name to values (N,), in SI units.

    Parameters
    ----------
    system : System
        what moves; systems of arrays broadcast against the states of many motions (M, N) and give
        (M, N), nan for motions that do not conserve an integral that others do
    states : States
        N rows of its motion
    """
    values = {name: sum(terms) for name, terms in _terms(_Parts.of(system, states)).items()}
    if 'energy_balance' in values:
        values['energy_balance'] = values['energy_balance'] - values['energy_balance'][..., :1]
    return values


def relative_drift(system: System, states: States) -> dict[str, np.ndarray]:
    """
    Return each first integral's change since row 0 (N,), relative to the size of its parts.

    The size is the largest since row 0.  An integral may be zero, and so may each of its terms:
    its size is that of the momenta and potentials behind them.  nan: the row's motion does not
    conserve it, others do.

    Parameters
    ----------
    system : System
        what moves
    states : States
        N rows of its motion
    """
    return drift_since(system, states, _FROM_ROW_0, applied_torque(system), {})[0]


def drift_since(
    system: System,
    states: States,
    since: np.ndarray,
    applied: np.ndarray,
    sizes_before: Mapping[str, np.ndarray],
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """
    Return relative_drift of motions that follow each other, and the sizes in their last row.

    Parameters
    ----------
    system : System
        what moves
    states : States
        N rows
    since : (N,)
        the row in which the motion of each began
    applied : (N,), N m
        its applied_torque
    sizes_before : dict
        the sizes up to row 0 of a motion that continues from other rows
    """
    parts, drift, last_sizes = _Parts.of(system, states), {}, {}
    sizes = _sizes(parts, applied)
    for name, terms in _terms(parts, since).items():
        value = sum(terms)
        change, size = value - value[..., since], sizes[name].copy()
        size[..., 0] = np.maximum(size[..., 0], sizes_before.get(name, 0.0))
        for begin, end in pairwise([*np.unique(since), size.shape[-1]]):
            rows = size[..., begin:end]
            np.maximum.accumulate(rows, axis=-1, out=rows)
        # What is zero in all its parts does not drift; nan: the motion does not conserve it.
        still = np.where(np.isnan(change), np.nan, 0.0)
        drift[name] = np.divide(change, size, out=still, where=size > 0.0)
        last_sizes[name] = size[..., -1]
    return drift, last_sizes


def conserve_alike(one: System, other: System) -> bool:
    """Whether two systems are of the same body and field, and conserve the same integrals."""
    return (
        one.undriven is other.undriven
        and len(one.torques) == len(other.torques)
        and all(map(_are_alike, one.torques, other.torques))
        and one.is_driven == other.is_driven
        and np.array_equal(one.rotor_torque != 0.0, other.rotor_torque != 0.0)
        and np.array_equal(np.isnan(one.rotor_target), np.isnan(other.rotor_target))
    )


def _are_alike(one, other):
    return one is other or (one.constants == other.constants and one.pieces == other.pieces)


def applied_torque(system: System) -> np.ndarray:
    """Return the size of the torque that acts on the body and those of the motors [N m]."""
    of_motors = np.sum(np.abs(system.rotor_torque))
    for rotor, target in zip(system.rotors, system.rotor_target, strict=True):
        if np.isfinite(target):
            torque = np.abs(rotor.inertia * rotor.speed_gain * target)
            of_motors = of_motors + np.minimum(torque, rotor.max_torque or np.inf)
    return length(system.torque_b) + of_motors


class _Parts(NamedTuple):
    """
    What the terms are made of: p (N,) of each rotor, pi and the stretch (N,) of each mode.

    The others are as of forms_of_components, and kinetic includes what the modes have.
    """

    system: System
    states: States
    p: list[np.ndarray]
    K_omega: Sequence[np.ndarray]
    rate: np.ndarray
    K_omega_size: np.ndarray
    kinetic: np.ndarray
    c_I_c: np.ndarray
    modal: list[tuple[np.ndarray, np.ndarray]]

    @classmethod
    def of(cls, system, states):
        omega, c, speeds = states.omega_bi_b, states.c_b, states.rotor_speed
        p = [rotor.axial_momentum(speeds[..., i], omega) for i, rotor in enumerate(system.rotors)]
        forms = _forms(omega, c, system.carrier_inertia, system.inertia)
        modal = [
            (
                states.inner[mode.rate_name] + mode.along(omega),
                mode.stretch(states.inner[mode.displacement_name]),
            )
            for mode in system.modes
        ]
        rate, size, kinetic, c_I_c = forms[3:]
        for pi, stretch in modal:
            kinetic = kinetic + 0.5 * (pi * pi + stretch * stretch)
        return cls(system, states, p, forms[:3], rate, size, kinetic, c_I_c, modal)


def _forms(omega, c, K, I):
    vectors, matrices = map(components, (omega, c)), map(_entries, (K, I))
    return forms_of_components(*vectors, *matrices)


def _sizes(parts, applied):
    """
    Return by name the size (N,) of the parts of each first integral.

    applied (N,): as of drift_since.  A vector counts with its length, whatever its direction.
    What field, torques and friction change within a radian of the swing counts too, and the work
    that they do there: a body that rests has no other rate, momentum or work.
    A kinetic energy is as uncertain as the whole momentum times the rate, which a fast rotor
    makes larger than omega . K omega.
    """
    system, states = parts.system, parts.states
    orbit, rate = system.orbit, parts.rate
    gradient = states.orbit.largest_gradient(states.orbit_s)
    weight = length(system.weight_moment)
    for i, rotor in enumerate(system.rotors):
        if rotor.is_damped:
            applied = applied + np.abs(rotor.friction_torque(states.rotor_speed[..., i]))
        if rotor.is_unbalanced:
            size = rotor.dynamic_imbalance + length(rotor.position) * rotor.static_imbalance
            applied = applied + size * states.rotor_speed[..., i] ** 2
    if system.torques:
        applied = applied + length(own_torque(system.torques, states))
    least, _, K_max = np.moveaxis(np.linalg.eigvalsh(system.carrier_inertia), -1, 0)
    swing = np.sqrt(gradient + (weight + applied) / least)
    p = [np.abs(p_i) for p_i in parts.p]
    # A mode takes and gives momentum and energy as long as it swings.
    ends = [
        np.sqrt(pi * pi + stretch * stretch) * length(mode.coupling)
        for mode, (pi, stretch) in zip(system.modes, parts.modal, strict=True)
    ]
    momentum = parts.K_omega_size + sum(p) + sum(ends) + K_max * swing
    trace = np.trace(system.inertia, axis1=-2, axis2=-1)
    energy = rate * momentum + gradient / 2.0 * trace + weight
    for pi, stretch in parts.modal:
        energy = energy + 0.5 * (pi * pi + stretch * stretch)
    if system.torques:
        energy = energy + np.abs(own_potential(system.torques, states))
    nu = length(orbit.lvlh_rate(states.orbit_s)) if orbit.has_lvlh else 0.0
    return {
        'energy': energy,
        'energy_balance': energy + applied + np.abs(states.work),
        'jacobi': energy + nu * momentum,
        'area': momentum,
        'momentum': momentum,
        'fourth': momentum**2,
        'axial_rate': rate + swing,
        **{
            momentum_name(rotor): p_i + rotor.inertia * (rate + swing)
            for rotor, p_i in zip(system.rotors, p, strict=True)
        },
    }


def _terms(parts, since=_FROM_ROW_0):
    """Return the terms, a list of (N,), whose sum each first integral is; since: as above."""
    system, states, p = parts.system, parts.states, parts.p
    orbit, weight, driven = system.orbit, system.weight_moment, system.is_driven
    omega, c = states.omega_bi_b, states.c_b
    moments, R_bp = principal_axes(system.inertia)
    gradient = orbit.gradient_at(states.orbit_s)
    spherical = np.ptp(moments, axis=-1) <= ROUNDING * np.max(moments, axis=-1)
    momentum = parts.K_omega
    for rotor, p_i in zip(system.rotors, p, strict=True):
        axis = components(rotor.axis)
        momentum = [H_i + p_i * a_i for H_i, a_i in zip(momentum, axis, strict=True)]
    for mode, (pi, _) in zip(system.modes, parts.modal, strict=True):
        d = components(mode.coupling)
        momentum = [H_i + pi * d_i for H_i, d_i in zip(momentum, d, strict=True)]
    H = from_components(momentum)
    kinetic, potential = parts.kinetic, gradient / 2.0 * parts.c_I_c
    weight_potential = dot(weight, c) if np.any(weight) else 0.0

    terms = {}
    own = [own_potential(system.torques, states)] if system.torques else []
    if driven or orbit.is_eccentric:
        terms['energy_balance'] = [kinetic, potential, weight_potential, -states.work]
    elif orbit.has_lvlh:
        terms['jacobi'] = [kinetic, potential, -dot(states.lvlh_rate_b, H), *own]
    else:
        terms['energy'] = [kinetic, potential, weight_potential, *own]
    # Modes take and give momentum, as free rotors do; other integrals are those of rigid bodies.
    is_free, newtonian = not (system.takes_work or system.torques), system.is_newtonian
    if is_free and not orbit.has_lvlh:
        terms['area'] = [dot(H, c)]
        applies = ~_is_there(weight) & newtonian
        for rotor in system.rotors:
            applies = applies & (np.asarray(rotor.momentum == 0.0) & (not rotor.turns_freely))
        if np.any(applies):
            adjugate = R_bp @ (_prod(moments) / moments[..., :, None] * np.swapaxes(R_bp, -1, -2))
            fourth = [dot(H, H), -gradient * dot(c, _apply(adjugate, c))]
            terms['fourth'] = _only(applies, fourth)
    applies = ~_is_there(weight) & (
        spherical | np.all(gradient == 0.0, axis=-1, keepdims=gradient.ndim > 1)
    )
    if np.any(applies) and is_free:
        terms['momentum'] = _only(applies, [length(H)])
    if newtonian:
        axis = _symmetry_axis(system, states, p, since)
        if not np.all(np.isnan(axis)):
            terms['axial_rate'] = [dot(omega, axis)]
    for i, rotor in enumerate(system.rotors):
        is_driven = system.rotor_torque[i] or np.isfinite(system.rotor_target[i])
        if rotor.turns_freely and not (rotor.is_damped or is_driven):
            terms[momentum_name(rotor)] = [p[i]]
    return terms


def momentum_name(rotor: Rotor) -> str:
    """Return the name of a rotor's axial momentum among the integrals."""
    return f'rotor_momentum.{rotor.name}' if rotor.name else 'rotor_momentum'


def _only(applies, terms):
    """Return terms with nan for the motions to which they do not apply."""
    return terms if np.all(applies) else [np.where(applies, term, np.nan) for term in terms]


def _symmetry_axis(system, states, p, since):
    """
    Return the axis (..., 3) about which all that acts on the body is symmetric; nan: none.

    That is K, I where there is a field, the weight, and the momentum of all rotors.
    """
    begins, motion = np.unique(since, return_inverse=True)
    h = np.zeros((len(begins), 3))
    for rotor, p_i in zip(system.rotors, p, strict=True):
        h = h + p_i[..., begins, None] * rotor.axis
    I, K = system.inertia, system.carrier_inertia
    is_pulled = np.any(states.orbit.gradient_at(states.orbit_s), axis=-1, keepdims=True)
    felt = np.where(is_pulled[..., None, None], I, K)
    return symmetry_axes((felt, K), (h, system.weight_moment))[..., motion, :]


def _entries(M):
    return [[M[..., i, j] for j in range(3)] for i in range(3)]


def _is_there(vector):
    return np.any(vector, axis=-1)


def _prod(moments):
    return np.prod(moments, axis=-1)[..., None, None]


def _apply(M, v):
    """Return M v."""
    return from_components(times(M, components(v)))

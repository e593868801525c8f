"""
The first integrals of every system: what a motion conserves, and by how much it fails to.

With K the carrier inertia, H = K omega + p a, c the unit vector from the attracting centre, m the
weight moment, V = (3 mu / 2 r^3) c . I c and nu the orbital rate:

    energy          omega . K omega / 2 + V + m . c                       fixed direction
    area            H . c                                                 fixed direction
    fourth          |I omega|^2 - (3 mu / r^3) c . adj(I) c               fixed, no rotor, m = 0
    jacobi          omega . K omega / 2 - nu . H + V                      circular orbit
    momentum        |H|                                                   no field, or a sphere
    axial_rate      omega . e                                             symmetric about e
    rotor_momentum  p                                                     free rotor
    energy_balance  energy less the work done and less its first value    driven, or elliptic

Agostinelli 1977, eqs 3-6; Beletsky 1957; Balli and Grioli 1979.
"""

import numpy as np

from . import rotation
from .inertia import principal_axes
from .motion import States
from .system import System
from .torque import angular_momentum

# Relative size below which a moment, a rotor's or weight's component counts as absent.
_ROUNDING = 1e-12


def first_integrals(system: System, states: States) -> dict[str, np.ndarray]:
    """Return what the motion of states conserves, name to values (N,), in SI units."""
    values = {name: sum(terms) for name, terms in _terms(system, states).items()}
    if 'energy_balance' in values:
        values['energy_balance'] = values['energy_balance'] - values['energy_balance'][0]
    return values


def relative_drift(
    system: System, states: States, begin: States | None = None
) -> dict[str, np.ndarray]:
    """
    Return each first integral's change relative to the size of what it is made of, (N,).

    The change is that since row 0 of begin, an earlier table of the same motion, or of states; the
    size is the larger one of the two rows.  An integral may be zero, and so may each of its terms:
    its size is that of the momenta and potentials behind them.
    """
    begin = (begin or states).rows(slice(1))
    start, start_sizes = _terms(system, begin), _sizes(system, begin)
    sizes = _sizes(system, states)
    drift = {}
    for name, terms in _terms(system, states).items():
        change = sum(terms) - sum(start[name])
        size = np.maximum(start_sizes[name], sizes[name])
        drift[name] = np.divide(change, size, out=np.zeros(len(states)), where=size > 0.0)
    return drift


def field_rate(system: System, states: States) -> np.ndarray:
    """Return sqrt(|3 mu / r^3| + |m| / K), the rate at which the field swings a body, (N,)."""
    least = np.min(np.linalg.eigvalsh(system.carrier_inertia))
    gradient = np.abs(states.orbit.gradient_at(states.orbit_s))
    return np.sqrt(gradient + np.linalg.norm(system.weight_moment) / least)


def _sizes(system, states):
    """
    Return by name the size (N,) that the parts of each first integral have.

    A vector counts with its length, whatever its direction.  What the field changes within a
    radian of the swing counts too: a body that rests in the field has no other rate or momentum.
    A kinetic energy is as uncertain as the whole momentum times the rate, which a fast rotor
    makes larger than omega . K omega.
    """
    orbit, rotor, omega = system.orbit, system.rotor, states.omega_bi_b
    swing = field_rate(system, states)
    rate = np.linalg.norm(omega, axis=-1)
    K_omega = omega @ system.carrier_inertia
    p = np.abs(rotor.axial_momentum(states.rotor_speed, omega))
    K_max = np.max(np.linalg.eigvalsh(system.carrier_inertia))
    momentum = np.linalg.norm(K_omega, axis=-1) + p + K_max * swing
    potential = np.abs(orbit.gradient_at(states.orbit_s)) / 2.0 * np.trace(system.inertia)
    energy = rate * momentum + potential + np.linalg.norm(system.weight_moment)
    nu = np.linalg.norm(orbit.lvlh_rate(states.orbit_s), axis=-1) if orbit.has_lvlh else 0.0
    return {
        'energy': energy,
        'energy_balance': energy + np.abs(states.work),
        'jacobi': energy + nu * momentum,
        'area': momentum,
        'momentum': momentum,
        'fourth': momentum**2,
        'axial_rate': rate + swing,
        'rotor_momentum': p + rotor.inertia * (rate + swing),
    }


def _terms(system, states):
    """Return the terms, a list of (N,), whose sum each first integral is."""
    orbit, rotor, weight = system.orbit, system.rotor, system.weight_moment
    omega, c = states.omega_bi_b, states.c_b
    driven = bool(np.any(system.torque_b) or system.rotor_torque)
    moments, R_bp = principal_axes(system.inertia)
    gradient = orbit.gradient_at(states.orbit_s)
    spherical = np.ptp(moments) <= _ROUNDING * np.max(moments)
    H = angular_momentum(system, omega, states.rotor_speed)
    kinetic = _dot(omega, omega @ system.carrier_inertia) / 2.0
    potential = gradient / 2.0 * _dot(c, c @ system.inertia)
    weight_potential = _dot(weight, c)

    terms = {}
    if driven or (orbit.has_lvlh and not orbit.is_circular):
        terms['energy_balance'] = [kinetic, potential, weight_potential, -states.work]
    elif orbit.has_lvlh:
        nu_b = rotation.rotate(rotation.conjugate(states.q_ib), orbit.lvlh_rate(states.orbit_s))
        terms['jacobi'] = [kinetic, potential, -_dot(nu_b, H)]
    else:
        terms['energy'] = [kinetic, potential, weight_potential]
        terms['area'] = [_dot(H, c)]
        if rotor.mode in ('none', 'constant_momentum') and not (rotor.momentum or np.any(weight)):
            adjugate = R_bp @ np.diag(np.prod(moments) / moments) @ R_bp.T
            terms['fourth'] = [_dot(H, H), -gradient * _dot(c, c @ adjugate)]
    if not driven and not np.any(weight) and (spherical or not np.any(gradient)):
        terms['momentum'] = [np.linalg.norm(H, axis=-1)]
    axis = None if driven else _symmetry_axis(system, moments, R_bp)
    if axis is not None:
        terms['axial_rate'] = [_dot(omega, axis)]
    if rotor.turns_freely and not system.rotor_torque:
        terms['rotor_momentum'] = [rotor.axial_momentum(states.rotor_speed, omega)]
    return terms


def _symmetry_axis(system, moments, R_bp):
    """Return the axis (3,) about which body, rotor and weight are symmetric, or None."""
    rotor, weight = system.rotor, system.weight_moment
    largest = np.max(moments)
    along = [a for a in (_rotor_axis(rotor), weight) if np.any(a)]
    if np.ptp(moments) <= _ROUNDING * largest:
        axis = along[0] / np.linalg.norm(along[0]) if along else None
    else:
        equal = [
            k for k in range(3) if abs(moments[k - 1] - moments[k - 2]) <= _ROUNDING * largest
        ]
        axis = R_bp[:, equal[0]] if equal else None
    if axis is None:
        return None
    aligned = all(
        np.linalg.norm(np.cross(axis, a)) <= _ROUNDING * np.linalg.norm(a) for a in along
    )
    return axis if aligned else None


def _rotor_axis(rotor):
    if rotor.turns_freely or rotor.momentum:
        return rotor.axis
    return np.zeros(3)


def _dot(a, b):
    return np.sum(a * b, axis=-1)

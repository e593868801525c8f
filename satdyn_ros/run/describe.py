"""What theory says about a scenario before it is run, as data."""

from typing import Any, TypedDict

import numpy as np
from scipy.integrate import trapezoid

from .. import exact
from ..dynamics.inertia import principal_axes
from ..dynamics.motion import Halted, Motion
from ..integrate.propagation import Propagation
from ..kernel import rotation
from ..kernel.rows import length
from ..theory.elliptic_libration import elliptic_librations
from ..theory.free_modes import free_frequencies
from ..theory.precession import regular_precession
from ..theory.stability import attitude_drift
from ..theory.steady_motions import SteadyMotion, steady_motions
from ..torques.thrust import thrust_of
from .samples import Samples
from .scenario import Scenario

# Of the table of torques: one in half a degree.
_TIMES_A_TURN = 721
# Units of the first integrals (dynamics/integrals.py).
_UNITS = {
    'energy': 'J',
    'area': 'N m s',
    'fourth': '(N m s)^2',
    'jacobi': 'J',
    'momentum': 'N m s',
    'axial_rate': 'rad/s',
    'rotor_momentum': 'N m s',
    'energy_balance': 'J',
}


class Description(TypedDict):
    """
    What theory says about a scenario: numbers, text, lists and dictionaries, ready for JSON.

    A value that is infinite or does not exist is None.

    Attributes
    ----------
    orbit : dict or None
        for an element set or an ephemeris the epoch tick_0; for an element set elements_epoch,
        age_days at tick 0, and perigee_height_m, apogee_height_m, period_s and inclination_rad of
        the mean elements, to the equator of date; for an ephemeris the epochs begin and end,
        lowest_height_m and highest_height_m over a turn from tick 0, or as far as it goes, and
        period_s and inclination_rad at tick 0, to the equator of the inertial axes.  Heights are
        above the equator's radius
    principal_moments : (3,), kg m^2
        of body.inertia
    principal_axes_b : (3, 3), body axes
        one axis per row
    motion : dict or None
        name, source, period_s and facts (name, value, unit, meaning) of the closed form
    why_not : str or None
        why there is no closed form
    first_integrals : dict
        name to value and unit at the start
    steady_motions : list
        for each permanent rotation or relative equilibrium, with the rotor momenta of the start:
        axis (body axes; on an orbit the direction up), rate_rad_s, on an orbit the attitude q_lb,
        stability, argument, periods_s of small motion, and attitude_drift_rad, by which the
        attitude of a stable rotation drifts in a day for a change of 1e-6 of its rate (an
        equilibrium in LVLH or at rest has none); empty if a torque acts or a part bends, which
        theory does not know
    rotation_class : dict or None
        on a circle and without friction: whether the motion is a rotation about a body-fixed axis,
        whether it is uniform, and why
    regular_precession : dict or None
        for the start: axis of the spin in the body and of the precession in space, both rates, the
        nutation, the sense, and how the cones of the instantaneous axis lie, with their
        half-angles
    elliptic_orbit : dict or None
        on an ellipse, where no attitude rests in LVLH and steady_motions is empty: eccentricity,
        period_s and planar librations, with the body axis that is the normal, p of Beletsky's
        equation and forced_amplitude_rad, None if it is not small
    torques : list
        if other torques act than that of the attracting centre, for each torque on the body, as
        the body flies for a turn of the orbit: topic, largest_n_m, mean_n_m and momentum_n_m_s,
        the momentum that it gives to the body meanwhile, inertial axes
    thruster : list
        for each one its name, torque_n_m (3) of its whole thrust, body axes, and for its shortest
        on-time least_impulse_n_m_s, the size of the angular impulse, and least_rate_rad_s (3), the
        change of the rate
    flexible : dict or None
        for a body with flexible parts: names, frequencies_rad_s of each mode by itself,
        free_rad_s, at which body and parts swing together, and unseen_rad_s, those of them that
        samples at publish.rate cannot distinguish from slower ones
    """

    orbit: Any
    principal_moments: list[float]
    principal_axes_b: list[list[float]]
    motion: Any
    why_not: Any
    first_integrals: dict[str, Any]
    steady_motions: list[dict[str, Any]]
    rotation_class: Any
    regular_precession: Any
    elliptic_orbit: Any
    torques: list[dict[str, Any]]
    thruster: list[dict[str, Any]]
    flexible: Any


def describe(scenario: Scenario) -> Description:
    """
    Return what theory says about a scenario before it is run.

    Examples
    --------
    >>> motion = describe(Scenario.from_yaml('config/euler_poinsot.yaml'))['motion']
    >>> motion['name']
    'free rotation'
    """
    system, state = scenario.system, scenario.initial_state
    motion = exact.recognise(system, state)
    moments, R_bp = principal_axes(system.inertia)
    return {
        'orbit': _orbit(scenario),
        'principal_moments': _as_json(moments),
        'principal_axes_b': _as_json(R_bp.T),
        'motion': None if motion is None else _motion(motion),
        'why_not': exact.explain(system, state),
        'first_integrals': _first_integrals(scenario, motion),
        'steady_motions': [
            _steady(scenario, steady)
            for steady in (() if system.torques or system.modes else steady_motions(system, state))
        ],
        'rotation_class': _rotation_class(scenario),
        'regular_precession': _regular_precession(scenario),
        'elliptic_orbit': _elliptic_orbit(scenario),
        'torques': _torques(scenario),
        'thruster': _of_each_thruster(scenario),
        'flexible': _flexible(scenario),
    }


def _orbit(scenario: Scenario) -> dict[str, Any] | None:
    said = scenario.system.orbit.described()
    return {name: _as_json(value) for name, value in said.items()} or None


def _motion(motion: exact.ExactMotion) -> dict[str, Any]:
    return {
        'name': motion.name,
        'source': motion.source,
        'period_s': _as_json(motion.period_s),
        'facts': [fact._replace(value=_as_json(fact.value))._asdict() for fact in motion.facts()],
    }


def _first_integrals(scenario: Scenario, motion: Motion | None) -> dict[str, Any]:
    if motion is None:
        motion = Propagation(scenario.system, scenario.initial_state)
    begin = motion.at(0.0)
    return {
        name: {'value': _as_json(values[0]), 'unit': _UNITS[name.split('.')[0]]}
        for name, values in scenario.integrals(begin).items()
    }


def _steady(scenario: Scenario, steady: SteadyMotion) -> dict[str, Any]:
    described = {
        'axis_b': _as_json(steady.axis_b),
        'rate_rad_s': _as_json(np.linalg.norm(steady.state.omega_bi_b)),
        'stability': steady.verdict.stability,
        'argument': steady.verdict.argument,
        'periods_s': _as_json(steady.periods_s),
        'attitude_drift_rad': None,
    }
    omega = steady.state.omega_bi_b
    if scenario.is_fixed and steady.verdict.stability == 'stable' and np.any(omega):
        described['attitude_drift_rad'] = _as_json(attitude_drift(omega, 1e-6 * omega))
    if not scenario.is_fixed:
        q_il = scenario.system.orbit.lvlh(0.0)
        described['q_lb'] = _as_json(
            rotation.multiply(rotation.conjugate(q_il), steady.state.q_ib)
        )
    return described


def _rotation_class(scenario: Scenario) -> dict[str, Any] | None:
    orbit = scenario.system.orbit
    is_on_circle = orbit.is_keplerian and not orbit.is_eccentric
    if not is_on_circle or not scenario.system.is_newtonian:
        return None
    return exact.rotation_class(scenario.system, scenario.initial_state)._asdict()


def _regular_precession(scenario: Scenario) -> dict[str, Any] | None:
    found = regular_precession(scenario.system, scenario.initial_state)
    if found is None:
        return None
    return {
        'axis_b': _as_json(found.axis_b),
        'axis_i': _as_json(found.axis_i),
        'spin_rad_s': found.spin,
        'precession_rad_s': float(found.precession),
        'nutation_rad': found.nutation,
        'sense': found.sense,
        'cones': found.cones,
        'body_cone_rad': found.body_cone,
        'space_cone_rad': found.space_cone,
    }


def _elliptic_orbit(scenario: Scenario) -> dict[str, Any] | None:
    orbit = scenario.system.orbit
    # Its librations are those under the attracting field alone.
    system = scenario.system
    if not orbit.is_keplerian or not orbit.is_eccentric:
        return None
    if system.torques or system.modes:
        return None
    return {
        'eccentricity': _as_json(orbit.eccentricity),
        'period_s': _as_json(orbit.period_s),
        'librations': [
            {
                'normal_b': _as_json(found.normal_b),
                'p': found.p,
                'forced_amplitude_rad': found.amplitude_rad,
            }
            for found in elliptic_librations(scenario.system, scenario.initial_state)
        ],
    }


def _torques(scenario: Scenario) -> list[dict[str, Any]]:
    system = scenario.system
    if not (system.orbit.has_lvlh and system.torques):
        return []
    t_s = np.linspace(0.0, system.orbit.period_s, _TIMES_A_TURN)
    try:
        states = Propagation(system, scenario.initial_state).at(t_s)
    except Halted as error:
        states = error.states
    flown = Samples(0, np.zeros(len(states.t_s), np.int64), states, system)
    found = []
    for topic in scenario.topic_table.values():
        if topic.type != 'geometry_msgs/msg/WrenchStamped' or topic.role != 'state':
            continue
        if topic.lacking(system):
            continue
        torque_b = topic.shows[0].of(flown)
        size = length(torque_b)
        torque_i = rotation.rotate(states.q_ib, torque_b)
        found.append(
            {
                'topic': topic.name,
                'largest_n_m': _as_json(size.max()),
                'mean_n_m': _as_json(size.mean()),
                'momentum_n_m_s': _as_json(trapezoid(torque_i, states.t_s, axis=0)),
            }
        )
    return found


def _of_each_thruster(scenario: Scenario) -> list[dict[str, Any]]:
    system = scenario.system
    if not scenario['thruster.names']:
        return []
    found = []
    for name, each in thrust_of(system).thrusters.items():
        impulse_b = each.min_on_time * each.torque_b
        found.append(
            {
                'name': name,
                'torque_n_m': _as_json(each.torque_b),
                'least_impulse_n_m_s': _as_json(np.linalg.norm(impulse_b)),
                'least_rate_rad_s': _as_json(system.carrier_inverse @ impulse_b),
            }
        )
    return found


def _flexible(scenario: Scenario) -> dict[str, Any] | None:
    system = scenario.system
    if not system.modes:
        return None
    free = free_frequencies(system)
    return {
        'names': [mode.name for mode in system.modes],
        'frequencies_rad_s': [float(mode.frequency) for mode in system.modes],
        'free_rad_s': _as_json(free),
        # Nyquist's: fewer than two samples a swing.
        'unseen_rad_s': _as_json(free[free >= np.pi * float(scenario.rate)]),
    }


def _as_json(value: Any) -> Any:
    """Return numbers of any kind as floats and lists; what is not finite as None."""
    if value is None or isinstance(value, str):
        return value
    if np.ndim(value):
        return [_as_json(item) for item in value]
    if isinstance(value, int):
        return value
    return float(value) if np.isfinite(value) else None

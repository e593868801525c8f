"""What runs come to: the rows of the table."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..dynamics import rotation
from ..dynamics.batch import propagate_all
from ..dynamics.integrals import relative_drift
from ..dynamics.motion import Motion, States
from ..dynamics.orbit import KeplerOrbit
from ..dynamics.propagator import Propagation
from ..run.scenario import Scenario
from .capture import captured_since, judged_axis, nadir_angle
from .plan import Plan

INTEGRALS = (
    'energy',
    'area',
    'fourth',
    'jacobi',
    'momentum',
    'axial_rate',
    'rotor_momentum',
    'energy_balance',
)
# Samples that are held at a time, some hundred megabytes: runs with more go fewer together.
_SAMPLES_AT_ONCE = 4_000_000


def rows(plan: Plan, runs: Sequence[int]) -> list[dict[str, Any]]:
    """Return the rows of runs; a column that is not in one has no value."""
    together = max(1, _SAMPLES_AT_ONCE // len(plan.t_s))
    parts = (runs[first : first + together] for first in range(0, len(runs), together))
    return [row for part in parts for row in _rows_of(plan, part)]


def _rows_of(plan, runs):
    values = [plan.values(run) for run in runs]
    flights = [_attempt(_flight, plan, each) for each in values]
    motions = [flight[1] for flight in flights if not isinstance(flight, Exception)]
    numeric = [motion for motion in motions if isinstance(motion, Propagation)]
    tables = dict(zip(numeric, propagate_all(numeric, plan.t_s), strict=True))
    found = []
    for run, varied, flight in zip(runs, values, flights, strict=True):
        columns = _attempt(_outcome, plan, flight, tables)
        if isinstance(columns, Exception):
            columns = {'failure': str(columns) or type(columns).__name__}
        found.append({'run': run, **varied, **columns})
    return found


def _attempt(step, *arguments):
    """Return what a step returns, or the exception that ends it: the other runs go on."""
    try:
        return step(*arguments)
    except Exception as error:
        return error


def _flight(plan, values):
    scenario = plan.scenario_of(values)
    return scenario, scenario.motion()


def _outcome(plan, flight, tables):
    if isinstance(flight, Exception):
        raise flight
    scenario, motion = flight
    states = tables[motion] if motion in tables else motion.at(plan.t_s)
    if isinstance(states, Exception):
        raise states
    return outcome(plan, scenario, states, motion)


def outcome(plan: Plan, scenario: Scenario, states: States, motion: Motion) -> dict[str, Any]:
    """
    Return what a run of a scenario comes to, by column, from its states at the plan's times.

    q_ib, omega_bi_b [rad/s], rotor_speed [rad/s], rotor_angle [rad]: the state at the end.  The
    rest is over the samples: the extremes of the rate, of the angle to LVLH and of that of the
    axis of least inertia to nadir, the capture, the largest relative change of each first
    integral.
    """
    rate = np.linalg.norm(states.omega_bi_b, axis=-1)
    columns = {
        'q_ib': states.q_ib[-1].tolist(),
        'omega_bi_b': states.omega_bi_b[-1].tolist(),
        'rate_min_rad_s': float(rate.min()),
        'rate_max_rad_s': float(rate.max()),
    }
    if scenario.system.rotor.turns_freely:
        columns['rotor_speed'] = float(states.rotor_speed[-1])
        columns['rotor_angle'] = float(states.rotor_angle[-1])
    for name, drift in relative_drift(scenario.system, states).items():
        columns[f'drift_{name}'] = float(np.max(np.abs(drift)))
    if isinstance(states.orbit, KeplerOrbit):
        angle = rotation.angle_between(rotation.IDENTITY, states.q_lb)
        columns['lvlh_angle_min_rad'] = float(angle.min())
        columns['lvlh_angle_max_rad'] = float(angle.max())
        columns |= _capture(plan, scenario, states, motion)
    if plan.keeps_samples:
        columns |= samples(scenario, states)
    return columns


def _capture(plan, scenario, states, motion):
    """Return the extremes of an axis's angle to nadir, whether it is captured and since when."""
    axis_b = judged_axis(plan.captured_axis, scenario.system.inertia)
    if axis_b is None:
        return {}
    angle = nadir_angle(states, axis_b)
    columns = {
        'nadir_angle_min_rad': float(angle.min()),
        'nadir_angle_max_rad': float(angle.max()),
    }
    end_s, period_s = states.t_s[-1], 2.0 * np.pi / states.orbit.mean_motion
    if end_s < period_s:
        return columns
    since_s = captured_since(states, axis_b, motion)
    captured = bool(end_s - since_s >= period_s)
    return columns | {'captured': captured, 'capture_s': since_s if captured else None}


def samples(scenario: Scenario, states: States) -> Mapping[str, Any]:
    """Return the attitudes and rates at the samples, relative to LVLH where there is one."""
    if scenario.is_fixed:
        return {
            'samples_q_ib': states.q_ib.tolist(),
            'samples_omega_bi_b': states.omega_bi_b.tolist(),
        }
    to_body = rotation.conjugate(states.q_ib)
    lvlh_rate_b = rotation.rotate(to_body, states.orbit.lvlh_rate(states.orbit_s))
    return {
        'samples_q_lb': states.q_lb.tolist(),
        'samples_omega_bl_b': (states.omega_bi_b - lvlh_rate_b).tolist(),
    }

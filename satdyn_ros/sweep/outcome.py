"""
Results of runs: the columns of the table.

Runs that differ only in numbers are propagated and measured together, as arrays (M, N) of M runs
at N times.  Where there is a table, a torque of one's own, a rotor whose turns count, an invalid
value or a propagation that halts, each run is made and measured by itself, and only the steps are
taken side by side; a closed form is evaluated by itself.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..dynamics.integrals import NAMES, relative_drift
from ..dynamics.motion import Halted, Motion, States
from ..dynamics.system import System
from ..integrate.batch import propagate_all, propagate_many
from ..integrate.propagation import Propagation
from ..kernel.rows import length
from ..run import environment
from ..run.many import many, part_of
from ..run.orbits import type_of
from ..run.scenario import Scenario
from .capture import capture_times, judged_axis
from .closed_loops import flown
from .extrema import angles, extrema_of
from .own_outcome import Wrong
from .plan import Plan

# Samples held at a time, some hundred megabytes: of longer runs, fewer are done together.
_SAMPLES_AT_ONCE = 4_000_000
# Samples measured at a time, so few that what is computed from them stays in the cache, and most
# of its memory in the process: that of large arrays is given back and had anew, page by page.
_SAMPLES_IN_CACHE = 28_000

OutcomeColumns = dict[str, Any]


def columns(plan: Plan, runs: Sequence[int]) -> OutcomeColumns:
    """Return the columns of runs, name to a value for each of them; nan or None: it has none."""
    together = max(1, _SAMPLES_AT_ONCE // len(plan.t_s))
    values = plan.values_of(runs)
    table = _Table(len(runs))
    for first in range(0, len(runs), together):
        part = slice(first, first + together)
        _fill(plan, runs[part], {name: some[part] for name, some in values.items()}, first, table)
    return {'run': np.array(runs), **values, **table.columns}


class _Table:
    """Columns that fill in any order; a column begins with its first value."""

    def __init__(self, count: int):
        self.count, self.columns = count, {'failure': np.full(count, None)}

    def put(self, rows, found: Mapping[str, Any]) -> None:
        """Store values (M, ...) of some rows."""
        for name, values in found.items():
            values = np.asarray(values)
            if name not in self.columns:
                self.columns[name] = np.full((self.count, *values.shape[1:]), np.nan)
            self.columns[name][rows] = values


def _fill(plan, runs, values, first, table):
    if plan.controller is not None:
        _fly_controlled(plan, plan.controller, runs, first, table)
        return
    for rows in _alike(plan, values):
        done = _propagate_together(plan, runs, values, rows, first, table)
        if not done.all():
            _propagate_one_by_one(plan, runs, rows[~done], first, table)


def _alike(plan, values) -> Iterator[np.ndarray]:
    """Yield the rows of runs that differ only in numbers."""
    rows = range(len(next(iter(values.values()))))
    alike = defaultdict(list)
    for row, *kinds in zip(rows, *(_kinds(v, values[v.name]) for v in plan.vary), strict=True):
        alike[tuple(kinds)].append(row)
    yield from map(np.array, alike.values())


def _kinds(varied, values):
    """Return of each value what runs that fly together have in common."""
    key = varied.quantity.key
    if key.kind == 'double_array':
        return map(len, values)
    if key.kind != 'double':
        return values
    # A circular orbit conserves what an ellipse does not; likewise rotors without friction.
    decides = key.name == 'orbit.eccentricity' or key.name.endswith('.friction')
    return np.equal(values, 0.0) if decides else (None,) * len(values)


def _propagate_together(plan, runs, values, rows, first, table):
    """Fly rows of values together and return which of them that was possible for, (M,)."""
    done = np.zeros(len(rows), bool)
    changed = _changed(plan, values, rows)
    if changed is None or changed['motion.method'] != 'numeric':
        return done
    own = plan.scenario.torques or plan.scenario.equipment.torques()
    if own or type_of(changed).is_shared(changed) or environment.asked(changed):
        return done
    alone = '.coulomb_friction', '.static_imbalance', '.dynamic_imbalance'
    if any(np.any(x) for key, x in changed.items() if key.endswith(alone)):
        return done
    scenario, valid = many(changed, len(rows))
    count = int(valid.sum())
    if not count:
        return done
    tolerance = np.zeros(count) + np.ravel(scenario['motion.tolerance'])
    system = scenario.system
    states, done[valid] = propagate_many(system, scenario.initial_state, tolerance, plan.t_s)
    size = max(1, _SAMPLES_IN_CACHE // len(plan.t_s))
    for begin in range(0, count, size):
        part = slice(begin, begin + size)
        some, reached = rows[valid][part], done[valid][part]
        some_runs = [runs[row] for row in some]
        found = outcome(plan, part_of(system, part), part_of(states, part), some_runs)
        table.put(first + some[reached], {k: np.asarray(x)[reached] for k, x in found.items()})
    return done


def _changed(plan, values, rows):
    """Return the values of every key, arrays (M,) or (M, k) of what varies; None: not together."""
    arrays = {}
    for varied in plan.vary:
        some = [values[varied.name][row] for row in rows]
        is_number = varied.quantity.key.kind in ('double', 'double_array')
        arrays[varied.name] = np.array(some) if is_number else some[0]
    try:
        return plan.changed(arrays)
    except ValueError:
        return None


def _propagate_one_by_one(plan, runs, rows, first, table):
    """Make the motion of each run by itself; only the steps are taken side by side."""
    scenarios: dict[int, Scenario] = {}
    motions: dict[int, Motion] = {}
    for row in rows:
        with _failure_recorded(table, first + row):
            scenarios[row] = plan.scenario_of(plan.values(runs[row]))
            motions[row] = scenarios[row].motion()
    numeric = {row: each for row, each in motions.items() if isinstance(each, Propagation)}
    flown = dict(zip(numeric, propagate_all(list(numeric.values()), plan.t_s), strict=True))
    for row, motion in motions.items():
        with _failure_recorded(table, first + row):
            states = flown[row] if row in flown else motion.at(plan.t_s)
            if isinstance(states, Halted):
                raise states
            system, some = scenarios[row].system, part_of(states, None)
            table.put([first + row], outcome(plan, system, some, [runs[row]]))


def _fly_controlled(plan, controller, runs, first, table):
    """Fly runs with a controller in each."""
    scenarios: dict[int, Scenario] = {}
    for row, run in enumerate(runs):
        with _failure_recorded(table, first + row):
            scenarios[row] = plan.scenario_of_run(run)
    rows, some = [*scenarios], [*scenarios.values()]
    for i, states in flown(controller, some, plan.ticks):
        row = rows[i]
        with _failure_recorded(table, first + row):
            if isinstance(states, Exception):
                raise states
            found = outcome(plan, some[i].system, part_of(states, None), [runs[row]])
            table.put([first + row], found)


@contextmanager
def _failure_recorded(table, row):
    """Let a run fail in any way: then its row says why, and the others go on."""
    try:
        yield
    except Wrong:
        raise
    except Exception as error:
        table.put([row], {'failure': [str(error) or type(error).__name__]})


def outcome(plan: Plan, system: System, states: States, runs: Sequence[int]) -> OutcomeColumns:
    """
    Return the results of M runs, by column, from their states (M, N) at the plan's times.

    q_ib, omega_bi_b [rad/s], rotor_speed [rad/s], rotor_angle [rad]: the state at the end.  The
    rest is over the samples: the extremes of the rate, of the angle to LVLH and of that of the
    axis of least inertia to nadir, the capture, the largest relative change of each first
    integral.  For runs with a controller there is neither capture nor change: they conserve
    nothing, and without it their motion would be another.  The columns of a named rotor end in
    _NAME.
    """
    rate = length(states.omega_bi_b)
    found: OutcomeColumns = {
        'q_ib': states.q_ib[:, -1],
        'omega_bi_b': states.omega_bi_b[:, -1],
        'rate_min_rad_s': rate.min(axis=-1),
        'rate_max_rad_s': rate.max(axis=-1),
    }
    for i, rotor in enumerate(system.rotors):
        if rotor.turns_freely:
            of_rotor = f'_{rotor.name}' if rotor.name else ''
            found[f'rotor_speed{of_rotor}'] = states.rotor_speed[:, -1, i]
            found[f'rotor_angle{of_rotor}'] = states.rotor_angle[:, -1, i]
    if plan.controller is None:
        for name, drift in relative_drift(system, states).items():
            if name.partition('.')[0] in NAMES:
                found[f'drift_{name.replace(".", "_")}'] = np.abs(drift).max(axis=-1)
    if states.orbit.has_lvlh:
        found |= _angles_and_capture(plan, system, states, runs)
    if plan.keeps_samples:
        found |= samples(states)
    return found | {own.name: own.values(states) for own in plan.outcomes}


def _angles_and_capture(plan, system, states, runs):
    """
    Return the extremes of the angle of the rotation from LVLH to the body.

    Where there is an axis, also those of its angle, either end of it, to nadir, 0 to pi/2 [rad],
    whether it is captured and since when.
    """
    axis_b = judged_axis(plan.captured_axis, system.inertia)
    passed = extrema_of(states, axis_b)
    found = angles('lvlh_angle', passed.lvlh, 2.0)
    if np.all(np.isnan(axis_b)):
        return found
    found |= angles('nadir_angle', passed.nadir)
    if plan.controller is not None:
        return found
    end_s, period_s = states.t_s[-1], states.orbit.period_s
    period_s = np.broadcast_to(np.ravel(period_s), len(runs))

    def follow(row):
        return plan.scenario_of(plan.values(runs[row])).motion()

    since_s = capture_times(states, passed, axis_b, period_s, follow)
    judged = np.isfinite(since_s) & (period_s <= end_s)
    captured = end_s - since_s >= period_s
    found['captured'] = np.where(judged, captured, np.nan)
    found['capture_s'] = np.where(judged & captured, since_s, np.nan)
    return found


def samples(states: States) -> dict[str, np.ndarray]:
    """Return the attitudes and rates at the samples, relative to LVLH where there is one."""
    if not states.orbit.has_lvlh:
        return {'samples_q_ib': states.q_ib, 'samples_omega_bi_b': states.omega_bi_b}
    omega_bl_b = states.omega_bi_b - states.lvlh_rate_b
    return {'samples_q_lb': states.q_lb, 'samples_omega_bl_b': omega_bl_b}

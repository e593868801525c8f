"""
Many motions side by side, in the lanes of the walk.

Every lane is one motion with steps of its own; when it has ended, the next motion takes its place.
A motion has the bits that it has alone.
"""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.constants import flat_constants_of_many
from ..dynamics.motion import Halted, States
from ..dynamics.system import State, System
from ..dynamics.variables import columns, initial_values, wanted_count
from ..trace.graph import flatten, kind_of
from .course import problem_of, stop_times_of
from .lanes import REACHED, RENEWED, UNFINISHED, Lanes, Problem
from .layout import Layout
from .propagation import Propagation
from .step_code import step_code
from .walk import walk

# The floats of the widest vector registers.
LANES = 8


def propagate_all(motions: Sequence[Propagation], t_s: ArrayLike) -> list[States | Halted]:
    """
    Return each motion's states at the ascending t_s (N,), or the error that ended it.

    The same bits as motion.at(t_s) of each, in a fraction of the time.
    """
    t_s = np.asarray(t_s, float)
    found: dict[Propagation, States | Halted] = {}
    alike = defaultdict(list)
    for motion in dict.fromkeys(motions):
        course = motion.new_course()
        alike[motion.wanted, kind_of(course.constants)].append((motion, course))
    for group in alike.values():
        courses = [course for _, course in group]
        begin = np.array([motion.begin() for motion, _ in group])
        like = courses[0].constants
        problem = problem_of(begin, courses, Layout.of(like), group[0][0].wanted)
        _walk_all(problem, like, t_s, courses)
        for m, (motion, course) in enumerate(group):
            outcome, (reached_s, *after) = int(problem.outcome[m]), problem.ended[m].tolist()
            states = motion.states_of(problem, m, t_s[: problem.rows[m]], course)
            found[motion] = states
            if outcome != REACHED:
                why = course.reason(outcome, *after)
                found[motion] = motion.halted(outcome, reached_s, states, why)
    return [found[motion] for motion in motions]


def propagate_many(
    system: System, state: State, tolerance: np.ndarray, t_s: np.ndarray
) -> tuple[States, np.ndarray]:
    """
    Return the states of M motions at the ascending t_s (N,), and whether each got there (M,).

    The constants of the system and the state may be arrays: (M, 1), vectors (M, 1, 3), matrices
    (M, 1, 3, 3); q_ib is (M, 1, 4), tolerance (M,).  All begin at tick 0.
    """
    count = len(tolerance)
    like, constants = flat_constants_of_many(system, count)
    anomaly = [
        np.broadcast_to(np.ravel(each), count) for each in system.orbit.mean_anomaly_at(0.0)
    ]
    stop_times_s = stop_times_of(system)
    begin = initial_values(system, state)[:, 0]
    wanted = wanted_count(system, like.does_work)
    problem = Problem(begin, Layout.of(like), wanted, len(stop_times_s))
    problem.settings[:] = np.column_stack([*anomaly, tolerance, *np.full((2, count), np.inf)])
    problem.constants[:], problem.is_new[:] = constants, RENEWED
    problem.stop_times_s[:, :-1] = stop_times_s
    _walk_all(problem, like, t_s, [])
    q_ib, omega_bi_b, speed, angle, inner, work = columns(system, problem.out)
    states = States(t_s, q_ib, omega_bi_b, speed, angle, work, system.orbit, t_s, inner=inner)
    return states, problem.outcome == REACHED


def _walk_all(problem, like, t_s, courses):
    """Walk all motions to their ends."""
    problem.ask(t_s)
    of_many, of_one, (_, arrays) = step_code(like, LANES), step_code(like, 1), flatten(like)
    lanes, single = (Lanes(count, of_one.layout, arrays) for count in (LANES, 1))
    tables = problem.address, lanes.address, single.address
    while not walk(*tables, of_many.attempt, of_one.dense):
        for l, m in enumerate(lanes.motion):
            if m >= 0 and UNFINISHED < problem.outcome[m] < REACHED:
                courses[m].go_on(problem, lanes, l, t_s)

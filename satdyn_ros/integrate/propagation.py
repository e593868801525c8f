"""
The propagation: the equations integrated by the explicit Runge-Kutta method of dop853.py.

The steps do not depend on the times that are asked for.
"""

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.constants import Constants
from ..dynamics.motion import Halted, Motion, States, TableEnded
from ..dynamics.system import State, System
from ..dynamics.torque import with_inner, without_number
from ..dynamics.variables import columns, initial_values, wanted_count
from .course import Course
from .lanes import BEGIN, FURTHEST, REACHED, STEPS, TABLE_ENDS, TOO_MANY_STEPS, Problem

if TYPE_CHECKING:
    from .one_lane import OneLane

# A third more steps than at 1e-12, a tenth of the error, and still above the rounding.
DEFAULT_TOLERANCE = 1e-13


class Propagation(Motion):
    """
    The motion of any system by numerical propagation.

    The propagation walks forward and keeps only its last step, so that memory use stays constant;
    for an earlier time it starts again.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state at the start
    start_s : s
        time of the start from tick 0
    tolerance : float
        relative local error of a step
    most_steps : int or None
        the most steps from one requested row to the next, None: any number.  A rotor that leaves
        its range counts as 200.  Steps up to the furthest row that was ever reached do not count
        again
    after : Propagation or None
        a motion of the same body under other torques that ends where this one begins: while it
        stands there, its lane is taken over, which changes no bit

    Examples
    --------
    >>> Propagation(system, state).at([10.0, 20.0]).q_ib  # doctest: +SKIP
    """

    name = 'propagation'
    source = 'Hairer, Norsett and Wanner 1993, II.10 (DOP853)'

    def __init__(
        self,
        system: System,
        state: State,
        start_s: float = 0.0,
        tolerance: float = DEFAULT_TOLERANCE,
        most_steps: int | None = None,
        after: 'Propagation | None' = None,
    ):
        super().__init__(system, with_inner(system, state, start_s), start_s)
        self.tolerance, self.most_steps = tolerance, most_steps
        self._steps_to_halt, self._furthest_s = 0.0, 0.0
        # From the first question on: in what it is computed.  Till then, in whose place.
        self._lane: OneLane | None = None
        self._after: Propagation | None
        self._after = after if after is None or after._lane is not None else after._after
        # The course that it begins with, if it is known yet.
        self._course: Course | None = None if self._after is not None else self.new_course()

    @cached_property
    def wanted(self) -> int:
        """How many of the variables are interpolated, from the first on."""
        return wanted_count(self.system, self.constants.does_work)

    @property
    def course(self) -> Course:
        """The course where the propagation stands."""
        if self._lane is not None:
            return self._lane.course
        if self._course is None:
            self._course = self.new_course()
        return self._course

    @property
    def constants(self) -> Constants:
        """The constants of the equations where the propagation stands."""
        return self.course.constants

    @property
    def stop_times_s(self) -> np.ndarray:
        """The times from tick 0 at which steps end, where the propagation stands."""
        return self.course.stop_times_s

    @property
    def steps(self) -> int:
        """The number of steps to where the propagation stands, or stood when it came to a halt."""
        taken = 0.0 if self._lane is None else self._lane.lanes.step_state[0, STEPS]
        return int(max(taken, self._steps_to_halt))

    def new_course(self) -> Course:
        """Return the course of the motion, at its start."""
        return Course(self.system, self.state, self.start_s, self.tolerance, self._steps_allowed)

    @property
    def _steps_allowed(self):
        return np.inf if self.most_steps is None else float(self.most_steps)

    def begin(self) -> np.ndarray:
        """Return the variables (V,) at the start."""
        return initial_values(self.system, self.state)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy begins with: from the start, as if nothing had been asked for."""
        walked = {'_lane': None, '_after': None, '_course': None, '_furthest_s': 0.0}
        return {**vars(self), **walked, '_steps_to_halt': 0.0}

    def _restart(self):
        if self._lane is not None:
            self._furthest_s = float(self._lane.lanes.step_state[0, FURTHEST])
        self._lane = self._course = None

    def _states(self, t_s, turn_b=None):
        is_ascending = len(t_s) < 2 or (t_s[1:] >= t_s[:-1]).all()
        order = None if is_ascending else np.argsort(t_s, kind='stable')
        sorted_s = t_s if order is None else t_s[order]
        lane = self._lane
        if lane is not None and len(t_s) and sorted_s[0] < lane.lanes.step_state[0, BEGIN]:
            self._restart()
        lane = self._lane = self._lane or self._taken_lane() or self._own_lane()
        problem, step = lane.problem, lane.lanes.step_state[0]
        problem.ask(sorted_s, turn_b)
        if lane.course.drives is not None:
            lane.course.drives.forget(float(step[BEGIN]))
        lane.course.allow(self._steps_allowed, problem, 0)
        try:
            while not lane.walk_on(sorted_s):
                # Another thread may have changed it.
                lane.course.allow(self._steps_allowed, problem, 0)
        except BaseException:
            # As by Ctrl-C, in the middle of a step.
            self._restart()
            raise
        count, outcome = int(problem.rows[0]), int(problem.outcome[0])
        found = self._found(problem, 0, sorted_s[:count], lane.course)
        if outcome != REACHED:
            reached_s, since, exits = problem.ended[0].tolist()
            self._steps_to_halt = step[STEPS] - since
            why = lane.course.reason(outcome, since, exits)
            self._restart()
            turned = None if turn_b is None else turn_b[:count]
            states = self._table(sorted_s[:count], turned, *found)
            raise self.halted(outcome, reached_s, states, why)
        if order is None:
            return found
        back = np.argsort(order)

        def in_order(table):
            if isinstance(table, dict):
                return {name: values[back] for name, values in table.items()}
            return np.take(table, back, axis=0)

        return tuple(map(in_order, found))

    def _taken_lane(self):
        """Return the lane of the motion before, in which this one begins; None: not in that."""
        after, self._after = self._after, None
        if after is None or after.tolerance != self.tolerance or (lane := after._lane) is None:
            return None
        # First, or after an interruption it would go on by what is half written.
        after._restart()
        if lane.takes(self.system, self.begin(), self.start_s, lambda: self.state):
            return lane
        after._lane = lane
        return None

    def _own_lane(self):
        """Return a lane of its own."""
        # It is compiled, which whoever asks for no propagation need not wait for.
        from .one_lane import OneLane

        lane = OneLane(self.system, self.begin(), self.course, self.wanted)
        lane.lanes.step_state[0, FURTHEST] = self._furthest_s
        return lane

    def halted(self, outcome: int, reached_s: float, states: States, why: str = '') -> Halted:
        """Return the error of a propagation that gets no further than reached_s."""
        if not why and outcome == TOO_MANY_STEPS:
            why = f'more than {self.most_steps} steps are needed to the next sample'
        state = states[-1] if len(states) else self.state
        if not why and (found := without_number(self.system, state, self.start_s + reached_s)):
            why = f'the torque {found.full_name()} is not a number there'
        why = why or f'no step meets the tolerance {self.tolerance:g}'
        kind = TableEnded if outcome == TABLE_ENDS else Halted
        return kind(f'the propagation came to a halt at {reached_s:g} s: {why}', reached_s, states)

    def states_of(self, problem: Problem, m: int, t_s: np.ndarray, course: Course) -> States:
        """Return the states of motion m of a problem at the ascending t_s (N,) of its rows."""
        return self._table(t_s, None, *self._found(problem, m, t_s, course))

    def _found(self, problem, m, t_s, course):
        """Return what _states does."""
        count = len(t_s)
        *found, work = columns(self.system, problem.out[m][:, :count])
        if course.has_jumped:
            work = work + course.jumped(t_s)
        return *found, work, *course.of_drives(t_s, problem.efforts[m][:, :count])

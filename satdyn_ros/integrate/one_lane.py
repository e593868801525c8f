"""A lane of one motion, and of those of the same body that follow it under other commands."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..dynamics.constants import (
    applied_by,
    constants_of,
    line_at,
    write_driven,
    write_events,
)
from ..dynamics.drives import Drives
from ..dynamics.system import State, System
from ..trace.graph import flatten, kind_of, numbered
from .course import Course, problem_of
from .lanes import ANOMALY, BEGINS, FURTHEST, HOLDS_UNTIL_S, REACHED, UNFINISHED, Lanes
from .step_code import step_code
from .walk import walk


class OneLane:
    """
    A motion in a lane of its own; the next one may take its place, with the bits it has alone.

    What a command changes then is numbers: the code, the lane, and the constants of the equations
    that depend neither on commands nor on the start stay.

    system: what moves; begin (V,): the variables at the start; course: of the motion; wanted: how
    many of the variables are interpolated.
    """

    def __init__(self, system: System, begin: np.ndarray, course: Course, wanted: int):
        constants = course.constants
        self.system, self.course, self.code = system, course, step_code(constants, 1)
        self.lanes = Lanes(1, self.code.layout, flatten(constants)[1])
        self.problem = problem_of(begin[None], [course], self.code.layout, wanted)
        self._does_work = constants.does_work
        undriven = constants_of(system.undriven)
        self._works_anyway = undriven.does_work
        self._friction = [rotor.friction for rotor in undriven.rotors]
        self._indices = numbered(constants)
        self._axes = [rotor.axis.tolist() for rotor in system.rotors]

    def walk_on(self, t_s: np.ndarray) -> bool:
        """Walk for a slice, to ascending times (N,) that are asked for; return whether it ends."""
        problem, lanes, code = self.problem, self.lanes, self.code
        if walk(problem.address, lanes.address, lanes.address, code.attempt, code.dense):
            return True
        if UNFINISHED < problem.outcome[0] < REACHED:
            self.course.go_on(problem, lanes, 0, t_s)
        return False

    def takes(
        self, system: System, begin: np.ndarray, start_s: float, state_of: Callable[[], State]
    ) -> bool:
        """
        Let the motion of a system begin in the lane, at start_s [s] from tick 0.

        begin: as of the class; state_of: gives the state that it is of.  Return whether the system
        is the same body under torques of the same kind; if not, nothing changes.
        """
        changed = {
            i: torque
            for i, torque in enumerate(system.torques)
            if torque is not self.system.torques[i]
        }
        if not self._is_alike(system, changed):
            return False
        course, drives = self.course, None
        if course.drives is not None:
            drives = Drives(system, state_of())
        if self._goes_on(system, start_s, changed, drives):
            self._write(system, start_s, changed, drives)
        else:
            course = course.of_next(system, state_of(), start_s)
            if course.most_stops >= self.problem.stop_times_s.shape[1]:
                return False
            self.course = course
            course.write(self.problem, 0)
        self.problem.begin[0] = begin
        self.problem.is_new[0], self.lanes.step_state[0, FURTHEST] = BEGINS, 0.0
        self.system = system
        return True

    def _is_alike(self, system, changed):
        works = self._works_anyway or system.is_driven
        return (
            system.undriven is self.system.undriven
            and works == self._does_work
            and all(
                kind_of(torque.constants) == kind_of(self.system.torques[i].constants)
                for i, torque in changed.items()
            )
        )

    def _goes_on(self, system, start_s, changed, drives):
        """Return whether the course goes on by other numbers, with the same tables."""
        return (
            # A rotor that is held counts with the inertia of the carrier.
            not any(each.hold for each in (self.course.drives, drives) if each is not None)
            and system.pieces == self.system.pieces
            and self.course.goes_on_at(start_s)
            and all(
                before is now
                for i, torque in changed.items()
                for before, now in zip(
                    flatten(self.system.torques[i].constants)[1],
                    flatten(torque.constants)[1],
                    strict=True,
                )
            )
        )

    def _write(self, system, start_s, changed, drives):
        """Write what the course takes over from its constants for another start."""
        course, problem = self.course, self.problem
        rotor_torque, events = system.rotor_torque, []
        if drives is not None:
            rotor_torque, events = drives.torques_and_events()
        torques: Mapping[int, Any] = {i: course.own_constants(x) for i, x in changed.items()}
        write_driven(
            problem.constants[0],
            self._indices,
            start_s,
            line_at(system, start_s),
            applied_by(system.torque_b.tolist(), self._axes, rotor_torque.tolist()),
            [rotor_torque[i] for i, _ in system.turning_rotors],
            torques,
        )
        write_events(problem.constants[0], self._indices, self._friction, events)
        course.start_anew(system, start_s, drives)
        problem.settings[0, ANOMALY] = course.anomaly[0]
        problem.settings[0, HOLDS_UNTIL_S] = course.until_s

"""Motions that take over from each other: what a command changes is numbers, not objects."""

import numpy as np

from ..dynamics.constants import applied_by, constants_of, line_at, write_driven
from ..dynamics.system import State, System
from ..dynamics.variables import ATTITUDE, RATE, Variables
from ..trace.graph import flatten, numbered
from .course import problem_of
from .lanes import (
    ANOMALY,
    BEGINS,
    FURTHEST,
    HOLDS_UNTIL_S,
    REACHED,
    UNFINISHED,
    Lanes,
)
from .propagation import Propagation
from .step_code import step_code
from .walk import walk


class Relay:
    """
    Motions of one body, each a Propagation bit by bit; the next begins where one ends.

    They are computed in one lane.  Of the constants of the equations, only what depends on the
    torques, on the start and on the true anomaly is written anew.

    system: of the present one.
    """

    def __init__(self, motion: Propagation):
        self.system = motion.system
        self._motion, self._course = motion, motion.new_course()
        course, self._constants = self._course, self._course.constants
        self._works_anyway = constants_of(self.system.undriven).does_work
        self._indices = numbered(self._constants)
        self._axes = [rotor.axis for rotor in self.system.rotors]
        self._turning: list[tuple[int, float, float, float, float]] = [
            (i, float(rotor.inertia), *rotor.axis.tolist())
            for i, rotor in self.system.turning_rotors
        ]
        self._parts = Variables.of(self.system)
        self._own_names = [n for torque in self.system.torques for n in torque.inner_names]
        self._coupled: list[tuple[float, float, float]] = [
            tuple(mode.coupling.tolist()) for mode in self.system.modes
        ]
        code, (_, arrays) = step_code(self._constants, 1), flatten(self._constants)
        self._code, self._t_s = code, np.zeros(1)
        self._lanes = Lanes(1, code.layout, arrays)
        self._problem = problem_of(motion.begin()[None], [course], code.layout, motion.wanted)
        self._problem.ask(self._t_s)
        # The variables where it stands; of the turning rotors the body rate along the axis and the
        # speed [rad/s]; of the modes d . omega and eta'.
        self._y: list[float] = []
        self._along: list[float] = []
        self._speeds: list[float] = []
        self._moved: list[float] = []
        self._swings: list[float] = []

    def reaches(self, t_s: float) -> bool:
        """Go on to a time [s] since the present motion began; return whether it gets there."""
        problem, lanes = self._problem, self._lanes
        self._t_s[0], problem.rows[0], problem.outcome[0] = t_s, 0, UNFINISHED
        while not walk(
            problem.address, lanes.address, lanes.address, self._code.attempt, self._code.dense
        ):
            if UNFINISHED < problem.outcome[0] < REACHED:
                self._course.set_constants()
                self._course.go_on(problem, lanes, 0, self._t_s)
        if problem.outcome[0] != REACHED:
            return False
        y = self._y = problem.out[0, :, 0].tolist()
        x, y_, z = y[RATE]
        self._along = [x * a + y_ * b + z * c for _, _, a, b, c in self._turning]
        self._speeds = [
            p / J - along
            for p, (_, J, *_), along in zip(
                y[self._parts.momenta], self._turning, self._along, strict=True
            )
        ]
        self._moved = [x * a + y_ * b + z * c for a, b, c in self._coupled]
        momenta = y[self._parts.modal_momenta]
        self._swings = [pi - moved for pi, moved in zip(momenta, self._moved, strict=True)]
        return True

    def takes_over(self, system: System, start_s: float) -> bool:
        """
        Let the next motion begin where this one stands, under the torques of a system.

        start_s: from tick 0.  Return whether it is of the same kind, in the same pieces of time;
        if not, nothing changes.
        """
        course = self._course
        is_alike = (self._works_anyway or system.is_driven) == self._constants.does_work
        is_anew = course.drives is not None or system.pieces != self.system.pieces
        if not (is_alike and (is_anew or course.goes_on_at(start_s))):
            return False
        problem, y, parts = self._problem, self._y, self._parts
        begin = problem.begin[0]
        begin[: len(y)] = y
        for n, (_, J, *_) in enumerate(self._turning):
            begin[parts.momenta.start + n] = J * (self._speeds[n] + self._along[n])
        for n, (swing, moved) in enumerate(zip(self._swings, self._moved, strict=True)):
            begin[parts.modal_momenta.start + n] = swing + moved
        begin[parts.work] = 0.0
        if is_anew:
            # Where each drive is on its law is found anew, or there are other tables.
            self._course = self._motion.course_of(system, self.state(), start_s)
            self._course.write(problem, 0)
        else:
            self._write(system, start_s)
        problem.is_new[0], self._lanes.step_state[0, FURTHEST] = BEGINS, 0.0
        self.system = system
        return True

    def _write(self, system, start_s):
        """Write what the present course takes over from its constants for another start."""
        course, problem = self._course, self._problem
        own = {
            i: course.own_constants(torque)
            for i, torque in enumerate(system.torques)
            if torque is not self.system.torques[i]
        }
        write_driven(
            problem.constants[0],
            self._indices,
            start_s,
            line_at(system, start_s),
            applied_by(system.torque_b, self._axes, system.rotor_torque),
            [system.rotor_torque[i] for i, *_ in self._turning],
            own,
        )
        course.start_anew(system, start_s)
        problem.settings[0, ANOMALY] = course.anomaly[0]
        problem.settings[0, HOLDS_UNTIL_S] = course.until_s

    def state(self) -> State:
        """Return the state where it stands."""
        y, system = self._y, self.system
        speeds = [np.nan] * len(system.rotors)
        angles = speeds.copy()
        turned = y[self._parts.angles]
        for n, (i, *_) in enumerate(self._turning):
            speeds[i], angles[i] = self._speeds[n], turned[n]
        inner: dict[str, float] = {}
        for mode, eta, swing in zip(
            system.modes, y[self._parts.displacements], self._swings, strict=True
        ):
            inner |= {mode.displacement_name: eta, mode.rate_name: swing}
        inner |= zip(self._own_names, y[self._parts.of_torques], strict=True)
        return State(np.array(y[ATTITUDE]), np.array(y[RATE]), speeds, angles, inner)

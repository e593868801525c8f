"""Motions of one kind side by side in lanes, each of which may restart by itself."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..dynamics.constants import applied_by, perifocal_line, turned_line, write_driven
from ..dynamics.system import System
from ..dynamics.variables import Variables, wanted_count
from ..kernel.time_table import Table
from ..kernel.vector import dot
from ..trace.graph import flatten, kind_of, numbered
from .batch import LANES
from .course import problem_of
from .lanes import (
    ANOMALY,
    BEGINS,
    HOLDS_UNTIL_S,
    MEAN_MOTION,
    MOTION_COUNT,
    REACHED,
    UNFINISHED,
    WAITING,
    Lanes,
    address,
)
from .layout import Layout
from .propagation import Propagation
from .step_code import step_code
from .walk import walk


class Driven(NamedTuple):
    """
    What commands set in M motions, in columns.

    torque_b [N m] (3, M): on the bodies; rotor_torque [N m] (R, M).  own: by their indices among
    the torques of the system the constants of those that are commanded, of columns (M,).
    """

    torque_b: np.ndarray
    rotor_torque: np.ndarray
    own: Mapping[int, Any]


class Relays:
    """
    Motions of one kind, each a Propagation bit by bit; each may restart at any time.

    system_of(m): the system of motion m under what is commanded now, of which its constants are
    made where a piece of time ends.

    y (M, W): the variables where they stand; start_s (M,): when each began, from tick 0; why: by
    motion, in one sentence, why it goes no further.

    ValueError: they are of different kinds.
    """

    def __init__(self, motions: Sequence[Propagation], system_of: Callable[[int], System]):
        self._motions, self._system_of = list(motions), system_of
        self._courses = [motion.new_course() for motion in motions]
        count, system, like = len(motions), motions[0].system, _working(motions[0])
        self._kind, self._indices = kind_of_motion(motions[0]), numbered(like)
        for motion in motions:
            self.refuse_other(motion)
        layout, begin = Layout.of(like), np.array([motion.begin() for motion in motions])
        self._problem = problem_of(begin, self._courses, layout, wanted_count(system, True))
        self._t_s = np.zeros((count, 1))
        self._problem.ask(self._t_s)
        self.why: dict[int, str] = {}
        self.y = begin[:, : self._problem.out.shape[1]].copy()
        self.start_s, self._anomaly = np.zeros((2, count))
        self._axes = np.zeros((len(system.rotors), 3, count))
        self._inertias = np.ones((len(system.turning_rotors), count))
        self._parts = Variables.of(system)
        self._couplings = np.zeros((len(system.modes), 3, count))
        self._perifocal = np.zeros((2, 3, count))
        # From when to when the pieces of time last of which its constants are.
        self._pieces_s = np.zeros((2, count))
        self._turning = [i for i, _ in system.turning_rotors]
        for m in range(count):
            self._note(m)
        # Motion m is in lane m % LANES of its group for good.
        arrays = flatten(like)[1]
        self._code, single = step_code(like, LANES), step_code(like, 1)
        self._dense, self._single = single.dense, Lanes(1, single.layout, arrays)
        self._groups = []
        for first in range(0, count, LANES):
            table = self._problem.table.copy()
            table[WAITING], table[MOTION_COUNT] = first, min(first + LANES, count)
            lanes = Lanes(LANES, layout, arrays)
            addresses = address(table), lanes.address, self._single.address
            self._groups.append((table, lanes, addresses))

    def refuse_other(self, motion: Propagation) -> None:
        """Raise ValueError for a motion that is of another kind."""
        if kind_of_motion(motion) != self._kind:
            raise ValueError(
                'runs side by side must be of one kind: with the same rotors that turn, torques '
                'and models, orbits that are all circular or all not, and inertias that all have '
                'products or all have none'
            )

    def _note(self, m):
        """Keep of motion m what it begins anew by."""
        motion, course = self._motions[m], self._courses[m]
        system = motion.system
        self.start_s[m], self._pieces_s[:, m] = motion.start_s, course.piece_s
        self._anomaly[m] = system.orbit.mean_anomaly_at(0.0)[0]
        for i, rotor in enumerate(system.rotors):
            self._axes[i, :, m] = rotor.axis
        for n, (_, rotor) in enumerate(system.turning_rotors):
            self._inertias[n, m] = rotor.inertia
        for n, mode in enumerate(system.modes):
            self._couplings[n, :, m] = mode.coupling
        if system.has_turning_axes:
            self._perifocal[:, :, m] = perifocal_line(system)

    def begin(self, m: int, motion: Propagation) -> None:
        """Let another motion, of the same kind, begin in place of motion m."""
        course = motion.new_course()
        self._motions[m], self._courses[m] = motion, course
        self._note(m)
        self._problem.begin[m] = motion.begin()
        course.write(self._problem, m)
        self._problem.is_new[m] = BEGINS
        self.y[m] = self._problem.begin[m, : self.y.shape[1]]
        self.why.pop(m, None)

    def take_over(self, rows: np.ndarray, start_s: np.ndarray, driven: Driven) -> np.ndarray:
        """
        Let the motions of rows (K,) begin anew where they stand at start_s (K,), from tick 0.

        driven: of all motions.  Return the rows that cannot by numbers alone: they are in another
        piece of time, or where each rotor is on the law of its drive is to be found anew.
        """
        if self._kind.switches:
            return rows
        begin_s, end_s = self._pieces_s[:, rows]
        stays = (begin_s <= start_s) & (start_s < end_s)
        left, rows, start_s = rows[~stays], rows[stays], start_s[stays]
        # Of all, which is most often so, a view does.
        at = slice(None) if len(rows) == len(self.y) else rows
        problem, y = self._problem, self.y
        along, speeds = self._rates(at)
        for n in range(len(self._turning)):
            momentum = self._parts.momenta.start + n
            y[at, momentum] = self._inertias[n, at] * (speeds[n] + along[n])
        for n, (swing, moved) in enumerate(zip(*self._swings(at), strict=True)):
            y[at, self._parts.modal_momenta.start + n] = swing + moved
        y[at, self._parts.work.start] = 0.0
        problem.begin[at, : y.shape[1]] = y[at]
        settings, numbers = problem.settings, problem.constants[at].T
        anomaly = self._anomaly[at] + settings[at, MEAN_MOTION] * start_s
        write_driven(
            numbers,
            self._indices,
            start_s,
            self._line(at, anomaly),
            self._applied(at, driven),
            driven.rotor_torque[self._turning][:, at],
            {i: _rows_of(constants, at) for i, constants in driven.own.items()},
        )
        if at is rows:
            problem.constants[rows] = numbers.T
        settings[at, ANOMALY], settings[at, HOLDS_UNTIL_S] = anomaly, end_s[stays] - start_s
        problem.is_new[at], self.start_s[at] = BEGINS, start_s
        return left

    # As in a motion alone, what overflows ends it in a sentence.
    @np.errstate(over='ignore', invalid='ignore')
    def _applied(self, at, driven):
        return applied_by(driven.torque_b[:, at], self._axes[:, :, at], driven.rotor_torque[:, at])

    def _line(self, at, anomaly):
        if not self._kind.turns_axes:
            return ()
        outward, ahead = self._perifocal[:, :, at]
        return turned_line(outward, ahead, anomaly)

    def reach(self, t_s: np.ndarray, goes: np.ndarray) -> None:
        """
        Let those that go (M,) go on to times [s] (M,) since each began; why says which do not.

        A motion that has ended must not go.
        """
        problem, outcome = self._problem, self._problem.outcome
        self._t_s[:, 0] = t_s
        problem.rows[goes], outcome[goes] = 0, UNFINISHED
        for _, lanes, tables in self._groups:
            while not walk(*tables, self._code.attempt, self._dense):
                for l, m in enumerate(lanes.motion.tolist()):
                    if m >= 0 and UNFINISHED < outcome[m] < REACHED:
                        self._go_on(m, lanes, l)
        reached = goes & (outcome == REACHED)
        self.y[reached] = problem.out[reached, :, 0]
        for m in np.flatnonzero(goes & ~reached).tolist():
            self.why[m] = self._reason(m)

    def _go_on(self, m, lanes, l):
        course, system = self._courses[m], self._system_of(m)
        if course.drives is None:
            course.start_anew(system, float(self.start_s[m]))
        course.go_on(self._problem, lanes, l, self._t_s[m])
        self._pieces_s[:, m] = course.piece_s

    def _reason(self, m):
        motion, (reached_s, *after) = self._motions[m], self._problem.ended[m].tolist()
        outcome, course = int(self._problem.outcome[m]), self._courses[m]
        states = motion.states_of(self._problem, m, np.zeros(0), course)
        return str(motion.halted(outcome, reached_s, states, course.reason(outcome, *after)))

    def _rates(self, at=slice(None)):
        """Return of the turning rotors the body rates along their axes, and their speeds."""
        omega = self.y[at, self._parts.rate].T
        along, speeds = [], []
        for n, i in enumerate(self._turning):
            along.append(dot(omega, self._axes[i][:, at]))
            momentum = self.y[at, self._parts.momenta.start + n]
            speeds.append(momentum / self._inertias[n, at] - along[n])
        return along, speeds

    def _swings(self, at=slice(None)):
        """Return of the modes eta', and d . omega."""
        omega = self.y[at, self._parts.rate].T
        moved = [dot(omega, d) for d in self._couplings[:, :, at]]
        momenta = self.y[at, self._parts.modal_momenta].T
        return [pi - d_omega for pi, d_omega in zip(momenta, moved, strict=True)], moved

    def states(self) -> tuple[Any, ...]:
        """Return q_ib (M, 4), omega_bi_b (M, 3), rotor_speed and _angle (M, R), inner (M,)."""
        speeds = np.full((len(self.y), len(self._axes)), np.nan)
        angles = speeds.copy()
        _, found = self._rates()
        for n, i in enumerate(self._turning):
            speeds[:, i] = found[n]
            angles[:, i] = self.y[:, self._parts.angles.start + n]
        swings, _ = self._swings()
        displacements, own = (
            self.y[:, part].T.copy()
            for part in (self._parts.displacements, self._parts.of_torques)
        )
        of_modes = [each for pair in zip(displacements, swings, strict=True) for each in pair]
        inner = dict(zip(self._kind.inner_names, [*of_modes, *own], strict=True))
        attitude, rate = self.y[:, self._parts.attitude], self.y[:, self._parts.rate]
        return attitude.copy(), rate.copy(), speeds, angles, inner


class Kind(NamedTuple):
    """What motions side by side have in common."""

    of_constants: tuple
    turning: tuple[int, ...]
    rotors: int
    turns_axes: bool
    switches: bool
    inner_names: tuple[str, ...]


def kind_of_motion(motion: Propagation) -> Kind:
    """Return what motions side by side must have in common."""
    system = motion.system
    return Kind(
        kind_of(_working(motion)),
        tuple(i for i, _ in system.turning_rotors),
        len(system.rotors),
        system.has_turning_axes,
        bool(system.switching_rotors),
        system.inner_names,
    )


def _working(motion):
    """Return constants with which work is counted: all else has the same bits without."""
    return motion.constants._replace(does_work=True)


def _rows_of(constants, at):
    """Return constants of columns (M,) with some rows of each."""
    parts = (
        part
        if isinstance(part, Table)
        else _rows_of(part, at)
        if isinstance(part, tuple)
        else part[at]
        if isinstance(part, np.ndarray)
        else part
        for part in constants
    )
    return type(constants)(*parts) if hasattr(constants, '_fields') else tuple(parts)

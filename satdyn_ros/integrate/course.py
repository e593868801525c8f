"""What holds for a motion while it is walked: the constants of the equations, and until when."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ..dynamics.constants import Constants, constants_of, with_tables
from ..dynamics.drives import Drives
from ..dynamics.system import State, System
from ..dynamics.variables import columns
from ..kernel import rotation
from ..kernel.rows import length
from ..kernel.time_table import Table
from ..orbits.pieces import Piece, Pieces, latest_at, tables_of
from ..orbits.tabled import ends
from ..torques.body_torque import BodyTorque
from ..trace.graph import flatten
from .lanes import (
    BEGIN,
    END,
    EXITS,
    FURTHEST,
    LATE,
    LEFT,
    RENEWED,
    ROTOR_LEAVES,
    SINCE,
    STEPS_ALLOWED,
    STEPS_OF_AN_EXIT,
    TABLE_ENDS,
    TOO_MANY_STEPS,
    UNFINISHED,
    Lanes,
    Problem,
    address,
)
from .layout import Layout

# At least as many corners as there may be in a piece of time.
_CORNERS = 256


class Course:
    """
    The course of a motion from its start.

    anomaly: mean anomaly at the start [rad], mean motion [rad/s] and eccentricity.  constants: of
    now, which hold until until_s from the start; piece_s: from when to when the pieces of time
    last that they are of, from tick 0; stop_times_s: the times from tick 0 at which steps end till
    then, ascending.  drives: of its rotors, None: none switches.

    ValueError: what depends on time alone is not known at the start.
    """

    def __init__(
        self, system: System, state: State, start_s: float, tolerance: float, steps_allowed: float
    ):
        self._system, self._start_s = system, start_s
        self._tolerance, self._steps_allowed = tolerance, steps_allowed
        self.anomaly = tuple(map(float, system.orbit.mean_anomaly_at(start_s)))
        # None: they are to be made.
        self._constants: Constants | None = None
        self.stop_times_s = self._all_stop_times_s = stop_times_of(system)
        self.drives: Drives | None = None
        self._why, self.until_s = '', np.inf
        self.piece_s = -np.inf, np.inf
        self._table_of: Callable[[Pieces], Table] | None = None
        self._current: dict[Pieces, Piece] = {}
        self._held: list[list[np.ndarray]] = []
        # When the table of the orbit jumps, from tick 0, and its work there up to then.
        self._jumps_s: list[float] = []
        self._jumped = [0.0]
        if system.switching_rotors:
            self.drives = Drives(system, state)
        if system.pieces:
            self._enter({each: each.piece_at(start_s) for each in system.pieces})

    @property
    def constants(self) -> Constants:
        """The constants of now."""
        if self._constants is None:
            self._constants = self._new_constants()
        return self._constants

    def _new_constants(self):
        system, start_s, drives = self._system, self._start_s, self.drives
        constants = constants_of(system, start_s) if drives is None else drives.constants(start_s)
        if self._table_of is None:
            return constants
        return with_tables(constants, system, self._table_of)

    def goes_on_at(self, start_s: float) -> bool:
        """Return whether the pieces of time that hold now are those of a start, from tick 0."""
        return self._current == {each: each.piece_at(start_s) for each in self._current}

    def start_anew(self, system: System, start_s: float, drives: Drives | None = None) -> None:
        """Let another motion of the same kind begin at start_s, while its pieces hold."""
        self._system, self._start_s, self._constants = system, start_s, None
        self.drives = drives
        self.anomaly = tuple(map(float, system.orbit.mean_anomaly_at(start_s)))
        self.until_s = self.piece_s[1] - start_s

    def of_next(self, system: System, state: State, start_s: float) -> 'Course':
        """Return the course of another motion that is computed as this one."""
        return Course(system, state, start_s, self._tolerance, self._steps_allowed)

    def own_constants(self, torque: BodyTorque) -> Any:
        """Return the constants of a torque in the pieces of now."""
        table_of = self._table_of
        return torque.constants if table_of is None else torque.constants_with(table_of)

    @property
    def most_stops(self) -> int:
        """At least as many stops as there may be before the constants hold no further."""
        return len(self._all_stop_times_s) + (2 + _CORNERS if self._system.pieces else 0)

    def write(self, problem: Problem, m: int) -> None:
        """Write what holds now for motion m of a problem."""
        numbers, arrays = flatten(self.constants)
        # Until the motion goes on by the new ones its lane still has those before.
        self._held = [*self._held[-1:], arrays]
        problem.constants[m], problem.arrays[m] = numbers, [*map(address, arrays)]
        problem.settings[m] = *self.anomaly, self._tolerance, 0.0, self.until_s
        self.allow(self._steps_allowed, problem, m)
        problem.stop_times_s[m] = np.inf
        problem.stop_times_s[m, : len(self.stop_times_s)] = self.stop_times_s
        problem.is_new[m] = RENEWED

    def allow(self, steps: float, problem: Problem, m: int) -> None:
        """Let motion m of a problem take so many steps from one row to the next."""
        self._steps_allowed = problem.settings[m, STEPS_ALLOWED] = steps

    def go_on(self, problem: Problem, lanes: Lanes, l: int, t_s: np.ndarray) -> None:
        """
        Let the motion in a lane go on where its constants hold no further.

        t_s (N,): ascending, of the rows that are asked for.
        """
        m, step = lanes.motion[l], lanes.step_state[l]
        y = lanes.y[l :: len(lanes.motion)][: problem.begin.shape[1]]
        q_ib, omega_bi_b, speeds = (each[0] for each in columns(self._system, y[:, None])[:3])
        if problem.outcome[m] == ROTOR_LEAVES:
            self.leave(int(step[LEFT]), float(step[END]), omega_bi_b, speeds)
            step[LEFT] = 0.0
            step[EXITS] += step[BEGIN] >= step[FURTHEST]
        else:
            try:
                self.enter_next(q_ib)
            except ValueError as error:
                self._why = str(error)
                # The time of a tick at the very end may be rounded to beyond it.
                late_s = latest_at(self.piece_s[1]) - self._start_s - step[END]
                has_late = step[LATE] == 0.0 and t_s[problem.rows[m]] <= step[END] + late_s
                step[LATE] = late_s
                problem.outcome[m] = UNFINISHED if has_late else TABLE_ENDS
                problem.ended[m] = step[END], step[SINCE], step[EXITS]
                return
        self.write(problem, m)
        problem.outcome[m] = UNFINISHED

    def leave(self, which: int, t_s: float, omega_bi_b: np.ndarray, speeds: np.ndarray) -> None:
        """
        Go on where a rotor has left its range at t_s, from the start of the motion.

        which: as of Drives.leave; omega_bi_b (3,), speeds (R,): of then [rad/s].
        """
        assert self.drives is not None
        self.drives.leave(which, t_s, omega_bi_b, speeds)
        self._constants = None

    def enter_next(self, q_ib: np.ndarray) -> None:
        """
        Go on where a piece of time ends, at an attitude (4,).

        ValueError: what depends on time alone is known no further.
        """
        following = {each: each.piece_from(self.piece_s[1]) for each in self._system.pieces}
        self._note_jump(following, q_ib)
        self._enter(following)

    def reason(self, outcome: int, since: float, exits: float) -> str:
        """
        Return why a motion has ended, if it is known here.

        since, exits: how many steps and exits of rotors there were after the last row.
        """
        if outcome == TOO_MANY_STEPS and exits * STEPS_OF_AN_EXIT > since:
            return (
                f'its rotors stop, start, or meet and leave limits more than {exits:g} times '
                'before the next sample'
            )
        return self._why if outcome == TABLE_ENDS else ''

    def of_drives(self, t_s: np.ndarray, efforts: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return rotor_torque and met_limit of States at ascending times, if there are any."""
        if self.drives is None:
            return ()
        shape = len(t_s), len(self._system.rotors)
        torques, met = np.full(shape, np.nan), np.zeros(shape, bool)
        for effort, (i, rotor) in zip(efforts, self._system.turning_rotors, strict=True):
            if rotor.mode == 'motor':
                torques[:, i] = effort
        for met_s, i in self.drives.met:
            row = int(np.searchsorted(t_s, met_s))
            if 0 < row < len(t_s):
                met[row, i] = True
        return torques, met

    @property
    def has_jumped(self) -> bool:
        """Whether the table of the orbit has jumped."""
        return bool(self._jumps_s)

    def jumped(self, t_s: np.ndarray) -> np.ndarray:
        """Return the work [J] of the jumps of the orbit's table up to times (N,)."""
        passed = np.searchsorted(self._jumps_s, self._start_s + t_s, side='right')
        return np.array(self._jumped)[passed]

    def _enter(self, current):
        """Go on by the tables of these pieces of time, as long as all of them last."""
        self._current, self._table_of = current, tables_of(current)
        self._constants = self._new_constants()
        begin_s = max(piece.begin_s for piece in current.values())
        end_s = min(piece.end_s for piece in current.values())
        corners_s = (each.corners_in(piece) for each, piece in current.items())
        stop_times_s = _ascending([self._all_stop_times_s, *corners_s])
        inside = stop_times_s[(begin_s < stop_times_s) & (stop_times_s < end_s)]
        self.stop_times_s = np.array([begin_s, *inside, end_s])
        self.piece_s, self.until_s = (begin_s, end_s), end_s - self._start_s

    def _note_jump(self, following, q_ib):
        """Count as work of the orbit what the potential jumps by where two stretches meet."""
        orbit, table = self._system.orbit, self._system.orbit.pieces
        if table is None:
            return
        pieces = self._current[table], following[table]
        if pieces[0].stretch == pieces[1].stretch:
            return
        potentials = []
        for piece, end in zip(pieces, (1, 0), strict=True):
            r_i = ends(table, piece)[end]
            r_b = rotation.rotate(rotation.conjugate(q_ib), r_i)
            r_I_r = r_b @ self._system.inertia @ r_b
            potentials.append(1.5 * orbit.mu / length(r_i) ** 5 * r_I_r)
        self._jumps_s.append(self.piece_s[1])
        self._jumped.append(self._jumped[-1] + float(potentials[1] - potentials[0]))


def stop_times_of(system: System) -> np.ndarray:
    """Return the times [s] from tick 0 at which steps end, ascending."""
    return _ascending(torque.stops() for torque in system.torques)


def _ascending(times_s: Iterable[np.ndarray]) -> np.ndarray:
    """Return times without those that come twice, ascending."""
    return np.unique(np.concatenate([np.zeros(0), *times_s]))


def problem_of(
    begin: np.ndarray, courses: Sequence[Course], layout: Layout, wanted: int
) -> Problem:
    """Return the problem of motions (M,) of one kind that begin with the variables (M, V)."""
    problem = Problem(begin, layout, wanted, max(each.most_stops for each in courses))
    for m, course in enumerate(courses):
        course.write(problem, m)
    return problem

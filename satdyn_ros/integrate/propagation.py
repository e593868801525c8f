"""
The propagation: the equations integrated by the explicit Runge-Kutta method of dop853.py.

The steps do not depend on the times that are asked for.  The compiled walk works in slices of a
few milliseconds, between which Ctrl-C and other threads get their turn.
"""

from collections.abc import Callable

import numpy as np

from ..dynamics.constants import Constants, constants_of, with_tables
from ..dynamics.drives import Drives
from ..dynamics.equations import MOMENTUM, OMEGA, Q, initial_values
from ..dynamics.motion import Halted, Motion, States, TableEnded
from ..dynamics.system import State, System
from ..dynamics.torque import without_number
from ..kernel import rotation
from ..kernel.compile import compiled
from ..kernel.rows import length
from ..kernel.time_table import Table
from ..orbits import KeplerOrbit, TabledOrbit
from ..orbits.pieces import Piece, Pieces, latest_at, tables_of
from .dense_output import add_turn, interpolate, make_dense
from .dop853 import (
    BEGIN,
    DENSE_OF,
    END,
    FURTHEST,
    LEFT,
    PASSED,
    PIECE_ENDS,
    REACHED,
    ROTOR_LEAVES,
    SINCE,
    STEP_UNDERFLOW,
    STEPS,
    TOO_MANY_STEPS,
    UNFINISHED,
    new_clock,
    step,
    step_arrays,
)
from .exits import stop_at_exit, write_efforts

# A third more steps than at 1e-12, a tenth of the error, and still above the rounding.
DEFAULT_TOLERANCE = 1e-13
# The most steps and rows of a slice.
_SLICE_STEPS, _SLICE_ROWS = 5000, 200_000
# What it takes to go on by other constants where a rotor leaves, counted as steps.
_STEPS_OF_AN_EXIT = 200
_NOT_WANTED, _NONE = np.empty((0, 3)), np.empty((0, 0))


class Propagation(Motion):
    """
    The motion of any system by numerical propagation.

    tolerance: relative local error of a step.  The propagation walks forward and keeps only its
    last step, so that memory use stays constant; for an earlier time it starts again.

    most_steps: the most steps from one requested row to the next, None: any number.  A rotor that
    leaves its range counts as 200.  Steps up to the furthest row that was ever reached do not
    count again.

    constants, anomaly: those of the equations, and mean anomaly at the start [rad], mean motion
    [rad/s] and eccentricity; stops_s: the times from tick 0 at which steps end; wanted: how many
    of the variables are interpolated, the first.  Where there are tables, constants and stops are
    those of one piece of time after the other.

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
    ):
        super().__init__(system, state, start_s)
        self.tolerance, self.most_steps = tolerance, most_steps
        self.constants = constants_of(system, start_s)
        self.anomaly = tuple(map(float, mean_anomaly(system, start_s)))
        self.wanted = wanted_count(system, self.constants.does_work)
        self.stops_s = stops_of(system)
        self._clock, self._steps_to_halt = new_clock(), 0.0
        self._all_stops_s, self._until_s = self.stops_s, np.inf
        self._drives: Drives | None = None
        self._table_of: Callable[[Pieces], Table] | None = None
        self._current: dict[Pieces, Piece] = {}
        self._begin()

    @property
    def steps(self) -> int:
        """The number of steps to where the propagation stands, or stood when it came to a halt."""
        return int(max(self._clock[STEPS], self._steps_to_halt))

    def _begin(self):
        y = initial_values(self.system, self.state)
        self._stages, self._dense = step_arrays(len(y))
        self._stages.y[: len(y)] = self._dense[0, : len(y)] = y
        if self.system.switching_rotors:
            self._drives = Drives(self.system, self.state)
            self._drive(self._drives)
        furthest = self._clock[FURTHEST]
        self._clock[:] = new_clock()
        self._clock[FURTHEST] = furthest
        # When the table of the orbit jumps, from tick 0, and its work there up to then.
        self._jumps_s: list[float] = []
        self._jumped = [0.0]
        if self.system.pieces:
            self._enter({each: each.piece_at(self.start_s) for each in self.system.pieces})

    def _drive(self, drives):
        """Go on by the constants of where the rotors are."""
        _, omega_bi_b, speeds, *_ = columns(self.system, self._stages.y[:, None])
        self.constants = drives.constants(self.start_s, omega_bi_b[0], speeds[0])
        if self._table_of is not None:
            self.constants = with_tables(self.constants, self.system, self._table_of)

    def _enter(self, current):
        """Go on by the tables of these pieces of time, as long as all of them last."""
        self._current = current
        self._table_of = tables_of(current)
        self.constants = with_tables(self.constants, self.system, self._table_of)
        begin_s = max(piece.begin_s for piece in current.values())
        self._end_s = min(piece.end_s for piece in current.values())
        stops_s = _with_corners(self._all_stops_s, current.items())
        inside = stops_s[(begin_s < stops_s) & (stops_s < self._end_s)]
        self.stops_s = np.array([begin_s, *inside, self._end_s])
        self._until_s = self._end_s - self.start_s
        self._clock[PASSED] = 0.0

    def _note_jump(self, following):
        """Count as work of the orbit what the potential jumps by where two stretches meet."""
        orbit = self.system.orbit
        if not isinstance(orbit, TabledOrbit):
            return
        pieces = self._current[orbit.pieces], following[orbit.pieces]
        if pieces[0].stretch == pieces[1].stretch:
            return
        q_ib = columns(self.system, self._stages.y[:, None])[0][0]
        potentials = []
        for piece, end in zip(pieces, (1, 0), strict=True):
            r_i = orbit.ends(piece)[end]
            r_b = rotation.rotate(rotation.conjugate(q_ib), r_i)
            r_I_r = r_b @ self.system.inertia @ r_b
            potentials.append(1.5 * orbit.mu / length(r_i) ** 5 * r_I_r)
        self._jumps_s.append(self._end_s)
        self._jumped.append(self._jumped[-1] + float(potentials[1] - potentials[0]))

    def _states(self, t_s, turn_b=_NOT_WANTED):
        order = None if (t_s[1:] >= t_s[:-1]).all() else np.argsort(t_s, kind='stable')
        sorted_s = t_s if order is None else t_s[order]
        if len(t_s) and sorted_s[0] < self._clock[BEGIN]:
            self._begin()
        out, efforts = np.empty((self.wanted, len(t_s))), _NONE
        if self._drives is not None:
            efforts = np.empty((len(self.system.turning_rotors), len(t_s)))
            self._drives.forget(float(self._clock[BEGIN]))
        rows, outcome, why, before, exits = 0, UNFINISHED, '', 0, 0
        while outcome == UNFINISHED:
            rows, outcome = _integrate(
                sorted_s,
                rows,
                out,
                efforts,
                turn_b,
                self._clock,
                self._stages,
                self._dense,
                self.anomaly,
                self.stops_s,
                self._until_s,
                self.constants,
                self.tolerance,
                self.steps_allowed - exits * _STEPS_OF_AN_EXIT,
            )
            if rows > before:
                before, exits = rows, 0
            if outcome == ROTOR_LEAVES and self._drives is not None:
                self._drives.leave(int(self._clock[LEFT]), float(self._clock[END]))
                self._clock[LEFT] = 0.0
                self._drive(self._drives)
                exits += self._clock[BEGIN] >= self._clock[FURTHEST]
                outcome = UNFINISHED
            if outcome == PIECE_ENDS:
                try:
                    following = {each: each.piece_from(self._end_s) for each in self.system.pieces}
                    self._note_jump(following)
                    self._enter(following)
                    outcome = UNFINISHED
                except ValueError as error:
                    why = str(error)
                    # The time of a tick at the very end may be rounded to beyond it.
                    end_s, latest_s = self._clock[END], latest_at(self._end_s) - self.start_s
                    late = np.searchsorted(sorted_s, latest_s, side='right')
                    if late > rows and sorted_s[late - 1] > end_s:
                        sorted_s = sorted_s.copy()
                        sorted_s[rows:late] = end_s
                        outcome = UNFINISHED
        if outcome != REACHED:
            reached_s = float(self._clock[END])
            if outcome == TOO_MANY_STEPS and exits * _STEPS_OF_AN_EXIT > self._clock[SINCE]:
                why = (
                    f'its rotors stop, start, or meet and leave limits more than {exits} times '
                    'before the next sample'
                )
            self._steps_to_halt = self._clock[STEPS] - self._clock[SINCE]
            of_drives = self._of_drives(sorted_s[:rows], efforts[:, :rows])
            found = *self._columns(out[:, :rows], sorted_s[:rows]), *of_drives
            self._begin()
            turned = turn_b[:rows] if len(turn_b) else None
            states = self._table(sorted_s[:rows], turned, *found)
            raise self.halted(outcome, reached_s, states, why)
        of_drives = self._of_drives(sorted_s, efforts)
        if order is not None:
            out[:, order] = out.copy()
            for table in of_drives:
                table[order] = table.copy()
        return *self._columns(out, t_s), *of_drives

    def _of_drives(self, t_s, efforts):
        """Return rotor_torque and met_limit of States at ascending times, if there are any."""
        if self._drives is None:
            return ()
        shape = len(t_s), len(self.system.rotors)
        torques, met = np.full(shape, np.nan), np.zeros(shape, bool)
        for effort, (i, rotor) in zip(efforts, self.system.turning_rotors, strict=True):
            if rotor.mode == 'motor':
                torques[:, i] = effort
        for met_s, i in self._drives.met:
            row = int(np.searchsorted(t_s, met_s))
            if 0 < row < len(t_s):
                met[row, i] = True
        return torques, met

    def constants_until(self, end_s: float) -> tuple[Constants, np.ndarray]:
        """
        Return the constants and the stops of the whole motion from its start to end_s.

        ValueError: a table ends before, or jumps.
        """
        if not self.system.pieces:
            return self.constants, self.stops_s
        span = self.start_s, self.start_s + end_s
        constants = with_tables(
            self.constants, self.system, lambda each: each.table_between(*span)
        )
        parts = [
            (each, piece) for each in self.system.pieces for piece in each.pieces_between(*span)
        ]
        stops_s = _with_corners(self._all_stops_s, parts)
        return constants, np.union1d(stops_s, [piece.begin_s for _, piece in parts])

    @property
    def steps_allowed(self) -> float:
        """Return most_steps as a number: infinite for any number."""
        return np.inf if self.most_steps is None else float(self.most_steps)

    def halted(self, outcome: int, reached_s: float, states: States, why: str = '') -> Halted:
        """Return the error of a propagation that gets no further than reached_s."""
        if not why and outcome == TOO_MANY_STEPS:
            why = f'more than {self.most_steps} steps are needed to the next sample'
        state = states[-1] if len(states) else self.state
        if not why and (found := without_number(self.system, state, self.start_s + reached_s)):
            why = f'the torque {found.full_name()} is not a number there'
        why = why or f'no step meets the tolerance {self.tolerance:g}'
        kind = TableEnded if outcome == PIECE_ENDS else Halted
        return kind(f'the propagation came to a halt at {reached_s:g} s: {why}', reached_s, states)

    def states_of(self, t_s: np.ndarray, out: np.ndarray) -> States:
        """Return the states at t_s (N,) of the wanted variables (V, N)."""
        return self._table(t_s, None, *self._columns(out, t_s))

    def _columns(self, out, t_s):
        *found, work = columns(self.system, out)
        if self._jumps_s:
            passed = np.searchsorted(self._jumps_s, self.start_s + t_s, side='right')
            work = work + np.array(self._jumped)[passed]
        return *found, work


def columns(system: System, out: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the columns of States of the wanted variables (..., V, N)."""
    q_ib = out[..., Q:OMEGA, :].swapaxes(-2, -1)
    omega_bi_b = out[..., OMEGA:MOMENTUM, :].swapaxes(-2, -1)
    rows, turning = out[..., 0, :].shape, system.turning_rotors
    speeds = [_repeated(np.nan, rows)] * len(system.rotors)
    angles = speeds.copy()
    for n, (i, rotor) in enumerate(turning):
        speeds[i] = np.asarray(rotor.speed(out[..., MOMENTUM + n, :], omega_bi_b))
        angles[i] = out[..., MOMENTUM + len(turning) + n, :]
    i = MOMENTUM + 2 * len(turning)
    work = out[..., i, :] if out.shape[-2] > i else _repeated(0.0, rows)
    return q_ib, omega_bi_b, _of_rotors(speeds, rows), _of_rotors(angles, rows), work


def _repeated(value, shape):
    # Of one row, np.broadcast_to costs more than the propagation of a tick.
    return np.ndarray(shape, float, np.float64(value), strides=(0,) * len(shape))


def _of_rotors(columns, rows):
    """Return one column per rotor as a table (..., N, R), without a copy where it can."""
    if len(columns) == 1:
        return columns[0][..., None]
    return np.stack(columns, axis=-1) if columns else np.empty((*rows, 0))


def wanted_count(system: System, does_work: bool) -> int:
    """Return how many variables are interpolated: not the work if it is none, nor the place."""
    return MOMENTUM + 2 * len(system.turning_rotors) + does_work


def mean_anomaly(system: System, start_s: float) -> tuple[float | np.ndarray, ...]:
    """Return mean anomaly at start_s, mean motion and eccentricity; zeros: no orbit."""
    orbit = system.orbit
    if not isinstance(orbit, KeplerOrbit):
        return 0.0, 0.0, 0.0
    mean_motion = orbit.mean_motion
    return orbit.mean_anomaly + mean_motion * start_s, mean_motion, orbit.eccentricity


def stops_of(system: System) -> np.ndarray:
    """Return the times [s] from tick 0 at which steps end, ascending."""
    return np.unique(np.concatenate([np.zeros(0), *(t.stops() for t in system.torques)]))


def _with_corners(stops_s, parts):
    """Return stops and the corners in some pieces [s from tick 0], ascending."""
    return np.unique(np.concatenate([stops_s, *(each.corners_in(piece) for each, piece in parts)]))


@compiled
def _integrate(
    t_s,
    rows,
    out,
    efforts,
    turn_b,
    clock,
    stages,
    dense,
    anomaly,
    stops_s,
    until_s,
    constants,
    tolerance,
    steps_allowed,
):
    """
    Fill out (V, N) with the wanted variables at the ascending times t_s (N,), from row `rows` on.

    Return how many rows are filled when the slice ends, and how it ends.  efforts (R, N): of the
    turning rotors the motors' torques [N m], where drives act.  turn_b (N, 3): as of
    States, added to; without rows: it is not wanted.  clock, stages, dense: the current step, as
    in dop853.py.  until_s: up to where the constants hold.
    """
    count, is_stuck = min(len(t_s), rows + _SLICE_ROWS), False
    for _ in range(_SLICE_STEPS):
        last = rows
        # The torque that holds a rotor is known when there is a step.
        waits = len(constants.drives) > 0 and clock[STEPS] == 0.0 and not is_stuck
        while last < count and t_s[last] <= clock[END] and not waits:
            last += 1
        counts = len(turn_b) > 0 and last > 0
        if (last > rows or counts) and clock[DENSE_OF] != clock[STEPS]:
            make_dense(clock, stages, dense, constants)
        if last > rows:
            interpolate(t_s, out, rows, last, clock, dense, constants)
            write_efforts(t_s, efforts, rows, last, clock, dense, constants)
            if counts:
                for i in range(max(rows, 1), last):
                    from_s = max(t_s[i - 1], clock[BEGIN])
                    add_turn(turn_b[i], from_s, t_s[i], clock, dense)
            rows = last
            if t_s[rows - 1] > clock[FURTHEST]:
                clock[FURTHEST], clock[SINCE] = t_s[rows - 1], 0.0
        if rows == count:
            break
        if is_stuck:
            return rows, STEP_UNDERFLOW
        if clock[LEFT] != 0.0:
            return rows, ROTOR_LEAVES
        if clock[END] >= until_s:
            return rows, PIECE_ENDS
        if clock[SINCE] >= steps_allowed:
            return rows, TOO_MANY_STEPS
        if counts:
            from_s = max(t_s[rows - 1], clock[BEGIN])
            add_turn(turn_b[rows], from_s, clock[END], clock, dense)
        if not step(clock, stages, anomaly, stops_s, constants, tolerance):
            is_stuck = True
            continue
        stop_at_exit(clock, stages, dense, constants)
        if clock[BEGIN] >= clock[FURTHEST]:
            clock[SINCE] += 1.0
    return rows, REACHED if rows == len(t_s) else UNFINISHED

"""
What the walk reads and writes: motions in lanes, and where what is in their arrays.

The compiled walk takes one table of integers for each: addresses of arrays, and counts.
"""

from collections.abc import Sequence

import numpy as np

from .layout import ARRAYS, FRAME, STAGES, TERMS, Layout, row_length

# The step state of a lane: where the last step began and ended, the length that is proposed for
# the next, the number of steps taken, the one that the dense output belongs to, the furthest row
# that was ever reached, the number of steps begun since; how many stop times are passed, and when
# the next one comes.
BEGIN, END, NEXT, STEPS, DENSE_OF, FURTHEST, SINCE, PASSED, STOP = range(9)
# Of a step that is tried: whether one is, its length, what that would be without a cut, the most
# that the next may grow to, whether it is cut at a corner, whether it ends at the stop, and
# whether there is none.
TRYING, TRIED, PROPOSED, MOST_GROWTH, IS_CUT, IS_STOPPED, IS_STUCK = range(9, 16)
# Where the step is to end because a rotor leaves its range, which, and which has left, as of
# Drives.leave; by how much a row may be beyond the last step.
EXIT_S, EXIT, LEFT, LATE = range(16, 20)
# How often a rotor has left its range since the furthest row; how long after the last step a
# corner is foreseen, 0: none is.
EXITS, FORESEEN = range(20, 22)
STEP_STATE_SIZE = 22

# The settings of a motion: mean anomaly at the start [rad], mean motion [rad/s] and eccentricity,
# tolerance, the most steps from row to row, and until when its constants hold.
ANOMALY, MEAN_MOTION, ECCENTRICITY, TOLERANCE, STEPS_ALLOWED, HOLDS_UNTIL_S = range(6)
SETTINGS = 6

# How a motion stands: it goes on, a piece of time ends or a rotor leaves its range, so that its
# constants hold no further; or it has ended: all rows are reached, no step meets the tolerance,
# too many steps are needed, or what depends on time alone is known no further.
UNFINISHED, PIECE_ENDS, ROTOR_LEAVES = range(3)
REACHED, STEP_UNDERFLOW, TOO_MANY_STEPS, TABLE_ENDS = range(3, 7)

# That a motion is new: other constants hold from now on, or it begins anew in its lane.
RENEWED, BEGINS = 1, 2

# What it takes to go on by other constants where a rotor leaves, counted as steps.
STEPS_OF_AN_EXIT = 200
# Floats in a cache line.
_LINE = 8


# What is in the table of Lanes, after the addresses of the ARRAYS of layout.py: addresses of the
# step states, of the motions and of the table itself, and how many lanes and variables of a row.
STEP_STATES_AT, MOTION_AT, LANE_COUNT, ROW, TABLE_AT = range(len(ARRAYS), len(ARRAYS) + 5)
# What is in the table of a Problem: addresses of its arrays; numbers of motions, of rows that are
# asked for, of variables that are wanted, of stops, numbers and arrays of each motion; the next
# motion to take a lane; the number of variables, where the true anomaly is among them (0: it
# is not), the number of turning rotors, where they and the event functions of their drives (0:
# there are none) begin among the constants, and where their momenta begin among the variables;
# whether a step is cut at a corner before its error is looked at (0: it is not); how many times
# there are from those of a motion to those of the next (0: they have the same).
(T_S_AT, BEGIN_AT, SETTINGS_AT, CONSTANTS_AT, ARRAYS_AT, STOPS_AT, IS_NEW_AT, OUT_AT) = range(8)
(EFFORTS_AT, TURN_AT, ROWS_AT, OUTCOME_AT, ENDED_AT) = range(8, 13)
(MOTION_COUNT, ROW_COUNT, WANTED, STOP_COUNT, CONSTANT_COUNT, ARRAY_COUNT) = range(13, 19)
(WAITING, SIZE, ANOMALY_AT, ROTORS, ROTORS_AT, EVENTS_AT, MOMENTA_AT) = range(19, 26)
CUTS_FIRST, T_S_STEP = 26, 27


class Lanes:
    """
    What motions of one kind are computed in, and its state; count: of lanes.

    motion (L,): which is in a lane, -1: none; step_state (L, STEP_STATE_SIZE); y: the variables,
    flat, those of all lanes side by side; table: addresses and counts.

    arrays: of one motion of that kind, from which what idle lanes compute, of no use, is read.
    """

    def __init__(self, count: int, layout: Layout, arrays: Sequence[np.ndarray]):
        row = row_length(layout.size, count)
        rows = {'y': row, 'dense': TERMS * row, 'k': STAGES * row, 'errors': 2 * row}
        sizes = {'frame': FRAME, **rows, 'constants': layout.numbers, 'arrays': layout.arrays}
        begins, total = {}, 0
        for name in ARRAYS:
            begins[name] = total
            # Each from the start of a cache line on: no vector straddles two lines.
            total += -(-sizes[name] * count // _LINE) * _LINE
        numbers = np.zeros(total + _LINE)
        first = -address(numbers) // numbers.itemsize % _LINE
        self.y = numbers[first + begins['y'] :][: row * count]
        self.motion, self.step_state = np.full(count, -1), np.zeros((count, STEP_STATE_SIZE))
        idle = numbers[first + begins['arrays'] :][: layout.arrays * count].view(np.int64)
        idle[:] = np.repeat([address(each) for each in arrays], count)
        begin = address(numbers) + numbers.itemsize * first
        of_code = [begin + numbers.itemsize * begins[name] for name in ARRAYS]
        addresses = [*of_code, address(self.step_state), address(self.motion)]
        self.table = np.array([*addresses, count, row, 0], np.int64)
        self.address = self.table[TABLE_AT] = address(self.table)
        self._numbers = numbers


class Problem:
    """
    The starts and the results of M motions of one kind.

    begin (M, V): the variables at the start; settings (M, 6), constants (M, P) and arrays (M, A):
    what holds now; stop_times_s (M, S): the times from tick 0 at which steps end, ascending, then
    infinite; is_new (M,): RENEWED where these have changed, BEGINS where the motion begins anew,
    else 0.  rows (M,): how many are filled; outcome (M,): how a motion stands; ended (M, 3): when
    it has ended, the end of its last step, and how many steps and exits of rotors it took since
    the last row.  table: addresses and counts.

    out (M, W, N): the wanted variables; efforts (M, R, N): the torques of the motors [N m], where
    drives act, else without rows.
    """

    def __init__(self, begin: np.ndarray, layout: Layout, wanted: int, most_stops: int):
        count = len(begin)
        self.begin, self._wanted = np.ascontiguousarray(begin), wanted
        self._rotors = layout.rotors if layout.events_at else 0
        self.settings = np.empty((count, SETTINGS))
        self.constants = np.empty((count, layout.numbers))
        self.arrays = np.empty((count, layout.arrays), np.int64)
        self.stop_times_s = np.full((count, most_stops + 1), np.inf)
        self.is_new, self.rows, self.outcome = np.zeros((3, count), np.int64)
        self.ended = np.zeros((count, 3))
        known = (
            self.begin,
            self.settings,
            self.constants,
            self.arrays,
            self.stop_times_s,
            self.is_new,
        )
        of_rows = self.rows, self.outcome, self.ended
        addresses = [0, *map(address, known), 0, 0, 0, *map(address, of_rows)]
        counts = [count, 0, wanted, most_stops + 1, layout.numbers, layout.arrays, 0]
        self.table = np.array([*addresses, *counts, *layout[:7], 0], np.int64)
        self.address = address(self.table)

    def ask(self, t_s: np.ndarray, turn_b: np.ndarray | None = None) -> None:
        """
        Let the motions go on to ascending times t_s (N,), or to times of their own (M, N).

        turn_b (N, 3): as of States, of one motion, added to; None: it is not wanted.
        """
        t_s = np.ascontiguousarray(t_s, float)
        count, rows, table = len(self.begin), t_s.shape[-1], self.table
        # The walk reads and writes them by their addresses.
        self._held = t_s, turn_b
        self.out = np.empty((count, self._wanted, rows))
        self.efforts = np.empty((count, self._rotors, rows))
        self.rows[:], self.outcome[:] = 0, UNFINISHED
        table[T_S_AT], table[ROW_COUNT] = address(t_s), rows
        table[T_S_STEP] = rows if t_s.ndim > 1 else 0
        table[OUT_AT], table[EFFORTS_AT] = address(self.out), address(self.efforts)
        table[TURN_AT] = 0 if turn_b is None else address(turn_b)


def address(array: np.ndarray) -> int:
    """Return where the numbers of an array are, as long as somebody holds it."""
    # A third of the time of array.ctypes.data.
    return array.__array_interface__['data'][0]

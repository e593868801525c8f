"""A motion from a tick on: the part of a run in which no event acts."""

from dataclasses import replace

from ..dynamics.motion import Halted, Motion, States
from ..dynamics.system import State
from ..integrate.propagation import Propagation
from .ticks import LAST_STAMP_NS, Ticks

# A motion that takes more steps from one tick to the next does not reach it.
MOST_STEPS_A_TICK = 10**6
NO_STAMP = f'the next tick comes after the last stamp of ROS, {LAST_STAMP_NS // 10**9} s'


class Segment:
    """
    A motion that begins at a tick, asked for its states at ticks.

    counts_turns: whether its states have turn_b, from tick to tick, zero at the first; so they
    have met_limit, where the motors have limits of speed.
    why_no_further: why it does not go on after the last tick that it reaches, one sentence.
    """

    def __init__(self, ticks: Ticks, begin_tick: int, motion: Motion, counts_turns: bool = False):
        self.motion, self.begin_tick = motion, begin_tick
        self.why_no_further = NO_STAMP
        self._ticks, self._counts_turns = ticks, counts_turns
        # Both are counted from the tick before.
        self._looks_back = counts_turns or bool(motion.system.switching_rotors)
        # What moves may not need the orbit, or a field that only a sensor sees.
        environment = motion.system.environment
        asked = () if environment is None else environment.asked
        self._tables = dict.fromkeys((*motion.system.pieces, *asked))
        # The first tick that the motion is known not to reach.
        self._end_tick = ticks.last + 1
        self._known_rows(begin_tick, ticks.seconds_between(0, begin_tick, begin_tick + 1))
        # States that were computed, from a tick on.
        self._ahead: tuple[int, States] | None = None

    def halt(self, tick: int, why: str) -> None:
        """Let the motion end before a tick, for a reason."""
        self._end_tick, self.why_no_further = tick, why

    def knows(self, tick: int) -> bool:
        """Whether all tables are known at a tick."""
        if not self._tables:
            return True
        orbit_s = self._ticks.seconds_between(0, tick, tick + 1)
        return all(table.known_rows(orbit_s)[0] for table in self._tables)

    def reaches(self, tick: int) -> bool:
        """Whether the motion has a state at a tick, its first or the next."""
        if tick == self.begin_tick:
            return tick < self._end_tick
        return self._has(tick) or len(self.states(tick, tick + 1)) > 0

    def states(self, first: int, last: int, with_last: bool = False) -> States:
        """
        Return the states at the ticks from first to before last, as far as the motion goes.

        with_last: the state at last is wanted soon, and is computed with them.
        """
        if self._ahead is None or not self._has(first):
            states = self._computed(first, min(last + with_last, self._end_tick))
            if not len(states):
                return states
            self._ahead = first, states
        begin, states = self._ahead
        return states.rows(slice(first - begin, last - begin))

    def state_at(self, tick: int) -> State:
        """Return the state at a tick that the motion reaches."""
        if self._ahead is not None and self._has(tick):
            begin, states = self._ahead
            return states[tick - begin]
        t_s = self._ticks.seconds_between(self.begin_tick, tick, tick + 1)
        return self.motion.at(t_s)[0]

    def catch_up(self, tick: int) -> None:
        """Go to a tick that the motion reached before, however many steps that takes."""
        if isinstance(self.motion, Propagation):
            most_steps, self.motion.most_steps = self.motion.most_steps, None
            # From the tick before, what is counted from there can yet be.
            self.state_at(max(tick - self._looks_back, self.begin_tick))
            self.motion.most_steps = most_steps

    def _has(self, tick):
        """Whether the state at a tick was computed and is kept."""
        return self._ahead is not None and 0 <= tick - self._ahead[0] < len(self._ahead[1])

    def _computed(self, first, last):
        begin = max(first - self._looks_back, self.begin_tick)
        if not isinstance(self.motion, Propagation):
            last = begin + self._known_rows(begin, self._ticks.seconds_between(0, begin, last))
        t_s = self._ticks.seconds_between(self.begin_tick, begin, last)
        try:
            states = self.motion.counting_at(t_s) if self._counts_turns else self.motion.at(t_s)
        except Halted as halted:
            states = halted.states
            self.halt(begin + len(states), str(halted))
        if begin < first:
            states = states.rows(slice(first - begin, None))
        orbit_s = self._ticks.seconds_between(0, first, first + len(states))
        count = self._known_rows(first, orbit_s)
        return replace(states.rows(slice(count)), orbit_s=orbit_s[:count])

    def _known_rows(self, first, orbit_s):
        """Return at how many of successive ticks all tables are known; it halts where not."""
        count = len(orbit_s)
        for table in self._tables:
            known, why = table.known_rows(orbit_s[:count])
            if known < count:
                self.halt(first + known, why)
                count = known
        return count

"""The thread that makes ticks happen: it sleeps until deadlines, publishes, and takes events."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from threading import Condition, RLock, Thread
from typing import Protocol, TypeVar

from ..base.nanoseconds import SECOND_NS
from ..run.events import Event
from ..run.samples import Samples
from ..run.simulation import Simulation
from .lateness import Lateness, Punctuality
from .realtime import GARBAGE

# Ticks are computed ahead for this time at most: what was published reaches the recorder soon.
_AHEAD_S = 0.25
_LARGEST_BLOCK = 256
# A longer sleep can be interrupted; a shorter one ends more punctually.
_SHORT_NS = 50_000_000
# How long, and how often, the end waits for a tick that is being computed.
_PATIENCE_S, _LOOK_S = 0.3, 0.02
# A lag after which deadlines are counted from the present.
_LARGEST_LAG_NS = SECOND_NS


class Publishable(Protocol):
    """The messages of a block of ticks, ready to be published row by row."""

    def publish(self, row: int) -> None:
        """Publish the messages of one tick."""


_Messages = TypeVar('_Messages', bound=Publishable)


class BlockListener(Protocol[_Messages]):
    """Gets each block of ticks before it is published, and how much of it was published."""

    def prepare(self, samples: Samples) -> _Messages:
        """Return the messages of ticks, which may yet be computed anew."""

    def published(
        self, happened: list[Event], samples: Samples, messages: _Messages, count: int
    ) -> None:
        """Handle what happened at the first tick, and that `count` ticks were published."""


class Pacing:
    """
    The ticks of a simulation, paced by absolute deadlines of the monotonic clock.

    Nothing is skipped: late ticks are published late; deadlines are reset after a lag of a second,
    a pause, or a change of the factor.  A run that has halted waits for a request or a reset.
    Where Python's garbage collection is disabled, it happens between ticks.

    Parameters
    ----------
    simulation : Simulation
        the run
    listener : BlockListener
        is told of the ticks
    factor : s/s
        simulated seconds per wall second, 0: as fast as possible
    failed : function of an Exception
        called once from the thread if it ends by an error
    begin : function
        called once from the thread before anything else
    first_tick_ns : ns or None
        the deadline of the first tick, None: its publication

    Attributes
    ----------
    lateness : Lateness
        the lags of all ticks that had deadlines
    """

    def __init__(
        self,
        simulation: Simulation,
        listener: BlockListener,
        factor: float,
        failed: Callable[[Exception], None],
        begin: Callable[[], None] = lambda: None,
        first_tick_ns: int | None = None,
    ):
        self._simulation = simulation
        self._listener = listener
        self._factor = factor
        self._failed = failed
        self._begin = begin
        self.lateness = Lateness()
        self._lags_ns: list[float] = []
        self._lock = RLock()
        self._changed = Condition(self._lock)
        self._attention = False
        self._stopping = False
        self._paused = False
        self._computing = False
        self._halted: str | None = None
        self._steps = 0
        self._step_begin = 0
        self._step_ended: Callable[[int], None] | None = None
        self._step_passed: Callable[[int], None] | None = None
        self._inbox: list[tuple[str | None, Callable[[int], Event]]] = []
        self._largest_block = 1
        self._block_length = 1
        self._tick = simulation.tick
        self._begin_anew = first_tick_ns is None
        self._begin_tick = simulation.next_tick
        self._begin_ns = first_tick_ns or 0
        self._period_ns = 0.0
        self._punctuality = Punctuality()
        self._thread = Thread(target=self._run, name='pacing', daemon=True)
        self._set_period()

    # -- from other threads ----------------------------------------------------------------------

    @property
    def between_ticks(self) -> AbstractContextManager:
        """While it is held, no tick is published."""
        return self._changed

    @property
    def tick(self) -> int:
        """The last tick that was published, -1 before the first."""
        return self._tick

    @property
    def is_paused(self) -> bool:
        """Whether ticks pass by ~/step alone."""
        return self._paused

    @property
    def is_stepping(self) -> bool:
        """Whether a step is in progress."""
        return self._steps > 0

    @property
    def halted(self) -> str | None:
        """Why no tick can follow, None: one can."""
        return self._halted

    @property
    def factor(self) -> float:
        """The requested simulated seconds per wall second."""
        return self._factor

    @property
    def is_alive(self) -> bool:
        """Whether the thread runs."""
        return self._thread.is_alive()

    def start(self) -> None:
        """Begin with the next tick."""
        GARBAGE.begin()
        self._thread.start()

    def stop(self) -> None:
        """Let no more ticks happen; one that is still being computed is abandoned."""
        self._attention = True
        with self._changed:
            self._stopping = True
            self._end_step()
            self._alert()
        patience_ends_s = time.monotonic() + _PATIENCE_S
        while self._thread.is_alive():
            if self._computing and time.monotonic() > patience_ends_s:
                return
            self._thread.join(_LOOK_S)

    def put(
        self, event_at: Callable[[int], Event], kind: str | None = None, restarts: bool = False
    ) -> None:
        """
        Let an event act at the next tick.

        Parameters
        ----------
        event_at : function of int
            returns the event at a tick
        kind : str or None
            while no tick passes, an event takes the place of one of its kind that waits
        restarts : bool
            whether it begins a new motion, with which a halted run continues
        """
        self._attention = True
        with self._changed:
            if restarts and self._halted:
                self._halted = None
                self._begin_anew = True
            if (self._paused or self._halted) and kind is not None:
                self._inbox = [item for item in self._inbox if item[0] != kind]
            self._inbox.append((kind, event_at))
            self._alert()

    def pause(self) -> None:
        """Let no tick pass from now on; a step ends."""
        self._attention = True
        with self._changed:
            self._paused = True
            self._end_step()
            self._alert()

    def resume(self) -> None:
        """Let ticks pass again; a step ends."""
        self._attention = True
        with self._changed:
            self._end_step()
            self._begin_anew = self._begin_anew or self._paused
            self._paused = False
            self._alert()

    def step(
        self,
        count: int,
        ended: Callable[[int], None],
        passed: Callable[[int], None] | None = None,
    ) -> bool:
        """
        Let ticks pass while paused; False: not paused, halted, or a step is in progress.

        Parameters
        ----------
        count : int
            how many ticks
        ended : function of int
            called once, by any thread and while no tick passes, when that many of the ticks have
            passed and no more will
        passed : function of int, or None
            called after each, before the next
        """
        with self._changed:
            if not self._paused or self._steps or self._halted or self._stopping:
                return False
            self._steps, self._step_begin = count, self._tick
            self._step_ended, self._step_passed = ended, passed
            self._changed.notify_all()
            return True

    def _end_step(self):
        """Let no more ticks of a step pass; the lock is held."""
        ended, self._step_ended, self._steps = self._step_ended, None, 0
        if ended is not None:
            ended(self._tick - self._step_begin)

    def set_factor(self, factor: float) -> None:
        """Change the simulated seconds per wall second."""
        self._attention = True
        with self._changed:
            self._factor = factor
            self._begin_anew = True
            self._set_period()
            self._alert()

    def take_punctuality(self) -> Punctuality:
        """Return what was counted since the last call."""
        with self._changed:
            taken, self._punctuality = self._punctuality, Punctuality()
            return replace(taken)

    def _alert(self):
        self._attention = True
        self._changed.notify_all()

    def _set_period(self):
        ticks_per_s = float(self._simulation.ticks.rate) * self._factor
        self._period_ns = SECOND_NS / ticks_per_s if self._factor else 0.0
        ahead = _AHEAD_S * ticks_per_s if self._factor else _LARGEST_BLOCK
        self._largest_block = max(1, min(_LARGEST_BLOCK, int(ahead)))

    # -- the thread ------------------------------------------------------------------------------

    def _run(self):
        try:
            self._begin()
            while (count := self._next_count()) > 0:
                self._play(count)
        except Exception as error:
            self._failed(error)
        finally:
            with self._changed:
                self._stopping = True
                self._end_step()
                self._changed.notify_all()

    def _next_count(self):
        """Return how many ticks to compute next, with what came scheduled; 0: stop."""
        with self._changed:
            while (self._halted or (self._paused and not self._steps)) and not self._stopping:
                self._attention = False
                self._changed.wait()
            if self._stopping:
                return 0
            self._attention = False
            for _, event_at in self._inbox:
                self._simulation.schedule(event_at(self._simulation.next_tick))
            self._inbox.clear()
            count = min(self._block_length, self._largest_block)
            return min(count, self._steps) if self._paused else count

    def _play(self, count):
        simulation = self._simulation
        GARBAGE.collect_at_last(has_deadlines=bool(self._period_ns))
        begin_s, self._computing = time.monotonic(), True
        happened, samples = simulation.advance(count)
        took_s, self._computing = time.monotonic() - begin_s, False
        messages = self._listener.prepare(samples)
        try:
            self._publish(samples, messages)
        finally:
            done = self._tick + 1 - samples.first_tick
            self.lateness.add(self._lags_ns)
            self._lags_ns.clear()
            # Of a tick that was not published nothing has happened, except that a run halts there.
            if done or simulation.halted:
                self._listener.published(happened, samples, messages, done)
        if simulation.halted:
            return self._halt(simulation.halted)
        if done < len(samples):
            simulation.rewind(samples.first_tick + done)
        if happened or done < len(samples):
            self._block_length = 1
        elif took_s < _AHEAD_S / 4:
            self._block_length = 2 * count
        else:
            self._block_length = max(1, int(count * _AHEAD_S / 2 / took_s))

    def _halt(self, sentence):
        with self._changed:
            # What came meanwhile may begin a new motion.
            if not self._inbox:
                self._halted = sentence
                self._end_step()

    def _publish(self, samples, messages):
        """Publish tick by tick until something comes up."""
        # Few steps of Python per tick: after a sleep the processor's caches are cold.
        publish, lock, stepping = messages.publish, self._lock, self._paused
        deadlines_ns = None if stepping or not self._period_ns else self._deadlines_ns(samples)
        for row in range(len(samples)):
            if deadlines_ns:
                lag_ns = self._sleep_to(deadlines_ns[row])
            with lock:
                if self._attention:
                    return
                publish(row)
                self._tick += 1
                if deadlines_ns:
                    self._count(lag_ns)
                if stepping:
                    self._steps -= 1
                    if self._step_passed is not None:
                        self._step_passed(self._tick - self._step_begin)
                    if self._steps == 0:
                        self._end_step()
            if self._begin_anew:
                return

    def _deadlines_ns(self, samples):
        if self._begin_anew:
            self._begin_anew = False
            self._begin_tick, self._begin_ns = samples.first_tick, time.monotonic_ns()
        first, period_ns = samples.first_tick - self._begin_tick, self._period_ns
        return [self._begin_ns + i * period_ns for i in range(first, first + len(samples))]

    def _sleep_to(self, deadline_ns):
        """Sleep, unless something comes up; return how long after the deadline it is then."""
        left_ns = deadline_ns - time.monotonic_ns()
        if GARBAGE.collect_within(left_ns):
            left_ns = deadline_ns - time.monotonic_ns()
        while left_ns > _SHORT_NS:
            with self._changed:
                if self._attention:
                    break
                self._changed.wait((left_ns - _SHORT_NS / 2) / SECOND_NS)
            left_ns = deadline_ns - time.monotonic_ns()
        if 0 < left_ns <= _SHORT_NS:
            time.sleep(left_ns / SECOND_NS)
        return time.monotonic_ns() - deadline_ns

    def _count(self, lag_ns):
        punctuality = self._punctuality
        self._lags_ns.append(lag_ns)
        if lag_ns > punctuality.largest_lag_ns:
            punctuality.largest_lag_ns = lag_ns
        if lag_ns > self._period_ns:
            punctuality.late_ticks += 1
            if lag_ns > _LARGEST_LAG_NS:
                punctuality.restarts += 1
                self._begin_anew = True

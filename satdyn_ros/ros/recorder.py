"""The thread that records a bag: it compresses, writes and flushes while the ticks continue."""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from pathlib import Path
from queue import Empty, Queue
from threading import Lock, Thread
from typing import Any

from ..actuators import Command
from ..bag.write_run import Recording
from ..base.sparse import Rows, SparseMessages
from ..messages.qos import Qos
from ..run.events import Event
from ..run.samples import Samples
from ..run.scenario import Scenario
from ..run.simulation import Simulation

# So many blocks of ticks may wait to be written; when more come, the ticks wait.
_WAITING = 64
# With the quarter of a second that a block of ticks may take, no message waits for a second.
_FLUSH_S = 0.7


@dataclass(frozen=True)
class _Block:
    """What happened at a tick, and the messages of the ticks from it on."""

    happened: list[Event]
    stamp_ns: int
    samples: Samples
    count: int
    rows: Mapping[str, Rows]
    simulation: Simulation

    @property
    def stamps_ns(self):
        return self.samples.stamps_ns[: self.count]

    @cached_property
    def message_counts(self) -> Counter[str]:
        counts = Counter(e.topic for e in self.happened if isinstance(e, Command))
        for name, table in self.rows.items():
            counts[name] += len(table.rows) if isinstance(table, SparseMessages) else self.count
        return counts

    def snapshot(self, row: int) -> dict[str, Any]:
        return self.simulation.snapshot(self.samples.first_tick + row)


class Recorder:
    """
    One bag in record.directory, named by the wall clock, open from its making to close().

    Parameters
    ----------
    scenario : Scenario
        of the node
    topics : tuple of str
        those recorded from the start
    resolve : function of str
        returns a topic's full name in the node's namespace
    report : function of str
        called once, by any thread, with a sentence if the bag does not hold all that it was given
    offered : dict or None
        as of Recording
    folder : str
        where in record.directory
    control : dict or None
        as of Recording

    Attributes
    ----------
    failure : str or None
        that sentence, None: it holds all

    Raises
    ------
    OSError
        it cannot be created
    """

    def __init__(
        self,
        scenario: Scenario,
        topics: tuple[str, ...],
        resolve: Callable[[str], str],
        report: Callable[[str], object],
        offered: Mapping[str, Qos] | None = None,
        folder: str = '',
        control: Mapping[str, Any] | None = None,
    ):
        self.failure: str | None = None
        self.message_count = 0
        self._report = report
        self._given: Counter[str] = Counter()
        self._recording = _open(folder, scenario, topics, resolve, offered, control)
        self._queue: Queue[_Block | None] = Queue(_WAITING)
        self._closing = Lock()
        self._is_closed = False
        self._thread = Thread(target=self._run, name='recorder', daemon=True)
        self._thread.start()

    @property
    def directory(self) -> Path:
        """Where the bag is."""
        return self._recording.directory

    @property
    def size_bytes(self) -> int:
        """The size of the bag's files, as far as they are written."""
        return self._recording.size_bytes

    @property
    def load(self) -> float:
        """How full the queue is, 0 to 1."""
        return self._queue.qsize() / _WAITING

    def put(
        self,
        happened: list[Event],
        samples: Samples,
        rows: Mapping[str, Rows],
        count: int,
        simulation: Simulation,
    ) -> None:
        """
        Record what happened at the first tick of samples, and the first of them.

        It waits while the queue is full; after close() nothing is recorded.

        Parameters
        ----------
        happened : list of Event
            at the first tick
        samples : Samples
            of consecutive ticks
        rows : dict
            the messages by topic
        count : int
            how many of the samples
        simulation : Simulation
            as it is at these samples; asked for a snapshot where a file begins
        """
        stamp_ns = simulation.ticks.stamp_ns(samples.first_tick)
        published = {name: table[:count] for name, table in rows.items()}
        block = _Block(happened, stamp_ns, samples, count, published, simulation)
        with self._closing:
            if not self._is_closed:
                self._given.update(block.message_counts)
                self._queue.put(block)

    def close(self) -> None:
        """Write what waits, complete the bag, and compare what it holds with what was given."""
        with self._closing:
            if self._is_closed:
                return
            self._is_closed = True
        self._queue.put(None)
        self._thread.join()
        if self.failure is None:
            self._attempt(self._compare)

    def _run(self):
        flush_s = time.monotonic() + _FLUSH_S
        while True:
            try:
                block = self._queue.get(timeout=max(0.0, flush_s - time.monotonic()))
                if block is None:
                    break
                # After a failure the queue is emptied all the same: the ticks must not wait.
                if self.failure is None:
                    self._attempt(self._write, block)
            except Empty:
                pass
            if time.monotonic() >= flush_s:
                if self.failure is None:
                    self._attempt(self._recording.flush)
                flush_s = time.monotonic() + _FLUSH_S
        self._attempt(self._recording.close)

    def _attempt(self, act, *arguments):
        """Act; the first error is reported, and only the end of the bag is written after it."""
        try:
            act(*arguments)
        except Exception as error:
            if self.failure is None:
                self.failure = (
                    str(error)
                    if isinstance(error, OSError)
                    else f'the recording of {self.directory} has ended: {error!r}'
                )
                self._report(self.failure)

    def _write(self, block):
        for event in block.happened:
            self._recording.event(event, block.stamp_ns)
        self._recording.samples(block.stamps_ns, block.rows, block.snapshot)
        self.message_count += sum(block.message_counts.values())

    def _compare(self):
        held = self._recording.message_counts()
        for name in held | self._given:
            if held[name] != self._given[name]:
                raise OSError(
                    f'{self.directory} holds {held[name]} messages of {name}; '
                    f'{self._given[name]} were to be recorded'
                )


def _open(folder, scenario, *others):
    """Return a new bag, its name numbered where another node has taken it."""
    stem = datetime.now().strftime('satdyn_%Y_%m_%d-%H_%M_%S')
    number = 1
    while True:
        name = stem if number == 1 else f'{stem}_{number}'
        try:
            directory = Path(scenario['record.directory'], folder, name)
            return Recording(directory, scenario, *others)
        except FileExistsError:
            number += 1

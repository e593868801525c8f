"""The thread that records a bag: it compresses, writes and flushes while the ticks go on."""

import time
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from queue import Empty, Full, Queue
from threading import Thread

from ..bag.recording import Recording
from ..messages.rows import Rows, SomeRows
from ..run.events import Event
from ..run.samples import Samples
from ..run.scenario import Scenario
from ..run.simulation import Simulation

# So many blocks of ticks may wait to be written; when more come, the ticks wait.
_WAITING = 64
# With the quarter of a second that a block of ticks may take, no message waits for a second.
_FLUSH_S = 0.7


class Recorder:
    """
    One bag in record.directory, named by the wall clock, open from its making to close().

    topics: those recorded from the start.  resolve: a topic's full name in the node's namespace.
    tell(sentence): called once if the bag can no longer be written.  OSError: it cannot be
    created.
    """

    def __init__(
        self,
        scenario: Scenario,
        topics: tuple[str, ...],
        resolve: Callable[[str], str],
        tell: Callable[[str], object],
    ):
        self.failure: str | None = None
        self.message_count = 0
        self._tell = tell
        self._recording = _open(scenario, topics, resolve)
        self._queue: Queue[tuple | None] = Queue(_WAITING)
        self._thread = Thread(target=self._run, name='recorder', daemon=True)
        self._thread.start()

    @property
    def directory(self) -> Path:
        """Where the bag is."""
        return self._recording.directory

    @property
    def size_bytes(self) -> int:
        """The size of the bag's files, as far as they are written."""
        return sum(path.stat().st_size for path in self.directory.glob('*.mcap'))

    @property
    def load(self) -> float:
        """How full the queue is, 0 to 1."""
        return self._queue.qsize() / _WAITING

    def put_event(self, event: Event, stamp_ns: int) -> None:
        """Record what acts at the tick of a stamp, ahead of the tick's samples."""
        self._put((0, self._recording.event, event, stamp_ns))

    def put_samples(
        self,
        samples: Samples,
        rows: Mapping[str, Rows],
        count: int,
        simulation: Simulation,
    ) -> None:
        """
        Record the first `count` ticks of samples, rows by topic; waits while the queue is full.

        simulation: as it is at these samples; asked for a snapshot where a file begins.
        """
        published = {name: table[:count] for name, table in rows.items()}

        def snapshot(row):
            return simulation.snapshot(samples.first_tick + row)

        message_count = sum(
            len(table.rows) if isinstance(table, SomeRows) else count
            for table in published.values()
        )
        write = self._recording.samples
        self._put((message_count, write, samples.stamps_ns[:count], published, snapshot))

    def close(self) -> None:
        """Write what waits and complete the bag."""
        self._put(None)
        self._thread.join()

    def _put(self, item):
        while self._thread.is_alive():
            try:
                return self._queue.put(item, timeout=0.1)
            except Full:
                continue

    def _run(self):
        flush_s = time.monotonic() + _FLUSH_S
        while True:
            try:
                item = self._queue.get(timeout=max(0.0, flush_s - time.monotonic()))
                if item is None:
                    break
                self._attempt(*item)
            except Empty:
                pass
            if time.monotonic() >= flush_s:
                self._attempt(0, self._recording.flush)
                flush_s = time.monotonic() + _FLUSH_S
        self._attempt(0, self._recording.close)

    def _attempt(self, message_count, write, *arguments):
        """Write unless an earlier write failed; an error is reported once, the rest is dropped."""
        if self.failure is not None:
            return
        try:
            write(*arguments)
        except OSError as error:
            self.failure = str(error)
            self._tell(self.failure)
        else:
            self.message_count += message_count


def _open(scenario, topics, resolve):
    """Return a new bag, its name numbered where another node has taken it."""
    stem = datetime.now().strftime('satdyn_%Y_%m_%d-%H_%M_%S')
    number = 1
    while True:
        name = stem if number == 1 else f'{stem}_{number}'
        try:
            return Recording(Path(scenario['record.directory'], name), scenario, topics, resolve)
        except FileExistsError:
            number += 1

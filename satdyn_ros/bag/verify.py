"""Whether a bag holds what its scenario and its events give: the run is repeated and compared."""

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path

import numpy as np
from mcap.records import Header, Metadata

from ..rosbag2.errors import BagError, Damaged, Incomplete
from ..rosbag2.integrity import check
from ..rosbag2.reader import Bag, TopicBlock
from ..rosbag2.scan import scan
from ..run.events import Derived, Event, Halt, RotorLimited, TorquesDropped
from ..run.rules import EVENTS_FOLLOW, RULES, SOURCE_DEFINES_THE_BITS
from ..run.samples import Samples
from ..run.simulation import Simulation
from . import run_metadata
from .comparison import PERTURBATION_RAD, Comparison, Difference
from .conservation import Conservation
from .declared import check_declarations
from .read_run import Happened, RecordedRun
from .rerun import Records, rerun


@dataclass(frozen=True)
class Verification:
    """
    What verify found.

    Attributes
    ----------
    message_count : int
        messages compared
    same_bytes : bool
        whether all are the same, byte for byte
    difference : Difference or None
        the first that rounding does not explain
    of_allowed : float
        the largest distance, as a fraction of what rounding may grow to on another machine
    other_machine : dict
        what was different when the bag was made, by name: then, now
    drift : dict
        the largest relative change of each first integral between events
    allowed_drift : float
        what the tolerance allows
    problem : str or None
        what cuts the bag short
    notes : tuple of str
        what could not be checked
    """

    message_count: int
    same_bytes: bool
    difference: Difference | None
    of_allowed: float
    other_machine: dict[str, tuple[str, str]]
    drift: dict[str, float]
    allowed_drift: float
    problem: str | None
    notes: tuple[str, ...] = ()

    @property
    def is_true(self) -> bool:
        """Whether the bag is complete and holds what its scenario and its events give."""
        drifts = any(drift > self.allowed_drift for drift in self.drift.values())
        return self.difference is None and self.problem is None and not drifts

    def __str__(self) -> str:
        if self.difference:
            said = f'the first difference is in {self.difference}'
        elif self.same_bytes:
            said = f'{self.message_count} messages, the same byte for byte'
        else:
            said = (
                f'{self.message_count} messages, differing by at most {self.of_allowed:.2g} of '
                'what rounding can grow to'
            )
        if self.other_machine:
            changes = ', '.join(
                f'{k} {a} then, {b} now' for k, (a, b) in self.other_machine.items()
            )
            said += f'; made on another machine or version ({changes})'
        drifts = ', '.join(f'{name} {drift:.1e}' for name, drift in self.drift.items())
        if drifts:
            said += f'; drift of {drifts} (allowed {self.allowed_drift:.1e})'
        return '; '.join([said, *self.notes, *([self.problem] if self.problem else [])])


def verify(
    path: str | Path, show: Callable[[int, int | None], None] = lambda done, total: None
) -> Verification:
    """
    Run a bag's own scenario and events again and compare every message, byte for byte.

    It takes as long as the run took to simulate.  A bag made on another machine or with other
    versions may differ by what rounding grows to.

    Parameters
    ----------
    path : str or Path
        the bag
    show : function of done and total
        called with numbers of ticks

    Raises
    ------
    Damaged
        a bag of satdyn_ros that is not as it was written
    BagError
        not a bag of satdyn_ros
    """
    recorded, notes = _recorded(path)
    other_machine = _other_machine(recorded)
    conservation = Conservation(recorded.scenario['motion.tolerance'])
    derived, snapshots = _Derived(recorded), _Snapshots(recorded, other_machine)

    def observe(simulation: Simulation, applied: list[Event], samples: Samples) -> None:
        conservation.observe(simulation, samples)
        derived.observe(applied, samples)
        snapshots.observe(simulation, samples)
        first = recorded.first_tick
        show(simulation.next_tick - first, recorded.end_tick - first)

    # A bag closed before its first sample may hold inputs and nothing that follows from them.
    has_samples = recorded.snapshot is not None
    runs = _runs(recorded, observe, other_machine) if has_samples else iter(())
    messages = _MessageStream(recorded.bag)
    comparison = Comparison(recorded)
    try:
        difference = _compared(comparison, messages, runs, () if has_samples else recorded.inputs)
        if has_samples:
            difference = difference or derived.difference(messages.last_ns) or snapshots.difference
    except BagError:
        raise
    except ValueError as error:
        raise Damaged(f'{path} cannot be run again: {error}') from error
    conservation.close()
    return Verification(
        message_count=messages.count,
        same_bytes=comparison.same_bytes,
        difference=difference,
        of_allowed=comparison.of_allowed,
        other_machine=other_machine,
        drift=conservation.drift,
        allowed_drift=conservation.allowed,
        problem=recorded.bag.problem,
        notes=notes,
    )


def _recorded(path):
    """Return the run in a bag and what could not be checked; a refusal says whose bag it is."""
    try:
        recorded, notes = _checked(path)
        check_declarations(recorded)
    except BagError as error:
        if isinstance(error, Damaged) == _is_ours(Path(path)):
            raise
        raise (BagError if isinstance(error, Damaged) else Damaged)(str(error)) from error
    return recorded, notes


def _runs(recorded, observe, other_machine):
    """Return what the bag should hold, part by part, and that of a perturbed run or None."""
    perturbed: Iterator[Records | None] = (
        rerun(recorded, PERTURBATION_RAD) if other_machine else repeat(None)
    )
    return zip(rerun(recorded, observe=observe), perturbed, strict=False)


def _other_machine(recorded: RecordedRun) -> dict[str, tuple[str, str]]:
    """Return by name what of the machine and the rules of a run differs: then, and here."""
    here = run_metadata.machine(recorded.scenario.torques)
    found = {
        name: (then, here.get(name, ''))
        for name, then in recorded.machine.items()
        if then != here.get(name)
    }
    if recorded.rules < SOURCE_DEFINES_THE_BITS:
        found['rules'] = str(recorded.rules), str(RULES)
    return found


def _compared(comparison, messages, runs, may_remain):
    """Return the first difference of messages from the records of runs, None: there is none."""
    difference = None
    for records, perturbed in runs:
        if messages.has_ended():
            # What happened after the last message is compared as well.
            continue
        found = messages.take(len(records.data))
        difference = comparison.difference(found, records, perturbed)
        if difference:
            return difference
    for rest in messages.rest():
        difference = difference or comparison.extra(rest, may_remain)
    return difference


def _checked(path: str | Path) -> tuple[RecordedRun, tuple[str, ...]]:
    """Return the run in a bag that is sound, as far as it can be checked, and what cannot be."""
    try:
        recorded = RecordedRun(path)
    except BagError:
        # What is damaged explains best why there is no run.
        with suppress(Incomplete):
            check(Bag(path))
        raise
    happened = Happened(recorded)
    try:
        notes = check(recorded.bag, happened.take)
    except Incomplete:
        return recorded, ()
    recorded.happened = happened
    return recorded, tuple(notes)


def _is_ours(path: Path) -> bool:
    """Whether any file, whatever its state, says that satdyn_ros wrote it."""
    for file in sorted(path.glob('*.mcap')) if path.is_dir() else [path]:
        try:
            for found in scan(file):
                match found.item:
                    case Header(library=name) | Metadata(name=name):
                        if name.startswith('satdyn_ros'):
                            return True
        except (BagError, OSError):
            continue
    return False


class _MessageStream:
    """The records of a bag's messages one after the other; count: how many were read."""

    def __init__(self, bag: Bag):
        self.count = 0
        self.last_ns = -1
        self._blocks = (item for item in bag.items() if isinstance(item, TopicBlock))
        self._waiting = np.empty(0, np.uint8)

    def take(self, size: int) -> np.ndarray:
        """Return the next bytes, fewer where the bag ends."""
        self._fill(size)
        taken, self._waiting = self._waiting[:size], self._waiting[size:]
        return taken

    def has_ended(self) -> bool:
        """Whether there are no more."""
        self._fill(1)
        return len(self._waiting) == 0

    def rest(self) -> Iterator[np.ndarray]:
        """Yield the bytes that are left, in whole records."""
        while not self.has_ended():
            yield self.take(len(self._waiting))

    def _fill(self, size):
        parts = [self._waiting]
        missing = size - len(self._waiting)
        while missing > 0 and (block := next(self._blocks, None)) is not None:
            self.count += len(block.contents)
            self.last_ns = max(self.last_ns, block.contents.span_ns[1])
            parts.append(block.contents.message_records())
            missing -= len(parts[-1])
        if len(parts) > 1:
            self._waiting = np.concatenate(parts)


class _Derived:
    """The events that a run causes itself, compared with those recorded in its bag."""

    def __init__(self, recorded: RecordedRun):
        self._ticks = recorded.ticks
        # By rules 0 the bag's timeouts are what acts.
        follow = recorded.rules >= EVENTS_FOLLOW
        self._kinds = Derived if follow else RotorLimited | TorquesDropped | Halt
        self._recorded = self._derived(recorded.events)
        self._found = self._derived(recorded.events_at_begin)
        self._end_tick = 0

    def observe(self, applied: list[Event], samples: Samples) -> None:
        """Process events and samples of a run."""
        self._found += self._derived(applied)
        self._end_tick = samples.first_tick + len(samples)

    def difference(self, last_ns: int) -> Difference | None:
        """
        Return the first event that is recorded and did not happen, or the reverse.

        last_ns: the log time of the last message; how the bag ends after it is open.
        """
        last_tick = self._ticks.tick_of(last_ns)
        recorded, found = set(self._recorded), set(self._found)
        wrong = [e for e in self._recorded if e not in found and e.tick <= self._end_tick]
        # A limit is ahead of the command that meets it, which a killed writer did not write.
        wrong = [e for e in wrong if e.tick <= last_tick or not isinstance(e, RotorLimited)]
        wrong += [e for e in self._found if e not in recorded and e.tick <= last_tick]
        for event in sorted(wrong, key=lambda event: event.tick)[:1]:
            t_s = self._ticks.seconds(event.tick)
            return Difference('the events', event.tick, t_s, type(event).__name__)
        return None

    def _derived(self, events: list[Event]) -> list[Event]:
        return [event for event in events if isinstance(event, self._kinds)]


class _Snapshots:
    """
    The snapshots with which files begin, by their ticks, compared with those of a run.

    difference: the first one.  A file that is read alone continues from its own.  Those of another
    machine differ by rounding, and those of other rules in what they hold: they are not compared.
    """

    def __init__(self, recorded: RecordedRun, other_machine: Mapping[str, tuple[str, str]]):
        self.difference: Difference | None = None
        self._ticks = recorded.ticks
        is_alike = not other_machine and recorded.rules == RULES
        self._begins = recorded.happened.begins if is_alike else {}
        self._waiting = deque(sorted(self._begins))

    def observe(self, simulation: Simulation, samples: Samples) -> None:
        """Take samples of a run."""
        while self._waiting and self._waiting[0] < samples.first_tick + len(samples):
            tick = self._waiting.popleft()
            if self.difference is None and tick >= samples.first_tick:
                self.difference = self._found(tick, simulation.snapshot(tick))

    def _found(self, tick, snapshot):
        said = run_metadata.to_record(self._begins[tick])
        # Only the first file of a run is its start.
        held = run_metadata.to_record({**snapshot, 'is_start': self._begins[tick].get('is_start')})
        for name in sorted(said.keys() | held.keys()):
            if said.get(name) != held.get(name):
                return Difference('the snapshot', tick, self._ticks.seconds(tick), name)
        return None

"""Records a run into a bag, for the node and for runs without ROS."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..actuators import Command, kind_of
from ..base.sparse import Rows, SparseMessages
from ..messages import qos, schemas
from ..messages.incoming import pack_command
from ..messages.packers import pack_tf_static
from ..rosbag2.chunk import Contents
from ..rosbag2.metadata import TopicMetadata
from ..rosbag2.reader import Bag
from ..rosbag2.tick_table import TickTable
from ..rosbag2.writer import BagWriter
from ..run.events import Event, RotorLimited, Topics
from ..run.scenario import Scenario
from ..run.ticks import Ticks
from . import run_metadata


def load_code() -> None:
    """Load the code that a recording needs, which the first time is made."""
    Contents(np.empty(0, np.uint8))


class Recording:
    """
    Write a run to a new bag directory, as record.* of its scenario says.

    Parameters
    ----------
    directory : str or Path
        the bag
    scenario : Scenario
        with the epoch resolved
    topics : tuple of str
        those recorded from the start, by their names in the scenario
    resolve : function of str
        from a name in the scenario to that of the topic
    offered : dict or None
        the quality of service of topics, by their names in the scenario, where it is not the usual
    control : dict or None
        as of provenance

    Raises
    ------
    ValueError
        as of provenance
    OSError
        as BagWriter
    """

    def __init__(
        self,
        directory: str | Path,
        scenario: Scenario,
        topics: tuple[str, ...],
        resolve: Callable[[str], str] = lambda name: f'/{name}',
        offered: Mapping[str, qos.Qos] | None = None,
        control: Mapping[str, Any] | None = None,
    ):
        self._scenario = scenario
        self._offered = offered or {}
        sensors = tuple(scenario.sensors)
        self._latched = {'tf_static': pack_tf_static(scenario)} if sensors else {}
        table = scenario.topic_table
        inputs = scenario.inputs
        recorded = (name for name in table if table[name].role == 'state' or name in inputs)
        self._names = {name: resolve(name) for name in (*recorded, *sensors, *self._latched)}
        ticks = Ticks(scenario.rate, scenario.epoch_ns)
        self._timeout = self._held = ticks.timeout(0, scenario['torque.timeout'])
        added = *topics, *sensors, *self._latched, *inputs
        self._added = set(added)
        self._writer = BagWriter(
            directory,
            [self._metadata(name) for name in added],
            compression=scenario['record.compression'],
            max_size_bytes=scenario['record.max_size_bytes'],
            max_duration_s=scenario['record.max_duration_s'],
            preamble={
                run_metadata.SCENARIO: run_metadata.provenance(scenario, self._names, control)
            },
            latched={self._names[name]: data for name, data in self._latched.items()},
        )

    @property
    def directory(self) -> Path:
        """The bag's directory."""
        return self._writer.directory

    @property
    def size_bytes(self) -> int:
        """The size of the bag's files, as far as they are written."""
        return self._writer.size_bytes

    def event(self, event: Event, stamp_ns: int) -> None:
        """Write what happened at the tick of a stamp, before the tick's samples."""
        match event:
            case Command():
                self._write_held(event)
                data = pack_command(stamp_ns, event, self._scenario.frames)
                self._writer.write_message(self._names[event.topic], stamp_ns, data)
            case _:
                # A controller may meet a limit at every tick, and nothing depends on its position.
                self._writer.write_metadata(
                    run_metadata.EVENT,
                    run_metadata.event_record(event),
                    ends_chunk=not isinstance(event, RotorLimited),
                )
        if isinstance(event, Topics):
            self._add(event.names)

    def _write_held(self, event: Command) -> None:
        """Write how long a torque is held, where that is not as written before."""
        if not kind_of(event.topic).is_held:
            return
        held = None if event.until_tick is None else event.until_tick - event.tick
        if held != self._held:
            self._held = held
            self._writer.write_metadata(run_metadata.HELD, run_metadata.held_record(held))

    def _add(self, names: Iterable[str]) -> None:
        """Add topics of which the bag did not know."""
        for name in names:
            if name not in self._added:
                self._added.add(name)
                self._writer.add_topic(self._metadata(name))

    def samples(
        self,
        stamps_ns: np.ndarray,
        rows: Mapping[str, Rows],
        snapshot: Callable[[int], Mapping[str, Any]],
    ) -> None:
        """
        Write the messages of ticks.

        Parameters
        ----------
        stamps_ns : (N,), ns
            of the ticks
        rows : dict
            by name in the scenario N rows each, or SparseMessages of a sensor
        snapshot : function of int
            of i: Simulation.snapshot of tick i of these; it is called where a file begins
        """
        self._writer.write(stamps_ns, self._by_topic(rows), self._record_of(snapshot))

    def table(self, count: int, rows: Mapping[str, np.ndarray]) -> TickTable:
        """
        Return a table of ticks, to be packed into again and again, for ticks().

        Parameters
        ----------
        count : int
            how many ticks
        rows : dict
            by name in the scenario one message, with what is the same in all
        """
        return self._writer.table(count, self._by_topic(rows))

    def ticks(
        self,
        stamps_ns: np.ndarray,
        table: TickTable,
        measured: Mapping[str, SparseMessages],
        snapshot: Callable[[int], Mapping[str, Any]],
    ) -> int:
        """
        Write ticks as samples() does, and return how many of the table are best written next.

        Parameters
        ----------
        stamps_ns : (N,), ns
            of the ticks
        table : TickTable
            the topics of every tick
        measured : dict
            the sensors' SparseMessages
        snapshot : function of int
            as of samples()
        """
        return self._writer.write_ticks(
            stamps_ns, table, self._by_topic(measured), self._record_of(snapshot)
        )

    def flush(self) -> None:
        """Hand everything written to the system, so that it survives the process."""
        self._writer.flush()

    def close(self) -> None:
        """Complete the bag."""
        self._writer.close()

    def message_counts(self) -> Counter[str]:
        """Return how many messages written here the closed bag holds, by names in the scenario."""
        counts = Bag(self.directory).message_counts
        names = self._names.keys() - self._latched.keys()
        return Counter({name: counts[self._names[name]] for name in names})

    def _record_of(self, snapshot):
        """Return the function that makes the metadata record of the snapshot of a tick."""

        def record(i):
            # A file begins, and says everything anew: what happened is in the one before.
            self._held, begun = self._timeout, snapshot(i)
            is_start = begun['is_start'] and self._writer.file_count == 1
            return run_metadata.SNAPSHOT, run_metadata.to_record({**begun, 'is_start': is_start})

        return record

    def _by_topic(self, by_name):
        self._add(by_name)
        return {self._names[name]: value for name, value in by_name.items()}

    def _metadata(self, name):
        topic = self._scenario.topic_table[name]
        match topic.role:
            case 'input':
                usual = qos.INPUTS
            case 'latched':
                usual = qos.LATCHED
            case _:
                usual = qos.state_topics(self._scenario.ticks_per_wall_s)
        quality = self._offered.get(name, usual)
        return TopicMetadata(
            self._names[name],
            topic.type,
            schemas.schema_text(topic.type),
            schemas.type_hash(topic.type),
            quality.to_yaml(),
        )

"""The run in a bag: its scenario, where it begins, and what happened in it."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Metadata

from ..actuators import Command, is_commanding, kind_of
from ..messages import cdr
from ..messages.packers import (
    Packer,
    geodetic_without_status,
    pack_tf_static,
    packer,
    tf_with_sensors,
)
from ..rosbag2.errors import BagError, Damaged
from ..rosbag2.reader import Bag, Messages, TopicBlock
from ..run.events import Event, Halt, Request, Reset
from ..run.parameter_file import parameters_of_record
from ..run.rules import EVENTS_FOLLOW, GEODETIC_HAS_A_FIX, MOUNTINGS_ARE_LATCHED
from ..run.scenario import Scenario
from ..run.simulation import Simulation
from ..run.ticks import Ticks
from . import run_metadata

# A tick with a message takes two bytes at least; topics may be switched off for so many ticks.
_TICKS_WITHOUT_MESSAGES = 5_000_000
# The numbers that a channel may have.
_CHANNELS = 2**16
# Where the last of these at a tick is a halt, the run does not reach it.
_ENDS = Halt | Request | Reset


class RecordedRun:
    """
    The run in a bag written by satdyn_ros.

    Parameters
    ----------
    path : str or Path
        the bag

    Attributes
    ----------
    provenance : dict
        what each file says of the run, as run_metadata.provenance
    scenario : Scenario
        with the epoch resolved
    names : dict
        the topics' names in the bag by those in the scenario
    machine : dict
        what the bits depend on besides the scenario
    rules : int
        by which it ran
    snapshot : dict or None
        the start of the bag, as Simulation.snapshot; None if it has no samples

    Raises
    ------
    ValueError
        path is not such a bag
    """

    def __init__(self, path: str | Path):
        self.bag = Bag(path)
        self.names: dict[str, str] = {}
        self.machine: dict[str, str] = {}
        self.rules = 0
        self._inputs_by_topic: dict[str, str] = {}
        begin = self._begin()
        if run_metadata.SCENARIO not in begin:
            raise BagError(
                f'{path} holds no scenario: satdyn_ros did not write it, or another program, '
                'such as ros2 bag convert, rewrote it without one'
            )
        self.provenance = begin[run_metadata.SCENARIO]
        torques = run_metadata.torques_of(self.provenance)
        with self.reading(run_metadata.SCENARIO):
            text = self.provenance['scenario']
            values = parameters_of_record(text, 'its scenario')
            self.scenario = Scenario(values, torques, rules=self.rules)
            self.scenario.typed = run_metadata.typed_of(self.provenance)
            self._check_inputs()
        self.snapshot: dict[str, Any] | None = None
        if run_metadata.SNAPSHOT in begin:
            with self.reading(run_metadata.SNAPSHOT):
                record = begin[run_metadata.SNAPSHOT]
                self.snapshot = run_metadata.snapshot_from_record(record, self.scenario)
        self.ticks = Ticks(self.scenario.rate, self.scenario.epoch_ns)
        self._layouts: dict[str, np.dtype] = {}

    @property
    def inputs(self) -> tuple[str, ...]:
        """The inputs of the run, by their names in the scenario."""
        return tuple(self._inputs_by_topic.values())

    @property
    def first_tick(self) -> int:
        """The tick where the bag begins; 0 if it has no samples."""
        return 0 if self.snapshot is None else self.snapshot['tick']

    @property
    def events(self) -> list[Event]:
        """What happened in the run, by ticks; at one tick in order."""
        return self.happened.events

    @cached_property
    def happened(self) -> 'Happened':
        """What happened in the run, from all of the bag."""
        happened = Happened(self)
        for item in self.bag.items():
            happened.take(item)
        return happened

    @property
    def end_tick(self) -> int:
        """The tick after the last one with a message or an event."""
        ticks = [event.tick for event in self.events[-1:]]
        if self.happened.last_ns is not None:
            ticks.append(self.ticks.tick_of(self.happened.last_ns))
        return max(ticks, default=self.first_tick) + 1

    def last_tick(self) -> int:
        """
        Return the last tick in the bag that the run reaches; all of the bag is read.

        BagError: the bag has no messages.  Damaged: it is too small to have so many ticks.
        """
        last_ns = self.happened.last_ns
        if last_ns is None:
            raise BagError(f'{self.bag.path} has no messages')
        last = self.ticks.tick_of(last_ns)
        at_last = [e for e in self.events if e.tick == last and isinstance(e, _ENDS)]
        if at_last and isinstance(at_last[-1], Halt):
            last -= 1
        ticks = last - self.first_tick
        most = _TICKS_WITHOUT_MESSAGES + sum(file.stat().st_size for file in self.bag.files) // 2
        if ticks > most:
            raise Damaged(
                f'{self.bag.path} has a message {ticks} ticks after its first; the limit for a '
                f'bag of its size is {most}'
            )
        return last

    @property
    def events_at_begin(self) -> list[Event]:
        """What happened before the samples with which the bag begins, if its snapshot has it."""
        if self._begins_with_the_run:
            return []
        return [event for event in self.events if event.tick <= self.first_tick]

    @property
    def _begins_with_the_run(self) -> bool:
        """Whether scenario and events say all; versions 0.1 and 0.2 show it by the tick alone."""
        return self.snapshot is None or self.snapshot.get('is_start', self.first_tick == 0)

    def simulation(self, method: str | None = None) -> Simulation:
        """
        Return the run from the start of the bag, with all that happens from there.

        method: as motion.method, in place of the scenario's.
        """
        changes = {} if method is None else {'motion.method': method}
        scenario = self.scenario.with_values(changes)
        if self.snapshot is None or self._begins_with_the_run:
            return Simulation(scenario, self.events, self.rules)
        later = self.events[len(self.events_at_begin) :]
        with self.reading(run_metadata.SNAPSHOT):
            return Simulation.from_snapshot(scenario, self.snapshot, later, self.rules)

    def channel_id(self, name: str) -> int:
        """
        Return the channel of a topic by its name in the scenario.

        A topic of which the bag has none has a number that no other topic has.
        """
        return self._channel_ids[name]

    @cached_property
    def _channel_ids(self) -> dict[str, int]:
        declared = self.bag.channel_ids
        taken = {*declared.values()}
        free = (i for i in range(1, _CHANNELS) if i not in taken)
        return {
            name: declared[topic] if topic in declared else next(free, 0)
            for name, topic in self.names.items()
        }

    def layout(self, name: str) -> np.dtype:
        """Return the layout of a topic's messages, by its name in the scenario."""
        if name not in self._layouts:
            self._layouts[name] = self.packer(name).dtype
        return self._layouts[name]

    def packer(self, name: str) -> Packer:
        """Return what packs samples for a topic, by its name in the scenario."""
        if name == 'tf' and self.rules < MOUNTINGS_ARE_LATCHED:
            return tf_with_sensors(self.scenario)
        if name == 'geodetic' and self.rules < GEODETIC_HAS_A_FIX:
            return geodetic_without_status(self.scenario)
        return packer(name, self.scenario)

    @property
    def latched(self) -> dict[str, bytes]:
        """What each file has ahead of its first tick, by names in the scenario."""
        if self.rules < MOUNTINGS_ARE_LATCHED or not self.scenario.sensors:
            return {}
        return {'tf_static': pack_tf_static(self.scenario)}

    def rows(self, name: str, messages: Messages) -> np.ndarray:
        """
        Return messages of a topic, by its name in the scenario, as rows of its layout, (N,).

        ValueError: satdyn_ros did not write them.
        """
        layout, data = self.layout(name), messages.data
        if not isinstance(data, np.ndarray) or data.shape[1] != layout.itemsize:
            raise Damaged(self._not_ours(name))
        return data.view(layout)[:, 0]

    @contextmanager
    def reading(self, name: str) -> Iterator[None]:
        """Say in one sentence that a metadata record is not what satdyn writes."""
        try:
            yield
        except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
            why = error if isinstance(error, ValueError) else 'it does not describe a run'
            raise Damaged(
                f'{self.bag.path} is damaged: the Metadata record {name}: {why}'
            ) from error

    def _begin(self) -> dict[str, dict[str, str]]:
        """
        Return the first metadata record of each name ahead of the first sample.

        That of the scenario names the inputs; messages on any other topic are samples.  After
        scenario and snapshot nothing is wanted.
        """
        records: dict[str, dict[str, str]] = {}
        for item in self.bag.items():
            if isinstance(item, TopicBlock):
                topics = {item.topics[i] for i in item.contents.counts}
                inputs = self._inputs_by_topic.keys()
                if not (inputs and topics <= inputs):
                    break
            elif item.name not in records:
                records[item.name] = item.metadata
                if item.name == run_metadata.SCENARIO:
                    self._take_provenance(item.metadata)
                if {run_metadata.SCENARIO, run_metadata.SNAPSHOT} <= records.keys():
                    break
        return records

    def _take_provenance(self, record):
        with self.reading(run_metadata.SCENARIO):
            self.rules = run_metadata.rules_of(record)
            self.names, self.machine = run_metadata.names_and_machine(record)
        self._inputs_by_topic = {
            topic: name for name, topic in self.names.items() if is_commanding(name)
        }

    def _check_inputs(self):
        """Raise Damaged where the inputs are not those of the scenario, or of version 0.1."""
        equipment = self.scenario.equipment
        wanted, found = {*equipment.topics}, {*self.inputs}
        for topic in found & equipment.of_earlier.keys():
            found = found - {topic} | {*equipment.of_earlier[topic].topics}
        if wanted - found:
            raise Damaged(f'its topics have no {min(wanted - found)}')
        if found - wanted:
            raise Damaged(
                f'its topics have {min(found - wanted)}, which its scenario does not have'
            )

    def inputs_of(self, block: TopicBlock) -> list[Command]:
        """Return the commands of a block in their recorded order, held until the next one."""
        contents = block.contents
        events: list[tuple[int, Command]] = []
        for channel_id in contents.counts:
            name = self._inputs_by_topic.get(block.topics[channel_id])
            if name is None:
                continue
            indices = contents.indices[channel_id]
            messages = block.messages(channel_id)
            rows = messages.data
            stamps_ns = contents.log_times[indices].tolist()
            for index, stamp_ns, row in zip(indices.tolist(), stamps_ns, rows, strict=True):
                events.append((index, self._input(name, self.ticks.tick_of(stamp_ns), row)))
        return [event for _, event in sorted(events, key=itemgetter(0))]

    def _input(self, name: str, tick: int, row: np.ndarray) -> Command:
        equipment = self.scenario.equipment
        actuator = equipment.of_topic.get(name) or equipment.of_earlier[name]
        topic = name if name in actuator.topics else actuator.topic
        type_name = actuator.earlier.get(name, actuator.message)
        try:
            return Command(tick, topic, actuator.read(name, cdr.read(type_name, bytes(row))))
        except ValueError:
            raise Damaged(self._not_ours(name)) from None

    def _not_ours(self, name):
        return f'{self.bag.path} has messages on {self.names[name]} that satdyn_ros did not write'


class Happened:
    """
    What happened in a run, item by item of its bag.

    Damaged is raised not by an item, but where the events or the last time are asked for: what
    else is wrong with the file comes first.
    """

    def __init__(self, run: RecordedRun):
        self._run = run
        self._events: list[Event] = []
        self._last_ns: int | None = None
        self._error: ValueError | None = None
        # By rules 0 a torque is held until the bag says that it has timed out.
        timeout = run.ticks.timeout(0, run.scenario['torque.timeout'])
        self._timeout = timeout if run.rules >= EVENTS_FOLLOW else None
        self._held = self._timeout
        # The snapshots with which files begin, by their ticks.
        self.begins: dict[int, dict[str, Any]] = {}

    def take(self, item: TopicBlock | Metadata) -> None:
        """Process the next item."""
        if self._error is not None:
            return
        try:
            if isinstance(item, TopicBlock):
                self._events += map(self._held_as_recorded, self._run.inputs_of(item))
            else:
                self._take_record(item)
        except ValueError as error:
            self._error = error
        if isinstance(item, TopicBlock) and len(item.contents):
            self._last_ns = max(self._last_ns or 0, item.contents.span_ns[1])

    def _take_record(self, record: Metadata) -> None:
        scenario = self._run.scenario
        with self._run.reading(record.name):
            match record.name:
                case run_metadata.EVENT:
                    self._events.append(
                        run_metadata.event_from_record(record.metadata, scenario.keys)
                    )
                case run_metadata.SCENARIO:
                    if record.metadata != self._run.provenance:
                        raise Damaged('it is not that of the file before')
                case run_metadata.HELD:
                    self._held = run_metadata.held_from_record(record.metadata)
                case run_metadata.SNAPSHOT:
                    self._held = self._timeout
                    snapshot = run_metadata.snapshot_from_record(record.metadata, scenario)
                    self.begins[snapshot['tick']] = snapshot

    def _held_as_recorded(self, event: Command) -> Event:
        if self._held is None or not kind_of(event.topic).is_held:
            return event
        return replace(event, until_tick=event.tick + self._held)

    @cached_property
    def events(self) -> list[Event]:
        """By ticks; at one tick in order."""
        self._check()
        return sorted(self._events, key=lambda event: event.tick)

    @property
    def last_ns(self) -> int | None:
        """The last log time of a message, or None if there are no messages."""
        self._check()
        return self._last_ns

    def _check(self) -> None:
        if self._error is not None:
            raise self._error

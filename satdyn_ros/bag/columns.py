"""The states in a bag as columns, block by block: the name of each, and its values."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property

import numpy as np
from mcap.records import Metadata

from ..base.nanoseconds import SECOND_NS
from ..dynamics import inertia
from ..kernel import rotation
from ..messages.contents import fields
from ..rosbag2.errors import Incomplete
from ..rosbag2.reader import TopicBlock
from ..rosbag2.summary import read_summary
from ..run import topics
from ..run.simulation import Simulation
from ..run.topics import Topic
from . import run_metadata
from .read_run import RecordedRun

Columns = dict[str, np.ndarray]

Q_IB, OMEGA_BI_B = topics.Q_IB.columns, topics.OMEGA_BI_B.columns
_TIMES = ('tick', 't_s', 'stamp_ns')
_LVLH_ANGLES = ('roll_rad', 'pitch_rad', 'yaw_rad', 'nadir_angle_rad')

# Enough rows that only the values of a block cost time, few enough for tens of megabytes.
_BLOCK_ROWS = 32768


def columns_of_topics(
    topics: Iterable[Topic], rotors: Iterable[str] = (), thrusters: Iterable[str] = ()
) -> dict[str, dict[str, tuple[str, ...]]]:
    """
    Return for each state topic its fields and the columns they fill, with names of joints.

    Where two topics hold the same quantity, the first one's values are used.
    """
    columns = {topic.name: fields(topic) for topic in topics if topic.role == 'state'}
    for i, rotor in enumerate(rotors):
        columns['rotor'] |= {
            f'position[{i}]': (f'{rotor}_angle_rad',),
            f'velocity[{i}]': (f'{rotor}_speed_rad_s',),
            f'effort[{i}]': (f'{rotor}_torque_n_m',),
        }
    for i, name in enumerate(thrusters):
        columns['thruster'] |= {
            f'position[{i}]': (f'{name}_propellant_used_kg',),
            f'effort[{i}]': (f'{name}_thrust_n',),
        }
    return columns


def dtype_of(column: str) -> np.dtype:
    """Return the type of a column's values: ticks, stamps and counts are integers."""
    return np.dtype(np.int64 if column in ('tick', 'stamp_ns', 'segment') else np.float64)


class StateTable:
    """
    The states in a bag, one row per tick.

    The columns tick, t_s (seconds from tick 0) and stamp_ns come first, then what the recorded
    topics hold, nan at a tick where it was not published, and the angles relative to LVLH: roll,
    pitch and yaw (3-2-1), and the angle between the axis of least inertia, whichever end is
    nearer, and nadir.  What a sensor measured stands at the tick whose stamp its message has, that
    of the exposure, nan at the others.

    Parameters
    ----------
    run : RecordedRun
        the bag
    columns : iterable of str
        those wanted, in this order; none: all but segment, which counts the restarts of the motion
        by requests and resets, and those in true_names, what sensors would have measured without
        errors, for which the run is run again
    step_s : s or None
        from row to row; None: every tick

    Attributes
    ----------
    names : list of str
        the columns
    ticks_read : int
        how many of tick_count were yielded

    Raises
    ------
    ValueError
        the bag has no such column, or step_s is not a whole number of ticks
    """

    def __init__(
        self,
        run: RecordedRun,
        columns: Iterable[str] = (),
        step_s: str | float | None = None,
    ):
        self.run = run
        self._restarts: set[int] = set()
        self.ticks_read = 0
        self._stride = 1 if step_s is None else _stride(step_s, run.scenario.rate)
        rotors = [rotor.label for rotor in run.scenario.system.rotors]
        thrusters, table = run.scenario['thruster.names'], run.scenario.topic_table.values()
        self._fields = {
            topic: {
                field: names
                for field, names in columns.items()
                if field in (run.layout(topic).names or ())
            }
            for topic, columns in columns_of_topics(table, rotors, thrusters).items()
            if topic in run.names and run.names[topic] in run.bag.topics
        }
        recorded = [name for f in self._fields.values() for names in f.values() for name in names]
        self._sensors = {
            name: sensor
            for name, sensor in run.scenario.sensors.items()
            if name in run.names and run.names[name] in run.bag.topics
        }
        self._latency = max((sensor.latency for sensor in self._sensors.values()), default=0)
        self._measured, self._true = (
            {
                name: [f'{name}_{what}_{column}' for column in sensor.columns]
                for name, sensor in self._sensors.items()
            }
            for what in ('measured', 'true')
        )
        measured = [name for names in self._measured.values() for name in names]
        self.true_names = [name for names in self._true.values() for name in names]
        self.names = [*_TIMES, *dict.fromkeys(recorded), *measured]
        if not run.scenario.is_fixed and Q_IB[0] in self.names:
            self.names += _LVLH_ANGLES
        if columns:
            self._choose(list(dict.fromkeys(columns)))

    @cached_property
    def tick_count(self) -> int | None:
        """How many ticks the bag spans; None: its last file is empty or was not completed."""
        try:
            statistics = read_summary(self.run.bag.files[-1]).statistics
        except Incomplete:
            return None
        if statistics is None or not statistics.message_count:
            return None
        return self.run.ticks.tick_of(statistics.message_end_time) + 1 - self.run.first_tick

    def blocks(self) -> Iterator[Columns]:
        """
        Yield the columns (N,) of successive rows; memory does not grow with the bag.

        ValueError: after all that could be read, the bag is damaged or was not completed.
        """
        waiting: list[Columns] = []
        rows, enough, last_ns = 0, _BLOCK_ROWS, 0
        truth = _Truth(self.run, self._true, self.names)
        for item in self.run.bag.items():
            if isinstance(item, Metadata):
                self._note_restart(item)
                continue
            waiting += (parts := [*self._recorded(item)])
            rows += max((len(part['stamp_ns']) for part in parts), default=0)
            if len(item.contents):
                last_ns = max(last_ns, int(item.contents.span_ns[1]))
            if rows < enough:
                continue
            last = self.run.ticks.tick_of(last_ns)
            merged = _merged([*waiting, *truth.until(last + 1)])
            # What comes may be of the last tick, or of one at which it was exposed, still.
            open_ns = self.run.ticks.stamp_ns(last - self._latency)
            done = int(np.searchsorted(merged['stamp_ns'], open_ns))
            if done:
                yield self._block({name: values[:done] for name, values in merged.items()})
            waiting = [{name: values[done:] for name, values in merged.items()}]
            rows = len(waiting[0]['stamp_ns'])
            enough = _BLOCK_ROWS + rows
        if rows:
            last = self.run.ticks.tick_of(last_ns)
            yield self._block(_merged([*waiting, *truth.until(last + 1)]))
        if self.run.bag.problem:
            raise ValueError(self.run.bag.problem)

    def _choose(self, chosen):
        names = [*self.names, *self.true_names]
        unknown = [name for name in chosen if name not in (*names, 'segment')]
        if unknown:
            raise ValueError(
                f'{self.run.bag.path} has no column {unknown[0]}; it has {", ".join(names)}'
            )
        self.names = chosen
        needed = {*chosen, *(Q_IB if {*_LVLH_ANGLES} & {*chosen} else ())}
        self._fields = {
            topic: {field: names for field, names in fields.items() if needed & {*names}}
            for topic, fields in self._fields.items()
        }

    def _note_restart(self, record):
        if record.name == run_metadata.EVENT and record.metadata['event'] in ('Request', 'Reset'):
            self._restarts.add(json.loads(record.metadata['tick']))

    def _recorded(self, block: TopicBlock) -> Iterator[Columns]:
        """Yield stamp_ns and columns of a block of messages: of the states, and of each sensor."""
        channels = {block.topics[i]: i for i in block.contents.indices}
        yield self._states(block)
        for name, sensor in self._sensors.items():
            if (channel_id := channels.get(self.run.names[name])) is None:
                continue
            rows = self.run.rows(name, block.messages(channel_id))
            seconds = rows['header.stamp.sec'].astype(np.int64)
            stamps_ns = seconds * SECOND_NS + rows['header.stamp.nanosec']
            values = rows[sensor.measures].reshape(len(rows), -1)
            columns = zip(self._measured[name], values.T, strict=bool(sensor.columns))
            chosen = {column: x for column, x in columns if column in self.names}
            yield {'stamp_ns': stamps_ns, **chosen}

    def _states(self, block: TopicBlock) -> Columns:
        """Return stamp_ns and the columns of the states at the ticks in a block of messages."""
        contents = block.contents
        channels = {block.topics[i]: i for i in contents.indices}
        present = {
            name: channels[self.run.names[name]]
            for name in self._fields
            if self.run.names[name] in channels
        }
        times = [contents.log_times[contents.indices[i]] for i in present.values()]
        stamps_ns = np.unique(np.concatenate([np.empty(0, np.uint64), *times]))
        columns: Columns = {'stamp_ns': stamps_ns.astype(np.int64)}
        filled: dict[tuple[str, ...], np.ndarray] = {}
        for topic, channel_id in present.items():
            missing = {
                field: names
                for field, names in self._fields[topic].items()
                if names not in filled or not np.all(filled[names])
            }
            if not missing:
                continue
            messages = block.messages(channel_id)
            rows = self.run.rows(topic, messages)
            indices = np.searchsorted(stamps_ns, messages.log_times_ns)
            for field, names in missing.items():
                values = rows[field].reshape(len(rows), -1)
                empty = ~filled.setdefault(names, np.zeros(len(stamps_ns), bool))[indices]
                for name, value in zip(names, values.T, strict=True):
                    column = columns.setdefault(name, np.full(len(stamps_ns), np.nan))
                    column[indices[empty]] = value[empty]
                filled[names][indices] = True
        return columns

    def _block(self, part: Columns) -> Columns:
        """Return the columns of rows that follow each other, the chosen ticks."""
        times = self.run.ticks
        stamps_ns = part['stamp_ns']
        ticks = times.ticks_of(stamps_ns)
        self.ticks_read = int(ticks[-1]) + 1 - self.run.first_tick
        chosen = ticks % self._stride == 0
        ticks, stamps_ns = ticks[chosen], stamps_ns[chosen]
        t_s = times.seconds_of(ticks)
        columns: Columns = {'tick': ticks, 't_s': t_s, 'stamp_ns': stamps_ns}
        needs_angles = bool({*_LVLH_ANGLES} & {*self.names})
        if 'segment' in self.names:
            columns['segment'] = np.searchsorted(sorted(self._restarts), ticks, side='right')
        missing = np.full(len(ticks), np.nan)
        for name in {*self.names, *(Q_IB if needs_angles else ())} - {*columns, *_LVLH_ANGLES}:
            columns[name] = part[name][chosen] if name in part else missing
        if needs_angles:
            q_ib = np.stack([columns[name] for name in Q_IB], axis=-1)
            columns |= zip(_LVLH_ANGLES, self._lvlh_angles(q_ib, t_s), strict=True)
        return {name: columns[name] for name in self.names}

    def _lvlh_angles(self, q_ib, t_s):
        """Return roll, pitch, yaw and the angle of the least axis to nadir, each (N,)."""
        system = self.run.scenario.system
        q_lb = rotation.multiply(rotation.conjugate(system.orbit.lvlh(t_s)), q_ib)
        moments, axes = inertia.principal_axes(system.inertia)
        least_l = rotation.rotate(q_lb, axes[:, np.argmin(moments)])
        # Nadir is z of LVLH.
        nadir_angle = np.arctan2(np.hypot(least_l[:, 0], least_l[:, 1]), np.abs(least_l[:, 2]))
        return [*rotation.roll_pitch_yaw(q_lb).T, nadir_angle]


class _Truth:
    """
    What sensors of a run would have measured without errors, as it is run again.

    columns: those of each sensor by its name.  wanted: which of them, if any.
    """

    def __init__(
        self, run: RecordedRun, columns: Mapping[str, Sequence[str]], wanted: Sequence[str]
    ):
        self._columns = {name: own for name, own in columns.items() if {*own} & {*wanted}}
        self._simulation: Simulation | None = None
        if self._columns:
            self._simulation = run.simulation()
            self._simulation.measure_truth()

    def until(self, tick: int) -> Iterator[Columns]:
        """Yield stamp_ns and the columns of sensors, further on until before a tick."""
        simulation = self._simulation
        while simulation is not None and simulation.next_tick < tick:
            _, samples = simulation.advance(min(tick - simulation.next_tick, _BLOCK_ROWS))
            if len(samples) == 0:
                return
            for name, columns in self._columns.items():
                measured = samples.measured[name]
                values = measured.values.reshape(len(measured), len(columns))
                yield {
                    'stamp_ns': measured.stamps_ns,
                    **dict(zip(columns, values.T, strict=True)),
                }


def _merged(parts: list[Columns]) -> Columns:
    """Return the columns of all stamps of parts; of two values for one, the first counts."""
    if len(parts) == 1:
        return parts[0]
    stamps_ns = np.unique(np.concatenate([part['stamp_ns'] for part in parts]))
    merged: Columns = {'stamp_ns': stamps_ns}
    for part in parts:
        indices = np.searchsorted(stamps_ns, part['stamp_ns'])
        for name, values in part.items():
            if name == 'stamp_ns':
                continue
            column = merged.setdefault(name, np.full(len(stamps_ns), np.nan))
            empty = np.isnan(column[indices])
            column[indices[empty]] = values[empty]
    return merged


def _stride(step_s: str | float, rate: Fraction) -> int:
    """Return how many ticks a step has; ValueError: not a whole number above 0."""
    try:
        ticks = Fraction(str(step_s)) * rate
    except (ValueError, ZeroDivisionError):
        ticks = Fraction(0)
    if ticks <= 0 or ticks.denominator != 1:
        # A decimal where that is the tick itself, else its fraction: what is named is allowed.
        tick, text = 1 / rate, f'{float(1 / rate):g}'
        allowed = text if Fraction(text) == tick else str(tick)
        raise ValueError(
            f"the step is {step_s} s; it must be a multiple of the bag's tick of {allowed} s"
        )
    # No run has so many.
    return min(int(ticks), 2**62)

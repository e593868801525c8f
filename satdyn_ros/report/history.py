"""The run in a bag at a limited number of rows, with bounds for the ticks between them."""

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import floor, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from ..bag.read_run import RecordedRun
from ..dynamics.motion import Motion, States, joined
from ..dynamics.torque import angular_momentum
from ..run.drift import Drift
from ..run.events import Event, RotorLimited
from ..run.samples import Samples, merged
from ..run.scenario import Scenario
from ..run.simulation import Simulation
from ..run.topics import Panel, Topic
from ..torques.magnetic import dipole_of
from ..torques.thrust import Thrust
from .curves import HELD_TICKS, Bounds, shown, topics_with_panels
from .earth_map import geodetic_topics
from .sensor_errors import ErrorsOfSensors, SensorErrors

# A controller may begin one at each tick.
MOST_MOTIONS = 200

# Instants are distinct on a time axis that is this many times longer than what is between them.
_DISTINCT = 500

# A line between two rows cannot follow a body that turns further from one to the next [rad].
LARGEST_TURN = np.pi / 2.0


@dataclass(frozen=True, eq=False)
class History:
    """
    The run in a bag, or a part of it, at some ticks, N of them, evenly spread, and the last one.

    Attributes
    ----------
    scenario : Scenario
        of the run
    ticks : int
        how many there are in all; row i stands for those from its own up to the next row's
    t_s : (N,), s
        from tick 0
    states : States
        their table, which refers to the orbit
    q_lb : (N, 4), or None
        attitude relative to LVLH; None: there is none
    shown : dict of (N, k)
        by their names what the topics with a panel show, and geodetic where it is published
    panels : dict of Panel
        titles and units of the topics with one
    applied_b : (N, 3), N m, body axes
        applied torque
    dipole_b : (N, 3), A m^2, body axes, or None
        magnetic dipole; None: the field turns none
    momentum_b : (N, 3), N m s, body axes
        H
    propellant : (N, K), kg, or None
        used by thrusters; None: there are none
    turned : (N,), rad
        the angle that the body turns within a row
    least, most, mean : dict of (N,)
        of a curve by its name, see curves.py, over all ticks of a row
    drift : dict of (N,)
        by first integral its largest relative change since the last event so far, of all ticks,
        nan where it is not one
    largest_drift : dict of float
        the same over the whole run
    motions : dict of Motion
        the first MOST_MOTIONS of the run, by the tick where they begin
    events : list of s and Event
        what happened, and when
    driven : list of two s
        the intervals in which a commanded torque or dipole acts
    valves_open : dict of lists of two s
        by the names of thrusters those in which their valves are open
    sensors : dict of SensorErrors
        by their names the errors of at most as many measurements as there may be rows
    """

    scenario: Scenario
    ticks: int
    t_s: np.ndarray
    states: States
    q_lb: np.ndarray | None
    shown: dict[str, np.ndarray]
    panels: dict[str, Panel]
    applied_b: np.ndarray
    dipole_b: np.ndarray | None
    momentum_b: np.ndarray
    propellant: np.ndarray | None
    turned: np.ndarray
    least: dict[str, np.ndarray]
    most: dict[str, np.ndarray]
    mean: dict[str, np.ndarray]
    drift: dict[str, np.ndarray]
    largest_drift: dict[str, float]
    motions: dict[int, Motion]
    events: list[tuple[float, Event]]
    driven: list[tuple[float, float]]
    valves_open: dict[str, list[tuple[float, float]]]
    sensors: dict[str, SensorErrors]

    @property
    def turns_too_far(self) -> np.ndarray:
        """Return the rows (N,) in which the body turns too far for a line to the next row."""
        return self.turned > LARGEST_TURN

    @property
    def span_s(self) -> float:
        """Return the time [s] from the first tick to the last."""
        return (self.ticks - 1) / float(self.scenario.rate)

    @property
    def window_s(self) -> float:
        """Return how long a window [s] may be for as many rows to follow the body."""
        rate = float(self.scenario.rate)
        every = round(np.diff(self.t_s).max(initial=0.0) * rate) or 1
        turn_per_tick = self.turned.max() / every
        # The average over a long row hides how fast the body turns during some of its ticks.
        suitable = int(0.9 * LARGEST_TURN / turn_per_tick) if turn_per_tick > 0.0 else every
        return max(len(self.t_s) - 1, 1) * max(suitable, 1) / rate

    @property
    def limited(self) -> list[tuple[float, float]]:
        """Return the intervals [s] in which rotors meet a limit; what looks like one is one."""
        intervals: list[tuple[float, float]] = []
        for t_s in sorted({t_s for t_s, event in self.events if isinstance(event, RotorLimited)}):
            is_near = intervals and t_s - intervals[-1][1] <= self.span_s / _DISTINCT
            begin_s = intervals.pop()[0] if is_near else t_s
            intervals.append((begin_s, t_s))
        return intervals


def history(
    path: str | Path,
    rows: int = 4000,
    begin_s: float | None = None,
    end_s: float | None = None,
) -> History:
    """
    Return the history of a bag in at most `rows` rows, and one of the last tick.

    Parameters
    ----------
    path : str or Path
        the bag
    rows : int
        the most rows
    begin_s, end_s : s or None
        the ticks k with begin_s <= k / rate <= end_s alone, counted from tick 0; None: no limit

    Raises
    ------
    ValueError
        the bag was not written by satdyn_ros, or has no ticks there
    """
    run = RecordedRun(path)
    if run.snapshot is None:
        raise ValueError(f'{path} has no samples')
    simulation = run.simulation()
    first, end = _window(run, simulation.next_tick, run.last_tick() + 1, begin_s, end_s)
    return History(
        scenario=run.scenario, ticks=end - first, **_read(run, simulation, first, end, rows)
    )


def _read(run, simulation, first, end, rows):
    """Return the fields of a History that follow from the samples of the ticks from first on."""
    every = -(-(end - first) // rows)
    row_ticks = np.unique([*range(first, end, every), end - 1])
    with_panels = topics_with_panels(run.scenario)
    bounds = Bounds(row_ticks, 1.0 / float(run.ticks.rate), with_panels)
    sensors = ErrorsOfSensors(simulation.sensors, run.ticks, range(first, end), rows)
    at_rows = _Rows([*with_panels, *geodetic_topics(run.scenario)])
    timeline, drifts = _Timeline(run), _LargestDrift()
    motions: dict[int, Motion] = {}
    for motion, applied, samples, changes in _measured(_stretches(simulation, first, end)):
        start = samples.first_tick
        sensors.take(motion, applied, samples)
        if drifts.is_new(motion) and len(motions) < MOST_MOTIONS:
            motions[start] = motion
        drift = drifts.take(motion, changes)
        if start < first:
            continue
        timeline.take(applied, samples)
        drifts.count()
        bounds.take(samples)
        # Numbers, not a slice: a view would keep all rows of the block in memory.
        begin, stop = np.searchsorted(row_ticks, [start, start + len(samples)])
        chosen = row_ticks[begin:stop] - start
        if len(chosen):
            at_rows.take(samples, chosen, drift)
    bounds.close()
    states = joined(at_rows.tables)
    return {
        't_s': states.orbit_s,
        'states': states,
        'q_lb': None if run.scenario.is_fixed else states.q_lb,
        'panels': {topic.name: topic.panel for topic in with_panels if topic.panel},
        'turned': bounds.turned,
        'least': bounds.least,
        'most': bounds.most,
        'mean': bounds.mean,
        'largest_drift': drifts.of_run,
        'motions': motions,
        'events': timeline.events,
        'driven': timeline.driven,
        'valves_open': timeline.valves_open,
        'sensors': sensors.result(),
        **at_rows.columns(drifts.of_run),
    }


class _LargestDrift:
    """By first integral its largest relative change so far: since an event, and of the run."""

    def __init__(self) -> None:
        self.of_run: dict[str, float] = {}
        self._motion: Motion | None = None
        self._so_far: dict[str, float] = {}

    def is_new(self, motion: Motion) -> bool:
        """Return whether a motion is another than the last one taken."""
        return motion is not self._motion

    def take(self, motion: Motion, changes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Return the largest change up to each of the rows (N,) that follow."""
        if self.is_new(motion):
            self._motion, self._so_far = motion, {}
        drift = {
            name: np.maximum.accumulate(np.maximum(np.abs(values), self._so_far.get(name, 0.0)))
            for name, values in changes.items()
        }
        self._so_far = {name: float(values[-1]) for name, values in drift.items()}
        return drift

    def count(self) -> None:
        """Let the rows taken last be among those of the run."""
        for name, value in self._so_far.items():
            self.of_run[name] = max(self.of_run.get(name, 0.0), value)


class _Timeline:
    """What happened, and between which instants [s] something acts."""

    def __init__(self, run: RecordedRun):
        self._run = run
        self.events: list[tuple[float, Event]] = []
        self.driven: list[tuple[float, float]] = []
        self.valves_open: dict[str, list[tuple[float, float]]] = {}

    def take(self, applied: list[Event], samples: Samples) -> None:
        """Add what was applied and the samples that follow."""
        ticks, start = self._run.ticks, samples.first_tick
        self.events += [(ticks.seconds(event.tick), event) for event in applied]
        span_s = ticks.seconds(start), ticks.seconds(start + len(samples))
        if self._run.scenario.equipment.is_driving(samples.acting):
            _extend(self.driven, *span_s)
        _note_open(self.valves_open, samples.system, span_s)


class _Rows:
    """What a history holds at its rows, block by block."""

    def __init__(self, topics: list[Topic]):
        self._topics = topics
        self.tables: list[States] = []
        self._shown: list[dict[str, np.ndarray]] = []
        self._drifts: list[dict[str, np.ndarray]] = []
        self._columns: dict[str, list[np.ndarray]] = defaultdict(list)

    def take(self, samples: Samples, chosen: np.ndarray, drift: dict[str, np.ndarray]) -> None:
        """Add the chosen rows of samples, and of their drift."""
        table, system = samples.states.rows(chosen), samples.system
        self.tables.append(table)
        every = shown(self._topics, samples)
        self._shown.append({name: values[chosen] for name, values in every.items()})
        self._drifts.append({name: values[chosen] for name, values in drift.items()})
        momentum_b = angular_momentum(system, table.omega_bi_b, table.rotor_speed, table.inner)
        self._columns['momentum_b'].append(momentum_b)
        self._columns['applied_b'].append(np.broadcast_to(system.torque_b, (len(table), 3)))
        dipole_b = dipole_of(system.torques)
        if dipole_b is not None:
            self._columns['dipole_b'].append(np.broadcast_to(dipole_b, (len(table), 3)))
        thrust = Thrust.among(system.torques)
        if thrust is not None:
            self._columns['propellant'].append(thrust.propellant_used(table.orbit_s))

    def columns(self, integrals: Iterable[str]) -> dict[str, Any]:
        """Return the fields of a History that these are, the drift of some first integrals."""
        found: dict[str, Any] = {'dipole_b': None, 'propellant': None}
        found |= {name: np.concatenate(parts) for name, parts in self._columns.items()}
        blocks = [*zip(self._drifts, self.tables, strict=True)]
        return found | {
            'shown': {
                topic.name: np.concatenate([part[topic.name] for part in self._shown])
                for topic in self._topics
            },
            'drift': {
                name: np.concatenate(
                    [part.get(name, np.full(len(table), np.nan)) for part, table in blocks]
                )
                for name in integrals
            },
        }


def _stretches(
    simulation: Simulation, first: int, end: int
) -> Iterator[tuple[Motion, list[Event], Samples]]:
    """
    Yield each motion with what happens in it and its samples, those before the tick first apart.

    A torque that changes nothing parts the samples of a run, but begins no motion: they come
    together.  ValueError: the run halts before the tick end.
    """
    motion = simulation.motion
    events: list[Event] = []
    parts: list[Samples] = []
    while simulation.next_tick < end:
        start = simulation.next_tick
        limit = first if start < first else end
        applied, samples = simulation.advance(min(HELD_TICKS, limit - start))
        if len(samples) == 0:
            raise ValueError(f'the run in the bag cannot continue: {simulation.halted}')
        if parts and (
            simulation.motion is not motion
            or start == first
            or start - parts[0].first_tick >= HELD_TICKS
        ):
            yield motion, events, merged(parts)
            events, parts = [], []
        motion = simulation.motion
        events += applied
        parts.append(samples)
    yield motion, events, merged(parts)


def _measured(
    stretches: Iterator[tuple[Motion, list[Event], Samples]],
) -> Iterator[tuple[Motion, list[Event], Samples, dict[str, np.ndarray]]]:
    """Yield each stretch with the relative drift in its rows."""
    measuring = Drift()
    waiting: deque[tuple[Motion, list[Event]]] = deque()
    for motion, events, samples in stretches:
        yield from _with_drift(waiting, measuring.take(motion, samples))
        waiting.append((motion, events))
    yield from _with_drift(waiting, measuring.close())


def _with_drift(waiting, measured):
    for parts, _, drift in measured:
        begin = 0
        for samples in parts:
            rows = slice(begin, begin + len(samples))
            begin = rows.stop
            found = {name: values[rows] for name, values in drift.items()}
            yield *waiting.popleft(), samples, found


def _window(run, first, end, begin_s, end_s):
    """Return the first tick and the one after the last that were asked for."""
    asked = {n: s for n, s in (('begin', begin_s), ('end', end_s)) if s is not None}
    for name, value in asked.items():
        if not isfinite(value):
            raise ValueError(f'--{name} is {value:g}; it must be a finite number of seconds')
    rate = run.ticks.rate
    from_tick = first if begin_s is None else max(first, run.ticks.ceil(begin_s))
    to_tick = end if end_s is None else min(end, floor(Fraction(str(end_s)) * rate) + 1)
    if from_tick >= to_tick:
        lowest, highest = run.ticks.seconds(first), run.ticks.seconds(end - 1)
        where = ' and '.join(f'--{name} {value:g}' for name, value in asked.items())
        raise ValueError(
            f'{run.bag.path} has no ticks within {where}; it holds those from {lowest:.9g} s to '
            f'{highest:.9g} s'
        )
    return from_tick, to_tick


def _note_open(valves_open, system, span_s):
    """Add when valves are open between two instants."""
    thrust = Thrust.among(system.torques)
    for name, intervals in thrust.open_between(*span_s).items() if thrust else ():
        open_so_far = valves_open.setdefault(name, [])
        for interval in intervals:
            _extend(open_so_far, *interval)


def _extend(intervals, begin_s, end_s):
    """Add an interval; one that continues the last extends it."""
    if intervals and intervals[-1][1] == begin_s:
        begin_s = intervals.pop()[0]
    intervals.append((begin_s, end_s))

"""What a bag shows: its run once more, thinned out for the eye, with the drift of every tick."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..bag.recorded_run import RecordedRun
from ..dynamics.integrals import relative_drift
from ..dynamics.motion import Motion, States
from ..dynamics.torque import angular_momentum, gravity_gradient
from ..rosbag2.reader import TopicBlock
from ..run.events import Event
from ..run.scenario import Scenario

_BLOCK_TICKS = 4096


@dataclass(frozen=True, eq=False)
class History:
    """
    The run in a bag at some ticks, N of them, evenly spread.

    t_s (N,): seconds from tick 0.  states: their table, which refers to the orbit; q_lb (N, 4) is
    None without LVLH.  torque_b (N, 3): gravity gradient [N m]; momentum_b (N, 3): H [N m s].
    drift: by first integral its largest relative change since the last event so far, of all ticks,
    (N,), nan where it is none.  largest_drift: the same over the whole run.  motions: those of the
    run, by the tick where they begin.  events: what happened, with the time of each.
    """

    scenario: Scenario
    ticks: int
    t_s: np.ndarray
    states: States
    q_lb: np.ndarray | None
    torque_b: np.ndarray
    momentum_b: np.ndarray
    drift: dict[str, np.ndarray]
    largest_drift: dict[str, float]
    motions: dict[int, Motion]
    events: list[tuple[float, Event]]


def history(path: str | Path, rows: int = 4000) -> History:
    """Return the history of a bag at about so many ticks; ValueError: it is no bag of ours."""
    run = RecordedRun(path)
    if run.snapshot is None:
        raise ValueError(f'{path} has no samples')
    simulation = run.simulation()
    first, end = simulation.next_tick, _last_tick(run) + 1
    every = max(1, -(-(end - first) // rows))
    tables, torques, momenta, drifts, events = [], [], [], [], []
    largest: dict[str, float] = {}
    so_far: dict[str, float] = {}
    motions: dict[int, Motion] = {}
    while simulation.next_tick < end:
        block = min(_BLOCK_TICKS, end - simulation.next_tick)
        applied, samples = simulation.advance(block)
        events += [(run.ticks.seconds(event.tick), event) for event in applied]
        states = samples.states
        if simulation.motion not in motions.values():
            motions[samples.first_tick] = simulation.motion
            begin, so_far = states, {}
        drift = {
            name: np.maximum.accumulate(np.maximum(np.abs(values), so_far.get(name, 0.0)))
            for name, values in relative_drift(samples.system, states, begin).items()
        }
        so_far = {name: float(values[-1]) for name, values in drift.items()}
        largest |= {name: max(largest.get(name, 0.0), value) for name, value in so_far.items()}
        chosen = slice((first - samples.first_tick) % every, None, every)
        table = states.rows(chosen)
        gradient = table.orbit.gradient_at(table.orbit_s)
        tables.append(table)
        torques.append(gravity_gradient(samples.system.inertia, table.c_b, gradient))
        momenta.append(angular_momentum(samples.system, table.omega_bi_b, table.rotor_speed))
        drifts.append({name: values[chosen] for name, values in drift.items()})
    states = joined(tables)
    return History(
        scenario=run.scenario,
        ticks=end - first,
        t_s=states.orbit_s,
        states=states,
        q_lb=None if run.scenario.is_fixed else states.q_lb,
        torque_b=np.concatenate(torques),
        momentum_b=np.concatenate(momenta),
        drift={
            name: np.concatenate(
                [
                    part.get(name, np.full(len(table), np.nan))
                    for part, table in zip(drifts, tables, strict=True)
                ]
            )
            for name in largest
        },
        largest_drift=largest,
        motions=motions,
        events=events,
    )


def joined(tables: list[States]) -> States:
    """Return tables that follow each other as one."""

    def column(name):
        return np.concatenate([getattr(table, name) for table in tables])

    return States(
        t_s=column('t_s'),
        q_ib=column('q_ib'),
        omega_bi_b=column('omega_bi_b'),
        rotor_speed=column('rotor_speed'),
        rotor_angle=column('rotor_angle'),
        work=column('work'),
        orbit=tables[0].orbit,
        orbit_s=column('orbit_s'),
    )


def _last_tick(run):
    blocks = (item.contents for item in run.bag.items() if isinstance(item, TopicBlock))
    return run.ticks.tick_of(max(block.span_ns[1] for block in blocks))

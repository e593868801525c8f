"""Runs of a sweep with a controller in each: side by side, or one after the other."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ..dynamics.motion import States, joined
from ..run.controlled import ControlledSimulation
from ..run.controllers import Seen, failure, period_of, sees_truth
from ..run.scenario import Scenario
from ..run.side_by_side import SideBySide, kind_of_run
from ..run.simulation import RunHalted
from .own_controller import OwnController


def flown(
    controllers: OwnController, scenarios: Sequence[Scenario], ticks: np.ndarray
) -> Iterator[tuple[int, States | Exception]]:
    """
    Yield the states of runs at ascending ticks (N,), or why a run has none, by their indices.

    A controller that is vectorized sees all runs of a kind at once, else each has its own.
    """
    if not getattr(controllers.new(), 'vectorized', False):
        for i, scenario in enumerate(scenarios):
            yield i, _outcome_of(_alone, controllers, scenario, ticks)
        return
    alike: dict[Any, list[int]] = defaultdict(list)
    for i, scenario in enumerate(scenarios):
        alike[kind_of_run(scenario)].append(i)
    for kind, indices in alike.items():
        if kind is None:
            for i in indices:
                yield i, _outcome_of(_alone, controllers, scenarios[i], ticks)
            continue
        some = [scenarios[i] for i in indices]
        found = _outcome_of(_together, controllers, some, ticks)
        for n, i in enumerate(indices):
            yield i, found if isinstance(found, Exception) else found[n]


def _outcome_of(fly: Callable[..., Any], *given: Any) -> Any:
    try:
        return fly(*given)
    except Exception as error:
        return error


def _alone(controllers, scenario, ticks):
    simulation = ControlledSimulation(scenario, controller=controllers.new())
    found, end = [], int(ticks[-1]) + 1
    while simulation.next_tick < end:
        _, samples = simulation.advance(end - simulation.next_tick)
        if simulation.halted:
            raise RunHalted(simulation.halted)
        here = ticks - samples.first_tick
        rows = here[(0 <= here) & (here < len(samples))]
        if len(rows):
            found.append(samples.states.rows(rows))
    return joined(found)


def _together(controllers, scenarios, ticks):
    controller, runs = controllers.new(), SideBySide(scenarios)
    period, needs_truth = period_of(controller, scenarios[0]), sees_truth(controller)
    wanted = dict.fromkeys(ticks.tolist())
    found: list[Any] = []
    try:
        if reset := getattr(controller, 'reset', None):
            seeds = np.array([each['sensors.seed'] for each in runs.scenarios])
            reset(scenarios[0], seeds)
        for tick in range(int(ticks[-1]) + 1):
            sample = runs.sample
            if tick in wanted:
                found.append(_table(sample))
            if tick % period == 0:
                seen = sample if needs_truth else Seen(sample)
                runs.act(**(controller.command(seen) or {}))
            if tick < ticks[-1]:
                runs.step()
    except Exception as error:
        raise failure(controller, error, runs.ticks.seconds(tick)) from error
    t_s = runs.ticks.seconds_of(ticks)
    tables = [np.stack(columns, axis=1) for columns in zip(*found, strict=True)]
    return [
        RunHalted(runs.halted[m]) if m in runs.halted else _states(scenario, t_s, tables, m)
        for m, scenario in enumerate(scenarios)
    ]


def _table(sample):
    return sample.q_ib, sample.omega_bi_b, sample.rotor_speed, sample.rotor_angle


def _states(scenario, t_s, tables, m):
    q_ib, omega_bi_b, speed, angle = (table[m] for table in tables)
    system, work = scenario.system, np.full(len(t_s), np.nan)
    return States(
        t_s,
        q_ib,
        omega_bi_b,
        speed,
        angle,
        work,
        system.orbit,
        t_s,
        environment=system.environment,
    )

"""
A sweep end to end, beside its propagation alone: what a run costs but for its steps.

The propagation's share is the CPU time inside propagate_many, in the same run.
"""

import multiprocessing
import statistics
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path

from common import Claim, milliseconds, show

from satdyn_ros.sweep import outcome
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.run import batches, part_name, store_batch
from satdyn_ros.sweep.table import keep, table, write_part

SWEEPS = Path(__file__).parents[1] / 'config' / 'sweeps'
ORBIT_S = 5677.0
# Batches on one and on two cores, as large as those of a long sweep, and so many that their
# beginning and end do not show.
SIZE = 1024
BEGINS = [*range(0, 6 * SIZE, SIZE)] * 12
# Name, sweep, duration, runs together (None: as many as in the sweep itself), what all over the
# propagation must and should be at most.
CASES = (
    ('capture.yaml, ten orbits', 'capture', None, None, 1.5, 1.2),
    ('smelt.yaml, twenty orbits', 'smelt', None, None, 1.5, 1.2),
    ('capture.yaml, one orbit', 'capture', ORBIT_S, SIZE, 3.0, 2.0),
    ('monte_carlo.yaml, one orbit', 'monte_carlo', ORBIT_S, SIZE, 3.0, 2.0),
)


def plan_of(name, duration_s):
    """Return a shipped sweep, perhaps shorter."""
    plan = Plan.from_yaml(SWEEPS / f'{name}.yaml')
    return plan if duration_s is None else replace(plan, duration_s=duration_s)


def shares(plan, count, rounds=5):
    """
    Return the median CPU seconds of a run and, over its propagation's, their median ratio.

    A round is the whole sweep but for what is left after the last batch of count runs, each batch
    written as a part.
    """
    inside, propagate = [], outcome.propagate_many

    def timed(*arguments):
        begin = time.process_time()
        found = propagate(*arguments)
        inside.append(time.process_time() - begin)
        return found

    begins = range(0, len(plan) - count + 1, count)
    per_run, ratios = [], []
    outcome.propagate_many = timed
    try:
        with tempfile.TemporaryDirectory() as directory:
            for _ in range(rounds + 1):
                inside.clear()
                begin = time.process_time()
                for first in begins:
                    columns = outcome.columns(plan, range(first, first + count))
                    write_part(Path(directory) / 'part', plan, table(plan, columns))
                    keep(Path(directory) / 'part')
                seconds = time.process_time() - begin
                per_run.append(seconds / count / len(begins))
                ratios.append(seconds / sum(inside))
    finally:
        outcome.propagate_many = propagate
    return statistics.median(per_run[1:]), statistics.median(ratios[1:])


def two_cores(rounds=7):
    """Return the wall seconds of the same runs on one process and on two, both started before."""
    text, spawn = plan_of('capture', ORBIT_S).to_text(), multiprocessing.get_context('spawn')
    seconds: dict[int, list[float]] = {1: [], 2: []}
    with ExitStack() as stack:
        pools = {cores: stack.enter_context(ProcessPoolExecutor(cores, spawn)) for cores in (1, 2)}
        parts = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        work = partial(store_batch, text, parts=parts)
        for round_ in range(rounds + 1):
            for cores, pool in pools.items():
                begin = time.perf_counter()
                done = pool.map(work, BEGINS, [first + SIZE for first in BEGINS])
                for first, _ in zip(BEGINS, done, strict=True):
                    keep(parts / part_name(first))
                if round_:
                    seconds[cores].append(time.perf_counter() - begin)
    return {cores: statistics.median(times) for cores, times in seconds.items()}


def main():
    """Run all; return title, claims and text."""
    claims = []
    for what, name, duration_s, count, must, aim in CASES:
        plan = plan_of(name, duration_s)
        seconds, ratio = shares(plan, count or next(batches(plan))[1])
        claims.append(
            Claim(
                f'a run of {what}, over its propagation alone',
                milliseconds(seconds),
                milliseconds(seconds / ratio),
                ratio,
                must,
                aim,
                at_most=True,
            )
        )
    cores = two_cores()
    claims.append(
        Claim(
            f'{SIZE * len(BEGINS)} runs of one orbit, two cores against one (wall)',
            milliseconds(cores[2]),
            milliseconds(cores[1]),
            cores[1] / cores[2],
            1.9,
        )
    )
    return 'Sweeps', show(claims), ''


if __name__ == '__main__':
    main()

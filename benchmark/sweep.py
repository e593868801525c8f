"""
A sweep end to end, beside its propagation alone: what a run costs but for its steps.

The propagation's share is the CPU time inside propagate_many, in the same run.
"""

import multiprocessing
import statistics
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

from common import Claim, milliseconds, show

from satdyn_ros.sweep import outcome
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.run import batch, batches
from satdyn_ros.sweep.table import table, write_part

SWEEPS = Path(__file__).parents[1] / 'config' / 'sweeps'
ORBIT_S = 5677.0
# Batches on one and on two cores, so many that their beginning and end do not show.
BEGINS = [*range(0, 6144, 512)] * 3
# Name, sweep, duration, runs together (None: as many as in the sweep itself), what all over the
# propagation must and should be at most.
CASES = (
    ('capture.yaml, ten orbits', 'capture', None, None, 1.5, 1.2),
    ('smelt.yaml, twenty orbits', 'smelt', None, None, 1.5, 1.2),
    ('capture.yaml, one orbit', 'capture', ORBIT_S, 1024, 3.0, 2.0),
    ('monte_carlo.yaml, one orbit', 'monte_carlo', ORBIT_S, 1024, 3.0, 2.0),
)


def plan_of(name, duration_s):
    """Return a shipped sweep, perhaps shorter."""
    plan = Plan.from_yaml(SWEEPS / f'{name}.yaml')
    return plan if duration_s is None else replace(plan, duration_s=duration_s)


def shares(plan, count, rounds=7):
    """Return the median CPU seconds of a batch, written as a part, and of its propagation."""
    inside, propagate = [], outcome.propagate_many

    def timed(*arguments):
        begin = time.process_time()
        found = propagate(*arguments)
        inside.append(time.process_time() - begin)
        return found

    all_in_all, first = [], max(0, len(plan) // 2 - count // 2)
    outcome.propagate_many = timed
    try:
        with tempfile.TemporaryDirectory() as directory:
            for _ in range(rounds + 1):
                begin = time.process_time()
                columns = outcome.columns(plan, range(first, first + count))
                write_part(Path(directory) / 'part', plan, table(plan, columns))
                all_in_all.append(time.process_time() - begin)
    finally:
        outcome.propagate_many = propagate
    ratios = [a / b for a, b in zip(all_in_all[1:], inside[1:], strict=True)]
    return statistics.median(all_in_all[1:]), statistics.median(ratios)


def two_cores(rounds=5):
    """Return the wall seconds of the same runs on one process and on two, started before."""
    text = plan_of('capture', ORBIT_S).to_text()
    work = [text] * len(BEGINS), BEGINS, [begin + 512 for begin in BEGINS]
    spawn, seconds = multiprocessing.get_context('spawn'), {}
    for cores in (1, 2):
        with ProcessPoolExecutor(cores, spawn) as pool:
            list(pool.map(batch, *work))
            times = []
            for _ in range(rounds):
                begin = time.perf_counter()
                list(pool.map(batch, *work))
                times.append(time.perf_counter() - begin)
        seconds[cores] = statistics.median(times)
    return seconds


def main():
    """Run all; return title, claims and text."""
    claims = []
    for what, name, duration_s, count, must, aim in CASES:
        plan = plan_of(name, duration_s)
        count = count or next(batches(plan))[1]
        seconds, ratio = shares(plan, count)
        claims.append(
            Claim(
                f'a run of {what}, over its propagation alone',
                milliseconds(seconds / count),
                milliseconds(seconds / ratio / count),
                ratio,
                must,
                aim,
                at_most=True,
            )
        )
    cores = two_cores()
    claims.append(
        Claim(
            f'{512 * len(BEGINS)} runs of one orbit, two cores against one (wall)',
            milliseconds(cores[2]),
            milliseconds(cores[1]),
            cores[1] / cores[2],
            1.9,
        )
    )
    return 'Sweeps', show(claims), ''


if __name__ == '__main__':
    main()

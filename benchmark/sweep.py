"""
A sweep end to end, beside its propagation alone: what a run costs but for its steps.

The propagation's share is the CPU time inside propagate_many, in the same run.
"""

import statistics
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

from common import QUICK, Claim, milliseconds, one_and_two_cores, show

from satdyn_ros.sweep import outcome
from satdyn_ros.sweep.batches import batches, part_name, store_batch
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.table import keep, table, write_part

SWEEPS = Path(__file__).parents[1] / 'config' / 'sweeps'
ORBIT_S = 5677.0
# Batches on one and on two cores, as large as those of a long sweep, and so many that their
# beginning and end do not show.
SIZE = 1024
BEGINS = [*range(0, 6 * SIZE, SIZE)] * (1 if QUICK else 16)
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

    begins = range(0, 1 if QUICK else len(plan) - count + 1, count)
    per_run, ratios = [], []
    outcome.propagate_many = timed
    try:
        with tempfile.TemporaryDirectory() as directory:
            for _ in range(2 if QUICK else rounds + 1):
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


def two_cores() -> Claim:
    """Return the claim of two cores, written as a sweep writes its parts."""
    text = plan_of('capture', ORBIT_S).to_text()
    with tempfile.TemporaryDirectory() as directory:
        parts = Path(directory)
        work = partial(store_batch, text, parts=parts)

        def run(pool: ProcessPoolExecutor) -> None:
            done = pool.map(work, BEGINS, [first + SIZE for first in BEGINS])
            for first, _ in zip(BEGINS, done, strict=True):
                keep(parts / part_name(first))

        return one_and_two_cores(f'{SIZE * len(BEGINS)} runs of one orbit', run, 1.9)


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
    claims.append(two_cores())
    return 'Sweeps', show(claims), ''


if __name__ == '__main__':
    main()

"""Batches of runs, wherever they are done: which runs, their rows, and the file of these."""

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import pyarrow as pa

from ..integrate.batch import LANES
from .outcome import columns
from .plan import Plan
from .table import table, write_part

_SAMPLES_A_BATCH = 500_000
# Of runs in step, the more there are together the less each costs.
_PARTS_IN_STEP = 4


def batches(plan: Plan) -> Iterator[tuple[int, int]]:
    """Yield the first run and the one after the last of each batch, wherever it is done."""
    # Short compared with the whole, for interruptions and for cores that finish together, but long
    # enough to fill the lanes of a propagation and to outweigh what is done once per batch.
    parts = 32 if plan.controller is None else _PARTS_IN_STEP
    size = max(2 * LANES, min(1024, len(plan) // parts, _SAMPLES_A_BATCH // len(plan.t_s)))
    for first in range(0, len(plan), size):
        yield first, min(first + size, len(plan))


def part_name(first: int) -> str:
    """Return the file name of the batch that begins with a run."""
    return f'{first:09d}.parquet'


def batch(text: str, first: int, last: int) -> pa.Table:
    """Return the rows of the runs first to last - 1 of the plan of a text."""
    plan = _plan(text)
    return table(plan, columns(plan, range(first, last)))


def store_batch(text: str, first: int, last: int, parts: Path) -> None:
    """Write the rows of the runs first to last - 1 as the part of their batch, to be kept."""
    write_part(parts / part_name(first), _plan(text), batch(text, first, last))


_plan = lru_cache(maxsize=1)(Plan.from_text)

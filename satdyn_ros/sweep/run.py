"""
A sweep from its file to its table: batches on the cores of a machine or of a cluster.

In the directory: sweep.json, what the table depends on; parts, a Parquet file per finished batch;
at the end table.parquet in their place, and bags.  What is there already is not done again.
"""

import logging
import multiprocessing
import os
import shutil
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent import futures
from contextlib import contextmanager
from functools import lru_cache, partial
from itertools import islice
from multiprocessing import resource_tracker
from multiprocessing.process import BaseProcess
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import pyarrow as pa

from .. import __version__
from ..bag.simulate import simulate
from ..base.interruption import interruptible, uninterrupted
from ..base.regular_file import regular_file
from ..integrate.batch import propagate_all
from ..integrate.batch_state import LANES
from ..integrate.propagation import Propagation
from ..run.scenario import Scenario
from .outcome import columns
from .plan import Plan
from .resources import check_resources
from .table import keep, table, unite, write_part

# Batches handed over at a time: enough for a large cluster, few enough for a small memory.
_IN_FLIGHT = 256
_SAMPLES_A_BATCH = 500_000
_CONNECT_S = 5.0


def sweep(
    path: str | Path,
    directory: str | Path,
    workers: int | None = None,
    dask_address: str | None = None,
    show: Callable[[int, int], object] = lambda done, total: None,
    satellite: str | None = None,
) -> Path:
    """
    Do all runs of a sweep file and return the path of their table, directory/table.parquet.

    An interrupted sweep continues where it was when called again.  workers: processes on this
    machine, None: one per core.  dask_address: a dask.distributed scheduler that does the runs
    instead.  show(done, total): called whenever runs have finished.  satellite: which one, where
    the scenario has several.
    ValueError: the file is wrong, the directory holds something else, or the machine is too small.
    OSError: a file cannot be written.
    """
    if workers is not None and workers < 1:
        raise ValueError(f'--workers is {workers}; it must be an integer of at least 1')
    plan, directory = Plan.from_yaml(path, satellite), Path(directory)
    for doubt in plan.scenario.warnings:
        logging.getLogger(__name__).warning(doubt)
    check_resources(plan, directory)
    _occupy(directory, plan)
    whole, parts = directory / 'table.parquet', directory / 'parts'
    if not whole.exists():
        parts.mkdir(exist_ok=True)
        # Processes here write their parts themselves: the rest of a table from a killed process
        # would be awaited for ever.  Those of a cluster may have no common disk.
        work = batch if dask_address else partial(store_batch, parts=parts)
        _run_batches(plan, parts, _executor(workers, dask_address), work, show)
        unite(whole, plan, [parts / part_name(first) for first, _ in batches(plan)])
    shutil.rmtree(parts, ignore_errors=True)
    for run in plan.bags:
        _record(plan, run, directory / 'bags')
    return whole


def batches(plan: Plan) -> Iterator[tuple[int, int]]:
    """Yield the first run and the one after the last of each batch, wherever it is done."""
    # Short compared with the whole, for interruptions and for cores that finish together, but long
    # enough to fill the lanes of a propagation and to outweigh what is done once per batch.
    size = max(2 * LANES, min(1024, len(plan) // 32, _SAMPLES_A_BATCH // len(plan.t_s)))
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


def _run_batches(plan, parts, executor, work, show):
    text = plan.to_text()
    kept = {each for each in batches(plan) if (parts / part_name(each[0])).exists()}
    missing = (each for each in batches(plan) if each not in kept)
    done = sum(last - first for first, last in kept)
    running: dict[Any, Any] = {}
    finished: SimpleQueue[Any] = SimpleQueue()
    with interruptible(), executor as pool:
        try:
            while True:
                show(done, len(plan))
                # An exception within the executor's functions could leave a lock taken, for which
                # its threads would wait for ever: interruptions act between them.
                with uninterrupted(), _hidden_from_processes():
                    for first, last in islice(missing, _IN_FLIGHT - len(running)):
                        future = pool.submit(work, text, first, last)
                        future.add_done_callback(finished.put)
                        running[future] = first, last
                if not running:
                    return
                future = finished.get()
                with uninterrupted():
                    rows, (first, last) = future.result(), running.pop(future)
                    part = parts / part_name(first)
                    if rows is not None:
                        write_part(part, plan, rows)
                    # Not by the processes, which would wait for the disk.
                    keep(part)
                done += last - first
        except BaseException:
            with uninterrupted():
                pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def _executor(workers, dask_address):
    """Provide the executor that runs the batches: processes here, or those of a cluster."""
    if dask_address is None:
        # Compiled here, where an interruption is handled, for all processes.
        scenario = Scenario()
        propagate_all([Propagation(scenario.system, scenario.initial_state)], np.zeros(1))
        spawn, others = multiprocessing.get_context('spawn'), multiprocessing.active_children()
        with futures.ProcessPoolExecutor(workers or os.cpu_count(), spawn, _follow_parent) as pool:
            try:
                yield pool
            except BaseException:
                # Their current batches are done again: that is faster than waiting for them.
                for process in set(multiprocessing.active_children()).difference(others):
                    process.kill()
                raise
        return
    from distributed import Client

    try:
        client = Client(dask_address, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        raise ValueError(
            f'--dask is {dask_address}, where no scheduler answers: {error}'
        ) from None
    with client:
        yield client.get_executor(pure=False)


@contextmanager
def _hidden_from_processes():
    """Let processes started here leave SIGINT to this one from their first moment."""
    # It would lift the block when the first process is started.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _follow_parent():
    """End when the parent process ends, however it does."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_after, args=(parent,), daemon=True).start()


def _end_after(process: BaseProcess) -> None:
    process.join()
    os._exit(1)


def _occupy(directory, plan):
    """Claim the directory for a plan; ValueError: it holds something else."""
    path, text = directory / 'sweep.json', f'{__version__}\n{plan.to_text()}'
    if path.exists():
        if regular_file(path).read_text() != text:
            raise ValueError(f'{directory} holds another sweep; give a new directory')
        return
    if directory.exists() and any(directory.iterdir()):
        raise ValueError(f'{directory} holds no sweep and is not empty; give a new directory')
    directory.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix('.partial')
    unfinished.write_text(text)
    unfinished.replace(path)


def _record(plan, run, bags):
    """Record a run's bag, unless it is there."""
    name = f'run_{run:06d}'
    if (bags / name).exists():
        return
    unfinished = bags / 'partial'
    shutil.rmtree(unfinished, ignore_errors=True)
    unfinished.mkdir(parents=True)
    scenario = plan.scenario_of(plan.values(run))
    for _ in simulate(scenario, plan.duration_s, unfinished / name):
        pass
    (unfinished / name).rename(bags / name)
    unfinished.rmdir()

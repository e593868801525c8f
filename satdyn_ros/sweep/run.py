"""
A sweep from its file to its table: batches on the cores of a machine or of a cluster.

In the directory: sweep.json, what the table depends on, versions included; parts, a Parquet file
per finished batch; at the end table.parquet in their place, and bags.  What is there already is
not done again.
"""

import json
import logging
import shutil
from collections.abc import Callable, Iterable, Sequence
from concurrent import futures
from functools import partial
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

from ..bag.simulate import simulate
from ..base.interruption import interruptible, uninterrupted
from ..base.regular_file import regular_file
from ..base.sentences import one_sentence
from ..torques.body_torque import BodyTorque
from .batches import batches, part_name, store_batch
from .plan import Plan
from .resources import check_resources
from .table import keep, schema, unite, write_part
from .workers import Failed, cluster, processes

# Batches handed over at a time: enough for a large cluster, few enough for a small memory.
_IN_FLIGHT = 256
# How often it is asked, while no batch finishes, whether any still can.
_CHECK_S = 1.0


def sweep(
    path: str | Path,
    directory: str | Path,
    workers: int | None = None,
    dask_address: str | None = None,
    show: Callable[[int, int], object] = lambda done, total: None,
    satellite: str | None = None,
    outcomes: Sequence[str] = (),
    torques: Iterable[type[BodyTorque]] = (),
    controller: str | None = None,
    controller_parameters: Sequence[str] = (),
) -> Path:
    """
    Do all runs of a sweep file and return the path of their table, directory/table.parquet.

    An interrupted sweep continues where it was when called again.

    Parameters
    ----------
    path : str or Path
        the sweep file
    directory : str or Path
        for the results
    workers : int or None
        processes on this machine, None: one per core
    dask_address : str or None
        a dask.distributed scheduler that does the runs instead
    show : function of done and total
        called whenever runs have finished
    satellite, outcomes, torques, controller, controller_parameters
        as of Plan.from_yaml

    Raises
    ------
    ValueError
        the file is wrong, the directory holds something else, or the machine is too small
    OSError
        a file cannot be written
    Failed
        a worker failed, not only a run
    """
    if workers is not None and workers < 1:
        raise ValueError(f'--workers is {workers}; it must be an integer of at least 1')
    plan = Plan.from_yaml(path, satellite, outcomes, torques, controller, controller_parameters)
    directory = Path(directory)
    for warning in plan.scenario.warnings:
        logging.getLogger(__name__).warning(warning)
    # An outcome of one's own must not have the name of another column.
    schema(plan)
    check_resources(plan, directory)
    _refuse_another(directory, plan)
    whole, parts = directory / 'table.parquet', directory / 'parts'
    if not whole.exists():
        _make_parts(plan, directory, parts, workers, dask_address, show)
        unite(whole, plan, [parts / part_name(first) for first, _ in batches(plan)])
    shutil.rmtree(parts, ignore_errors=True)
    for run in plan.bags:
        _record(plan, run, directory / 'bags')
    return whole


def _make_parts(plan, directory, parts, workers, dask_address, show):
    """Do the runs that have not been done, and write the part of the table of each batch."""
    # Processes here write their parts themselves: the rest of a table from a killed process would
    # be awaited for ever.  Those of a cluster may have no common disk.
    pool = (
        cluster(dask_address)
        if dask_address
        else processes(workers, partial(store_batch, parts=parts))
    )
    with interruptible(), pool as executor:
        _occupy(directory, plan, executor.versions)
        parts.mkdir(exist_ok=True)
        _run_batches(plan, parts, executor, show)


def _run_batches(plan, parts, executor, show):
    text = plan.to_text()
    kept = {each for each in batches(plan) if (parts / part_name(each[0])).exists()}
    missing = (each for each in batches(plan) if each not in kept)
    done = sum(last - first for first, last in kept)
    running: dict[Any, Any] = {}
    finished: SimpleQueue[Any] = SimpleQueue()
    while True:
        show(done, len(plan))
        # An exception within the executor's functions could leave a lock taken, for which its
        # threads would wait for ever: interruptions act between them.
        with uninterrupted():
            for first, last in islice(missing, _IN_FLIGHT - len(running)):
                future = executor.submit(text, first, last)
                future.add_done_callback(finished.put)
                running[future] = first, last
        if not running:
            return
        future = _next(finished, executor.check)
        with uninterrupted():
            first, last = running.pop(future)
            rows, part = _result(future, first, last), parts / part_name(first)
            if rows is not None:
                write_part(part, plan, rows)
            # Not by the processes, which would wait for the disk.
            keep(part)
        done += last - first


def _next(finished, check):
    while True:
        try:
            return finished.get(timeout=_CHECK_S)
        except Empty:
            check()


def _result(future, first, last):
    try:
        return future.result()
    except OSError:
        raise
    except futures.CancelledError:
        raise Failed('the scheduler was lost; the same command does the remaining runs') from None
    except Exception as error:
        cause = one_sentence(error) or type(error).__name__
        raise Failed(f'the runs {first} to {last - 1} could not be done: {cause}') from error


def _refuse_another(directory, plan):
    """Raise ValueError where a directory holds something else than the plan's sweep."""
    path = directory / 'sweep.json'
    if path.exists():
        if _written(path)[0] != json.loads(plan.to_text()):
            raise ValueError(f'{directory} holds another sweep; give a new directory')
    elif directory.exists() and any(directory.iterdir()):
        raise ValueError(f'{directory} holds no sweep and is not empty; give a new directory')


def _written(path):
    """Return the plan, and the versions, of a sweep.json; None: it is not one."""
    try:
        written = json.loads(regular_file(path).read_text())
        return written, written.pop('versions')
    except (ValueError, AttributeError, KeyError):
        return None, {}


def _occupy(directory, plan, used):
    """Claim the directory for a plan and versions; ValueError: it was begun with others."""
    path = directory / 'sweep.json'
    if path.exists():
        begun = _written(path)[1]
        differing = [f'{k} {begun.get(k)}, not {v}' for k, v in used.items() if begun.get(k) != v]
        if differing:
            raise ValueError(
                f'{directory} was begun with {", ".join(differing)}; continue with the same, or '
                'give a new directory'
            )
        return
    directory.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix('.partial')
    unfinished.write_text(json.dumps(json.loads(plan.to_text()) | {'versions': used}, indent=1))
    unfinished.replace(path)


def _record(plan, run, bags):
    """Record a run's bag, unless it is there."""
    name = f'run_{run:06d}'
    if (bags / name).exists():
        return
    unfinished = bags / 'partial'
    shutil.rmtree(unfinished, ignore_errors=True)
    unfinished.mkdir(parents=True)
    scenario = plan.scenario_of_run(run)
    own = plan.controller.new() if plan.controller else None
    for _ in simulate(scenario, plan.duration_s, unfinished / name, controller=own):
        pass
    (unfinished / name).rename(bags / name)
    unfinished.rmdir()

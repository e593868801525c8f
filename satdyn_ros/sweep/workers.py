"""
Who does the batches of a sweep: processes on this machine, or the workers of a dask cluster.

An executor has submit(text, first, last), which returns a future of the runs first to last - 1 of
the plan of a text, check(), which raises where no batch can finish any more, and versions.
"""

import logging
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent import futures
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.process import BaseProcess
from typing import Any

import numpy as np

from ..base.interruption import uninterrupted
from ..integrate.batch import propagate_all
from ..integrate.propagation import Propagation
from ..run.scenario import Scenario
from .versions import versions

_CONNECT_S = 5.0
# A cluster may need that long to start its first worker, or one in place of the last.
_WORKER_S = 30.0
# The workers of a cluster may differ from this machine in these, but not from each other.
_OF_THE_CLUSTER = ('processor', 'system')

# Those whose levels dask sets.
_LOGGERS = ('distributed', 'distributed.client', 'tornado')

_log = logging.getLogger(__name__)


class Failed(RuntimeError):  # noqa: N818 - it says what a sweep did
    """A sweep that cannot continue; its text is one sentence."""


# -- processes on this machine --------------------------------------------------------------------


class Processes:
    """Processes of this machine: work(text, first, last) is what one does with a batch."""

    def __init__(self, pool: futures.Executor, work: Callable[[str, int, int], Any]):
        self.versions = versions()
        self._pool, self._work = pool, work

    def submit(self, text: str, first: int, last: int) -> futures.Future[Any]:
        """Hand over a batch."""
        with _hidden_from_processes():
            return self._pool.submit(self._work, text, first, last)

    def check(self) -> None:
        """Do nothing: the futures themselves end with a pool that is broken."""


@contextmanager
def processes(count: int | None, work: Callable[[str, int, int], Any]) -> Iterator[Processes]:
    """Provide processes on this machine, None: one per core, that do the work of a batch."""
    # Compiled here, where an interruption is handled, for all processes.
    scenario = Scenario()
    propagate_all([Propagation(scenario.system, scenario.initial_state)], np.zeros(1))
    spawn, others = multiprocessing.get_context('spawn'), multiprocessing.active_children()
    with futures.ProcessPoolExecutor(count or os.cpu_count(), spawn, _follow_parent) as pool:
        try:
            yield Processes(pool, work)
        except BaseException:
            with uninterrupted():
                pool.shutdown(wait=False, cancel_futures=True)
                # Their current batches are done again: that is faster than waiting for them.
                for process in set(multiprocessing.active_children()).difference(others):
                    process.kill()
            raise


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


# -- the workers of a cluster ---------------------------------------------------------------------


class Cluster:
    """The workers of a dask scheduler; ValueError: their versions differ, or there are none."""

    def __init__(self, client: Any, address: str):
        # Before Python 3.11 it is not Python's own.
        from distributed import TimeoutError as OutOfTime

        self._client, self._address = client, address
        try:
            client.wait_for_workers(1, timeout=_WORKER_S)
        except OutOfTime:
            raise self._without_workers() from None
        self._last_worker_s = time.monotonic()
        find, _, _ = _functions({})
        found = {
            where: answer if isinstance(answer, dict) else {'satdyn_ros': f'({answer})'}
            for where, answer in sorted(client.run(find, on_error='return').items())
        }
        first = next(iter(found.values()), {})
        self.versions = versions() | {k: first[k] for k in _OF_THE_CLUSTER if k in first}
        _, difference, self._work = _functions(self.versions)
        for where, answer in found.items():
            if answer != self.versions:
                raise ValueError(difference(where, answer))
        self._pool = client.get_executor(pure=False)

    def submit(self, text: str, first: int, last: int) -> futures.Future[Any]:
        """Hand over a batch."""
        return self._pool.submit(self._work, text, first, last)

    def check(self) -> None:
        """Raise ValueError where all workers have been gone for a while."""
        if self._client.scheduler_info()['workers']:
            self._last_worker_s = time.monotonic()
        elif time.monotonic() - self._last_worker_s > _WORKER_S:
            raise self._without_workers()

    def _without_workers(self):
        return ValueError(
            f'--dask is {self._address}, a scheduler that has had no worker for {_WORKER_S:g} s; '
            'start workers, then give the same command again'
        )


@contextmanager
def cluster(address: str) -> Iterator[Cluster]:
    """
    Provide the workers of a dask scheduler, which return the tables of the batches.

    ValueError, one sentence: no scheduler answers, it has no worker for half a minute, or one has
    other versions.
    """
    from distributed import Client

    with _silent():
        try:
            client = Client(address, timeout=_CONNECT_S)
        except (OSError, ValueError) as error:
            raise ValueError(f'--dask is {address}, where no scheduler answers: {error}') from None
        try:
            yield Cluster(client, address)
        except KeyboardInterrupt:
            _log.info('interrupted: the same command does the runs that the cluster has not done')
            raise
        finally:
            with uninterrupted():
                # What it has not done yet is cancelled.
                client.close()


@contextmanager
def _silent():
    """Leave to the sentence at the end what dask would log of lost connections."""
    before = {name: logging.getLogger(name).level for name in _LOGGERS}
    try:
        for name in before:
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


def _functions(expected: Mapping[str, str]) -> tuple[Callable, Callable, Callable]:
    """
    Return what finds a worker's versions, says what differs from those expected, and does a batch.

    They are no module's, so they are sent as code: a worker without this package, or with another
    version of it, would not outlive a name that it cannot import.
    """

    def find():
        try:
            import satdyn_ros
        except ImportError as error:
            return {'satdyn_ros': f'({error})'}
        try:
            from satdyn_ros.sweep.versions import versions
        except ImportError as error:
            found = f'{satdyn_ros.__version__} of {satdyn_ros.__file__}'
            return {'satdyn_ros': f'{found} ({error})'}
        return versions()

    def difference(where, found):
        differing = [
            f'{name} {found[name]}, not {value}'
            for name, value in expected.items()
            if name in found and found[name] != value
        ]
        return (
            f'the worker {where} has {", ".join(differing)}; all must have the same versions: end '
            'this one, then give the same command again'
        )

    def do(text, first, last):
        found = find()
        if found != expected:
            from distributed import get_worker

            raise ValueError(difference(get_worker().address, found))
        from satdyn_ros.sweep.batches import batch

        return batch(text, first, last)

    return find, difference, do

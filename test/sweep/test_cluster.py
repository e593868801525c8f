"""A sweep on a dask cluster, whose processes are real, ends with its table or one sentence."""

import json
import re
import shutil
import signal
import socket
import subprocess
import sys

import pytest

from satdyn_ros.sweep import workers
from satdyn_ros.sweep.run import sweep
from satdyn_ros.sweep.versions import versions

from .sweeps import ENVIRONMENT, MANY, ROOT, start, wait_for_parts, write

pytestmark = pytest.mark.long
CONTROLLER = """
import numpy as np


class Spinner:
    vectorized = True

    def command(self, sample):
        return {'torque_b': 1e-3 * np.sin(0.1 * sample.t_s)[..., None] * np.ones(3)}
"""
ENDLESS = MANY | {'runs': 10_000}


class Dask:
    """A dask scheduler; both it and its workers are processes of their own."""

    def __init__(self, folder):
        with socket.socket() as probe:
            probe.bind(('127.0.0.1', 0))
            self.address = f'tcp://127.0.0.1:{probe.getsockname()[1]}'
        self.folder, self.processes = folder, []
        self.scheduler = self._start('scheduler', '--host', self.address)

    def start_workers(self, count, imported_from=ROOT):
        """Start workers that have the package from a folder."""
        arguments = (self.address, '--no-nanny', '--nthreads', '1')
        return [self._start('worker', *arguments, path=imported_from) for _ in range(count)]

    def wait_for_workers(self, count):
        """Wait until so many workers are registered."""
        from distributed import Client

        with Client(self.address, timeout=60) as client:
            client.wait_for_workers(count, timeout=60)

    def _start(self, kind, *arguments, path=ROOT):
        command = [sys.executable, '-m', f'distributed.cli.dask_{kind}', *arguments]
        with (self.folder / 'dask.log').open('a') as log:
            process = subprocess.Popen(
                [*command, '--no-dashboard'],
                stdout=log,
                stderr=log,
                cwd=self.folder,
                env=ENVIRONMENT | {'PYTHONPATH': str(path)},
            )
        self.processes.append(process)
        return process


@pytest.fixture
def dask(tmp_path):
    """Start a scheduler without workers; end it, and those that were started, after the test."""
    dask = Dask(tmp_path)
    yield dask
    for process in reversed(dask.processes):
        process.kill()
        process.wait()


@pytest.fixture
def other_version(tmp_path):
    """Return a folder with another version of the package."""
    copy = tmp_path / 'other' / 'satdyn_ros'
    shutil.copytree(ROOT / 'satdyn_ros', copy, ignore=shutil.ignore_patterns('__pycache__'))
    front = copy / '__init__.py'
    front.write_text(re.sub("__version__ = '.*'", "__version__ = '9.9'", front.read_text()))
    return copy.parent


def without(folder, module, error):
    """Return a folder where a module cannot be imported."""
    folder.mkdir()
    (folder / f'{module}.py').write_text(error)
    return folder


def sentence_of(process):
    """Return the one line that a command writes when it ends, and its exit code."""
    _, stderr = process.communicate(timeout=120)
    (line,) = stderr.splitlines()
    return line, process.returncode


def test_no_scheduler(tmp_path):
    """An address where nothing listens is reported in one sentence."""
    with pytest.raises(ValueError, match=r'--dask is tcp://127\.0\.0\.1:1, where no') as raised:
        sweep(write(tmp_path), tmp_path / 'out', dask_address='tcp://127.0.0.1:1')
    assert '\n' not in str(raised.value)


def test_no_worker(tmp_path, dask, monkeypatch):
    """A scheduler to which no worker comes is given up."""
    monkeypatch.setattr(workers, '_WORKER_S', 1.0)
    with pytest.raises(ValueError, match=f'{dask.address}, .* no worker for 1 s'):
        sweep(write(tmp_path), tmp_path / 'out', dask_address=dask.address)
    assert not (tmp_path / 'out').exists()


def test_loses_a_worker(many, tmp_path, dask):
    """Over TCP, with one of two workers killed midway, the table is complete and the same."""
    path, expected = many
    first, _ = dask.start_workers(2)
    dask.wait_for_workers(2)
    directory = tmp_path / 'cluster'
    process = start(path, directory, '--dask', dask.address)
    wait_for_parts(directory, 8)
    first.kill()
    assert not (directory / 'table.parquet').exists()
    _, stderr = process.communicate(timeout=100)
    assert process.returncode == 0, stderr
    assert (directory / 'table.parquet').read_bytes() == expected


def test_loses_all_workers(tmp_path, dask, monkeypatch):
    """When the last worker is lost and none comes in its place, the sweep ends and says so."""
    monkeypatch.setattr(workers, '_WORKER_S', 1.0)
    (worker,) = dask.start_workers(1)
    dask.wait_for_workers(1)
    with pytest.raises(ValueError, match='no worker for 1 s'):
        sweep(
            write(tmp_path, **ENDLESS),
            tmp_path / 'out',
            dask_address=dask.address,
            show=lambda done, total: done and worker.kill(),
        )


def test_loses_the_scheduler(tmp_path, dask):
    """The end of the scheduler ends the sweep."""
    dask.start_workers(1)
    process = start(write(tmp_path, **ENDLESS), tmp_path / 'out', '--dask', dask.address)
    wait_for_parts(tmp_path / 'out', 1)
    dask.scheduler.kill()
    assert sentence_of(process) == (
        'satdyn sweep: the scheduler was lost; the same command does the remaining runs',
        1,
    )


def test_a_worker_without_the_package(tmp_path, dask):
    """It is named, with what it lacks, and is not lost by being asked."""
    error = 'raise ModuleNotFoundError("No module named \'satdyn_ros\'")'
    bare = without(tmp_path / 'bare', 'satdyn_ros', error)
    (worker,) = dask.start_workers(1, bare)
    process = start(write(tmp_path), tmp_path / 'out', '--dask', dask.address)
    line, code = sentence_of(process)
    assert re.search(r"the worker tcp://\S+ has satdyn_ros \(No module named 'satdyn_ros'\)", line)
    assert code == 2
    assert worker.poll() is None


def test_a_worker_of_another_version(tmp_path, dask, other_version):
    """It is named, with what differs, before anything is done."""
    dask.start_workers(1)
    dask.start_workers(1, other_version)
    dask.wait_for_workers(2)
    process = start(write(tmp_path), tmp_path / 'out', '--dask', dask.address)
    line, code = sentence_of(process)
    assert re.search(r'the worker tcp://\S+ has .*satdyn_ros 9\.9, not \d', line)
    assert re.search(r'sources \w{12}, not \w{12}; all must have the same', line)
    assert 'numba' not in line
    assert code == 2
    assert not (tmp_path / 'out').exists()


def test_a_worker_of_another_version_that_joins(tmp_path, dask, other_version):
    """It does no run: the sweep ends with the same sentence, which says how to go on."""
    dask.start_workers(1)
    directory = tmp_path / 'out'
    process = start(write(tmp_path, **ENDLESS), directory, '--dask', dask.address)
    wait_for_parts(directory, 1)
    written = json.loads((directory / 'sweep.json').read_text())
    assert written['versions'] == versions()
    dask.start_workers(1, other_version)
    line, code = sentence_of(process)
    assert re.search(r'the worker tcp://\S+ has .*satdyn_ros 9\.9, not \d', line)
    assert line.endswith(': end this one, then give the same command again')
    assert code == 1


def test_the_error_of_a_worker(tmp_path, dask):
    """What a worker says is passed on, however long, in one line."""
    error = 'raise ImportError("no room for it\\n" * 100)'
    dask.start_workers(1, without(tmp_path / 'full', 'pyarrow', error))
    (tmp_path / 'full' / 'satdyn_ros').symlink_to(ROOT / 'satdyn_ros')
    process = start(write(tmp_path), tmp_path / 'out', '--dask', dask.address)
    line, code = sentence_of(process)
    assert 'could not be done: no room for it no room' in line
    assert len(line) < 600
    assert code == 1


def test_ctrl_c(tmp_path, dask):
    """It ends the sweep in one sentence, and the finished runs stay."""
    dask.start_workers(1)
    directory = tmp_path / 'out'
    process = start(write(tmp_path, **ENDLESS), directory, '--dask', dask.address)
    wait_for_parts(directory, 1)
    process.send_signal(signal.SIGINT)
    line, code = sentence_of(process)
    assert line.startswith('interrupted: the same command')
    assert code == 130
    assert list(directory.glob('parts/*.parquet'))


def test_a_controller_flies_there_as_here(dask, tmp_path):
    """The workers find its file, wherever they run."""
    (tmp_path / 'spinner.py').write_text(CONTROLLER)
    path = write(tmp_path, controller='spinner.py:Spinner', duration_s=1000.0)
    dask.start_workers(2)
    there = sweep(path, tmp_path / 'there', dask_address=dask.address)
    here = sweep(path, tmp_path / 'here', workers=1)
    assert there.read_bytes() == here.read_bytes()

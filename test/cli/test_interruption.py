"""Signals end a command at once and cleanly; a failing standard output loses no work."""

import os
import shutil
import signal
import subprocess
import sys
import time
from itertools import cycle
from pathlib import Path
from random import Random

import pytest
import yaml

from satdyn_ros.bag.verify import verify

ROOT = Path(__file__).parents[2]
DEFAULT = ROOT / 'config/default.yaml'
# The command, with Ctrl-C when its main thread has just taken the lock of a future.
CTRL_C_AT_A_LOCK = """
import signal, sys, threading
from satdyn_ros.cli.main import main

def enter(condition):
    entered = plain(condition)
    caller = sys._getframe(1).f_globals['__name__']
    if threading.get_ident() == here and caller == 'concurrent.futures._base':
        threading.Condition.__enter__ = plain
        signal.raise_signal(signal.SIGINT)
    return entered

here, plain = threading.get_ident(), threading.Condition.__enter__
threading.Condition.__enter__ = enter
sys.exit(main(sys.argv[1:]))
"""
# The command, with Ctrl-C when a result of a compiled function becomes a Python object.
CTRL_C_AT_A_RESULT = """
import signal, sys
from numba.core import serialize
from satdyn_ros.cli.main import main

def unpickle(*arguments):
    signal.raise_signal(signal.SIGINT)
    return plain(*arguments)

plain, serialize._numba_unpickle = serialize._numba_unpickle, unpickle
sys.exit(main(sys.argv[1:]))
"""
# The command, with Ctrl-C when its arguments have been read.
CTRL_C_AT_THE_START = """
import signal, sys
import satdyn_ros.cli.main as command

command.show_notices = lambda: signal.raise_signal(signal.SIGINT)
sys.exit(command.main(sys.argv[1:]))
"""
# The command, which says when it begins; what comes before and after is Python's own.
COMMAND = """
import signal, sys
from satdyn_ros.base.interruption import interruptible
from satdyn_ros.cli.main import main

signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
with interruptible():
    print('begun', flush=True)
    code = main(sys.argv[1:])
sys.exit(code)
"""
# A rate whose steps are so small that one block of ticks takes minutes.
STIFF = {'orbit': {'type': 'fixed'}, 'initial': {'angular_velocity': [1e4, 1e3, 0.0]}}


def start(*arguments, program=('-m', 'satdyn_ros.cli.main'), **options):
    """Start the command in a process group of its own, as a terminal does."""
    return subprocess.Popen(
        [sys.executable, *program, *map(str, arguments)],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        **options,
    )


def wait_for(process, condition):
    """Wait until a condition holds; a process that ends before fails the test."""
    while not condition():
        assert process.poll() is None, process.communicate()[1]
        time.sleep(0.01)


@pytest.fixture(scope='module', autouse=True)
def _compiled(tmp_path_factory):
    """Compile ahead, which says so on stderr, where the tests expect silence."""
    directory = tmp_path_factory.mktemp('compiled')
    path = directory / 'sweep.yaml'
    path.write_text(
        f'{{scenario: {DEFAULT}, duration_s: 100.0, runs: 64, vary: {{initial.attitude: sphere}}}}'
    )
    start('sweep', path, '-o', directory / 'sweep').communicate()
    start('simulate', DEFAULT, '--duration', '1', '-o', directory / 'bag').communicate()


@pytest.mark.long
@pytest.mark.parametrize(('number', 'code'), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_stiff_run_is_interrupted_in_the_midst_of_a_block(tmp_path, number, code):
    """It ends without a traceback and leaves a bag that can be verified."""
    scenario, bag = tmp_path / 'stiff.yaml', tmp_path / 'bag'
    scenario.write_text(yaml.safe_dump({'/**': {'ros__parameters': STIFF}}))
    process = start('simulate', scenario, '--duration', '1e6', '-o', bag)
    wait_for(process, (bag / 'bag_0.mcap').exists)
    process.send_signal(number)
    _, errors = process.communicate()
    assert (process.returncode, 'Traceback' in errors) == (code, False)
    assert verify(bag).is_true


@pytest.fixture
def long_sweep(tmp_path):
    """Return the path of a sweep of more batches than a test waits for."""
    pytest.importorskip('pyarrow')
    path = tmp_path / 'sweep.yaml'
    path.write_text(
        f'{{scenario: {DEFAULT}, duration_s: 1.0e+5, runs: 5000, vary: '
        '{initial.attitude: sphere}}'
    )
    return path


@pytest.mark.parametrize('parts', [0, pytest.param(1, marks=pytest.mark.long)])
def test_a_sweep_ends_with_its_processes_and_says_nothing(long_sweep, tmp_path, parts):
    """Ctrl-C, which a terminal sends to all processes, at the start and in the midst."""
    directory = tmp_path / 'sweep'
    process = start('sweep', long_sweep, '-o', directory)
    wait_for(process, (directory / 'parts').exists)
    wait_for(process, lambda: len(list((directory / 'parts').glob('*.parquet'))) >= parts)
    os.killpg(process.pid, signal.SIGINT)
    # The workers hold stderr open: it ends when they have ended too.
    _, errors = process.communicate()
    assert (process.returncode, errors) == (130, '')


@pytest.mark.long
def test_a_sweep_ends_where_an_interruption_would_leave_a_lock_taken(long_sweep, tmp_path):
    """The executor's thread takes the locks of its futures too, and is awaited at the end."""
    program = ('-c', CTRL_C_AT_A_LOCK)
    process = start('sweep', long_sweep, '-o', tmp_path / 'sweep', program=program)
    _, errors = process.communicate()
    assert (process.returncode, errors) == (130, '')


@pytest.mark.long
def test_an_export_ends_where_an_interruption_would_leave_a_lock_taken(tmp_path):
    """So does the thread that reads ahead; no part of a file is left."""
    pytest.importorskip('polars')
    bag = tmp_path / 'bag'
    start('simulate', DEFAULT, '--duration', '1', '-o', bag).communicate()
    process = start('export', bag, '-o', tmp_path / 'table.csv', program=('-c', CTRL_C_AT_A_LOCK))
    _, errors = process.communicate()
    assert (process.returncode, errors) == (130, '')
    assert [path.name for path in tmp_path.iterdir()] == ['bag']


@pytest.mark.long
def test_an_interruption_within_a_call_of_compiled_code_is_no_error(tmp_path):
    """It arrives as a SystemError, since the call returns a result and an exception."""
    bag = tmp_path / 'bag'
    # A closed form: what else numba compiled is not called by runs.
    start('simulate', 'config/balli_grioli.yaml', '--duration', '1', '-o', bag).communicate()
    process = start('verify', bag, program=('-c', CTRL_C_AT_A_RESULT))
    _, errors = process.communicate()
    assert (process.returncode, errors) == (130, '')


def test_ctrl_c_at_the_start_is_the_normal_end_of_watch_too():
    """Exit code 0, as of a node beside it, which launch interrupts at the same time."""
    process = start('watch', 'bag', program=('-c', CTRL_C_AT_THE_START))
    _, errors = process.communicate()
    assert (process.returncode, errors) == (0, '')


@pytest.fixture
def commands(long_sweep, tmp_path):
    """Return commands of all kinds, with {} where the path of an output begins."""
    bag, torn = tmp_path / 'bag', tmp_path / 'torn'
    start('simulate', DEFAULT, '--duration', '5e3', '-o', bag).communicate()
    shutil.copytree(bag, torn)
    file = torn / 'bag_0.mcap'
    os.truncate(file, file.stat().st_size // 2)
    return [
        ['simulate', DEFAULT, '--duration', '1e5', '-o', '{}'],
        ['verify', bag],
        ['sweep', long_sweep, '-o', '{}'],
        ['export', bag, '-o', '{}.csv'],
        ['recover', torn, '-o', '{}'],
        ['export', bag, '-o', '{}.parquet'],
        ['export', bag, '-o', '{}.aem'],
        ['report', bag, '-o', '{}.html'],
        ['plot', bag, '-o', '{}.png'],
    ]


@pytest.mark.long
@pytest.mark.parametrize('count', [4, pytest.param(200, marks=pytest.mark.torture)])
def test_commands_end_cleanly_at_whatever_instant_they_are_interrupted(commands, count, tmp_path):
    """By Ctrl-C or SIGTERM, or they were done; all their processes end, without a traceback."""
    random = Random(count)
    for number, command in zip(range(count), cycle(commands), strict=False):
        arguments = [str(each).format(tmp_path / f'out_{number}') for each in command]
        process = start(*arguments, program=('-c', COMMAND), stdout=subprocess.PIPE)
        assert process.stdout.readline() == 'begun\n'
        time.sleep(random.uniform(0.0, 2.0))
        kind, code = random.choice([(signal.SIGINT, 130), (signal.SIGTERM, 143)])
        if kind == signal.SIGINT:
            os.killpg(process.pid, kind)
        else:
            process.send_signal(kind)
        _, errors = process.communicate()
        assert process.returncode in (0, code), f'{command}: {errors}'
        assert 'Traceback' not in errors
    print(f'{count} commands interrupted')


def test_an_output_that_fails_does_not_change_what_was_done(tmp_path):
    """On a full disk the bag elsewhere is complete, the code is 0 and stderr says what is lost."""
    bag = tmp_path / 'bag'
    with open('/dev/full', 'w') as full:
        process = start('simulate', DEFAULT, '--duration', '1', '-o', bag, stdout=full)
        _, errors = process.communicate()
    assert (process.returncode, errors) == (
        0,
        'satdyn simulate: the command completed, but its output could not be written: '
        'No space left on device\n',
    )
    assert verify(bag).is_true

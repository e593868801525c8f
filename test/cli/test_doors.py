"""What has no end, or is no file, is refused wherever a command reads: none waits for it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from satdyn_ros.cli.main import main

ROOT = Path(__file__).parents[2]
DEFAULT = str(ROOT / 'config/default.yaml')
# All commands in one process, each with its exit code and what it says on stderr.
PROGRAM = """
import contextlib, io, json, sys
from satdyn_ros.cli.main import main
for arguments in json.loads(sys.argv[1]):
    with contextlib.redirect_stderr(io.StringIO()) as said:
        code = main(arguments)
    print(json.dumps([code, said.getvalue()]), flush=True)
"""


def fifo(path):
    """Make a FIFO to which nobody writes."""
    os.mkfifo(path)
    return str(path)


def device(path):
    """Make a link to a device that never ends."""
    path.symlink_to('/dev/zero')
    return str(path)


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of one second."""
    directory = tmp_path_factory.mktemp('doors') / 'bag'
    assert main(['simulate', DEFAULT, '--duration', '1', '-o', str(directory)]) == 0
    return directory


@pytest.mark.parametrize(
    ('make', 'reason'),
    [
        (fifo, 'it is a FIFO, not a file'),
        pytest.param(device, 'it is a device, not a file', marks=pytest.mark.long),
    ],
)
def test_every_path_that_a_command_reads(bag, tmp_path, make, reason):
    """Exit code 2 and one sentence, at once, of each command and each kind of file."""
    pytest.importorskip('pyarrow')
    name, aem = make(tmp_path / 'it'), make(tmp_path / 'it.aem')
    simulate = ['--duration', '1', '-o', str(tmp_path / 'none')]
    commands = [
        ['simulate', name, *simulate],
        ['simulate', DEFAULT, '--events', name, *simulate],
        ['simulate', DEFAULT, '--from', name, '--at', '0', *simulate],
        ['simulate', DEFAULT, '--from', aem, '--at', '2000-01-01T00:00:00', *simulate],
        ['describe', name],
        ['check', name, '--duration', '1'],
        ['sweep', name, '-o', str(tmp_path / 'none')],
        ['node', '--params-file', name],
        ['node', '--ros-args', '--params-file', name],
    ]
    commands += [[reader, name] for reader in ('verify', 'recover', 'replay', 'watch')]
    outputs = {'export': 'x.csv', 'plot': 'x.png', 'report': 'x.html'}
    commands += [[reader, name, '-o', str(tmp_path / out)] for reader, out in outputs.items()]
    # In a bag: a file of it, listed or not, and its metadata.yaml.
    parts = [
        ('bag_0.mcap', 'metadata.yaml'),
        ('bag_0.mcap', None),
        ('metadata.yaml', 'bag_0.mcap'),
    ]
    for number, (gone, kept) in enumerate(parts):
        directory = tmp_path / f'bag{number}'
        directory.mkdir()
        make(directory / gone)
        if kept:
            shutil.copy(bag / kept, directory / kept)
        commands += [['verify', str(directory)], ['recover', str(directory)]]
        commands.append(['export', str(directory), '-o', str(tmp_path / 'x.csv')])
    # Of a sweep: its scenario, its table, and what its directory holds.
    scenario = tmp_path / 'sweep.yaml'
    vary = {'orbit.raan': {'values': [0.0]}}
    scenario.write_text(yaml.safe_dump({'scenario': name, 'vary': vary, 'duration_s': 10.0}))
    commands.append(['sweep', str(scenario), '-o', str(tmp_path / 'none')])
    sound = tmp_path / 'sound.yaml'
    sound.write_text(yaml.safe_dump({'scenario': DEFAULT, 'vary': vary, 'duration_s': 10.0}))
    occupied, drawn = tmp_path / 'occupied', tmp_path / 'drawn'
    occupied.mkdir()
    make(occupied / 'sweep.json')
    commands.append(['sweep', str(sound), '-o', str(occupied)])
    drawn.mkdir()
    (drawn / 'sweep.json').touch()
    make(drawn / 'table.parquet')
    commands.append(['plot', str(drawn), '-o', str(tmp_path / 'x.png')])
    # A command that waits for ever ends the test with what the others said.
    process = subprocess.run(
        [sys.executable, '-c', PROGRAM, json.dumps(commands)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
    )
    answers = [json.loads(line) for line in process.stdout.splitlines()]
    assert len(answers) == len(commands), process.stderr
    for command, (code, said) in zip(commands, answers, strict=True):
        assert code == 2, (command, said)
        assert said.count('\n') == 1, (command, said)
        assert reason in said, (command, said)


def test_recover_of_an_empty_file_or_device(tmp_path, capsys):
    """What holds nothing is not a bag, and stays as it is."""
    empty, link = tmp_path / 'empty.mcap', tmp_path / 'link.mcap'
    empty.touch()
    link.symlink_to('/dev/null')
    assert main(['recover', str(empty)]) == 2
    assert capsys.readouterr().err.endswith('empty.mcap is not a bag: it is empty\n')
    assert main(['recover', str(link)]) == 2
    assert 'link.mcap is not a bag: it is a device' in capsys.readouterr().err
    assert main(['recover', str(tmp_path)]) == 2
    assert 'link.mcap is not a file of a bag: it is a device' in capsys.readouterr().err
    assert sorted(file.name for file in tmp_path.iterdir()) == ['empty.mcap', 'link.mcap']
    assert link.is_symlink()

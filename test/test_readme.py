"""The README says what the code does: its tables, commands and examples."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from satdyn_ros.cli.arguments import parser
from satdyn_ros.run import events
from satdyn_ros.run.scenario import Scenario
from scripts.write_tables import DOCUMENTS, with_tables

ROOT = Path(__file__).parents[1]
README = (ROOT / 'README.md').read_text(encoding='utf-8')


def blocks(language):
    """Return the fenced blocks of a language."""
    return re.findall(f'```{language}\n(.*?)```', README, re.DOTALL)


def test_tables_are_those_of_the_declarations():
    """Topics, parameters and the keys of sweeps are documented as they are declared."""
    for document in DOCUMENTS:
        text = document.read_text(encoding='utf-8')
        assert with_tables(text) == text
    assert README.count('| `body.inertia` |') == 1
    assert README.count('| `attitude` |') == 1


def test_services_are_those_with_examples():
    """Each service that has an example, which a test sends to a node, is in the table."""
    told = re.findall(r'^\| `~/(\w+)` \|', README, re.MULTILINE)
    assert sorted(told) == sorted(path.stem for path in ROOT.glob('msg_examples/services/*'))


def test_the_two_commands_come_first():
    """Who opens the README sees what it is and what to type; make knows both."""
    head = README.split('\n## ')[0]
    assert re.findall(r'^    make (\w+)', head, re.MULTILINE) == ['demo', 'test']
    makefile = (ROOT / 'Makefile').read_text()
    assert {'demo', 'test'} <= set(re.findall(r'^(\w+):', makefile, re.MULTILINE))


def test_commands_are_those_of_theparser():
    """Every command is in the table, and every example line is one that the parser takes."""
    told = re.findall(r'^\| `satdyn (\w+)` \|', README, re.MULTILINE)
    (commands,) = parser()._subparsers._group_actions
    assert told == list(commands.choices)
    lines = re.findall(r'^    satdyn (.*)', README, re.MULTILINE)
    assert lines
    for line in lines:
        parser().parse_args(shlex.split(line))


@pytest.mark.parametrize('example', blocks('python'))
def test_examples_run(example):
    """Each example in Python runs as it stands."""
    environment = os.environ | {'PYTHONPATH': str(ROOT)}
    subprocess.run([sys.executable, '-c', example], cwd=ROOT, env=environment, check=True)


def test_the_events_are_read():
    """The example of an events file is one."""
    (text,) = blocks('yaml')
    assert len(events.from_yaml_text(text, Scenario())) == 3


def test_files_are_there():
    """What the README names is in the project."""
    named = re.findall(r'`((?:config|docs|test|msg_examples)/[\w./]*)`', README)
    assert named
    assert [name for name in named if not (ROOT / name).exists()] == []

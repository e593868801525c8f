"""README and documentation say what the code does: tables, commands, examples and links."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from satdyn_ros.cli.arguments import parser
from satdyn_ros.run import events
from satdyn_ros.run.keys import KEYS
from satdyn_ros.run.scenario import Scenario
from scripts.write_tables import DOCUMENTS, with_tables

ROOT = Path(__file__).parents[1]
README = ROOT / 'README.md'
PAGES = [README, ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').rglob('*.md'))]
# The tutorial has a test of its own, in which each step stands on the one before.
RUN = [page for page in PAGES if page.name != 'tutorial.md']
# Where the commands of the pages write; here each page gets a folder of its own.
SCRATCH = '/tmp/satdyn_docs'


def blocks(page, language):
    """Return the fenced blocks of a language on a page."""
    return re.findall(rf'^```{language}\n(.*?)^```', page.read_text(encoding='utf-8'), re.M | re.S)


def examples(language):
    """Return the blocks of a language on all pages, each with an id that names its page."""
    return [
        pytest.param(text, id=f'{page.stem} {number}')
        for page in RUN
        for number, text in enumerate(blocks(page, language), 1)
    ]


def environment():
    path = f'{Path(sys.executable).parent}:{os.environ["PATH"]}'
    return os.environ | {'PYTHONPATH': str(ROOT), 'PATH': path}


def test_tables_are_those_of_the_declarations():
    """Topics, parameters, commands and the keys of sweeps are documented as they are declared."""
    for document in DOCUMENTS:
        text = document.read_text(encoding='utf-8')
        assert with_tables(text) == text, f'{document}: python scripts/write_tables.py'
    parameters = (ROOT / 'docs/reference/parameters.md').read_text(encoding='utf-8')
    assert all(parameters.count(f'| `{name}` |') == 1 for name in KEYS)


def test_services_are_those_with_examples():
    """Each service that has an example, which a test sends to a node, is in the table."""
    text = (ROOT / 'docs/reference/topics.md').read_text(encoding='utf-8')
    told = re.findall(r'^\| `~/(\w+)` \|', text, re.MULTILINE)
    assert sorted(told) == sorted(path.stem for path in ROOT.glob('msg_examples/services/*'))


def test_the_readme_is_short_and_the_two_commands_come_first():
    """The README is short, and make knows the targets that it names."""
    lines = README.read_text(encoding='utf-8').splitlines()
    assert len(lines) <= 120
    assert max(map(len, lines)) <= 120
    head = README.read_text(encoding='utf-8').split('\n## ')[0]
    assert re.findall(r'^    make (\w+)', head, re.MULTILINE) == ['demo', 'test']


@pytest.mark.parametrize('page', PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_are_ones_that_exist(page):
    """The parser takes each line that begins with satdyn, and make knows each target."""
    text = page.read_text(encoding='utf-8')
    for line in re.findall(r'^    satdyn (.*)', text, re.MULTILINE):
        parser().parse_args(shlex.split(line))
    makefile = (ROOT / 'Makefile').read_text()
    told = set(re.findall(r'^    make (\w+)', text, re.M)) | set(re.findall(r'`make (\w+)`', text))
    assert told <= set(re.findall(r'^(\w+):', makefile, re.MULTILINE))


@pytest.mark.parametrize('page', PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_is_named_is_there(page):
    """Files that a page names are in the project, and its links lead somewhere."""
    text = page.read_text(encoding='utf-8')
    named = re.findall(r'`((?:config|docs|test|msg_examples|examples)/[\w./]*)`', text)
    named = [ROOT / name for name in named]
    linked = re.findall(r'\]\((?!http)([^)#]+)', text)
    named += [page.parent / link for link in linked if not link.endswith('.rst')]
    assert [str(path) for path in named if not path.exists()] == []


@pytest.mark.parametrize('example', examples('python'))
def test_examples_in_python_run(example):
    """Each example in Python runs as it stands."""
    if 'rclpy' in example:
        pytest.importorskip('rclpy')
    done = subprocess.run(
        [sys.executable, '-c', example],
        cwd=ROOT,
        env=environment(),
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    'page', [page for page in RUN if blocks(page, 'sh')], ids=lambda page: page.stem
)
def test_commands_run(page, tmp_path):
    """The commands of a page, in their order, each with exit code 0."""
    for line in ''.join(blocks(page, 'sh')).replace(SCRATCH, str(tmp_path)).splitlines():
        done = subprocess.run(
            shlex.split(line), cwd=ROOT, env=environment(), capture_output=True, text=True
        )
        assert done.returncode == 0, f'{line}\n{done.stderr}'


@pytest.mark.parametrize('text', examples('yaml'))
def test_examples_in_yaml_are_read(text):
    """A list is one of events, a map a scenario or a sweep."""
    content = yaml.safe_load(text)
    if isinstance(content, list):
        assert events.from_yaml_text(text, Scenario())
    elif '/**' in content:
        Scenario.from_yaml_text(text)
    else:
        assert {'scenario', 'duration'} & set(content) or 'vary' in content

"""README and documentation say what the code does: tables, commands, examples and links."""

import re
import shlex
from pathlib import Path

import pytest
import yaml

from satdyn_ros.cli.command_line import parser
from satdyn_ros.run import events
from satdyn_ros.run.keys import KEYS
from satdyn_ros.run.scenario import Scenario
from scripts.run_pages import Block, blocks, pages
from scripts.write_tables import DOCUMENTS, with_tables

ROOT = Path(__file__).parents[1]
README = ROOT / 'README.md'
PAGES = pages(ROOT)
COMMAND = re.compile(r'^    (?:(?:satdyn|make|pip|python3?|ros2|colcon|git) |\.).*', re.MULTILINE)

each_page = pytest.mark.parametrize('page', PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def of_language(page: Path, language: str) -> list[Block]:
    """Return the blocks of a language on a page."""
    return [block for block in blocks(page, ROOT) if block.language == language]


def commands(block: Block) -> list[str]:
    """Return the commands of a block without the comments behind them."""
    return [line.split(' #')[0].strip() for line in block.lines]


def test_tables_are_those_of_the_declarations():
    """Topics, parameters, commands and the keys of sweeps are documented as they are declared."""
    for document in DOCUMENTS:
        text = document.read_text(encoding='utf-8')
        assert with_tables(text) == text, f'{document}: python scripts/write_tables.py'


def entries() -> dict[str, str]:
    """Return what the page of parameters says of each key, by its name."""
    parameters = (ROOT / 'docs/reference/parameters.md').read_text(encoding='utf-8')
    found = re.findall(r'^#### `([\w.]+)`\n\n(.+\\\n.+)\n\n', parameters, re.MULTILINE)
    assert len({name for name, _ in found}) == len(found) == parameters.count('\n#### ')
    return dict(found)


def test_every_key_has_an_entry():
    """A sensor's by its type, or with NAME for all types; a named plate's and rotor's too."""
    told = entries()
    named = Scenario({'surface.names': ['NAME'], 'rotor.names': ['NAME']}).keys
    for name, key in {**KEYS, **named}.items():
        of_any_type = re.sub(r'^sensors\.\w+\.', 'sensors.NAME.', name)
        says = told.get(name) or told.get(of_any_type)
        if says:
            assert key.meaning in says
        else:
            assert f'also `{name}`' in told[name.replace('.NAME.', '.')]


def test_services_are_those_with_examples():
    """Each service that has an example, which a test sends to a node, is in the table."""
    text = (ROOT / 'docs/reference/topics.md').read_text(encoding='utf-8')
    told = re.findall(r'^\| `~/(\w+)`<br>', text, re.MULTILINE)
    assert sorted(told) == sorted(path.stem for path in ROOT.glob('msg_examples/services/*'))


def test_the_readme_is_short_and_the_two_commands_come_first():
    """It takes two screens, and begins with what shows and proves the package."""
    lines = README.read_text(encoding='utf-8').splitlines()
    assert len(lines) <= 115
    assert max(map(len, lines)) <= 120
    assert commands(blocks(README, ROOT)[0]) == ['make demo', 'make test']


def test_the_front_page_says_what_each_page_is_for():
    """In a line, in the order of the lists beside it, which make docs wants to be complete."""
    text = (ROOT / 'docs/index.md').read_text(encoding='utf-8')
    lines = re.findall(r'^- \[[^]]+\]\(([\w/-]+)\.\w+\): .+\.$', text, re.MULTILINE)
    listed = re.findall(r'^[\w-]+(?:/[\w-]+)*$', text.partition('```{toctree}')[2], re.MULTILINE)
    assert len(lines) > 30
    assert lines == listed


@each_page
def test_commands_are_ones_that_exist(page):
    """The parser takes each command of a page, whether it is run or not; make has each target."""
    told = re.findall(r'`make ([\w-]+)', page.read_text(encoding='utf-8'))
    for block in of_language(page, 'sh'):
        for line in block.lines:
            if line.startswith('satdyn '):
                parser().parse_args(shlex.split(line, comments=True)[1:])
        told += re.findall(r'^make ([\w-]+)', block.text, re.MULTILINE)
    targets = re.findall(r'^([\w -]+):', (ROOT / 'Makefile').read_text(), re.MULTILINE)
    assert set(told) <= set(' '.join(targets).split())


@each_page
def test_commands_are_in_blocks_that_are_run(page):
    """None stands indented, where make pages would not see it."""
    text = re.sub(r'^```.*?^```$', '', page.read_text(encoding='utf-8'), flags=re.M | re.S)
    assert COMMAND.findall(text) == []


@each_page
def test_the_ci_makes_what_a_page_makes(page):
    """A target that make pages leaves to .ci/run is there."""
    made = (ROOT / '.ci/run').read_text().splitlines()
    for block in of_language(page, 'sh'):
        if not block.words:
            lines = [line for line in commands(block) if line.startswith('make ')]
            assert set(lines) <= {*made, 'make clean'}


def test_the_ci_runs_the_pages():
    """What the pages tell is run before a change lands."""
    assert 'make pages' in (ROOT / '.ci/run').read_text().splitlines()


def test_every_folder_of_tests_is_in_one_of_the_longer_proofs():
    """No long test is left out by all parts, or run by two."""
    makefile = (ROOT / 'Makefile').read_text().replace('\\\n', ' ')
    parts = re.findall(r'^LONG_TESTS_\d := (.*)$', makefile, re.MULTILINE)
    dealt = [path for part in parts for word in part.split() for path in ROOT.glob(word)]
    tests = [
        *ROOT.glob('test/test_*.py'),
        *{path.parent for path in ROOT.glob('test/*/test_*.py')},
    ]
    assert sorted(dealt) == sorted(tests)
    assert len(parts) == 4, 'the first part is make oldest'


def test_every_example_is_run():
    """By a page, by another example that imports it or, the demo, by make demo."""
    lines = [
        line
        for page in PAGES
        for block in of_language(page, 'sh')
        if 'long' not in block.words
        for line in block.lines
    ]
    lines += re.findall(r'^demo:.*\n(.*)', (ROOT / 'Makefile').read_text(), re.MULTILINE)
    examples = sorted((ROOT / 'examples').glob('*.py'))
    imported = re.findall(
        r'^(?:from|import) (\w+)', ''.join(path.read_text() for path in examples), re.MULTILINE
    )
    for path in examples:
        is_run = any(f'examples/{path.name}' in line for line in lines)
        assert is_run or path.stem in imported, path.name


@each_page
def test_what_is_named_is_there(page):
    """Files that a page names are in the project, and its links lead somewhere."""
    text = page.read_text(encoding='utf-8')
    named = re.findall(r'`((?:config|docs|test|msg_examples|examples|scripts)/[\w./]*)`', text)
    named = [ROOT / name for name in named]
    linked = re.findall(r'\]\((?!http)([^)#]+)', text)
    named += [page.parent / link for link in linked if not link.endswith('.rst')]
    assert [str(path) for path in named if not path.exists()] == []


@pytest.mark.parametrize(
    'text',
    [
        pytest.param(block.text, id=block.location)
        for page in PAGES
        for block in of_language(page, 'yaml')
        if not block.words
    ],
)
def test_examples_in_yaml_are_read(text):
    """A list is one of events, a map a scenario or a sweep; those with a name are files to run."""
    content = yaml.safe_load(text)
    if isinstance(content, list):
        assert events.from_yaml_text(text, Scenario())
    elif '/**' in content:
        Scenario.from_yaml_text(text)
    else:
        assert {'scenario', 'duration'} & set(content) or 'vary' in content

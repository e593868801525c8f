"""What make pages takes for a page that does what it says, and for one that does not."""

import os
import re
import sys
from pathlib import Path

import pytest

from scripts import run_pages
from scripts.run_pages import Failed, Reader

PYTHON = f'{sys.executable} -u -c'
# It ends by Ctrl-C, as a program that has nothing to close.
WAITS = f'{PYTHON} "import signal; print(1); signal.pause()"'
DEAF = """\
import os, signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
print('pid', os.getpid())
signal.pause()"""


@pytest.fixture
def reader(tmp_path: Path) -> Reader:
    """Return a reader in a folder of its own."""
    path = f'{Path(sys.executable).parent}:{os.environ["PATH"]}'
    return Reader(tmp_path, {'PATH': path}, frozenset({'make demo'}))


def read(reader: Reader, *fenced: str) -> Reader:
    """Let a reader run a page of blocks, each given as what follows the opening fence."""
    page = reader.folder / 'page.md'
    page.write_text('\n'.join(f'```{text}\n```\n' for text in fenced))
    reader.read(page)
    return reader


def test_a_page_that_does_what_it_says(reader):
    """Files are written, programs run, and commands in one shell; each is counted."""
    read(
        reader,
        'python two.py\nTWO = 2',
        'yaml three.yaml\n3',
        'sh\nexport FOUR=4  # for all that follows\ncat \\\n  three.yaml',
        'text\n3',
        'python\nimport os\nfrom two import TWO\nprint(TWO, "and", os.environ["FOUR"])',
        'text\n2 ... 4',
        'none\nno block that anybody runs',
    )
    assert (reader.commands, reader.programs, reader.outputs) == (2, 1, 2)
    assert (reader.folder / 'two.py').read_text() == 'TWO = 2\n'


def test_what_ci_makes_is_not_made_again(reader):
    """There is no Makefile here, which the other target would need."""
    assert read(reader, 'sh\nmake demo  # twenty seconds').commands == 0
    with pytest.raises(Failed, match='exit code 2'):
        read(reader, 'sh\nmake other')


@pytest.mark.parametrize(
    'stated', ['one\nthree', 'two\none', 'on', 'one two', 'o...x', 'one\none']
)
def test_an_output_that_is_not_printed(reader, stated):
    """Whole lines, in their order; the page, the line and what is missing are reported."""
    with pytest.raises(Failed) as failed:
        read(reader, 'sh\nprintf "one\\ntwo\\n"', f'text\n{stated}')
    assert str(failed.value).startswith('page.md:1: not printed: ')
    assert str(failed.value).removeprefix('page.md:1: not printed: ') in stated.splitlines()


@pytest.mark.parametrize('block', ['sh\nfalse\ntrue', 'sh\nfalse | true', 'python\n1 / 0'])
def test_a_command_that_fails(reader, block):
    """Whatever comes after it, in its line or behind it."""
    with pytest.raises(Failed, match=r'^page\.md:1: exit code 1$'):
        read(reader, block)


def test_a_word_that_nobody_knows(reader):
    """A block that is marked wrong is not passed over."""
    with pytest.raises(Failed, match='a block of sh cannot be'):
        read(reader, 'sh backgroud\ntrue')


def test_commands_in_terminals_of_their_own(reader):
    """They run on while the rest of the page is run, until Ctrl-C; one that is done may end."""
    read(reader, f'sh background\n{WAITS}\n{PYTHON} "print(1)"', 'text\n1', 'sh\ntrue')
    assert (reader.commands, reader.outputs, reader.terminals) == (3, 2, [])


@pytest.mark.parametrize(
    ('line', 'why'),
    [
        # Deaf to the Ctrl-C that comes when it has printed and is about to end.
        (
            f'{PYTHON} "import signal as s, sys; s.signal(s.SIGINT, s.SIG_IGN); print(1); '
            'sys.exit(3)"',
            'exit code 3 of',
        ),
        (f'{PYTHON} "print(2)"', 'not printed: 1'),
    ],
)
def test_a_command_in_the_background_that_ends_early(reader, line, why):
    """With an exit code, or before it has printed what the page says."""
    with pytest.raises(Failed, match=f'page.md:1: {why}'):
        read(reader, f'sh background\n{line}', 'text\n1')


def test_a_command_that_ctrl_c_does_not_end(reader, monkeypatch, capsys):
    """It is reported, and ended all the same."""
    monkeypatch.setattr(run_pages, 'END_TIMEOUT_S', 0.2)
    with pytest.raises(Failed, match='Ctrl-C does not end'):
        read(
            reader, f'python deaf.py\n{DEAF}', 'sh background\npython -u deaf.py', 'text\npid ...'
        )
    (pid,) = re.findall(r'^pid (\d+)', capsys.readouterr().out, re.MULTILINE)
    assert not Path('/proc', pid).exists()


def test_what_is_left_out_is_listed(reader, monkeypatch):
    """What takes long and, where there is no ROS 2, what needs it, line by line."""
    monkeypatch.setenv('PATH', str(reader.folder))
    read(reader, 'sh long\nfalse  # hours\nfalse', 'sh ros2\nros2 topic \\\n  list', 'sh\ntrue')
    assert reader.left_out == [
        'page.md:1: false  # hours',
        'page.md:1: false',
        'page.md:6: ros2 topic   list',
    ]
    assert reader.commands == 1

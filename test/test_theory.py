"""The table of results in docs/theory.md names what exists."""

import re
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ROWS = re.findall(
    r'^\| ([^|]+) \| [^|]+ \| (`[^|]+`) \| `([^|]+)` \|$',
    (ROOT / 'docs/theory.md').read_text(),
    re.MULTILINE,
)


def test_every_row_is_read():
    """The table is long, and every source is in it."""
    assert len(ROWS) > 50
    assert {row[0].split()[0] for row in ROWS} == {'Ag', 'Be', 'BG', 'Pa', 'Tb', 'further'}


@pytest.mark.parametrize(('source', 'names', 'test'), ROWS, ids=[row[0] for row in ROWS])
def test_functions_and_tests_exist(source, names, test):
    """Each name is one of the package, each test a file."""
    assert (ROOT / 'test' / test).is_file()
    for name in re.findall(r'`([^`]+)`', names):
        parts = name.split('.')
        found = import_module('satdyn_ros.' + parts[0])
        for k, part in enumerate(parts[1:], start=2):
            if not hasattr(found, part):
                found = import_module('satdyn_ros.' + '.'.join(parts[:k]))
            else:
                found = getattr(found, part)


def test_reference_cases_that_are_named_exist():
    """A1, B2, G8 and so on are cases of the references."""
    text = (ROOT / 'test/reference/newtonian.json').read_text()
    known = set(re.findall(r'"name": "([ABGX][0-9]+)_', text))
    proofs = re.findall(r'^Proof: .*', (ROOT / 'docs/theory.md').read_text(), re.MULTILINE)
    named = {case for proof in proofs for case in re.findall(r'\b[ABGX][0-9]+\b', proof)}
    assert named
    assert named <= known

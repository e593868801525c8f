"""The pages of docs/theory name results, functions, tests and cases that exist."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / 'docs/theory/rigid_bodies.md').read_text()
PROOFS = [
    proof
    for page in sorted((ROOT / 'docs/theory').glob('*.md'))
    for proof in re.findall(r'Proof: .*', page.read_text())
]
ROWS = re.findall(r'^\| ([^|]+) \| [^|]+ \| (`[^|]+`)<br>`([^|]+)` \|$', PAGE, re.MULTILINE)


def test_every_row_is_read():
    """The table is long, and every source is in it."""
    assert len(ROWS) > 50
    assert {row[0].split()[0] for row in ROWS} == {'Ag', 'Be', 'BG', 'Pa', 'Tb', 'further'}


@pytest.fixture(scope='module')
def unknown() -> dict[str, str]:
    """Return the names of the table that a new Python does not know after the page's imports."""
    imports = re.findall(r'^```python\n(.*?)^```', PAGE, re.MULTILINE | re.DOTALL)
    names = sorted({name for row in ROWS for name in re.findall(r'`([^`]+)`', row[1])})
    program = f"""{imports[-1]}
import json
unknown = {{}}
for name in {names}:
    try:
        eval(name)
    except Exception as error:
        unknown[name] = str(error)
print(json.dumps(unknown))"""
    run = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def test_functions_and_tests_exist(unknown):
    """Each name is one after the imports that the page shows, as it stands, each test a file."""
    for source, names, test in ROWS:
        assert (ROOT / 'test' / test).is_file(), source
        for name in re.findall(r'`([^`]+)`', names):
            assert name not in unknown, f'{source}: {unknown[name]}'


def test_reference_cases_that_are_named_exist():
    """A1, B2, G8 and so on are cases of the references."""
    text = (ROOT / 'test/reference/newtonian.json').read_text()
    known = set(re.findall(r'"name": "([ABGX][0-9]+)_', text))
    named = {case for proof in PROOFS for case in re.findall(r'\b[ABGX][0-9]+\b', proof)}
    assert named
    assert named <= known


def test_proofs_are_tests():
    """A proof names files; one without its folder is in the folder of the one before it."""
    for proof in PROOFS:
        folder = ROOT
        for name in re.findall(r'`((?:test/[\w/]*)?test_\w+\.py)`', proof):
            if '/' in name:
                folder = (ROOT / name).parent
            assert (folder / Path(name).name).is_file(), f'{name} in {proof}'


def test_modules_that_are_named_exist():
    """Such as integrate/walk.py, in the text of the pages and on that of the design."""
    rooms = '|'.join(path.name for path in (ROOT / 'satdyn_ros').iterdir() if path.is_dir())
    for page in [*(ROOT / 'docs').glob('theory/*.md'), ROOT / 'docs/design.md']:
        for name in re.findall(rf'`((?:{rooms})/[\w/]+\.py)`', page.read_text()):
            is_test = (ROOT / 'test' / name).is_file()
            assert is_test or (ROOT / 'satdyn_ros' / name).is_file(), f'{name} on {page.name}'

"""Compiled code that is kept never outlives the equations that it was made of."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# A small compiled function that calls another file's.
USER = """
from .compiled import compiled, is_kept
from .vector import dot

@compiled
def square(a):
    return dot(a, a)

kept = is_kept(square)
print(square((1.0, 2.0, 3.0)), kept)
"""


@pytest.fixture
def package(tmp_path):
    """Return a copy of the package that has a module of compiled code more."""
    copy = tmp_path / 'satdyn_ros'
    shutil.copytree(ROOT / 'satdyn_ros', copy, ignore=shutil.ignore_patterns('__pycache__'))
    (copy / 'dynamics' / 'user.py').write_text(USER)
    return copy


def run(package, **environment):
    """Return what the module says: the function's value, and whether its code was there."""
    return subprocess.run(
        [sys.executable, '-c', 'import satdyn_ros.dynamics.user'],
        env=os.environ | {'PYTHONPATH': str(package.parent)} | environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        cwd=package.parent,
    ).stdout.split()


@pytest.mark.parametrize('elsewhere', [False, True])
def test_code_is_kept_until_any_source_changes(package, tmp_path, elsewhere):
    """Kept for the next start; a change in what is called makes new code, and old code goes."""
    environment = {'NUMBA_CACHE_DIR': str(tmp_path / 'cache')} if elsewhere else {}
    assert run(package, **environment) == ['14.0', 'False']
    assert run(package, **environment) == ['14.0', 'True']
    vector = package / 'dynamics' / 'vector.py'
    vector.write_text(
        vector.read_text().replace('return a[0] * b[0] +', 'return 2 * a[0] * b[0] +')
    )
    assert run(package, **environment) == ['15.0', 'False']
    place = 'cache/satdyn_ros' if elsewhere else 'satdyn_ros/dynamics/__pycache__/compiled'
    assert len(list((tmp_path / place).iterdir())) == 1

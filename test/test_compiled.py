"""Compiled code that is kept never outlives the equations that it was made of."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
# A small compiled function that calls another file's.
USER = """
from ..compiled import compiled, is_kept
from .vector import dot

@compiled
def square(a):
    return dot(a, a)

kept = is_kept(square)
print(square((1.0, 2.0, 3.0)), kept)
"""

# Everything that is compiled: ellipse, free rotor and torque; closed form; lanes.
MOTIONS = """
import sys
from hashlib import sha256
import numpy as np
from satdyn_ros import Scenario
from satdyn_ros.dynamics.batch import propagate_all
from satdyn_ros.dynamics.orbit import KeplerOrbit
from satdyn_ros.dynamics.propagator import Propagation
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System

system = System(
    np.diag([900.0, 800.0, 600.0]),
    Rotor('free', np.array([0.0, 1.0, 0.0]), inertia=0.05),
    KeplerOrbit(eccentricity=0.1),
    torque_b=np.array([0.0, 1e-4, 0.0]),
)
state = State(np.array([0.0, 0.0, 0.6, 0.8]), np.array([0.01, 0.02, -0.01]), 30.0, 0.0)
t_s = np.linspace(0.0, 6000.0, 601)
tables = [
    Propagation(system, state).at(t_s),
    Scenario.from_yaml('config/default.yaml').motion().at(t_s),
    Scenario.from_yaml('config/paladini.yaml').motion().at(t_s),
    *propagate_all([Propagation(system, state)], t_s),
    *propagate_all([Scenario.from_yaml('config/default.yaml').motion()], t_s),
]
for states in tables:
    print(sha256(states.q_ib.tobytes() + states.omega_bi_b.tobytes()).hexdigest())
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
    place = 'cache/satdyn_ros' if elsewhere else 'satdyn_ros/__pycache__/compiled'
    assert len(list((tmp_path / place).iterdir())) == 1


def test_the_same_bits_when_compiled_and_when_loaded(tmp_path):
    """The process that compiles gives the same bytes as those that find the code."""
    said = [
        subprocess.run(
            [sys.executable, '-c', MOTIONS],
            env=os.environ | {'NUMBA_CACHE_DIR': str(tmp_path)},
            stdout=subprocess.PIPE,
            check=True,
            cwd=ROOT,
        ).stdout
        for _ in range(2)
    ]
    assert said[0] == said[1]
    assert len(set(said[0].split())) == 5

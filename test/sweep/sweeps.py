"""Sweep files for the tests, and sweeps in processes of their own."""

import os
import subprocess
import sys
import time
from pathlib import Path

import yaml

from satdyn_ros.sweep.outcome import columns
from satdyn_ros.sweep.table import table

ROOT = Path(__file__).parents[2]
ENVIRONMENT = os.environ | {'PYTHONPATH': str(ROOT)}
# 19 batches of 16 runs, long enough to be interrupted among.
MANY = {'runs': 100, 'duration_s': 100_000.0, 'interval_s': 1000.0}

SCENARIO = {
    'body': {'inertia': [800.0, 900.0, 600.0]},
    'rotor': {'mode': 'constant_momentum', 'momentum': -5.0},
    'initial': {'frame': 'lvlh', 'attitude': [0.0, 0.0, 0.0, 1.0]},
    'publish': {'rate': 0.1, 'topics': ['attitude']},
    'time': {'epoch_ns': 1},
}
SWEEP = {
    'scenario': 'scenario.yaml',
    'seed': 1,
    'runs': 4,
    'duration_s': 12000.0,
    'interval_s': 100.0,
    'vary': {
        'rotor.momentum': {'linspace': [-10.0, 10.0, 3]},
        'initial.attitude': 'sphere',
        'initial.angular_velocity': {'normal': [[0.0, 0.0, 0.0], [1e-3, 1e-3, 1e-3]]},
    },
}


def write(folder, parameters=None, **changes):
    """Write a scenario and the sweep above with changes into a folder; return the sweep's path."""
    sections = {'/**': {'ros__parameters': SCENARIO | (parameters or {})}}
    (folder / 'scenario.yaml').write_text(yaml.safe_dump(sections))
    path = folder / 'sweep.yaml'
    path.write_text(yaml.safe_dump(SWEEP | changes, sort_keys=False))
    return path


def rows_of(plan, runs):
    """Return the rows of runs of a sweep."""
    return table(plan, columns(plan, runs)).to_pylist()


def start(path, directory, *more):
    """Start a sweep in a process of its own."""
    command = [sys.executable, '-m', 'satdyn_ros.cli.main', 'sweep', path, '-o', directory, *more]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)


def wait_for_parts(directory, count):
    """Wait until so many batches are done."""
    for _ in range(6000):
        if len(list((directory / 'parts').glob('*.parquet'))) >= count:
            return
        time.sleep(0.01)
    raise TimeoutError(f'{directory} has not {count} batches')

"""Code for other processors, run on this one: the compiler must do as well for all of them."""

import os
import subprocess
import sys
import tempfile
import time

import numpy as np
from common import QUICK, Claim, medians, milliseconds, show
from problem import DURATION_S, START, system

from satdyn_ros.integrate.propagation import Propagation

# As loose as allows of the problem's greatest error.
TOLERANCE = 2.5e-13

# By the compiler's name, what it stands for, and by how much slower its code may be.
PROCESSORS = {
    'haswell': ('Intel since 2013, vectors of four', 1.3),
    'znver2': ('AMD since 2019, vectors of four', 1.3),
    'x86-64': ('all, vectors of two', 1.5),
}
if QUICK:  # For each, code is compiled anew.
    PROCESSORS = {'x86-64': PROCESSORS['x86-64']}


def final_state(repetitions: int = 10) -> float:
    """Propagate to the final state of the test problem; return the CPU seconds."""
    satellite, end_s = system(), np.array([DURATION_S])
    begin = time.process_time()
    for _ in range(repetitions):
        Propagation(satellite, START, tolerance=TOLERANCE).at(end_s)
    return (time.process_time() - begin) / repetitions


class Child:
    """A process whose code is for a processor by the compiler's name, '': for this one."""

    def __init__(self, processor: str, folder: str):
        given = {
            'NUMBA_CPU_NAME': processor,
            'NUMBA_CPU_FEATURES': '',
            'NUMBA_CACHE_DIR': folder,
        }
        self.process = subprocess.Popen(
            [sys.executable, __file__, '--child'],
            env=os.environ | (given if processor else {}),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def final_state(self) -> float:
        """Let it propagate; return the CPU seconds."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write('\n')
        self.process.stdin.flush()
        return float(self.process.stdout.readline())


def main(rounds=15):
    """Run all; return title, claims and text."""
    with tempfile.TemporaryDirectory() as folder:
        children = {name: Child(name, folder) for name in ('', *PROCESSORS)}
        seconds = medians({n: each.final_state for n, each in children.items()}, rounds)
        for child in children.values():
            child.process.communicate()
    claims = [
        Claim(
            f'final state, code for {name} ({what}), over code for this processor',
            milliseconds(seconds[name]),
            milliseconds(seconds['']),
            seconds[name] / seconds[''],
            must,
            at_most=True,
        )
        for name, (what, must) in PROCESSORS.items()
    ]
    return 'Code for other processors', show(claims), ''


if __name__ == '__main__':
    if '--child' in sys.argv:
        for _ in sys.stdin:
            print(final_state(), flush=True)
    else:
        main()

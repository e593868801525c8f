"""
Damp a tumble with magnetorquers until wheels can take the rest, then point to nadir.

    satdyn simulate cubesat_adcs --duration 6000 -o bags/detumbled \
        --controller detumble_then_point.py:DetumbleThenPoint

Both laws are those of their files: b_dot.py and nadir.py.

It flies inside the run, and a run repeats to the byte.  A controller that is a program of its own,
such as flight software, closes the loop over topics: examples/bdot.py.
"""

import numpy as np
from b_dot import BDot
from nadir import Nadir


class DetumbleThenPoint:
    """slow_rad_s: below this rate, by the gyro, the wheels take over for good."""

    period_s = None
    needs_truth = False

    def __init__(self, slow_rad_s=0.03, gain=1e5):
        self.slow_rad_s = slow_rad_s
        self.damp, self.point = BDot(gain), Nadir()

    def reset(self, scenario, seed):
        """Begin with the tumble."""
        self.is_pointing = False
        self.damp.reset(scenario, seed)
        self.point.reset(scenario, seed)

    def command(self, sample):
        """Return the dipole of the one law, or the torques of the motors of the other."""
        rate = sample.measured.get('gyro')
        if not self.is_pointing and rate is not None:
            self.is_pointing = bool(np.linalg.norm(rate) < self.slow_rad_s)
        if not self.is_pointing:
            return self.damp.command(sample)
        return {'dipole_b': (0.0, 0.0, 0.0), **self.point.command(sample)}

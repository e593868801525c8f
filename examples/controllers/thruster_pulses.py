"""
On-times of thrusters for an angular impulse: the allocation of the controllers beside this file.

The torques of thrusters only push.  Of all on-times that are not negative those are taken whose
impulse comes nearest to the one that is wanted: non-negative least squares (Lawson and Hanson,
Solving least squares problems, 1974, chapter 23), as of scipy.optimize.nnls.
"""

import numpy as np
from scipy.optimize import nnls


class Pulses:
    """
    The pulses of a scenario's thrusters within periods of period_s [s].

    torques_b (3, K) [N m]: of each thruster, body axes.
    """

    def __init__(self, scenario, period_s):
        self.names, self.period_s = scenario['thruster.names'], period_s

        def of_each(key):
            return np.array([scenario[f'thruster.{name}.{key}'] for name in self.names])

        arms = np.cross(of_each('position'), of_each('direction'))
        self.torques_b = (of_each('thrust')[:, None] * arms).T
        self.least = of_each('min_on_time')

    def on_times(self, impulse_b):
        """Return by name the on-times [s] that come nearest to an angular impulse [N m s] (3,)."""
        on_times, _ = nnls(self.torques_b, impulse_b)
        # All are cut alike, which leaves the impulse its direction.
        on_times /= max(1.0, on_times.max() / self.period_s)
        # One that is shorter than the shortest is that one or none, whichever is nearer.
        nearest = np.where(on_times < 0.5 * self.least, 0.0, self.least)
        on_times = np.where(on_times < self.least, nearest, on_times)
        return dict(zip(self.names, on_times.tolist(), strict=True))

"""
How far a body turned from tick to tick, from its attitudes alone.

A gyro counts the rate that a motion has; what is said of its errors needs another witness.  The
rotation vectors of m equal parts of an interval add up to the integral of the rate as m grows, by
even powers of 1 / m, so that Richardson's extrapolation finds it.
"""

from itertools import pairwise

import numpy as np

from ..dynamics.motion import Motion
from ..integrate.propagation import Propagation
from ..kernel import rotation

# Parts of an interval, in the fewest of which the body turns by this angle at most [rad].
_PARTS, _LARGEST_TURN = (1, 2, 4, 8), 0.5


class FlownAgain:
    """A motion that is flown once more, for its attitudes: it need not go back itself."""

    def __init__(self, motion: Motion):
        self.motion = self._again = motion
        if isinstance(motion, Propagation):
            # It stands at one instant, from which the run goes on.
            start = motion.system, motion.state, motion.start_s
            self._again = Propagation(*start, motion.tolerance)

    def turns(self, begin_s: np.ndarray, interval_s: float, fastest: float) -> np.ndarray:
        """
        Return the integral (N, 3) of omega_bi_b [rad] from some times on, for an interval each.

        Parameters
        ----------
        begin_s : (N,), s
            ascending, since the motion began
        interval_s : s
            the interval
        fastest : rad/s
            the body's rate at most
        """
        each = int(fastest * interval_s / _LARGEST_TURN) + 1
        fractions = np.linspace(0.0, 1.0, each * _PARTS[-1] + 1)
        t_s = begin_s[:, None] + interval_s * fractions
        q_ib = self._again.at(t_s.ravel()).q_ib.reshape(*t_s.shape, 4)
        sums = [_sum_of_turns(q_ib[:, :: _PARTS[-1] // parts]) for parts in _PARTS]
        for per_halving in (4.0, 16.0, 64.0):
            sums = [
                fine + (fine - coarse) / (per_halving - 1.0) for coarse, fine in pairwise(sums)
            ]
        return sums[0]


def _sum_of_turns(q_ib: np.ndarray) -> np.ndarray:
    """Return the sum (N, 3) of the rotation vectors along attitudes (N, m + 1, 4)."""
    turned = rotation.multiply(rotation.conjugate(q_ib[:, :-1]), q_ib[:, 1:])
    return np.sum(rotation.to_vector(turned), axis=1)

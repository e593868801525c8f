"""
Attitude and rate from a gyro and a star tracker.

The gyro turns the estimate on, and each sample of the star tracker takes a part of what is left:
the passive complementary filter with its bias, of Mahony, Hamel and Pflimlin (Nonlinear
complementary filters on the special orthogonal group, IEEE Transactions on Automatic Control 53,
2008), in steps.

It is for controllers inside the run.  For an estimate that other processes use, take
examples/estimator.py.
"""

import numpy as np

from satdyn_ros.kernel import rotation

# Of an error a sample takes this part; that of the bias lets it fade without a swing.
PART = 0.3
BIAS_PART = PART**2 / 4.0


class AttitudeEstimate:
    """
    What is known of a body whose sensors are called gyro and star_tracker.

    q_ib (4,): None before the first sample of the star tracker.  omega_bi_b (3,) [rad/s]: None
    before that of the gyro.
    """

    def __init__(self, scenario):
        self.q_ib, self.omega_bi_b = None, None
        self._bias = np.zeros(3)
        self._q_bg = scenario['sensors.gyro.mounting']
        self._q_sb = rotation.conjugate(scenario['sensors.star_tracker.mounting'])
        self._now_ns, self._seen_ns = None, None

    def update(self, sample):
        """Take what a sample has measured."""
        measured = sample.measured
        if 'gyro' in measured:
            self._turn(measured['gyro'])
        if 'star_tracker' in measured and self.omega_bi_b is not None:
            self._correct(measured['star_tracker'])

    def _turn(self, rate_g):
        """Turn on to the stamp of a sample of the gyro."""
        since_ns, self._now_ns = self._now_ns, rate_g.stamp_ns
        self.omega_bi_b = rotation.rotate(self._q_bg, rate_g) - self._bias
        if self.q_ib is not None:
            between_s = 1e-9 * (self._now_ns - since_ns)
            self.q_ib = self._after(self.q_ib, between_s)

    def _correct(self, q_is):
        """Take a part of what the star tracker sees, which was some time ago."""
        age_s = 1e-9 * (self._now_ns - q_is.stamp_ns)
        q_seen = self._after(rotation.multiply(q_is, self._q_sb), age_s)
        since_ns, self._seen_ns = self._seen_ns, q_is.stamp_ns
        if self.q_ib is None:
            self.q_ib = q_seen
            return
        off = rotation.to_vector(rotation.multiply(rotation.conjugate(self.q_ib), q_seen))
        turn = rotation.from_vector(PART * off)
        self.q_ib = rotation.normalise(rotation.multiply(self.q_ib, turn))
        self._bias -= BIAS_PART * off / (1e-9 * (self._seen_ns - since_ns))

    def _after(self, q_ib, between_s):
        turn = rotation.from_vector(between_s * self.omega_bi_b)
        return rotation.multiply(q_ib, turn)

"""
Attitude and biases by the multiplicative extended Kalman filter, of a gyro and what else there is.

Lefferts, Markley and Shuster, Kalman filtering for spacecraft attitude estimation, 1982: the state
is a quaternion and biases, its error a small rotation and biases.  The bias of a magnetometer is
estimated as that of the gyro is: noise averages out, a bias does not.
"""

from dataclasses import dataclass, replace

import numpy as np

from satdyn_ros.kernel import rotation

# Before the first sample the state is known to these standard deviations [rad, rad/s, T].
ATTITUDE_SIGMA, GYRO_BIAS_SIGMA, FIELD_BIAS_SIGMA = 1.0, 0.01, 1e-6


@dataclass(frozen=True, eq=False)
class Estimate:
    """
    Attitude q_ib (4,), biases, and the covariance P of their errors, at a stamp.

    bias, in body axes: of the gyro (3,) [rad/s]; where there is a magnetometer (6,), with its bias
    [T] behind.  The errors are the rotation vector of q_ib* q_true, in body axes, and the biases.
    """

    stamp_ns: int
    q_ib: np.ndarray
    bias: np.ndarray
    P: np.ndarray

    @classmethod
    def near(cls, stamp_ns, q_ib, has_field_bias):
        """Return what is known before the first sample, linear about an attitude near the true."""
        sigmas = [ATTITUDE_SIGMA, GYRO_BIAS_SIGMA] + has_field_bias * [FIELD_BIAS_SIGMA]
        P = np.diag(np.repeat(sigmas, 3) ** 2)
        return cls(stamp_ns, q_ib, np.zeros(len(P) - 3), P)

    def predicted(self, stamp_ns, rate_b, N, K, K_field=0.0):
        """
        Return the estimate at a stamp, with the rate of the gyro since this one in body axes.

        N, K: noise density and bias random walk of the gyro [rad/s/sqrt(Hz), rad/s^2/sqrt(Hz)],
        K_field: bias random walk of the magnetometer [T/sqrt(s)] (Farrenkopf 1978).
        """
        dt = (stamp_ns - self.stamp_ns) * 1e-9
        turned = rotation.from_vector((rate_b - self.bias[:3]) * dt)
        q_ib = rotation.normalise(rotation.multiply(self.q_ib, turned))
        F = np.eye(len(self.P))
        F[:3, :3], F[:3, 3:6] = rotation.matrix(turned).T, -dt * np.eye(3)
        angle, cross = N**2 * dt + K**2 * dt**3 / 3.0, -(K**2) * dt**2 / 2.0
        Q = K_field**2 * dt * np.eye(len(self.P))
        Q[:6, :6] = np.kron([[angle, cross], [cross, K**2 * dt]], np.eye(3))
        return Estimate(stamp_ns, q_ib, self.bias, F @ self.P @ F.T + Q)

    def updated(self, error, H, R):
        """Return the estimate after what was measured less what was expected, H x + noise of R."""
        gain = np.linalg.solve(H @ self.P @ H.T + R, H @ self.P).T
        correction = gain @ error
        q_ib = rotation.multiply(self.q_ib, rotation.from_vector(correction[:3]))
        # Joseph's form keeps P symmetric and positive.
        rest = np.eye(len(self.P)) - gain @ H
        P = rest @ self.P @ rest.T + gain @ R @ gain.T
        bias = self.bias + correction[3:]
        return replace(self, q_ib=rotation.normalise(q_ib), bias=bias, P=P)

    def updated_by_attitude(self, q_ib, R):
        """Return the estimate after a measured attitude, R that of its error in body axes."""
        error = rotation.to_vector(rotation.multiply(rotation.conjugate(self.q_ib), q_ib))
        return self.updated(error, np.eye(3, len(self.P)), R)

    def updated_by_direction(self, s_b, s_i, R):
        """Return the estimate after a direction measured in body axes and known in inertial."""
        expected_b, H = self._expected(s_i)
        return self.updated(s_b - expected_b, H, R)

    def updated_by_field(self, B_b, B_i, R):
        """Return the estimate after a field [T] measured in body axes and known in inertial."""
        expected_b, H = self._expected(B_i)
        H[:, 6:] = np.eye(3)
        return self.updated(B_b - expected_b - self.bias[3:], H, R)

    def _expected(self, v_i):
        """Return v_b of a known v_i, and H = [v_b x]: an error a makes it v_b + v_b x a."""
        v_b = rotation.rotate(rotation.conjugate(self.q_ib), v_i)
        H = np.zeros((3, len(self.P)))
        H[:, :3] = np.cross(np.eye(3), v_b)
        return v_b, H

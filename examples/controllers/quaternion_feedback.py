"""
Turn a body to a reference attitude with reaction wheels, by what gyro and star tracker measure.

The quaternion feedback of Wie, Weiss and Arapostathis (Quaternion feedback regulator for
spacecraft eigenaxis rotations, Journal of Guidance, Control, and Dynamics 12, 1989): the torque on
the body is -I (k e + d w), with e twice the vector part of the error quaternion and w the rate
relative to the reference.  With gains along I the body turns about one axis.  To that come what
the reference asks for, and what the turning itself takes, omega x (I omega + h).
"""

import numpy as np
from attitude_estimate import AttitudeEstimate

from satdyn_ros.kernel import rotation

# Until the star tracker, which looks along -z, sees stars, the body turns about x [rad/s]: so it
# looks along a great circle, of which the Earth hides less than half.
SEARCH_B = np.array([0.015, 0.0, 0.0])


class QuaternionFeedback:
    """
    The controller of any reference of satdyn_ros.guidance; the files beside this one choose.

    swing_rad_s, damping: of the small errors, which settle as a damped swing does: k is the square
    of the first, d twice their product.
    """

    period_s = None
    needs_truth = False

    def __init__(self, reference, swing_rad_s=0.1, damping=0.9):
        self.reference = reference
        self.k, self.d = swing_rad_s**2, 2.0 * damping * swing_rad_s

    def reset(self, scenario, seed):
        """Begin with what the scenario says of the body and its wheels."""
        self.inertia, self.wheels = scenario.system.inertia, scenario.system.rotors
        self.axes = np.array([wheel.axis for wheel in self.wheels])
        self.spins = np.array([wheel.inertia for wheel in self.wheels])
        # Of all torques of the wheels that make one of the body, the smallest.
        self.shares = np.linalg.pinv(self.axes.T)
        self.estimate = AttitudeEstimate(scenario)

    def command(self, sample):
        """Return the torques of the motors [N m] by name."""
        torque_b = self.torque(sample)
        if torque_b is None:
            return {}
        return {'rotor_torque': self.motor_torques(torque_b, sample.rotor_speed)}

    def torque(self, sample):
        """Return the torque that the body is to get [N m] (3,), body axes; None: not known yet."""
        self.estimate.update(sample)
        q_ib, omega_b = self.estimate.q_ib, self.estimate.omega_bi_b
        if omega_b is None:
            return None
        if q_ib is None:
            acceleration = -self.d * (omega_b - SEARCH_B)
        else:
            acceleration = self.acceleration(q_ib, omega_b, self.reference(sample))
        H_b = self.inertia @ omega_b + self.wheel_momentum(sample)
        return self.inertia @ acceleration + np.cross(omega_b, H_b)

    def acceleration(self, q_ib, omega_b, reference):
        """Return what brings a body to a reference [rad/s^2] (3,), body axes."""
        q_br = rotation.multiply(rotation.conjugate(q_ib), reference.q_ir)
        x, y, z, w = q_br
        # From the reference to the body, the shorter way round.
        error = -2.0 * np.copysign(1.0, w) * np.array([x, y, z])
        omega_r_b = rotation.rotate(q_br, reference.omega_ri_r)
        slip = omega_b - omega_r_b
        follow = rotation.rotate(q_br, reference.alpha_ri_r) - np.cross(slip, omega_r_b)
        return follow - self.k * error - self.d * slip

    def wheel_momentum(self, sample):
        """Return the momentum of the wheels relative to the body [N m s] (3,), body axes."""
        return self.axes.T @ (self.spins * sample.rotor_speed)

    def motor_torques(self, torque_b, speeds):
        """Return by name what the motors are to give for a torque on the body [N m] (3,)."""
        torques = -self.shares @ torque_b
        # All are cut alike, which leaves the torque its direction.
        limits = np.array([wheel.max_torque or np.inf for wheel in self.wheels])
        torques /= max(1.0, np.max(np.abs(torques) / limits))
        friction = [w.friction_torque(s) for w, s in zip(self.wheels, speeds, strict=True)]
        names = [wheel.label for wheel in self.wheels]
        return dict(zip(names, (torques + friction).tolist(), strict=True))

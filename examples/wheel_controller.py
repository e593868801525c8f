"""
Point a tumbling satellite by its reaction wheels alone, through its topics.

Run it beside a node:  satdyn node --params-file config/three_wheels.yaml
                       python examples/wheel_controller.py config/three_wheels.yaml
The scenario file serves as the data sheet of body and wheels; there may be any number of motors,
as long as their axes span space, such as those of config/pyramid.yaml.  It ends with exit code 0
once the satellite rests at the target, with 1 if that takes too long.  The wheels then hold the
momentum that the satellite had: nothing here dumps it.

Take a loop over topics, as here, for a controller that is a program of its own: flight software,
another language, hardware.  For the law alone take the class in controllers/inertial.py: it flies
inside the run, faster, and gives the same bytes each time.
"""

import argparse
import sys

import numpy as np
import rclpy
import rclpy.utilities
from pointing import Pointing, point
from sensor_msgs.msg import JointState

from satdyn_ros import Scenario
from satdyn_ros.dynamics.torque import angular_momentum


class Wheels:
    """The motors of a system, which turn a wanted torque on the body into motor torques."""

    def __init__(self, system):
        self._motors = [i for i, rotor in enumerate(system.rotors) if rotor.mode == 'motor']
        rotors = [system.rotors[i] for i in self._motors]
        self.names = [rotor.label for rotor in rotors]
        axes = np.reshape([rotor.axis for rotor in rotors], (-1, 3)).T
        if np.linalg.matrix_rank(axes) < 3:
            raise ValueError(
                'the motors turn the body about fewer than three axes; their axes must span space'
            )
        self._allocation = np.linalg.pinv(axes)
        self._friction = np.array([rotor.friction for rotor in rotors])
        self._max_torque = np.array([rotor.max_torque or np.inf for rotor in rotors])
        self._max_speed = np.array([rotor.max_speed or np.inf for rotor in rotors])

    def torques(self, torque_b, speeds):
        """
        Return motor torques (M,) [N m] for a wanted torque on the body, and what saturates.

        speeds: of all rotors [rad/s].  What saturates is a dictionary, wheel to limit, in words.
        Where a torque is beyond its limit all are scaled down, which keeps their direction.
        """
        speed = speeds[self._motors]
        # The wheels take up the reaction and must overcome their friction.
        wanted = -self._allocation @ torque_b + self._friction * speed
        torques = wanted / max(1.0, np.max(np.abs(wanted) / self._max_torque))
        too_fast = (np.abs(speed) >= self._max_speed) & (torques * speed > 0.0)
        too_strong = np.abs(wanted) > self._max_torque
        saturated = {}
        for i, name in enumerate(self.names):
            if too_fast[i]:
                saturated[name] = f'{self._max_speed[i]:g} rad/s'
            elif too_strong[i]:
                saturated[name] = f'{self._max_torque[i]:g} N m'
        return torques, saturated


class WheelController(Pointing):
    """
    Torque = -Kp e - Kd omega + omega x H with e the rotation vector from the target to the body.

    Kp = I wn^2 and Kd = 2 I wn damp the error critically at the bandwidth wn [rad/s]; omega x H
    compensates for the momentum H of body and wheels.
    """

    def __init__(self, system, bandwidth):
        super().__init__('wheel_controller')
        self._system, self._bandwidth = system, bandwidth
        self._wheels, self._saturated = Wheels(system), {}
        self._speeds = None
        self._command = self.create_publisher(JointState, 'rotor_command', 1000)
        self.create_subscription(JointState, 'rotor', self._take_rotors, 1000)

    def _take_rotors(self, message):
        self._speeds = np.array(message.velocity)

    def act(self, stamp, error, omega_bi_b):
        """Command the wheels to turn the body with the torque for a state."""
        if self._speeds is None:
            return
        wn = self._bandwidth
        feedback = self._system.inertia @ (-(wn**2) * error - 2.0 * wn * omega_bi_b)
        H = angular_momentum(self._system, omega_bi_b, self._speeds)
        torques, saturated = self._wheels.torques(feedback + np.cross(omega_bi_b, H), self._speeds)
        command = JointState(name=self._wheels.names, effort=torques.tolist())
        command.header.stamp = stamp
        self._command.publish(command)
        self._report(saturated)

    def _report(self, saturated):
        for name in saturated.keys() - self._saturated.keys():
            print(f'{name} saturates at {saturated[name]}', flush=True)
        for name in self._saturated.keys() - saturated.keys():
            print(f'{name} is within its limits again', flush=True)
        self._saturated = saturated


def main():
    """Point the satellite and report progress."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('scenario', help="the node's parameter file, the wheels' data sheet")
    parser.add_argument('--bandwidth', type=float, default=0.1, help='rad/s')
    parser.add_argument('--timeout', type=float, default=300.0, help='s')
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    scenario = Scenario.from_yaml(arguments.scenario)
    rclpy.init()
    try:
        controller = WheelController(scenario.system, arguments.bandwidth)
    except ValueError as error:
        parser.error(f'{arguments.scenario}: {error}')
    return point(controller, arguments.timeout)


if __name__ == '__main__':
    raise SystemExit(main())

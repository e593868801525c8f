"""
Point a tumbling satellite by proportional and derivative feedback, through its topics alone.

Run it beside a node:  satdyn node --params-file config/cubesat.yaml
                       python examples/controller.py
It ends with exit code 0 once the satellite rests at the target, with 1 if that takes too long.

Take a loop over topics, as here, for a controller that is a program of its own: flight software,
another language, hardware.  For the law alone take a class such as those in controllers/: it flies
inside the run, faster, and gives the same bytes each time.
"""

import argparse
import sys

import rclpy
import rclpy.utilities
from geometry_msgs.msg import WrenchStamped
from pointing import Pointing, point


class Controller(Pointing):
    """
    Torque = -Kp e - Kd omega with e the rotation vector from the target to the body.

    For moments near I [kg m^2], Kp = I wn^2 and Kd = 2 I wn damp the error critically at the
    bandwidth wn [rad/s].  source: the prefix of the names of the topics that it uses.
    """

    def __init__(self, inertia, bandwidth, source='', name='controller'):
        super().__init__(name, source)
        self._kp, self._kd = inertia * bandwidth**2, 2.0 * inertia * bandwidth
        self.command = self.create_publisher(WrenchStamped, 'torque', 1000)

    def act(self, stamp, error, omega_bi_b):
        """Publish the torque that a state calls for."""
        message = WrenchStamped()
        # Without a frame it is in body axes, whatever frame these have.
        message.header.stamp = stamp
        torque_b = message.wrench.torque
        torque_b.x, torque_b.y, torque_b.z = (-self._kp * error - self._kd * omega_bi_b).tolist()
        self.command.publish(message)


def main():
    """Point the satellite and report progress."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--inertia', type=float, default=0.03, help='kg m^2')
    parser.add_argument('--bandwidth', type=float, default=0.3, help='rad/s')
    parser.add_argument('--timeout', type=float, default=120.0, help='s')
    parser.add_argument(
        '--estimate', action='store_true', help='use the estimates of examples/estimator.py'
    )
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    rclpy.init()
    source = 'estimate/' if arguments.estimate else ''
    return point(Controller(arguments.inertia, arguments.bandwidth, source), arguments.timeout)


if __name__ == '__main__':
    raise SystemExit(main())

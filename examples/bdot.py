"""
Damp a tumbling satellite by its magnetorquers and a magnetometer alone, through its topics.

Run it beside a node:  satdyn node --params-file detumble.yaml
                       python examples/bdot.py
with a detumble.yaml as in docs/how-to/detumble.md.  It ends with exit code 0 once the field turns
slowly about the body, with 1 if that takes too long.

Take a loop over topics, as here, for a controller that is a program of its own: flight software,
another language, hardware.  For the law alone take the class in controllers/b_dot.py: it flies
inside the run, faster, and gives the same bytes each time.
"""

import argparse
import sys

import numpy as np
import rclpy
import rclpy.utilities
from geometry_msgs.msg import Vector3Stamped
from rclpy.node import Node
from sensor_msgs.msg import MagneticField
from stepping import Stepping

# So many samples in a row have to be slow, at 1 Hz those of half an orbit: a body that turns about
# the field shows it when the orbit has turned the field.
SLOW_SAMPLES = 2400


class BDot(Node):
    """
    The B-dot law m = -k dB/dt (Stickler and Alfriend 1976), with differences of samples.

    The field seems to turn with -omega, so that the torque m x B takes work from what turns
    across B.  gain: k [A m^2 s/T], about 2 n J / B^2 with the orbital rate n and a moment J
    (Avanzini and Giulietti 2012).  field: the topic of a magnetometer, or of the true field.
    """

    def __init__(self, gain, field='magnetic_field'):
        super().__init__('bdot')
        self.samples = self.slow_samples = 0
        self._gain, self._last = gain, None
        self.command = self.create_publisher(Vector3Stamped, 'magnetorquer_command', 1000)
        take = self.create_subscription(MagneticField, field, self._take_field, 1000)
        self.state_subscriptions = [take]

    def _take_field(self, message):
        self.act(message.header.stamp, message.magnetic_field)

    def act(self, stamp, field):
        """Publish the dipole that a sample calls for, none for the first."""
        t_s, B = stamp.sec + 1e-9 * stamp.nanosec, np.array([field.x, field.y, field.z])
        last_s, last_B = self._last or (t_s - 1.0, B)
        self._last = t_s, B
        B_dot = (B - last_B) / (t_s - last_s)
        rate_deg_s = np.degrees(np.linalg.norm(B_dot) / np.linalg.norm(B))
        if self.samples % 500 == 1:
            print(f'the field turns by {rate_deg_s:.3f} deg/s', flush=True)
        self.samples += 1
        self.slow_samples = self.slow_samples + 1 if rate_deg_s < 0.2 else 0
        command = Vector3Stamped()
        # Without a frame it is in body axes, whatever frame these have.
        command.header.stamp = stamp
        m = command.vector
        m.x, m.y, m.z = (-self._gain * B_dot).tolist()
        self.command.publish(command)


class SteppedBDot(Stepping, BDot):
    """The same in lockstep."""


def main():
    """Damp the satellite and report progress."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--gain', type=float, default=1e5, help='A m^2 s/T')
    parser.add_argument('--field', default='magnetic_field', help='the topic of the magnetometer')
    parser.add_argument('--samples', type=int, default=12000, help='the most that it may take')
    parser.add_argument('--lockstep', action='store_true', help='as examples/lockstep.py')
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    rclpy.init()
    controller = (SteppedBDot if arguments.lockstep else BDot)(arguments.gain, arguments.field)
    if isinstance(controller, SteppedBDot):
        controller.begin()
    while controller.slow_samples < SLOW_SAMPLES and controller.samples < arguments.samples:
        if isinstance(controller, SteppedBDot):
            controller.pass_tick()
        else:
            rclpy.spin_once(controller)
    is_slow = controller.slow_samples >= SLOW_SAMPLES
    print(f'{"slow" if is_slow else "not slow"} after {controller.samples} samples')
    controller.destroy_node()
    rclpy.try_shutdown()
    return 0 if is_slow else 1


if __name__ == '__main__':
    raise SystemExit(main())

"""
Close a loop without losing a message: pause the node, then command and step, tick by tick.

Run it beside a node that stays at tick 0:
    satdyn node --params-file config/cubesat.yaml --ros-args -p time.factor:=1e-6
    python examples/lockstep.py --ticks 500
A loop over topics includes the delays of the machine.  Here the satellite waits: each pass
receives the sample of the last tick, sends the torque for the next one, and requests a step, whose
reply comes when the tick has passed.  The same start gives the same messages, byte for byte,
however busy the machine is.

Take it where the controller has to be a process of its own and no message may be lost.  Where
it may be Python, a class such as those in controllers/ does the same inside the run, with no
messages to wait for.
"""

import argparse
import sys

import numpy as np
import rclpy
import rclpy.utilities
from controller import Controller
from stepping import Stepping


class Lockstep(Stepping, Controller):
    """The controller, which lets a tick pass once its torque has been sent."""


def main():
    """Run some ticks in lockstep, and print where the satellite points."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--ticks', type=int, default=500)
    parser.add_argument('--inertia', type=float, default=0.03, help='kg m^2')
    parser.add_argument('--bandwidth', type=float, default=0.3, help='rad/s')
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    rclpy.init()
    controller = Lockstep(arguments.inertia, arguments.bandwidth, name='lockstep')
    controller.begin()
    for _ in range(arguments.ticks - 1):
        controller.pass_tick()
    controller.end()
    error_deg = np.degrees(controller.error_rad)
    print(f'error {error_deg:.6f} deg after {arguments.ticks} ticks, {controller.missed} missed')
    controller.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()

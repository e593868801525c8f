"""From the command to the first published message, and to the first line of help."""

import os
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

from common import Claim, medians, milliseconds, show

IMPORTS = ('satdyn_ros.ros.start', 'numba', 'rclpy', 'numpy')
ROOT = Path(__file__).parents[1]
ENVIRONMENT = os.environ | {'ROS_DOMAIN_ID': '87', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}

# Ends the process at its first message that is not rclpy's own, and says when that was.
UNTIL_FIRST_MESSAGE = """
import os, time
from rclpy.publisher import Publisher
publish = Publisher.publish
def first(self, message):
    publish(self, message)
    if self.topic_name.split('/')[-1] not in ('parameter_events', 'rosout'):
        os.write(1, b'%d' % time.monotonic_ns())
        os._exit(0)
Publisher.publish = first
"""

MINIMAL = """
import rclpy
from geometry_msgs.msg import QuaternionStamped
rclpy.init()
node = rclpy.create_node('minimal')
node.create_publisher(QuaternionStamped, 'attitude', 10).publish(QuaternionStamped())
"""

OURS = f"""
import sys
sys.argv = ['satdyn', 'node', '--params-file', {str(ROOT / 'config' / 'default.yaml')!r}]
from satdyn_ros.cli.main import main
main()
"""


def to_first_message(program: str) -> float:
    """Return the wall seconds from the start of a process to its first message."""
    begin = time.monotonic_ns()
    process = subprocess.run(
        [sys.executable, '-c', UNTIL_FIRST_MESSAGE + program],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        check=True,
        timeout=60,
    )
    return (int(process.stdout) - begin) * 1e-9


def whole(arguments: list[str]) -> float:
    """Return the wall seconds of a whole process."""
    begin = time.monotonic_ns()
    subprocess.run([sys.executable, *arguments], stdout=subprocess.DEVNULL, check=True, timeout=60)
    return (time.monotonic_ns() - begin) * 1e-9


def main():
    """Run all; return title, claims and text."""
    seconds = medians(
        {
            'ours': lambda: to_first_message(OURS),
            'minimal': lambda: to_first_message(MINIMAL),
            'help': lambda: whole(['-m', 'satdyn_ros.cli.main', '--help']),
            'pass': lambda: whole(['-c', 'pass']),
            **{name: partial(whole, ['-c', f'import {name}']) for name in IMPORTS},
        }
    )
    allowed = 1.3 * seconds['minimal'] + 0.5
    claims = [
        Claim(
            'wall time to the first message over (1.3 minimal rclpy node + 0.5 s)',
            milliseconds(seconds['ours']),
            milliseconds(seconds['minimal']),
            seconds['ours'] / allowed,
            1.0,
            at_most=True,
        ),
        Claim(
            '`satdyn --help` over (`python -c pass` + 0.2 s)',
            milliseconds(seconds['help']),
            milliseconds(seconds['pass']),
            seconds['help'] / (seconds['pass'] + 0.2),
            1.0,
            at_most=True,
        ),
    ]
    cost = {name: seconds[name] - seconds['pass'] for name in IMPORTS}
    text = (
        f'To import the node takes {milliseconds(cost["satdyn_ros.ros.start"])}; each in a '
        f'process of its own, numba takes {milliseconds(cost["numba"])}, rclpy '
        f'{milliseconds(cost["rclpy"])} and numpy {milliseconds(cost["numpy"])}, which numba and '
        'rclpy import too.'
    )
    return 'Start', show(claims), text


if __name__ == '__main__':
    main()

"""From the command to the first published message and the first line of help; first starts."""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from functools import partial
from pathlib import Path

from common import QUICK, Claim, medians, milliseconds, show

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

PROPAGATE = """
import sys
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.run.scenario import Scenario
scenario = Scenario.from_yaml(sys.argv[1])
Propagation(scenario.system, scenario.initial_state).at([60.0])
"""

# Two scenarios whose equations are of different kinds, and what is done with each.
SCENARIOS = 'default', 'cubesat_leo'
COMMANDS = {
    'describe {}': ['-m', 'satdyn_ros.cli.main', 'describe', '{}'],
    'simulate {} --duration 60': [
        *('-m', 'satdyn_ros.cli.main', 'simulate', '{}', '--duration', '60', '-o', 'run'),
    ],
    'a propagation of {} in Python': ['-c', PROPAGATE, '{}'],
}


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


def cpu_seconds(arguments: list[str], cache: str) -> float:
    """Return the CPU seconds of a process and its children, with compiled code in a folder."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [sys.executable, *arguments],
            cwd=folder,
            env=os.environ | {'NUMBA_CACHE_DIR': cache, 'PYTHONPATH': str(ROOT)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            check=True,
        )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def first_starts(rounds: int) -> list[Claim]:
    """
    Return the claims of starts without compiled code.

    Of each command: with no code at all, with that of the other scenario, and again.
    """
    seconds = defaultdict(list)
    for _ in range(rounds):
        for command, arguments in COMMANDS.items():
            for first, other in (SCENARIOS, SCENARIOS[::-1]):

                def run(scenario, cache, arguments=arguments):
                    return cpu_seconds([each.replace('{}', scenario) for each in arguments], cache)

                with tempfile.TemporaryDirectory() as cache:
                    seconds[command, first, 'none'].append(run(first, cache))
                    seconds[command, other, 'another'].append(run(other, cache))
                    seconds[command, other, 'its own'].append(run(other, cache))
    claims = []
    for command in COMMANDS:
        for scenario in SCENARIOS:
            code = {
                kind: statistics.median(seconds[command, scenario, kind])
                for kind in ('none', 'another', 'its own')
            }
            for kind, what, must, aim in (
                ('none', 'with no compiled code', 5.0, 2.5),
                ('another', 'with that of the other scenario', 1.5, None),
            ):
                claims.append(
                    Claim(
                        f'{command.format(scenario)}, {what}, over its next start',
                        f'{code[kind]:.2f} s',
                        f'{code["its own"]:.2f} s',
                        code[kind] / code['its own'],
                        must,
                        aim,
                        at_most=True,
                    )
                )
    return claims


def main(rounds=3):
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
        *first_starts(1 if QUICK else rounds),
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

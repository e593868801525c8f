"""The environment of a low orbit: what its tables and torques cost a day, and a tick live."""

import itertools
import subprocess
import sys
import tempfile
from pathlib import Path

from common import QUICK, Claim, medians, milliseconds, show
from live import ENVIRONMENT, RATE_HZ, cpu_of_a_tick, start, stop
from offline import written

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.base.nanoseconds import SECOND_NS
from satdyn_ros.run.keys import KEYS
from satdyn_ros.run.scenario import Scenario

DAY_S = 600.0 if QUICK else 86_400.0
# When live pieces of the tables end, in seconds from the first tick, and how long is watched.
EDGE_S, AFTER_EDGE = 3, 100
LATER = itertools.count(1)

STATE = 'attitude', 'imu'
CUBESAT = Scenario.from_yaml('cubesat_leo').with_values({'publish.topics': STATE})
GRADIENT = CUBESAT.with_values(
    {name: KEYS[name].default for name in CUBESAT.values if name.startswith('environment.')}
)
SENT = 'magnetic_field', 'sun_direction', 'sunlight', 'geodetic'

LAG = """
import struct, sys, time
import rclpy
from geometry_msgs.msg import QuaternionStamped
epoch_ns, edge_s, count, rate_hz = map(int, sys.argv[1:])
rclpy.init()
node = rclpy.create_node('lag')
delays_ns = {}
def take(data):
    seconds, nanoseconds = struct.unpack_from('<iI', data, 4)
    at_ns = seconds * 10**9 + nanoseconds - epoch_ns
    delays_ns[at_ns * rate_hz // 10**9] = time.monotonic_ns() - at_ns
node.create_subscription(QuaternionStamped, 'attitude', take, 1000, raw=True)
watched = range(edge_s * rate_hz, edge_s * rate_hz + count)
while watched[-1] not in delays_ns:
    rclpy.spin_once(node)
median_ns = sorted(delays_ns.values())[len(delays_ns) // 2]
print((max(delays_ns[k] for k in watched) - median_ns) * 1e-9)
"""


def at(flight, later_s):
    """Return a flight from some seconds later on: runs of one instant share their tables."""
    return flight.with_values({'time.epoch_ns': flight.epoch_ns + round(later_s * SECOND_NS)})


def day(flight):
    """Return a contender that records a day with tables of its own."""

    def record(directory):
        for _ in simulate(at(flight, next(LATER)), DAY_S, directory / 'day'):
            pass

    return written(record)


def node(flight, directory):
    """Start our node with a flight, recording."""
    live = {
        'publish.rate': RATE_HZ,
        'record.enabled': True,
        'record.directory': directory,
    }
    file = Path(directory) / 'parameters.yaml'
    file.write_text(flight.with_values(live).to_yaml())
    return start(['-m', 'satdyn_ros.cli.main', 'node', '--params-file', str(file)])


def lag_at_edge(flight, directory) -> float:
    """
    Return by how much the latest of some ticks from EDGE_S on is later than most [s].

    There pieces of the tables end, and a thread makes those after the next.
    """
    assert CUBESAT.system.environment is not None
    edge_s = CUBESAT.system.environment.magnetic_field.piece_at(60.0).end_s
    flight = at(flight, edge_s - EDGE_S)
    arguments = flight.epoch_ns, EDGE_S, AFTER_EDGE, RATE_HZ
    subscriber = subprocess.Popen(
        [sys.executable, '-c', LAG, *map(str, arguments)],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        text=True,
    )
    process = node(flight, directory)
    lag_s = float(subscriber.communicate(timeout=120.0)[0])
    stop(process)
    return lag_s


def offline(rounds):
    """Return the claims about a recorded day."""
    seconds = medians(
        {
            'gradient': day(GRADIENT),
            'environment': day(CUBESAT),
            'and sent': day(CUBESAT.with_values({'publish.topics': STATE + SENT})),
        },
        rounds,
    )
    return [
        Claim(
            what,
            milliseconds(seconds[contender]),
            milliseconds(seconds['gradient']),
            seconds[contender] / seconds['gradient'],
            must,
            at_most=True,
        )
        for contender, what, must in (
            (
                'environment',
                'a day at 10 Hz with field, air and Sun, over that with gravity gradient alone',
                3.0,
            ),
            ('and sent', 'the same with four topics of the environment more', None),
        )
    ]


def live(rounds):
    """Return the claims about the node."""
    with tempfile.TemporaryDirectory() as directory:
        gradient, environment = medians(
            {
                'gradient': lambda: cpu_of_a_tick(lambda: node(GRADIENT, directory)),
                'environment': lambda: cpu_of_a_tick(lambda: node(CUBESAT, directory)),
            },
            rounds,
        ).values()
        lag_s, lag_environment_s = medians(
            {
                'gradient': lambda: lag_at_edge(GRADIENT, directory),
                'environment': lambda: lag_at_edge(CUBESAT, directory),
            },
            rounds,
        ).values()
    return [
        Claim(
            f'CPU of a tick at {RATE_HZ} Hz beyond that with gravity gradient alone, over 15 us',
            f'{environment:.0f} us',
            f'{gradient:.0f} us',
            (environment - gradient) / 15.0,
            1.0,
            at_most=True,
        ),
        Claim(
            f'lag of the latest of {AFTER_EDGE} ticks as tables are made, beyond that, over 1 ms',
            milliseconds(lag_environment_s),
            milliseconds(lag_s),
            (lag_environment_s - lag_s) * RATE_HZ,
            1.0,
            at_most=True,
        ),
    ]


def main(rounds=7):
    """Run all; return title, claims and text."""
    return 'Environment', show(offline(rounds) + live(rounds)), ''


if __name__ == '__main__':
    main()

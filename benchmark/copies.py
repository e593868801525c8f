"""
The cost of the sensors, against topics of the same size and rate that hold copies.

As a program it is the command satdyn whose sensors copy the true state.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

from satdyn_ros.cli.main import main
from satdyn_ros.sensors import Gyro, Measurements, StarTracker
from satdyn_ros.sensors.measurements import as_array, sampled

# A gyro at each tick with all that can be wrong, and a star tracker at each hundredth.
SENSORS = {
    'names': ['gyro', 'star_tracker'],
    'seed': 1,
    'gyro': {
        'integrating': True,
        'noise_density': 1e-5,
        'bias_random_walk': 1e-7,
        'scale_factor': [1e-4, -1e-4, 2e-4],
        'resolution': 1e-6,
        'max_rate': 5.0,
    },
    'star_tracker': {
        'divisor': 100,
        'latency': 6,
        'cross_boresight': 5e-5,
        'roll': 3.5e-4,
        'max_rate': 0.2,
    },
}


@contextmanager
def copying() -> Iterator[None]:
    """Let both sensors give the state as it is."""
    with (
        patch.object(Gyro, 'measure', _copy_of('omega_bi_b')),
        patch.object(StarTracker, 'measure', _copy_of('q_ib')),
    ):
        yield


def _copy_of(column):
    def measure(sensor, ticks, states, memory):
        samples = sampled(ticks, sensor.divisor)
        rows = slice(samples.start - ticks.start, None, sensor.divisor)
        exposed = as_array(samples)
        return Measurements(exposed, exposed, getattr(states, column)[rows]), memory

    return measure


if __name__ == '__main__':
    with copying():
        sys.exit(main())

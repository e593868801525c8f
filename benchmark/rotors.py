"""
What each further free rotor costs: ten orbits of a satellite with one to four of them.

The time is that of a step: the motions differ, and with them the number of steps.
"""

import time

import numpy as np
from common import Claim, medians, show

from satdyn_ros.dynamics.propagator import Propagation
from satdyn_ros.run.scenario import Scenario

SPAN_S = 57_120.0
AXES = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8])


def scenario(count):
    """Return a tumbling satellite with free rotors of its own axes."""
    names = [f'r{i}' for i in range(count)]
    values = {'body.inertia': [900.0, 800.0, 600.0], 'rotor.names': names}
    values |= {'initial.frame': 'inertial', 'initial.angular_velocity': [0.01, 0.02, -0.015]}
    for name, axis in zip(names, AXES, strict=False):
        values |= {f'rotor.{name}.mode': 'free', f'rotor.{name}.axis': axis}
        values |= {f'rotor.{name}.inertia': 2.0, f'rotor.{name}.speed': 10.0}
    return Scenario(values)


def main(rounds=21):
    """Run all; return title, claims and text."""

    def propagation(count):
        given = scenario(count)

        def run():
            begin = time.process_time()
            motion = Propagation(given.system, given.initial_state)
            motion.at(np.array([SPAN_S]))
            return (time.process_time() - begin) / motion.steps

        return run

    seconds = medians({str(n): propagation(n) for n in range(1, len(AXES) + 1)}, rounds)
    claims = [
        Claim(
            f'{n} free rotors over {n - 1}, a step',
            f'{seconds[str(n)] * 1e9:.0f} ns',
            f'{seconds[str(n - 1)] * 1e9:.0f} ns',
            seconds[str(n)] / seconds[str(n - 1)],
            must=1.2,
            at_most=True,
        )
        for n in range(2, len(AXES) + 1)
    ]
    return 'Rotors', show(claims), ''


if __name__ == '__main__':
    main()

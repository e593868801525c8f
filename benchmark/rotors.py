"""
What each further free rotor costs: ten orbits of a satellite with one to four of them.

The time is that of a step: the motions differ, and with them the number of steps.  With a tilted
rotor the carrier's inertia is no diagonal matrix, which costs a step more than the rotor itself:
the two are not compared with each other.
"""

import time

import numpy as np
from common import QUICK, Claim, medians, show

from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.run.scenario import Scenario

SPAN_S = 57_120.0
AXES = {
    'free': ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
    'tilted free': ([0.6, 0.0, 0.8], [0.8, 0.6, 0.0], [0.0, 0.8, 0.6], [-0.6, 0.0, 0.8]),
}


def scenario(axes):
    """Return a tumbling satellite with free rotors about some axes."""
    names = [f'r{i}' for i in range(len(axes))]
    values = {'body.inertia': [900.0, 800.0, 600.0], 'rotor.names': names}
    values |= {'initial.frame': 'inertial', 'initial.angular_velocity': [0.01, 0.02, -0.015]}
    for name, axis in zip(names, axes, strict=True):
        values |= {f'rotor.{name}.mode': 'free', f'rotor.{name}.axis': axis}
        values |= {f'rotor.{name}.inertia': 2.0, f'rotor.{name}.speed': 10.0}
    return Scenario(values)


def main(rounds=21):
    """Run all; return title, claims and text."""

    def propagation(axes):
        given = scenario(axes)

        def run():
            begin = time.process_time()
            motion = Propagation(given.system, given.initial_state)
            motion.at(np.array([SPAN_S]))
            return (time.process_time() - begin) / motion.steps

        return run

    # With each, code of its own is compiled once.
    counts = range(1, 3 if QUICK else 5)
    seconds = medians(
        {(kind, n): propagation(axes[:n]) for kind, axes in AXES.items() for n in counts}, rounds
    )
    claims = [
        Claim(
            f'{n} {kind} rotors over {n - 1}, a step',
            f'{seconds[kind, n] * 1e9:.0f} ns',
            f'{seconds[kind, n - 1] * 1e9:.0f} ns',
            seconds[kind, n] / seconds[kind, n - 1],
            must=1.2,
            at_most=True,
        )
        for kind in AXES
        for n in counts[1:]
    ]
    return 'Rotors', show(claims), ''


if __name__ == '__main__':
    main()

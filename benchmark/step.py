"""
What an attempt of a step costs, by what the equations hold: of one motion, and in eight lanes.

It is the code alone that the walk calls by its address, without the control of the step and
without dense output.  The scenarios have steps of different lengths: the time of an attempt is one
of the equations, not of how long a propagation takes.
"""

import time
from typing import Any

import numpy as np
from common import QUICK, Claim, medians, show

from satdyn_ros.integrate.batch import LANES
from satdyn_ros.integrate.course import problem_of
from satdyn_ros.integrate.lanes import REACHED, UNFINISHED, Lanes
from satdyn_ros.integrate.layout import ARRAYS
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.integrate.step_code import step_code
from satdyn_ros.integrate.walk import walk
from satdyn_ros.kernel.looped import looped
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.trace.graph import flatten
from satdyn_ros.trace.memory import call, floats, integers

ATTEMPTS = 100 if QUICK else 5_000
# Where the steps have found their length.
BEGIN_S = 100.0
DEFAULT = 'default'
# What is changed in the default scenario; None: another shipped one, of that name.
SCENARIOS: dict[str, dict[str, Any] | None] = {
    DEFAULT: {},
    'a free rotor more': {
        'rotor.names': ['wheel', 'free'],
        **{'rotor.wheel.mode': 'constant_momentum', 'rotor.wheel.axis': [0.0, 1.0, 0.0]},
        'rotor.wheel.momentum': -5.0,
        **{'rotor.free.mode': 'free', 'rotor.free.axis': [1.0, 0.0, 0.0]},
        **{'rotor.free.inertia': 0.05, 'rotor.free.speed': 10.0},
    },
    'the magnetic torque': {'body.dipole': [0.0, 0.0, 10.0], 'environment.magnetic_field': 'igrf'},
    'the aerodynamic torque': {
        **{'body.box': [1.0, 1.0, 2.0], 'body.box_centre': [0.0, 0.0, 0.1]},
        **{'environment.atmosphere': 'msis', 'environment.ap': 4.0},
        **{'environment.f107': 67.0, 'environment.f107_average': 67.0},
    },
    'the solar torque': {
        **{'body.box': [1.0, 1.0, 2.0], 'body.box_centre': [0.0, 0.0, 0.1]},
        'environment.sun': 'ephemeris',
    },
    'cubesat_leo': None,
}
_Y, _DENSE = ARRAYS.index('y'), ARRAYS.index('dense')


@looped
def attempts(count: int, attempt: int, lanes_at: int, size: int) -> int:
    """Take steps of one length, each from where the last one ended, as those of a walk."""
    lanes = integers(lanes_at)
    y, y_0 = floats(lanes[_Y]), floats(lanes[_DENSE])
    for _ in range(count):
        call(attempt, lanes_at)
        for i in range(size):
            y_0[i] = y[i]
    return count


def scenario(name: str) -> Scenario:
    """Return a scenario of the table."""
    changes = SCENARIOS[name]
    if changes is None:
        return Scenario.from_yaml(name)
    values = {**Scenario.from_yaml(DEFAULT).values, 'time.epoch': '2026-03-01T00:00:00Z'}
    values.pop('time.epoch_ns', None)
    if 'rotor.names' in changes:
        values = {key: x for key, x in values.items() if not key.startswith('rotor.')}
    return Scenario({**values, **changes})


def in_lanes(given: Scenario, count: int):
    """Return what takes a step of so many equal motions and measures the seconds of one."""
    motions = [Propagation(given.system, given.initial_state) for _ in range(count)]
    courses = [motion.new_course() for motion in motions]
    constants = courses[0].constants
    of_lanes, of_one = step_code(constants, count), step_code(constants, 1)
    begin, t_s = np.array([motion.begin() for motion in motions]), np.array([BEGIN_S])
    problem = problem_of(begin, courses, of_lanes.layout, motions[0].wanted)
    problem.ask(t_s)
    _, arrays = flatten(constants)
    lanes = Lanes(count, of_lanes.layout, arrays)
    single = lanes if count == 1 else Lanes(1, of_one.layout, arrays)
    tables = problem.address, lanes.address, single.address
    while not walk(*tables, of_lanes.attempt, of_one.dense):
        for l, m in enumerate(lanes.motion):
            if m >= 0 and UNFINISHED < problem.outcome[m] < REACHED:
                courses[m].go_on(problem, lanes, l, t_s)
    found = lanes.y.copy()

    def run():
        # The tables of the courses are those to which the lanes have addresses.
        assert courses
        lanes.y[:] = found
        begin = time.process_time()
        attempts(ATTEMPTS, of_lanes.attempt, lanes.address, len(lanes.y))
        return (time.process_time() - begin) / (ATTEMPTS * count)

    return run


def main(rounds=21):
    """Run all; return title, claims and text."""
    given = {name: scenario(name) for name in SCENARIOS}
    seconds = medians(
        {(name, n): in_lanes(given[name], n) for n in (1, LANES) for name in given}, rounds
    )

    def claim(what, ours, peer):
        times = f'{seconds[ours] * 1e9:.0f} ns', f'{seconds[peer] * 1e9:.0f} ns'
        return Claim(what, *times, seconds[ours] / seconds[peer])

    first, *others = given
    claims = [
        claim(f'{name} over {first}, {where}', (name, n), (first, n))
        for n, where in ((1, 'alone'), (LANES, f'a motion of {LANES} in lanes'))
        for name in others
    ]
    claims += [claim(f'{name}, in lanes over alone', (name, LANES), (name, 1)) for name in given]
    return 'An attempt of a step', show(claims), ''


if __name__ == '__main__':
    main()

"""
What parts that move inside cost: two flexible modes, and a hysteresis rod.

The time is that of a step: the motions differ, and with them the number of steps.  The body has
products of inertia, as its carrier has with modes, and a rod is held against a dipole in the same
field, whose table both read; a rod reads that of the field's derivative too.
"""

import time

import numpy as np
from common import QUICK, Claim, medians, show

from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.run.scenario import Scenario

SPAN_S = 2_000.0 if QUICK else 40_000.0
BODY = {
    'body.inertia': [9.0, 8.0, 6.0, 0.3, -0.2, 0.1],
    'orbit.inclination': 1.1,
    'initial.frame': 'inertial',
    'initial.angular_velocity': [0.01, 0.02, -0.015],
    'time.epoch': '2026-03-01T00:00:00Z',
}
MODES = {
    'flexible.names': ['left', 'right'],
    'flexible.left.frequency': 0.05,
    'flexible.left.coupling': [0.6, -0.2, 0.1],
    'flexible.right.frequency': 0.07,
    'flexible.right.coupling': [0.1, 0.4, -0.5],
}
FIELD = {'environment.magnetic_field': 'dipole'}
ROD = {
    'hysteresis.names': ['rod'],
    'hysteresis.rod.axis': [0.6, 0.0, 0.8],
    'hysteresis.rod.volume': 1e-6,
    'hysteresis.rod.coercive_force': 12.0,
    'hysteresis.rod.remanence': 0.004,
    'hysteresis.rod.saturation': 0.025,
}
FLOWN = {
    'body': BODY,
    'two modes': BODY | MODES,
    'dipole': BODY | FIELD | {'body.dipole': [0.01, 0.0, 0.02]},
    'rod': BODY | FIELD | ROD,
}


def propagation(values):
    """Return a contender that takes the steps of a scenario and returns the time of one [s]."""
    given = Scenario(values)

    def run():
        motion = Propagation(given.system, given.initial_state)
        motion.at(0.0)
        begin = time.process_time()
        motion.at(np.array([SPAN_S]))
        return (time.process_time() - begin) / motion.steps

    return run


def main(rounds=21):
    """Run all; return title, claims and text."""
    seconds = medians({name: propagation(values) for name, values in FLOWN.items()}, rounds)
    claims = [
        Claim(
            f'{one} over {other}, a step',
            f'{seconds[one] * 1e9:.0f} ns',
            f'{seconds[other] * 1e9:.0f} ns',
            seconds[one] / seconds[other],
            must=must,
            at_most=True,
        )
        for one, other, must in (('two modes', 'body', 1.5), ('rod', 'dipole', 1.5))
    ]
    return 'Parts that move inside', show(claims), ''


if __name__ == '__main__':
    main()

"""Where the time of a step goes: its parts alone, and those that overlap in one loop."""

import time

import numpy as np
from common import medians
from problem import DURATION_S, GRID_S, START, system

from satdyn_ros.integrate import dop853
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel.compile import compiled
from satdyn_ros.kernel.simd import PACK, zero

TOLERANCE, STEPS = 2.5e-13, 20_000
ALWAYS = -np.inf, np.inf
evaluate, combine, attempt = dop853.evaluate, dop853.combine, dop853.attempt


@compiled
def stages(count, arrays, h, constants):
    """Evaluate the equations twelve times a step, each with what the last one gave."""
    y, k = arrays.y, arrays.k
    for _ in range(count):
        for i in range(12):
            evaluate(0.0, y, h, constants, k, i)
            for j in range(7):
                y[j] += 1e-9 * k[i * len(y) + j]


@compiled
def combinations(count, arrays, h, constants):
    """Combine the stages to the argument of the next, twelve times a step."""
    for _ in range(count):
        for i in range(12):
            combine(i + 1, arrays.y_0, arrays.k, arrays.y, len(arrays.y), zero(PACK))


@compiled
def both(count, arrays, h, constants):
    """Evaluate and combine in turn, as a step does."""
    for _ in range(count):
        for i in range(12):
            evaluate(0.0, arrays.y, h, constants, arrays.k, i)
            combine(i + 1, arrays.y_0, arrays.k, arrays.y, len(arrays.y), zero(PACK))


@compiled
def attempts(count, arrays, h, constants):
    """Do both and estimate the error."""
    for _ in range(count):
        h += 1e-30 * attempt(arrays, 0.0, h, ALWAYS, constants, len(arrays.y), zero(PACK))
        arrays.y[:] = arrays.y_0


def text(rounds: int = 21) -> str:
    """Measure, and return the paragraph that tells of it."""

    def propagation(t_s):
        def run():
            motion = Propagation(system(), START, tolerance=TOLERANCE)
            begin = time.process_time()
            motion.at(t_s)
            return (time.process_time() - begin) / motion.steps

        return run

    def part(function):
        def run():
            motion = Propagation(system(), START, tolerance=TOLERANCE)
            motion.at(np.array([1.0]))
            clock = motion._clock
            h = clock[dop853.END] - clock[dop853.BEGIN]
            given = motion._stages, h, motion.constants
            begin = time.process_time()
            function(STEPS, *given)
            return (time.process_time() - begin) / STEPS

        return run

    seconds = medians(
        {
            'step': propagation(np.array([DURATION_S])),
            'step with two rows': propagation(GRID_S[::50].copy()),
            'step with a hundred rows': propagation(GRID_S),
            **{run.__name__: part(run) for run in (stages, combinations, both, attempts)},
        },
        rounds,
    )
    ns = {name: round(each * 1e9) for name, each in seconds.items()}
    return (
        f'A step of the test problem takes {ns["step"]} ns.  The equations, twelve times, take '
        f'{ns["stages"]} ns alone, each waiting for the last, and the combinations of the stages '
        f'{ns["combinations"]} ns alone; in turn, as a step has them, they overlap and take '
        f'{ns["both"]} ns: what bounds them is that each waits for the last, not how much there '
        f'is to do.  The estimate of the error takes {ns["attempts"] - ns["both"]} ns.  The rest, '
        f'{ns["step"] - ns["attempts"]} ns, was not measured apart: the control of the step, '
        'whose roots and quotients the next step waits for.  No step '
        'of this problem is taken again.  All that a step touches is some kB, which the '
        'first-level cache holds.  The dense output of a step takes '
        f'{ns["step with two rows"] - ns["step"]} ns more with two rows, four stages and seven '
        f'combinations, and each further row '
        f'{(seconds["step with a hundred rows"] - seconds["step with two rows"]) / 100 * 1e9:.1f}'
        ' ns.'
    )


if __name__ == '__main__':
    print(text())

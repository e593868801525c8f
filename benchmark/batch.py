"""Many trajectories compared with heyoka's batch and ensemble modes, and one core with two."""

from concurrent.futures import ProcessPoolExecutor

import heyoka as hy
import numpy as np
from common import QUICK, Claim, medians, milliseconds, one_and_two_cores, show
from problem import (
    DURATION_S,
    START,
    check,
    from_lvlh,
    heyoka_equations,
    system,
    to_lvlh,
)

from satdyn_ros.dynamics.system import State
from satdyn_ros.integrate.batch import propagate_many

COUNT, LANES = 128, 8
OURS, HEYOKA = 3e-13, 5e-12
END_S = np.array([DURATION_S])
# Slightly different rates, the first of them the test problem's.
RATES = START.omega_bi_b * (1.0 + 1e-3 * np.arange(COUNT))[:, None]
# So many that giving out the work does not show.
MANY = np.tile(RATES, (1 if QUICK else 32, 1))


def ours(rates=RATES):
    """Propagate from every rate, side by side; return the last attitudes."""
    count = len(rates)
    starts = State(np.tile(START.q_ib, (count, 1, 1)), rates[:, None])
    states, arrived = propagate_many(system(), starts, np.full(count, OURS), END_S)
    assert arrived.all()
    return states.q_ib[:, 0]


def heyoka_batch(lvlh=False):
    """
    Return a function that does the same with heyoka's batch integrator, compiled once.

    lvlh: of q_lb in place of q_ib, which it then returns.
    """
    integrator = hy.taylor_adaptive_batch(heyoka_equations(lvlh), np.zeros((7, LANES)), tol=HEYOKA)
    attitude = to_lvlh(START.q_ib) if lvlh else START.q_ib

    def run():
        attitudes = []
        for first in range(0, COUNT, LANES):
            integrator.set_time(0.0)
            integrator.state[:4] = attitude[:, None]
            integrator.state[4:] = RATES[first : first + LANES].T
            integrator.propagate_until(np.full(LANES, DURATION_S))
            attitudes.append(integrator.state[:4].T.copy())
        return np.concatenate(attitudes)

    return run


def heyoka_ensemble():
    """Return a function that does the same with heyoka's ensemble, its threads on all cores."""
    y_0 = np.concatenate([START.q_ib, START.omega_bi_b])
    integrator = hy.taylor_adaptive(heyoka_equations(), y_0, tol=HEYOKA)

    def begin(copy, i):
        copy.time = 0.0
        copy.state[:] = np.concatenate([START.q_ib, RATES[i]])
        return copy

    def run():
        done = hy.ensemble_propagate_until(integrator, DURATION_S, COUNT, begin)
        return np.array([one[0].state[:4] for one in done])

    return run


def many(pool: ProcessPoolExecutor) -> None:
    """Propagate MANY in a pool of processes."""
    for _ in pool.map(ours, np.split(MANY, len(MANY) // 64)):
        pass


def main():
    """Run all; return title, claims and text."""
    contenders = {
        'ours': ours,
        'heyoka batch': heyoka_batch(),
        'heyoka batch, LVLH': heyoka_batch(lvlh=True),
        'heyoka ensemble': heyoka_ensemble(),
    }
    for name, run in contenders.items():
        q = run()[:1]
        check(name, from_lvlh(q, END_S) if 'LVLH' in name else q, END_S)
    seconds = medians(contenders)
    claims = [
        Claim(
            f'a trajectory of {COUNT}, against {peer}',
            milliseconds(seconds['ours'] / COUNT),
            milliseconds(seconds[peer] / COUNT),
            seconds['ours'] / seconds[peer],
            1.0,
            0.8,
            at_most=True,
        )
        for peer in list(contenders)[1:]
    ]
    claims.append(one_and_two_cores(f'{len(MANY)} trajectories', many, 1.8))
    return 'Many trajectories', show(claims), ''


if __name__ == '__main__':
    main()

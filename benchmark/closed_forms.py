"""A million random times of each closed form, compared with the propagation to the same times."""

from pathlib import Path

import numpy as np
from common import QUICK, Claim, medians, milliseconds, show

from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.run.scenario import Scenario

CONFIG = Path(__file__).parents[1] / 'config'
SCENARIOS = ('agostinelli', 'beletsky', 'balli_grioli', 'paladini', 'euler_poinsot')
TIMES = 10_000 if QUICK else 1_000_000


def main(rounds=7):
    """Run all; return title, claims and text."""
    claims, rows = [], ['| closed form | largest difference [rad] |', '| --- | --- |']
    for name in SCENARIOS:
        scenario = Scenario.from_yaml(CONFIG / f'{name}.yaml')
        exact = scenario.motion()
        span_s = 10.0 * (exact.period_s or 1000.0)
        t_s = np.random.default_rng(1).uniform(0.0, span_s, TIMES)

        def propagate(scenario=scenario, t_s=t_s):
            return Propagation(scenario.system, scenario.initial_state).at(t_s)

        def evaluate(exact=exact, t_s=t_s):
            return exact.at(t_s)

        difference = 2.0 * np.max(
            np.linalg.norm(
                np.minimum(
                    np.abs(evaluate().q_ib - propagate().q_ib),
                    np.abs(evaluate().q_ib + propagate().q_ib),
                ),
                axis=1,
            )
        )
        rows.append(f'| {exact.name} ({exact.source}) | {difference:.2g} |')
        seconds = medians({'ours': evaluate, 'propagation': propagate}, rounds)
        claims.append(
            Claim(
                f'{name}, 1e6 random times: cost over that of the propagation to them',
                milliseconds(seconds['ours']),
                milliseconds(seconds['propagation']),
                seconds['ours'] / seconds['propagation'],
                must=1.0,
                aim=0.4,
                at_most=True,
            )
        )
    text = '\n'.join(rows)
    print(text)
    return 'Closed forms', show(claims), text


if __name__ == '__main__':
    main()

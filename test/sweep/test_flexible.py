"""A sweep over what describes flexible modes: each run is that of its scenario alone."""

import numpy as np
import pyarrow.parquet as pq
import yaml
from actuated import cases

from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.run import sweep

VARY = {
    'flexible.left.frequency': {'values': [0.5, 2.0]},
    'flexible.left.displacement': {'uniform': [0.0, 0.1]},
    'flexible.right.coupling': {'values': [[0.1, 0.0, 0.3], [0.0, 0.5, 0.0], [0.0, 9.0, 0.0]]},
}


def test_runs_side_by_side_are_those_alone(tmp_path):
    """Bit by bit; what leaves the body no inertia is refused by itself."""
    body = {'/**': {'ros__parameters': cases('flexible.json')['flex_two_free']['scenario']}}
    (tmp_path / 'body.yaml').write_text(yaml.safe_dump(body))
    given = {'scenario': 'body.yaml', 'duration_s': 50.0, 'runs': 2, 'vary': VARY}
    (tmp_path / 'sweep.yaml').write_text(yaml.safe_dump(given))
    table = pq.read_table(sweep(tmp_path / 'sweep.yaml', tmp_path / 'out', workers=1)).to_pylist()
    plan = Plan.from_yaml(tmp_path / 'sweep.yaml')
    refused = [row for row in table if row['failure']]
    assert len(table) == 12
    assert len(refused) == 4
    assert all('flexible.right.coupling' in row['failure'] for row in refused)
    for row in table:
        if not row['failure']:
            alone = plan.scenario_of(plan.values(row['run'])).motion().at(50.0)
            np.testing.assert_array_equal(row['q_ib'], alone.q_ib[0])
            assert abs(row['drift_energy']) < 1e-11

"""The reference cases of bodies with parts that move inside, run by their scenarios and events."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from satdyn_ros import Scenario, Simulation
from satdyn_ros.kernel import rotation
from satdyn_ros.run import events
from satdyn_ros.run.samples import Samples

REFERENCE = Path(__file__).parent / 'reference'


@cache
def cases(file: str) -> dict[str, dict[str, Any]]:
    """Return the cases of a file by their names."""
    return {raw['name']: raw for raw in json.loads((REFERENCE / file).read_text())['cases']}


def flown(raw: dict[str, Any], parts: int = 1) -> tuple[Scenario, list[Samples]]:
    """Return the scenario of a case, and its samples at the times of the truth, one each."""
    scenario = Scenario.from_dict(raw['scenario'])
    listed = events.from_yaml_text(yaml.safe_dump(raw['events']), scenario)
    simulation = Simulation(scenario, listed)
    found = []
    for row in raw['states']:
        tick = round(row['t'] * float(scenario.rate))
        while tick > simulation.next_tick:
            simulation.advance(tick - simulation.next_tick)
        found.append(simulation.advance(1)[1])
    return scenario, found


def check(raw: dict[str, Any], samples: list[Samples]) -> None:
    """Compare attitudes with the bound of a case, all else with the bound times its largest."""
    rows, bound = raw['states'], raw['bound']
    q = np.array([row['q_xyzw'] for row in rows])
    found = np.concatenate([each.states.q_ib for each in samples])
    assert np.max(rotation.angle_between(found, q)) < bound
    _compare(bound, [row['omega'] for row in rows], [s.states.omega_bi_b[0] for s in samples])
    if 'rotor_speed' in rows[0]:
        _compare(
            bound, [row['rotor_speed'] for row in rows], [s.states.rotor_speed[0] for s in samples]
        )
    for name in rows[0].get('flexible', {}):
        for i, leaf in enumerate(('displacement', 'rate')):
            true = [row['flexible'][name][i] for row in rows]
            _compare(bound, true, [s.states.inner[f'flexible.{name}.{leaf}'][0] for s in samples])


def _compare(bound, true, found):
    true, found = np.array(true, float), np.array(found, float)
    np.testing.assert_allclose(found, true, rtol=0.0, atol=bound * np.nanmax(np.abs(true)))

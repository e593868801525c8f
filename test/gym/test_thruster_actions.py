"""Thrusters in environments of Gymnasium: an action is a fraction of an on-time."""

import numpy as np
import pytest

gymnasium = pytest.importorskip('gymnasium')

from satdyn_ros import Scenario  # noqa: E402
from satdyn_ros.gym import SatelliteEnv, SatelliteVectorEnv  # noqa: E402
from satdyn_ros.gym.task import Task  # noqa: E402

THRUST, ARM, MOMENT, LONGEST_S = 3.0, 0.5, 2.0, 0.5
PAIR = Scenario(
    {
        'orbit.type': 'fixed',
        'body.inertia': [MOMENT, 1.5, 1.0],
        'initial.attitude': [0.0, 0.0, 0.0, 1.0],
        'publish.rate': 10.0,
        'thruster.names': ['a', 'b'],
        'thruster.a.position': [0.0, ARM, 0.0],
        'thruster.a.thrust': THRUST,
        'thruster.b.position': [0.0, -ARM, 0.0],
        'thruster.b.thrust': THRUST,
    }
)
TASK = Task(
    PAIR,
    observation={'omega_bi_b': 1.0},
    action={'thrusters': {'a': LONGEST_S, 'b': LONGEST_S}},
    reward=lambda sample, action: -np.sum(sample.omega_bi_b**2, axis=-1),
    duration_s=10.0,
    interval_s=LONGEST_S,
)


@pytest.mark.parametrize(
    ('action', 'share'), [((0.4, -1.0), 0.4), ((0.0, 1.0), -1.0), ((-1, -1), 0)]
)
def test_an_action_is_a_fraction_of_an_on_time(action, share):
    """The rate after it is that of its impulse; it is given once, and below zero there is none."""
    env = SatelliteEnv(TASK)
    env.reset(seed=1)
    seen, *_ = env.step(np.array(action))
    assert seen[0] == pytest.approx(share * LONGEST_S * THRUST * ARM / MOMENT, abs=1e-12)
    again, *_ = env.step(np.zeros(2))
    assert again[0] == pytest.approx(seen[0], abs=1e-12)


def test_in_step_they_are_refused():
    """One sentence says that they fly one by one."""
    with pytest.raises(ValueError, match=r'runs with thruster\.names fly one by one'):
        SatelliteVectorEnv(TASK, num_envs=2).reset(seed=1)

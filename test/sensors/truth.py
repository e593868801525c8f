"""True states for sensors to measure: a body that turns as a test says, in an environment."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from satdyn_ros.dynamics.motion import States
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection


def everywhere(**vectors) -> Any:
    """Return an environment that has the same vector (3,) at all times in each of its tables."""

    def table(vector):
        return SimpleNamespace(
            values=lambda t_s, columns: np.tile(np.asarray(vector, float), (len(t_s), 1))
        )

    return SimpleNamespace(**{name: table(vector) for name, vector in vectors.items()})


def turning(count, rate_b, interval_s, orbit=None, q_ib=rotation.IDENTITY, environment=None):
    """Return the states of a body that turns at a constant rate_b (3,) [rad/s] from q_ib on."""
    t_s = np.arange(count) * interval_s
    nothing = np.full((count, 1), np.nan)
    turn_b = np.tile(np.multiply(rate_b, interval_s), (count, 1))
    turn_b[:1] = 0.0
    return States(
        t_s=t_s,
        q_ib=rotation.multiply(q_ib, rotation.from_vector(np.outer(t_s, rate_b))),
        omega_bi_b=np.tile(np.asarray(rate_b, float), (count, 1)),
        rotor_speed=nothing,
        rotor_angle=nothing,
        work=np.zeros(count),
        orbit=orbit or FixedDirection(),
        orbit_s=t_s,
        turn_b=turn_b,
        environment=environment,
    )


def at_tick_0(scenario):
    """Return the state of a scenario at tick 0 as a table, without the code that flies it."""
    system, state = scenario.system, scenario.initial_state
    return turning(1, np.zeros(3), 1.0, system.orbit, state.q_ib, system.environment)

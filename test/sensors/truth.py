"""True states for sensors to measure: a body that turns as a test says."""

import numpy as np

from satdyn_ros.dynamics.motion import States
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection


def turning(count, rate_b, interval_s, orbit=None, q_ib=rotation.IDENTITY):
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
    )

"""A torque of one's own: it depends on the time and on the attitude, and fires once."""

import math
from typing import NamedTuple

import numpy as np

from satdyn_ros.torques import BodyTorque, Key, select


class Gust(BodyTorque):
    name = 'gust'
    keys = (
        Key('gust.size', 'double', 0.0, 'N m', 'of the swinging part'),
        Key('gust.rate', 'double', 0.02, 'rad/s', 'how fast it swings', above=0.0),
        Key('gust.kick', 'double_array', (0.0, 0.0, 0.0), 'N m', 'while it fires', lengths=(3,)),
        Key('gust.begin_s', 'double', 50.0, 's', 'when it fires, for ten seconds'),
    )

    class Constants(NamedTuple):
        size: float
        rate: float
        kick: tuple[float, float, float]
        begin_s: float

    @staticmethod
    def torque(t_s, r_i, v_i, q_ib, omega_bi_b, constants):
        begin_s = constants.begin_s
        fires = select(t_s < begin_s, 0.0, select(t_s < begin_s + 10.0, 1.0, 0.0))
        x, y, z = constants.kick
        swing = constants.size * math.cos(constants.rate * t_s) * q_ib[2]
        return fires * x + swing, fires * y, fires * z - swing * q_ib[0]

    def stops(self):
        return self.constants.begin_s + np.array([0.0, 10.0])

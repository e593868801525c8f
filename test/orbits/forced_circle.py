"""A type of orbits in one file: a circle that thrust keeps at another rate than that of a fall."""

from dataclasses import dataclass

import numpy as np

from satdyn_ros.base.key import Key
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits.ellipses import MU, SEMI_MAJOR_AXIS
from satdyn_ros.orbits.orbit import Orbit, OrbitConstants
from satdyn_ros.orbits.orbit_type import OrbitType
from satdyn_ros.orbits.pieces import PIECE_TURN, Stretch


@dataclass(frozen=True)
class ForcedCircle(Orbit):
    """A circle of a radius [m] about +Z, from +X on at a rate [rad/s]."""

    mu: float
    radius_m: float
    turn_rate: float

    is_eccentric = False

    @property
    def mean_motion(self):
        return self.turn_rate

    @property
    def stretches(self):
        return (Stretch(0.0, PIECE_TURN / self.turn_rate),)

    @property
    def constants(self):
        r, rate = self.radius_m, self.turn_rate
        outward, ahead, normal = np.eye(3)
        gradient = 3.0 * self.mu / r**3
        return OrbitConstants(
            rate, gradient, outward, ahead, normal, semi_latus_rectum=r, speed=r * rate
        )

    def anomaly(self, t_s):
        return self.turn_rate * np.asarray(t_s, float)

    def mean_anomaly_at(self, t_s):
        return self.turn_rate * t_s, self.turn_rate, 0.0

    def position_velocity(self, t_s):
        f, zero = self.anomaly(t_s), np.zeros(np.shape(t_s))
        outward = np.stack([np.cos(f), np.sin(f), zero], axis=-1)
        ahead = np.stack([-np.sin(f), np.cos(f), zero], axis=-1)
        return self.radius_m * outward, self.radius_m * self.turn_rate * ahead

    def lvlh(self, t_s):
        r_i, v_i = self.position_velocity(t_s)
        down, ahead = -r_i / self.radius_m, v_i / (self.radius_m * self.turn_rate)
        return rotation.from_matrix(np.stack([ahead, np.cross(down, ahead), down], axis=-1))

    def lvlh_rate(self, t_s):
        return np.broadcast_to([0.0, 0.0, self.turn_rate], (*np.shape(t_s), 3))


class Forced(OrbitType):
    """A forced circle."""

    name = 'forced'
    keys = (
        MU,
        SEMI_MAJOR_AXIS,
        Key('orbit.turn_rate', 'double', 1e-3, 'rad/s', 'its rate', above=0.0, is_optional=True),
    )

    @classmethod
    def orbit(cls, values, is_earlier):
        keys = ('orbit.mu', 'orbit.semi_major_axis', 'orbit.turn_rate')
        return ForcedCircle(*(values[key] for key in keys))

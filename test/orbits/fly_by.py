"""A type of orbits in one file: a straight line past the centre, known as a table."""

from dataclasses import dataclass

import numpy as np

from satdyn_ros.orbits.ellipses import MU, STATE
from satdyn_ros.orbits.orbit_type import OrbitType
from satdyn_ros.orbits.pieces import Stretch
from satdyn_ros.orbits.tabled import OrbitSource, tabled_orbit


@dataclass(frozen=True)
class Line(OrbitSource):
    """The line from a position [m] on with a velocity [m/s]."""

    position: tuple[float, ...]
    velocity: tuple[float, ...]

    stretches = (Stretch(0.0, 100.0),)

    def coefficients(self, piece):
        half_s = piece.stretch.length_s / 2.0
        velocity = np.array(self.velocity)
        middle = self.position + velocity * (piece.begin_s + half_s)
        return np.stack([middle, half_s * velocity], axis=-1)


class FlyBy(OrbitType):
    """A straight line."""

    name = 'line'
    keys = (MU, *STATE)

    @classmethod
    def orbit(cls, values, is_earlier):
        line = Line(values['orbit.position'], values['orbit.velocity'])
        return tabled_orbit(line, values['orbit.mu'])

"""Measurements of the true states, with noise that is a function of seed, sensor and tick."""

from .gyro import Gyro
from .measurements import Measurements
from .star_tracker import StarTracker
from .suite import Suite

__all__ = ['Gyro', 'Measurements', 'StarTracker', 'Suite']

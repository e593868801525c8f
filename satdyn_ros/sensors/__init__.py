"""Measurements of the true states, with noise that is a function of seed, sensor and tick."""

from importlib import import_module
from pkgutil import iter_modules

from .coarse_sun_sensor import CoarseSunSensor
from .gyro import Gyro
from .magnetometer import Magnetometer
from .measurements import Measurements
from .sensor import COMMON, KINDS, Sensor
from .star_tracker import StarTracker
from .suite import Suite
from .sun_sensor import SunSensor

# A kind of sensors is a file here, which nothing else needs to name.
for _found in iter_modules(__path__):
    import_module(f'{__name__}.{_found.name}')

__all__ = [
    'COMMON',
    'KINDS',
    'CoarseSunSensor',
    'Gyro',
    'Magnetometer',
    'Measurements',
    'Sensor',
    'StarTracker',
    'Suite',
    'SunSensor',
]

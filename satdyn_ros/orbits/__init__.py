"""
Where the attracting centre is: in a fixed direction, in the focus of an ellipse, or by a table.

All answer the same questions about the line from the centre to the body.  c_i is its unit vector
in inertial axes and 3 mu / r^3 [1/s^2] the gradient, the strength of the torque
(3 mu / r^3) c x I c.
"""

from importlib import import_module
from pkgutil import iter_modules

from .fixed import FixedDirection
from .kepler import KeplerOrbit
from .orbit import Orbit
from .orbit_type import ORBIT_TYPES, OrbitType
from .tabled import TabledOrbit

# What reads texts, which is loaded where there is one.
_LATER = {'earlier_ephemeris', 'ephemeris', 'spk', 'tle'}
# The types of orbits that are shipped, in the order in which sentences list them; any other is a
# file here, which nothing else needs to name.
for _found in ('ellipses', 'orbit_texts', *(each.name for each in iter_modules(__path__))):
    if _found not in _LATER:
        import_module(f'{__name__}.{_found}')

__all__ = ['ORBIT_TYPES', 'FixedDirection', 'KeplerOrbit', 'Orbit', 'OrbitType', 'TabledOrbit']

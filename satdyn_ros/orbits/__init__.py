"""
Where the attracting centre is: in a fixed direction, in the focus of an ellipse, or by a table.

All answer the same questions about the line from the centre to the body.  c_i is its unit vector
in inertial axes and 3 mu / r^3 [1/s^2] the gradient, the strength of the torque
(3 mu / r^3) c x I c.
"""

from .fixed import FixedDirection
from .kepler import KeplerOrbit
from .tabled import TabledOrbit

__all__ = ['FixedDirection', 'KeplerOrbit', 'TabledOrbit']

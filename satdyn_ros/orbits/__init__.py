"""
Where the attracting centre is: in a fixed direction, or at the focus of a Kepler orbit.

Both answer the same questions about the line from the centre to the body.  c_i is its unit vector
in inertial axes and 3 mu / r^3 [1/s^2] the gradient, the strength of the torque
(3 mu / r^3) c x I c.
"""

from .fixed import FixedDirection
from .kepler import KeplerOrbit

__all__ = ['FixedDirection', 'KeplerOrbit']

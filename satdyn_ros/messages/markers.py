"""
What RViz and Foxglove draw of a satellite: the body, its axes, nadir, rate, momentum and dipole.

Everything is in the body frame, so one TF lookup places it.  Sizes are symbolic: the body's
longest edge and the axes are 1 m, the arrows show directions and are 1.5 m.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..dynamics import inertia, torque
from ..dynamics.system import System
from ..kernel import rotation
from ..torques.magnetic import dipole_of

_CUBE, _ARROW, _LINE_LIST = 1, 0, 5
_WHITE, _GREY, _ORANGE = (1.0, 1.0, 1.0, 1.0), (0.7, 0.7, 0.75, 0.9), (1.0, 0.6, 0.1, 1.0)
_CYAN, _MAGENTA = (0.2, 0.8, 0.9, 1.0), (0.9, 0.3, 0.9, 1.0)
_RED, _GREEN, _BLUE = (1.0, 0.2, 0.2, 1.0), (0.2, 1.0, 0.2, 1.0), (0.3, 0.4, 1.0, 1.0)
_YELLOW = (0.95, 0.9, 0.2, 1.0)
_ARROW_LENGTH = 1.5


def content(header: dict[str, Any], system: System) -> dict[str, Any]:
    """Return the content of visualization_msgs/MarkerArray for samples of a system."""
    size, q_bp = box(system.inertia)
    body = {
        'type': _CUBE,
        'pose': {'orientation': q_bp},
        'scale': size,
        'color': _GREY,
    }
    axes = {
        'type': _LINE_LIST,
        'scale': (0.02, 0.0, 0.0),
        'color': _WHITE,
        'points': [end for axis in np.eye(3) for end in (np.zeros(3), axis)],
        'colors': [colour for colour in (_RED, _GREEN, _BLUE) for _ in range(2)],
    }
    markers = {
        'body': body,
        'axes': axes,
        'nadir': _arrow(_nadir, _ORANGE),
        'rate': _arrow(_rate, _CYAN),
        'momentum': _arrow(_momentum, _MAGENTA),
    }
    if dipole_of(system.torques) is not None:
        markers['dipole'] = _arrow(_dipole, _YELLOW)
    return {'markers': [{'header': header, 'ns': ns, **marker} for ns, marker in markers.items()]}


def box(tensor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the edges (3,) of the homogeneous box with this inertia, and its attitude to the body.

    From 12 I_x = m (b^2 + c^2) and so on, 6 (I_y + I_z - I_x) = m a^2; the mass is unknown, so
    the longest edge is 1, and none is thinner than 0.01: a rod or a plate stays visible.
    """
    moments, R_bp = inertia.principal_axes(tensor)
    edges = np.sqrt(np.maximum(np.sum(moments) - 2.0 * moments, 0.0))
    return np.maximum(edges / np.max(edges), 0.01), rotation.from_matrix(R_bp)


def _arrow(tip: Callable, colour) -> dict[str, Any]:
    # An arrow between two points has the diameters of shaft and head and the head's length.
    return {
        'type': _ARROW,
        'scale': (0.03, 0.07, 0.15),
        'color': colour,
        'points': [np.zeros(3), tip],
    }


def _nadir(samples):
    return -_ARROW_LENGTH * samples.states.c_b


def _rate(samples):
    return _along(samples.states.omega_bi_b)


def _momentum(samples):
    states = samples.states
    return _along(
        torque.angular_momentum(
            samples.system, states.omega_bi_b, states.rotor_speed, states.inner
        )
    )


def _dipole(samples):
    dipole_b = np.asarray(dipole_of(samples.system.torques))
    return _along(np.broadcast_to(dipole_b, (len(samples), 3)))


def _along(v_b):
    """Return arrows along v_b (N, 3); a zero vector has none."""
    x, y, z = v_b.T
    length = np.sqrt(x * x + y * y + z * z)
    return v_b * (_ARROW_LENGTH / np.where(length > 0.0, length, 1.0))[:, None]

"""What the report's 3-D view shows at each time: the body's box and the arrows around it."""

from typing import Any

import numpy as np

from ..dynamics import rotation
from ..dynamics.inertia import principal_axes
from .history import History

# Okabe and Ito's colours.
_AXES = ('#D55E00', '#009E73', '#0072B2')
_NADIR, _VELOCITY, _RATE, _MOMENTUM = '#E69F00', '#56B4E9', '#CC79A7', '#000000'


def scene(run: History) -> dict[str, Any]:
    """
    Return the view as plain data: frame, box, turns and arrows.

    frame: the axes of the view, LVLH or, without an orbit, inertial.  box: the corners (8, 3) of a
    body with these moments, in body axes, of size 1.  q (N, 4): body to the view.  arrows: name,
    colour, tips (N, 3) or one tip, in the view's axes.
    """
    q_vb = run.states.q_ib if run.q_lb is None else run.q_lb
    arrows = [
        _arrow(f'body {name}', colour, 1.1 * rotation.rotate(q_vb, axis))
        for name, colour, axis in zip('xyz', _AXES, np.eye(3), strict=True)
    ]
    if run.q_lb is None:
        arrows.append(_arrow('to the centre', _NADIR, np.array([[0.0, 0.0, -1.4]])))
    else:
        arrows.append(_arrow('nadir', _NADIR, np.array([[0.0, 0.0, 1.4]])))
        arrows.append(_arrow('velocity', _VELOCITY, 1.4 * _direction(_velocity(run))))
    omega_v = rotation.rotate(q_vb, run.states.omega_bi_b)
    momentum_v = rotation.rotate(q_vb, run.momentum_b)
    arrows.append(_arrow('rate', _RATE, 1.25 * omega_v / _longest(omega_v)))
    arrows.append(_arrow('momentum', _MOMENTUM, 1.25 * momentum_v / _longest(momentum_v)))
    return {
        'frame': 'inertial' if run.q_lb is None else 'LVLH',
        'box': _rounded(_box(run)),
        'q': _rounded(rotation.continuous(q_vb)),
        'arrows': arrows,
    }


def _velocity(run):
    q_li = rotation.multiply(run.q_lb, rotation.conjugate(run.states.q_ib))
    return rotation.rotate(q_li, run.states.v_i)


def _box(run):
    """Return the corners (8, 3) of the cuboid that has these moments, its longest edge 1."""
    moments, R_bp = principal_axes(run.scenario.system.inertia)
    # I_1 = m (b^2 + c^2) / 12 and so on: a^2 is as (I_2 + I_3 - I_1).
    edges = np.sqrt(np.maximum(np.sum(moments) - 2.0 * moments, 1e-3 * np.max(moments)))
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return (signs * edges / np.max(edges) / 2.0) @ R_bp.T


def _direction(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _longest(vectors):
    return max(float(np.max(np.linalg.norm(vectors, axis=-1))), 1e-300)


def _arrow(name, colour, tips):
    return {'name': name, 'colour': colour, 'tips': _rounded(tips)}


def _rounded(values):
    """Return nested lists with what the eye can tell apart."""
    return np.round(values, 5).tolist()

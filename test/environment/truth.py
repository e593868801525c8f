"""Reference values of the environment, which other programs computed, and plates that feel it."""

import json
from functools import cache
from typing import Any

import numpy as np
from cases import REFERENCE

from satdyn_ros.kernel import rotation


@cache
def _content() -> dict[str, Any]:
    return json.loads((REFERENCE / 'environment.json').read_text())


def cases(field: str) -> list[Any]:
    """Return the bodies whose fields have this one, as they are in the file."""
    return [case for case in _content()['cases'] if field in case['fields'][0]]


def points(name: str, of: str = 'r_itrs') -> np.ndarray:
    """Return a column of the single positions, of all that have the value `of`."""
    return np.array([point[name] for point in _content()['field_points'] if of in point])


def two_lines() -> list[list[str]]:
    """Return the two lines of each of the positions that have some."""
    return [point['tle'] for point in _content()['field_points'] if 'tle' in point]


def column(rows: list[dict[str, Any]], name: str) -> np.ndarray:
    """Return a column of a case's states, orbit or fields."""
    return np.array([row[name] for row in rows])


def stamps_ns(case: dict[str, Any]) -> np.ndarray:
    """Return the times of a case's fields."""
    t_s = column(case['fields'], 't')
    return case['scenario']['time']['epoch_ns'] + np.rint(1e9 * t_s).astype(np.int64)


def in_body_axes(case: dict[str, Any], v_i: np.ndarray) -> np.ndarray:
    """Return vectors (N, 3) at the times of a case in the axes of its body."""
    q_bi = rotation.conjugate(column(case['states'], 'q_xyzw'))
    return rotation.rotate(q_bi, v_i)


def plates(scenario: dict[str, Any]) -> list[dict[str, Any]]:
    """Return area, normal, position and coefficients of each plate, those of the box as well."""
    surface = dict(scenario['surface'])
    found = [surface[name] for name in surface.get('names', [])]
    if box := scenario['body'].get('box'):
        edges, centre = np.array(box), np.array(scenario['body']['box_centre'])
        for axis in range(3):
            for side in (1.0, -1.0):
                normal = side * np.eye(3)[axis]
                found.append(
                    {
                        'area': np.prod(edges) / edges[axis],
                        'normal': normal,
                        'position': centre + 0.5 * edges * normal,
                        'drag_coefficient': surface.get('drag_coefficient', 2.2),
                        'specular': surface.get('specular', 0.0),
                        'diffuse': surface.get('diffuse', 0.0),
                    }
                )
    return found

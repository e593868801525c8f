"""Flat plates: they make up the surface of a body for air and sunlight."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ..base.key import Key
from ..kernel.vector import Vector, dot

# What is the same of a plate and of all sides of the box.
COEFFICIENTS = (
    Key('drag_coefficient', 'double', 2.2, '', 'C_D in the flow of the air', low=0.0),
    Key('specular', 'double', 0.0, '', 'part of the sunlight that it mirrors', low=0.0, high=1.0),
    Key('diffuse', 'double', 0.0, '', 'part of the sunlight that it scatters', low=0.0, high=1.0),
)
# Of a plate; they follow its name.
KEYS_OF_A_PLATE = (
    Key('area', 'double', 0.0, 'm^2', 'area of the plate, which has one side', low=0.0),
    Key(
        'normal',
        'double_array',
        (0.0, 0.0, 1.0),
        '',
        'outward normal of the plate, body axes; only its direction counts',
        lengths=(3,),
        is_direction=True,
    ),
    Key(
        'position',
        'double_array',
        (0.0, 0.0, 0.0),
        'm',
        'centre of pressure of the plate from the mass centre, body axes',
        lengths=(3,),
    ),
    *COEFFICIENTS,
)
# Of the surface as a whole; coefficients without a name are also the defaults of plates.
KEYS_OF_THE_SURFACE = (
    Key(
        'body.box',
        'double_array',
        (0.0, 0.0, 0.0),
        'm',
        'edges of a box along the body axes, whose sides are plates; zero: there is none',
        lengths=(3,),
        low=0.0,
        is_optional=True,
    ),
    Key(
        'body.box_centre',
        'double_array',
        (0.0, 0.0, 0.0),
        'm',
        'centre of the box from the mass centre, body axes',
        lengths=(3,),
        is_optional=True,
    ),
    Key(
        'surface.names',
        'string_array',
        (),
        '',
        'names of flat plates, each described by surface.NAME.area and so on; coefficients '
        'without a name are those of the sides of body.box, and of the plates that have none '
        'of their own',
        is_optional=True,
    ),
    *(replace(key, name=f'surface.{key.name}', is_optional=True) for key in COEFFICIENTS),
)


class Plate(NamedTuple):
    """
    A flat plate with one side.

    Attributes
    ----------
    area : m^2
        A
    normal : (3,), body axes
        outward unit vector
    position : (3,), m, body axes
        of the centre of pressure from the mass centre
    drag_coefficient : float
        C_D
    specular, diffuse : float
        reflectances
    """

    area: float
    normal: tuple[float, ...]
    position: tuple[float, ...]
    drag_coefficient: float = 2.2
    specular: float = 0.0
    diffuse: float = 0.0


def along_normals(plates: Sequence[Any], v: Vector) -> Vector:
    """Return n . v of each plate, of what has a normal."""
    return tuple(dot(plate.normal, v) for plate in plates)


def box(edges: Sequence[float], centre: Sequence[float], *coefficients: float) -> list[Plate]:
    """
    Return the six sides of a box along the body axes, +x, -x, +y and so on.

    What follows are the coefficients of a Plate.

    Parameters
    ----------
    edges : (3,), m
        along the body axes
    centre : (3,), m, body axes
        from the mass centre
    """
    plates = []
    for axis, side in product(range(3), (1.0, -1.0)):
        normal = side * np.eye(3)[axis]
        area = np.prod(np.delete(edges, axis))
        position = np.asarray(centre) + 0.5 * np.asarray(edges) * normal
        plates.append(Plate(area, tuple(normal), tuple(position), *coefficients))
    return plates


def plates_of(values: Mapping[str, Any]) -> list[Plate]:
    """Return the plates that a scenario describes, the sides of its box first."""
    found = []
    if np.any(values['body.box']):
        coefficients = (values[f'surface.{key.name}'] for key in COEFFICIENTS)
        found = box(values['body.box'], values['body.box_centre'], *coefficients)
    for name in values['surface.names']:
        found.append(Plate(*(values[f'surface.{name}.{key.name}'] for key in KEYS_OF_A_PLATE)))
    return [plate for plate in found if plate.area]


def given_plates(values: Mapping[str, Any]) -> list[str]:
    """Return the key by which a scenario describes plates; none: it has no plates."""
    if not plates_of(values):
        return []
    return ['body.box' if any(values['body.box']) else 'surface.names']

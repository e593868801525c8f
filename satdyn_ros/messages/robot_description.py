"""
The body as ROS knows it: the URDF of a satellite, for RViz and whoever else reads one.

A link for each frame that the node's transforms place: the body, with its box, plates and wheels,
and each sensor, by its mounting.  No link has a mass, which the scenario does not say.  Without
body.box the box is the symbolic one of the markers;
wheels and sensors, whose sizes and positions are unknown, are drawn in proportion to it.
"""

from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ..kernel import rotation
from ..run.scenario import Scenario
from .markers import box

_GREY, _BLUE, _ORANGE, _GREEN = (
    '0.7 0.7 0.75 1',
    '0.15 0.25 0.6 1',
    '1 0.6 0.1 1',
    '0.2 0.8 0.3 1',
)
# Of the box's longest edge: radius and width of a wheel, edge of a sensor, thickness of a plate.
_WHEEL, _SENSOR, _PLATE = (0.12, 0.04), 0.08, 0.005
_OF_A_PLATE = ('normal', 'position', 'area')


def urdf(scenario: Scenario) -> str:
    """Return the URDF: lengths in metres, links named as the scenario's frames."""
    robot = Element('robot', name='satdyn')
    frames = scenario.frames
    body = SubElement(robot, 'link', name=frames.body)
    edges, q_bp = box(scenario.system.inertia)
    centre = np.zeros(3)
    if any(scenario['body.box']):
        edges, centre = np.array(scenario['body.box']), np.array(scenario['body.box_centre'])
        q_bp = rotation.IDENTITY
    longest = float(np.max(edges))
    _visual(body, 'box', _GREY, centre, q_bp, size=edges)
    for name in scenario['surface.names']:
        normal, position, area = (scenario[f'surface.{name}.{key}'] for key in _OF_A_PLATE)
        edge = float(np.sqrt(area))
        size = (edge, edge, _PLATE * longest)
        _visual(body, 'box', _BLUE, np.array(position), _from_z(np.array(normal)), size=size)

    def surface(direction):
        """Return how far from its centre the box ends in a direction, of unit length."""
        along_edges = np.abs(rotation.rotate(rotation.conjugate(q_bp), direction))
        return float(np.min(0.5 * edges / np.maximum(along_edges, 1e-9)))

    for rotor in scenario.system.rotors:
        if rotor.mode != 'none':
            radius, length = ((part * longest,) for part in _WHEEL)
            outside = centre + surface(rotor.axis) * rotor.axis
            q_bz = _from_z(rotor.axis)
            _visual(body, 'cylinder', _ORANGE, outside, q_bz, radius=radius, length=length)
    for frame_id, mounting in frames.sensors:
        q_bs = np.asarray(mounting)
        sensor = SubElement(robot, 'link', name=frame_id)
        # Its axes are placed where the body's are; it is drawn where its z axis looks from.
        along_z = np.array([0.0, 0.0, surface(rotation.rotate(q_bs, [0.0, 0.0, 1.0]))])
        cube = np.full(3, _SENSOR * longest)
        _visual(sensor, 'box', _GREEN, along_z, rotation.IDENTITY, size=cube)
        joint = SubElement(robot, 'joint', name=f'{frame_id}_mounting', type='fixed')
        SubElement(joint, 'parent', link=frames.body)
        SubElement(joint, 'child', link=frame_id)
        _origin(joint, np.zeros(3), q_bs)
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding='unicode')


def _visual(
    link: Element,
    shape: str,
    colour: str,
    at: np.ndarray,
    q: np.ndarray,
    **sizes: Iterable[float],
) -> None:
    """Add a shape at a position and with an attitude to the link."""
    visual = SubElement(link, 'visual')
    _origin(visual, at, q)
    geometry = SubElement(visual, 'geometry')
    SubElement(geometry, shape, {key: _text(numbers) for key, numbers in sizes.items()})
    # What has the name of an earlier one has its colour in RViz.
    SubElement(SubElement(visual, 'material', name=f'rgba {colour}'), 'color', rgba=colour)


def _origin(parent: Element, at: np.ndarray, q: np.ndarray) -> None:
    # Roll, pitch and yaw of URDF are the 3-2-1 angles.
    SubElement(parent, 'origin', xyz=_text(at), rpy=_text(rotation.roll_pitch_yaw(q)))


def _from_z(direction: np.ndarray) -> np.ndarray:
    """Return the shortest turn q_bz that takes +z to a direction."""
    x, y, z = direction / np.linalg.norm(direction)
    half_turn = z < -1.0 + 1e-12
    return np.array([1.0, 0.0, 0.0, 0.0]) if half_turn else rotation.normalise([-y, x, 0.0, 1 + z])


def _text(numbers: Iterable[float]) -> str:
    return ' '.join(f'{float(number) + 0.0:.9g}' for number in numbers)

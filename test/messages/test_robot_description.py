"""The URDF of a satellite: its links are the frames of the transforms, placed as these do."""

import shutil
import subprocess
from xml.etree import ElementTree

import numpy as np
import pytest
from messages.readers import TYPESTORE, plain
from scipy.spatial.transform import Rotation

from satdyn_ros.cli.main import main
from satdyn_ros.messages.packers import pack_tf_static
from satdyn_ros.messages.robot_description import urdf
from satdyn_ros.run.parameter_file import with_own_frames
from satdyn_ros.run.scenario import Scenario

VALUES = {
    'body.box': [0.1, 0.2, 0.3],
    'body.box_centre': [0.0, 0.0, 0.05],
    'surface.names': ['panel'],
    'surface.panel.area': 0.09,
    'surface.panel.normal': [0.0, -2.0, 0.0],
    'surface.panel.position': [0.4, 0.0, 0.0],
    'environment.sun': 'none',
    'environment.atmosphere': 'none',
    'rotor.names': ['rw_x', 'rw_z'],
    **{f'rotor.{name}.mode': 'free' for name in ('rw_x', 'rw_z')},
    **{f'rotor.{name}.inertia': 1.0 for name in ('rw_x', 'rw_z')},
    'rotor.rw_x.axis': [1.0, 0.0, 0.0],
    'rotor.rw_z.axis': [0.0, 0.0, -1.0],
    'sensors.names': ['gyro', 'star_tracker'],
    'sensors.star_tracker.mounting': [0.5, 0.5, -0.5, 0.5],
}
PARSER = shutil.which('check_urdf') or ''


@pytest.fixture(scope='module')
def scenario():
    return Scenario(with_own_frames(VALUES, '/sat1/satdyn', VALUES))


@pytest.fixture(scope='module')
def robot(scenario):
    return ElementTree.fromstring(urdf(scenario))


def numbers(node, name):
    return [float(number) for number in node.get(name).split()]


def turn(origin):
    """Return the rotation of an origin: fixed axes, roll first, as URDF has them."""
    return Rotation.from_euler('xyz', numbers(origin, 'rpy'))


def test_each_link_has_a_transform(scenario, robot):
    """The body is that of /tf; the sensors stand to it as /tf_static has them."""
    body, *sensors = (link.get('name') for link in robot.iter('link'))
    assert body == scenario.frames.body == 'sat1/base_link'
    static = plain(TYPESTORE.deserialize_cdr(pack_tf_static(scenario), 'tf2_msgs/msg/TFMessage'))
    transforms = {each['child_frame_id']: each for each in static['transforms']}
    assert sensors == list(transforms) == ['sat1/gyro', 'sat1/star_tracker']
    for joint in robot.iter('joint'):
        child = joint.find('child').get('link')
        assert joint.find('parent').get('link') == transforms[child]['header']['frame_id'] == body
        q = transforms[child]['transform']['rotation']
        static_turn = Rotation.from_quat([q[axis] for axis in 'xyzw'])
        # Nine digits of angles.
        assert (turn(joint.find('origin')).inv() * static_turn).magnitude() < 1e-8
        assert numbers(joint.find('origin'), 'xyz') == [0.0, 0.0, 0.0]


def test_the_body_has_its_box_its_plates_and_its_wheels(robot):
    """In metres; each wheel where its axis leaves the box, each plate with its normal along z."""
    body = robot.find('link')
    box, panel, *wheels = body.findall('visual')
    assert numbers(box.find('geometry/box'), 'size') == [0.1, 0.2, 0.3]
    assert numbers(box.find('origin'), 'xyz') == [0.0, 0.0, 0.05]
    assert numbers(panel.find('geometry/box'), 'size')[:2] == pytest.approx([0.3, 0.3])
    assert numbers(panel.find('origin'), 'xyz') == [0.4, 0.0, 0.0]
    axes = [turn(v.find('origin')).apply([0.0, 0.0, 1.0]) for v in (panel, *wheels)]
    np.testing.assert_allclose(axes, [[0, -1, 0], [1, 0, 0], [0, 0, -1]], atol=1e-8)
    origins = [numbers(wheel.find('origin'), 'xyz') for wheel in wheels]
    np.testing.assert_allclose(origins, [[0.05, 0.0, 0.05], [0.0, 0.0, -0.1]], atol=1e-9)


def test_without_a_box_it_is_that_of_the_markers():
    """Whose longest edge is 1 m; without a rotor there is no wheel."""
    (link,) = ElementTree.fromstring(urdf(Scenario({'body.inertia': [2.0, 2.0, 2.0]})))
    (visual,) = link.findall('visual')
    assert numbers(visual.find('geometry/box'), 'size') == pytest.approx([1.0, 1.0, 1.0])


@pytest.mark.skipif(not PARSER, reason='no check_urdf of urdfdom here')
def test_the_parser_of_rviz_reads_it(scenario, tmp_path):
    """Its tree has the body at the root and the sensors as its children."""
    (tmp_path / 'sat.urdf').write_text(urdf(scenario))
    result = subprocess.run(
        [PARSER, str(tmp_path / 'sat.urdf')], capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert 'root Link: sat1/base_link has 2 child' in result.stdout


def test_satdyn_describe_prints_it(capsys):
    """As the node publishes it."""
    assert main(['describe', 'cubesat_sensors', '--urdf']) == 0
    assert capsys.readouterr().out == f'{urdf(Scenario.from_yaml("cubesat_sensors"))}\n'

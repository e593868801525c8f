from dataclasses import replace

import numpy as np
import pytest
from messages.drawn_samples import AXIS, FRAMES, SYSTEMS, samples
from messages.readers import read
from scipy.spatial.transform import Rotation

from satdyn_ros.messages import contents, markers
from satdyn_ros.orbits.pieces import Pieces
from satdyn_ros.run.topics import TOPICS
from satdyn_ros.torques.magnetic import Magnetic


def drawn(flight, of, row):
    """Return the markers of a sample by name, as rclpy reads them."""
    packed = contents.message(TOPICS['markers'], FRAMES[flight], SYSTEMS[flight]).pack(of)
    message = read('visualization_msgs/msg/MarkerArray', packed[row].tobytes())['rclpy']
    return {marker['ns']: marker for marker in message['markers']}


def ends(marker):
    return [np.array(list(point.values())) for point in marker['points']]


@pytest.mark.parametrize('flight', SYSTEMS)
def test_arrows_point_along_what_they_are_named_for(flight):
    """From the centre, 1.5 m long: nadir, omega and H = I omega + J s a + eta' d in body axes."""
    of, row = samples(flight), 11
    system, states = of.system, of.states
    nadir_i = [0.0, 0.0, -1.0]
    if system.orbit.has_lvlh:
        nadir_i = -states.r_i[row] / np.linalg.norm(states.r_i[row])
    h = system.rotors[0].momentum
    if system.rotors[0].mode in ('free', 'motor'):
        h = system.rotors[0].inertia * states.rotor_speed[row, 0]
    # What the modes have beside their share of I omega is along their couplings.
    of_modes = sum(states.inner[mode.rate_name][row] * mode.coupling for mode in system.modes)
    directions = {
        'nadir': Rotation.from_quat(states.q_ib[row]).inv().apply(nadir_i),
        'rate': states.omega_bi_b[row],
        'momentum': system.inertia @ states.omega_bi_b[row] + h * AXIS + of_modes,
    }
    arrows = drawn(flight, of, row)
    for name, direction in directions.items():
        begin, tip = ends(arrows[name])
        assert np.array_equal(begin, np.zeros(3))
        assert tip == pytest.approx(1.5 * direction / np.linalg.norm(direction), abs=1e-13)


def test_body_axes_are_red_green_and_blue():
    """X, y and z of the body frame in the colours of RViz, 1 m each."""
    axes = drawn('circle, no rotor', samples('circle, no rotor'), 0)['axes']
    assert np.array_equal(ends(axes)[1::2], np.eye(3))
    strongest = [max(colour, key=lambda c: (c != 'a') * colour[c]) for colour in axes['colors']]
    assert strongest == list('rrggbb')


def test_the_dipole_is_that_of_the_body_and_of_its_magnetorquers():
    """Where a field turns it, 1.5 m along their sum."""
    flight, field = 'circle, no rotor', Pieces(lambda piece: np.zeros((3, 16)), [])
    of = samples(flight)
    magnetic = Magnetic((0.1, 0.0, 0.0), field)
    system = replace(of.system, torques=(magnetic.commanded((0.2, 0.0, 0.4)),))
    packed = contents.message(TOPICS['markers'], FRAMES[flight], system).pack(
        replace(of, system=system)
    )
    message = read('visualization_msgs/msg/MarkerArray', packed[3].tobytes())['rclpy']
    *_, dipole = message['markers']
    assert dipole['ns'] == 'dipole'
    assert ends(dipole)[1] == pytest.approx([0.9, 0.0, 1.2], abs=1e-15)


def test_all_markers_stand_in_the_body_frame_and_are_distinct():
    """One frame, the sample's stamp, and names by which a viewer distinguishes them."""
    of = samples('ellipse, motor')
    shown = drawn('ellipse, motor', of, 3)
    assert list(shown) == ['body', 'axes', 'nadir', 'rate', 'momentum']
    for marker in shown.values():
        assert marker['header']['frame_id'] == FRAMES['ellipse, motor'].body
        assert marker['header']['stamp']['nanosec'] == of.stamps_ns[3] % 10**9
        assert marker['color']['a'] > 0.0
        assert marker['scale']['x'] > 0.0


def test_box_is_the_body_whose_inertia_was_given():
    """A homogeneous box of known edges, turned in the body frame, is found again."""
    edges, mass = np.array([2.0, 0.5, 1.0]), 30.0
    moments = mass / 12.0 * (np.sum(edges**2) - edges**2)
    turn = Rotation.from_rotvec([0.1, -0.2, 0.15])
    R = turn.as_matrix()
    scale, q = markers.box(R @ np.diag(moments) @ R.T)
    assert scale == pytest.approx(edges / 2.0, abs=1e-12)
    assert (turn.inv() * Rotation.from_quat(q)).magnitude() < 1e-12


def test_a_rod_stays_visible():
    """Edges that the moments make zero are drawn thin."""
    scale, _ = markers.box(np.diag([3.0, 3.0, 0.0]))
    assert scale == pytest.approx([0.01, 0.01, 1.0])


def test_a_body_at_rest_has_no_rate_to_point_along():
    """A zero vector becomes an arrow without length, not one of nans."""
    of = samples('circle, no rotor')
    of.states.omega_bi_b[:] = 0.0
    assert np.array_equal(ends(drawn('circle, no rotor', of, 0)['rate'])[1], np.zeros(3))

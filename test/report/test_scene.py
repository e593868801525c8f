"""The scene draws the body that flies: box, plates and what sensors see."""

import browser as pages
import flights
import numpy as np
import pytest

from satdyn_ros import Scenario
from satdyn_ros.report.html import report
from satdyn_ros.report.scene import description

INERTIA = [0.07, 0.11, 0.12]
TURN_X = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]
WINGS = {
    'names': ['left', 'right'],
    'left': {'normal': [0.0, 3.0, 4.0], 'position': [0.0, 0.25, 0.0], 'area': 0.09},
    'right': {'normal': [0.0, 0.0, -1.0], 'position': [0.1, -0.25, 0.0], 'area': 0.04},
}
SENSORS = {
    'names': ['eye', 'tracker', 'gyro'],
    'eye': {'type': 'sun_sensor', 'field_of_view': 0.6, 'mounting': TURN_X},
    'tracker': {'type': 'star_tracker', 'earth_exclusion': 0.4, 'sun_exclusion': 0.5},
}
BOX = {'box': [0.2, 0.1, 0.34], 'box_centre': [0.0, 0.0, 0.03]}


def scenario(box=True, wings=True):
    values = {
        'body': {'inertia': INERTIA, **(BOX if box else {})},
        'sensors': SENSORS,
        'environment': {'sun': 'ephemeris'},
        'publish': {'rate': 2.0},
        'time': {'epoch': '2026-03-01T00:00:00Z'},
    }
    return Scenario.from_dict(values | ({'surface': WINGS} if wings else {}))


def test_lengths_are_those_of_the_scenario_in_one_unit():
    """The widest side of box and wings is 1: here along y, by the circles around the wings."""
    body = description(scenario(), [])['body']
    left, right = body['plates']
    # Half of a square's diagonal, as far as y sees the left one, whose normal has 0.6 of it.
    width = 0.25 + 0.3 / np.sqrt(2.0) * 0.8 + 0.25 + 0.2 / np.sqrt(2.0)
    np.testing.assert_allclose(np.multiply(body['edges'], width), BOX['box'])
    np.testing.assert_allclose(np.multiply(body['centre'], width), BOX['box_centre'])
    np.testing.assert_allclose([width * plate['edge'] for plate in (left, right)], [0.3, 0.2])
    np.testing.assert_allclose(np.multiply(right['position'], width), [0.1, -0.25, 0.0])
    np.testing.assert_allclose(left['normal'], [0.0, 0.6, 0.8])
    assert body['q_bp'] == [0.0, 0.0, 0.0, 1.0]


def test_without_a_box_there_is_none_beside_plates_and_one_by_the_moments_without():
    """What has no size is a homogeneous box; plates alone are drawn alone."""
    plates = description(scenario(box=False), [])['body']
    assert (plates['has_box'], len(plates['plates'])) == (False, 2)
    assert max(plates['edges']) == pytest.approx(1.0)
    by_moments = description(scenario(box=False, wings=False), [])['body']
    assert (by_moments['has_box'], by_moments['plates']) == (True, [])
    # Edges of a homogeneous box: those squared are as the sums of two moments less the third.
    squared = np.array([0.11 + 0.12 - 0.07, 0.07 + 0.12 - 0.11, 0.07 + 0.11 - 0.12])
    np.testing.assert_allclose(
        np.sort(by_moments['edges']), np.sort(np.sqrt(squared / squared.max()))
    )


def test_cones_are_those_of_sensors_that_look():
    """A field of view, and the wider of the angles in which a tracker is blinded."""
    cones = {cone['name']: cone for cone in description(scenario(), [])['cones']}
    assert cones.keys() == {'eye', 'tracker'}
    eye, tracker = cones['eye'], cones['tracker']
    assert (eye['half_angle'], tracker['half_angle']) == (0.6, 0.5)
    # A quarter turn about x takes z to -y.
    np.testing.assert_allclose(eye['axis'], [0.0, -1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(tracker['axis'], [0.0, 0.0, 1.0])


@pytest.mark.long
def test_the_page_draws_them_where_they_are(browser, tmp_path):
    """Corners of plates on their planes, rims of cones at their angles, in body axes."""
    report(flights.record(tmp_path / 'sat', scenario(), 9, ()), tmp_path / 'sat.html')
    browser.get((tmp_path / 'sat.html').as_uri())
    pages.wait(browser, 'window.satdyn && satdyn.stage.scene.frames.length > 0')
    boxes, rims = browser.execute_script(
        """const { scene } = satdyn.stage;
        const points = (made) => {
          made.updateMatrix();
          const { array } = made.children[1].geometry.attributes.position;
          return Array.from({ length: array.length / 3 }, (_, k) => new THREE.Vector3(
            ...array.slice(3 * k, 3 * k + 3)).applyMatrix4(made.matrix).toArray());
        };
        return [[scene.solid, ...scene.plates].map(points), scene.cones.map(points)];"""
    )
    shown = description(scenario(), [])
    body = shown['body']
    corners = np.unique(np.round(boxes[0], 6), axis=0)
    np.testing.assert_allclose(np.mean(corners, axis=0), body['centre'], atol=1e-6)
    np.testing.assert_allclose(np.ptp(corners, axis=0), body['edges'], atol=1e-5)
    for found, plate in zip(boxes[1:], body['plates'], strict=True):
        off = np.array(found) - plate['position']
        # As thick as 0.01.
        np.testing.assert_allclose(np.abs(off @ plate['normal']), 0.005, atol=1e-6)
        np.testing.assert_allclose(
            np.linalg.norm(off, axis=1), np.hypot(plate['edge'] / np.sqrt(2.0), 0.005), atol=1e-6
        )
    for found, made in zip(rims, shown['cones'], strict=True):
        axis = np.array(made['axis'])
        apex = body['centre'] + np.abs(body['edges'] @ axis) / 2.0 * axis
        away = np.array(found) - apex
        cosine = away @ axis / np.linalg.norm(away, axis=1)
        np.testing.assert_allclose(cosine, np.cos(made['half_angle']), atol=1e-5)
    pages.wait_for_labels(browser)
    assert pages.errors(browser) == []

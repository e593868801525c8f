"""The scene of CesiumJS: where the satellite is above the Earth, and how it points there."""

import json
import shutil
import subprocess
from pathlib import Path

import flights
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from satdyn_ros import Scenario
from satdyn_ros.bag.export import Options, export, table
from satdyn_ros.base.nanoseconds import epoch, stamp_ns
from satdyn_ros.exchange.czml import CzmlWriter

pytest.importorskip('erfa')

VECTOR_B = (0.3, -0.4, 0.5)
# UT1 - UTC, up to 0.9 s, and the motion of the pole are left out: 7e-5 rad, of which in 2023 and
# 2026 less than 1e-5 is there.
TURNED_RAD = 1e-5
SCENARIO = Scenario.from_dict(
    {
        'body': {'box': [1.0, 2.0, 3.0]},
        'orbit': {'inclination': 0.9},
        'publish': {'rate': 1.0},
        'initial': {'angular_velocity': [0.001, -0.002, 0.0015]},
        'time': {'epoch': '2026-03-01T00:00:00Z'},
    }
)


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return flights.record(tmp_path_factory.mktemp('czml') / 'sat', SCENARIO, 601, ())


@pytest.fixture(scope='module')
def scene(bag):
    path = bag.with_name('sat.czml')
    assert export(bag, path, Options(step_s=10)) == 61
    return path


def earth_fixed(vector_i, t_s):
    """Return the components of a vector in ITRS, by astropy."""
    coordinates = pytest.importorskip('astropy.coordinates')
    time = pytest.importorskip('astropy.time')
    pytest.importorskip('astropy.utils.iers').conf.auto_download = False
    at = time.Time(epoch(SCENARIO.epoch_ns + round(t_s * 1e9)), scale='utc')
    given = coordinates.CartesianRepresentation(*vector_i, unit='m')
    turned = coordinates.GCRS(given, obstime=at).transform_to(coordinates.ITRS(obstime=at))
    return turned.cartesian.xyz.to_value('m')


def assert_right(bag, t_s, r_t, q_tb, allowed_rad=TURNED_RAD):
    """Assert that position and attitude are those of the bag, turned by astropy."""
    states = table(bag)
    row = int(t_s)
    q_ib = Rotation.from_quat([states[f'q_ib_{name}'][row] for name in 'xyzw'])
    right = earth_fixed(q_ib.apply(VECTOR_B), t_s)
    found = Rotation.from_quat(q_tb).apply(VECTOR_B)
    np.testing.assert_allclose(found, right, rtol=0.0, atol=allowed_rad)
    r_i, _ = SCENARIO.system.orbit.position_velocity(float(t_s))
    np.testing.assert_allclose(r_t, earth_fixed(r_i, t_s), rtol=0.0, atol=TURNED_RAD * 7e6)


def test_rows_are_earth_fixed(bag, scene):
    """Position and attitude as astropy has them; packets of one satellite and its track."""
    packets = json.loads(scene.read_text())
    assert [packet['id'] for packet in packets] == [
        'document',
        *('SAT', 'SAT/ground_track') * 2,
    ]
    assert packets[0]['clock']['interval'].endswith('/2026-03-01T00:10:00.000000000Z')
    assert packets[1]['availability'] == packets[0]['clock']['interval']
    assert packets[1]['box']['dimensions']['cartesian'] == [1.0, 2.0, 3.0]
    positions = np.reshape(packets[3]['position']['cartesian'], (-1, 4))
    attitudes = np.reshape(packets[3]['orientation']['unitQuaternion'], (-1, 5))
    for row in (0, 33, 60):
        assert positions[row, 0] == attitudes[row, 0] == 10.0 * row
        assert_right(bag, 10 * row, positions[row, 1:], attitudes[row, 1:])


@pytest.mark.long
def test_cesium_evaluates_it(bag, scene):
    """Between rows too: what CesiumJS interpolates is the flight, its track is on the ground."""
    node, script = shutil.which('node'), Path(__file__).with_name('cesium_reader.cjs')
    if node is None or subprocess.run([node, '-e', 'require("cesium")']).returncode:
        pytest.skip('cesium is not installed: npm install cesium, and its path in NODE_PATH')
    times_s = (0, 95, 594)
    epochs = [f'{epoch(SCENARIO.epoch_ns + t * 10**9)}Z' for t in times_s]
    result = subprocess.run(
        [node, str(script), str(scene), 'SAT', *epochs], capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    rows, stop = json.loads(result.stdout)
    assert stop == '2026-03-01T00:10:00Z'
    for t_s, (r_t, q_tb, track) in zip(times_s, rows, strict=True):
        # The rate changes by 1e-6 rad/s a second, and a steady turn over 10 s is off by an eighth.
        assert_right(bag, t_s, r_t, q_tb, 5e-5)
        assert abs(track[2]) < 1e-3
        assert abs(track[0] - np.arctan2(r_t[1], r_t[0])) < 1e-9


def test_packets_are_joined_however_many(bag, tmp_path):
    """Each write makes packets with the epoch of the first: no row is lost between blocks."""
    path = tmp_path / 'all.czml'
    assert export(bag, path) == 601
    packets = json.loads(path.read_text())
    times = [
        t for packet in packets if 'orientation' in packet
        for t in packet['orientation']['unitQuaternion'][::5]
    ]  # fmt: skip
    assert times == list(range(601))


def test_seconds_past_the_epoch_count_a_leap_second(tmp_path):
    """CesiumJS adds them up in TAI: by IERS Bulletin C 52 23:59:58 is 3 s before 00:00:00."""
    begin_ns = stamp_ns('2016-12-31T23:59:58')
    with open(tmp_path / 'leap.czml', 'w+') as file:
        writer = CzmlWriter(file, 'SAT')
        writer.write(
            begin_ns + 10**9 * np.arange(4),
            np.full((4, 3), 7e6),
            np.tile([0.0, 0.0, 0.0, 1.0], (4, 1)),
            np.zeros(4),
            np.zeros(4),
        )
        writer.close()
    packets = json.loads((tmp_path / 'leap.czml').read_text())
    assert packets[3]['position']['cartesian'][::4] == [0, 1, 3, 4]


def test_what_is_not_above_the_earth_is_refused(tmp_path):
    """In one sentence, and no file is left."""
    fixed = Scenario({'orbit.type': 'fixed', 'time.epoch_ns': 1})
    held = flights.record(tmp_path / 'held', fixed, 3, ())
    with pytest.raises(ValueError, match='has no orbit about the Earth'):
        export(held, tmp_path / 'x.czml')
    assert list(tmp_path.glob('x.*')) == []

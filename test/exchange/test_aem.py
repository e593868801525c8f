"""The Attitude Ephemeris Message, read and written by others."""

import json
import re

import numpy as np
import pytest
from cases import REFERENCE
from exchange.readers import BODY_VECTOR, by_orekit
from scipy.spatial.transform import Rotation

from satdyn_ros import Scenario
from satdyn_ros.base import nanoseconds
from satdyn_ros.exchange.aem import AemWriter
from satdyn_ros.exchange.aem_reader import AttitudeFile, attitude_at
from satdyn_ros.exchange.ccsds import Subject

TUMBLER = Scenario.from_dict(
    {
        'orbit': {'type': 'kepler', 'eccentricity': 0.1, 'inclination': 0.9},
        'initial': {'angular_velocity': [0.01, -0.02, 0.015]},
    }
)
STAMPS_NS = 1_700_000_000_123_456_789 + np.rint(np.arange(12) * (1e9 / 3)).astype(np.int64)

# Figure G-4 of 504.0-B-2: a spinner of 18.29 deg/s, two rows ten seconds apart.
MMS = """\
CCSDS_AEM_VERS = 2.0
CREATION_DATE = 2023-02-14T12:00:00
ORIGINATOR = GSFC

META_START
COMMENT a comment
OBJECT_NAME = MMS
OBJECT_ID = 2015-011A
REF_FRAME_A = EME2000
REF_FRAME_B = SC_BODY_1
TIME_SYSTEM = UTC
START_TIME = 2023-054T00:00:09.150001
STOP_TIME = 2023-054T00:00:19.150001
ATTITUDE_TYPE = QUATERNION/ANGVEL
ANGVEL_FRAME = SC_BODY_1
META_STOP

DATA_START
2023-054T00:00:09.150001 0.056482 0.209807 -0.912091 0.347679 -0.021029 0.023643 18.288407
2023-054T00:00:19.150001 0.208972 -0.060605 0.371436 0.902603 -0.019288 0.021817 18.291279
DATA_STOP
"""

BY_OREKIT = json.loads((REFERENCE / 'aem_types.json').read_text())


def message(given):
    """Return the message of one row of a type, as Orekit read it."""
    direction = f'ATTITUDE_DIR = {given["direction"]}\n' if given['direction'] else ''
    other = {'EME2000': 'SC_BODY_1', 'SC_BODY_1': 'EME2000'}[given['frame_a']]
    return (
        f'CCSDS_AEM_VERS = {given["version"]}\nCREATION_DATE = 2023-02-14T12:00:00\n'
        'ORIGINATOR = X\nMETA_START\nOBJECT_NAME = A\nOBJECT_ID = 2015-011A\n'
        f'CENTER_NAME = EARTH\nREF_FRAME_A = {given["frame_a"]}\nREF_FRAME_B = {other}\n'
        f'{direction}TIME_SYSTEM = UTC\nSTART_TIME = 2023-054T00:00:00\n'
        f'STOP_TIME = 2023-054T00:00:00\nATTITUDE_TYPE = {given["type"]}\n'
        f'{"".join(f"{line}{chr(10)}" for line in given["keywords"])}META_STOP\nDATA_START\n'
        f'2023-054T00:00:00 {given["row"]}\nDATA_STOP\n'
    )


@pytest.fixture(scope='module')
def states():
    return TUMBLER.motion().at(np.arange(12) / 3.0)


def write(path, states, with_rates=True, segments=((0, 5), (5, 12)), version=None):
    with open(path, 'w+') as file:
        writer = AemWriter(file, Subject('SAT'), with_rates, version)
        for first, end in segments:
            rows = slice(first, end)
            writer.write(STAMPS_NS[rows], states.q_ib[rows], states.omega_bi_b[rows])
            writer.end_segment()
    return path


def written(tmp_path, text):
    path = tmp_path / 'message.aem'
    path.write_text(text)
    return path


def test_a_byte_order_mark_is_skipped(tmp_path):
    """That some editors put first."""
    path = tmp_path / 'message.aem'
    path.write_bytes(b'\xef\xbb\xbf' + MMS.encode())
    assert attitude_at(path, '2023-054T00:00:19.150001').omega_bi_b is not None


@pytest.mark.parametrize(
    ('old', 'new', 'reason'),
    [
        ('DATA_STOP\n', '', None),
        ('DATA_STOP\n', f'DATA_STOP\n{MMS.splitlines()[-2]}\n', 'line 22: a row that begins with'),
        ('DATA_START\n', 'DATA_START\nTIME_SYSTEM = TT\n', 'line 19: the keyword TIME_SYSTEM'),
        ('META_STOP\n', '', 'line 17: DATA_START stands in the metadata'),
        (
            'ATTITUDE_TYPE',
            'TIME_SYSTEM = UTC\nATTITUDE_TYPE',
            'line 14: TIME_SYSTEM is given twice',
        ),
    ],
)
def test_lines_stand_where_the_standard_has_them(tmp_path, old, new, reason):
    """Or are refused by their number; DATA_STOP may lack at the end."""
    path = written(tmp_path, MMS.replace(old, new))
    if reason is None:
        assert attitude_at(path, '2023-054T00:00:19.150001').omega_bi_b is not None
        return
    with pytest.raises(ValueError, match=reason):
        attitude_at(path, '2023-054T00:00:19.150001')


@pytest.mark.long
def test_orekit_turns_a_body_vector_as_we_do(states, tmp_path):
    """Its inertial components agree within 1e-9 rad, the rates and the epochs too, by segment."""
    segments = by_orekit(write(tmp_path / 'rates.aem', states))
    assert [len(rows) for rows in segments] == [5, 7]
    epochs, vectors_i, spins = zip(*(row for rows in segments for row in rows), strict=True)
    assert list(epochs) == nanoseconds.epochs(STAMPS_NS)
    ours = Rotation.from_quat(states.q_ib).apply(BODY_VECTOR)
    np.testing.assert_allclose(vectors_i, ours, rtol=0.0, atol=1e-9 * np.linalg.norm(BODY_VECTOR))
    # Sixteen digits of some tenths of a degree per second.
    np.testing.assert_allclose(spins, states.omega_bi_b, rtol=0.0, atol=1e-16)


@pytest.mark.long
@pytest.mark.parametrize('with_rates', [True, False])
def test_orekit_reads_the_other_version_too(states, tmp_path, with_rates):
    """Rates of Euler's angles in 1.0, as QUATERNION/RATE; attitudes alone in 2.0."""
    version = '1.0' if with_rates else '2.0'
    path = write(tmp_path / 'other.aem', states, with_rates, [(0, 12)], version)
    ((*rows,),) = by_orekit(path)
    ours = Rotation.from_quat(states.q_ib).apply(BODY_VECTOR)
    np.testing.assert_allclose([row[1] for row in rows], ours, rtol=0.0, atol=1e-9)
    if with_rates:
        np.testing.assert_allclose([row[2] for row in rows], states.omega_bi_b, atol=1e-14)


@pytest.mark.parametrize('version', ['1.0', '2.0'])
@pytest.mark.parametrize('with_rates', [True, False])
def test_each_version_is_read_again(states, tmp_path, version, with_rates):
    """With and without rates."""
    path = write(tmp_path / 'sat.aem', states, with_rates, [(0, 12)], version)
    assert path.read_text().startswith(f'CCSDS_AEM_VERS = {version}\n')
    found = attitude_at(path, nanoseconds.epoch(STAMPS_NS[7]))
    np.testing.assert_allclose(found.q_ib, states.q_ib[7], rtol=0.0, atol=1e-15)
    assert (found.omega_bi_b is not None) == with_rates
    if found.omega_bi_b is not None:
        np.testing.assert_allclose(found.omega_bi_b, states.omega_bi_b[7], rtol=0.0, atol=1e-14)


def test_rates_that_the_first_version_cannot_give_are_refused(tmp_path):
    """Where the first of Euler's axes lies on the last."""
    with open(tmp_path / 'x.aem', 'w+') as file:
        writer = AemWriter(file, Subject('SAT'), True, '1.0')
        half = np.sqrt(0.5)
        with pytest.raises(
            ValueError, match=r'00:00:01.* the second Euler angle is 90 deg, where'
        ):
            writer.write(
                np.array([0, 10**9]),
                np.array([[0.0, 0.0, 0.0, 1.0], [0.0, half, 0.0, half]]),
                np.ones((2, 3)),
            )


def test_orekit_reads_attitudes_without_rates(states, tmp_path):
    """The plain type."""
    ((*rows,),) = by_orekit(write(tmp_path / 'plain.aem', states, False, [(0, 12)]))
    ours = Rotation.from_quat(states.q_ib).apply(BODY_VECTOR)
    np.testing.assert_allclose([row[1] for row in rows], ours, rtol=0.0, atol=1e-9)


def test_the_published_spinner_turns_by_its_rate(tmp_path):
    """Of the standard's own example: rate in body axes and deg/s, quaternion as q_ib."""
    path = written(tmp_path, MMS)
    first, second = (attitude_at(path, f'2023-02-23T00:00:{s}.150001Z') for s in ('09', '19'))
    turned = Rotation.from_quat(first.q_ib).inv() * Rotation.from_quat(second.q_ib)
    assert first.omega_bi_b is not None
    assert second.omega_bi_b is not None
    rate = (first.omega_bi_b + second.omega_bi_b) / 2.0
    # A turn of more than half: what is left to a whole one, the other way round.
    missing = Rotation.from_rotvec(10.0 * rate).inv() * turned
    assert missing.magnitude() < np.radians(0.5)
    assert first.stamp_ns == 1_677_110_409_150_001_000


def test_what_was_written_is_read_again(states, tmp_path):
    """To sixteen digits."""
    path = write(tmp_path / 'rates.aem', states)
    found = attitude_at(path, nanoseconds.epoch(STAMPS_NS[7]))
    assert found.stamp_ns == STAMPS_NS[7]
    np.testing.assert_allclose(found.q_ib, states.q_ib[7], rtol=0.0, atol=1e-15)
    assert found.omega_bi_b is not None
    np.testing.assert_allclose(found.omega_bi_b, states.omega_bi_b[7], rtol=0.0, atol=1e-16)
    plain = attitude_at(
        write(tmp_path / 'plain.aem', states, False), nanoseconds.epoch(STAMPS_NS[7])
    )
    assert plain.omega_bi_b is None


@pytest.mark.long
def test_frames_from_body_to_inertial_are_inverted_as_orekit_does(tmp_path):
    """With the body as frame A both read another attitude than before, and the same."""
    path = written(
        tmp_path,
        MMS.replace('REF_FRAME_A = EME2000', 'REF_FRAME_A = SC_BODY_1').replace(
            'REF_FRAME_B = SC_BODY_1', 'REF_FRAME_B = EME2000'
        ),
    )
    ((row, _),) = by_orekit(path)
    found = attitude_at(path, row[0])
    ours = Rotation.from_quat(found.q_ib).apply(BODY_VECTOR)
    np.testing.assert_allclose(row[1], ours, rtol=0.0, atol=1e-9)
    assert found.omega_bi_b is not None
    np.testing.assert_allclose(row[2], found.omega_bi_b, rtol=0.0, atol=1e-9)


def test_rates_of_the_inertial_frame_in_its_own_axes_are_turned(tmp_path):
    """ANGVEL is the rate of B relative to A, here inertial to body, in the axes of either."""
    direct = attitude_at(written(tmp_path, MMS), '2023-02-23T00:00:09.150001')
    assert direct.omega_bi_b is not None
    q_ib = Rotation.from_quat(direct.q_ib)
    numbers = [*q_ib.inv().as_quat(), *np.degrees(-q_ib.apply(direct.omega_bi_b))]
    words = MMS.splitlines()[-3].split()[1:]
    inverted = (
        MMS.replace(' '.join(words), ' '.join(map(repr, map(float, numbers))))
        .replace('REF_FRAME_B = SC_BODY_1', 'REF_FRAME_B = EME2000')
        .replace('REF_FRAME_A = EME2000', 'REF_FRAME_A = SC_BODY_1')
    )
    for name in ('EME2000', 'REF_FRAME_B'):
        text = inverted.replace('ANGVEL_FRAME = SC_BODY_1', f'ANGVEL_FRAME = {name}')
        found = attitude_at(written(tmp_path, text), '2023-02-23T00:00:09.150001')
        np.testing.assert_allclose(found.q_ib, direct.q_ib, rtol=0.0, atol=1e-15)
        assert found.omega_bi_b is not None
        np.testing.assert_allclose(found.omega_bi_b, direct.omega_bi_b, rtol=0.0, atol=1e-15)


@pytest.mark.long
def test_files_of_the_first_issue_are_read_as_orekit_does(tmp_path):
    """504.0-B-1: scalar first or last, and the direction by a keyword of its own."""
    for direction, position, numbers in (
        ('A2B', 'LAST', '0.056482 0.209807 -0.912091 0.347679'),
        ('B2A', 'FIRST', '0.347679 0.056482 0.209807 -0.912091'),
    ):
        path = written(
            tmp_path,
            MMS.replace('VERS = 2.0', 'VERS = 1.0')
            .replace('META_STOP', f'QUATERNION_TYPE = {position}\nMETA_STOP')
            .replace('TIME_SYSTEM', f'ATTITUDE_DIR = {direction}\nTIME_SYSTEM')
            .replace('QUATERNION/ANGVEL\nANGVEL_FRAME = SC_BODY_1', 'QUATERNION')
            .replace('0.056482 0.209807 -0.912091 0.347679 -0.021029 0.023643 18.288407', numbers)
            .replace('2023-054T00:00:19.150001 0.208972 -0.060605 0.371436 0.902603', '')
            .replace(' -0.019288 0.021817 18.291279\n', ''),
        )
        ((row,),) = by_orekit(path)
        ours = Rotation.from_quat(attitude_at(path, row[0]).q_ib).apply(BODY_VECTOR)
        np.testing.assert_allclose(row[1], ours, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ('old', 'new', 'reason'),
    [
        ('CCSDS_AEM_VERS = 2.0', 'CCSDS_OEM_VERS = 2.0', 'is not an Attitude Ephemeris Message'),
        (
            'CCSDS_AEM_VERS = 2.0',
            '<?xml version="1.0"?>',
            'line 2: its XML ends early',
        ),
        (
            'TIME_SYSTEM = UTC',
            'TIME_SYSTEM = UT1',
            'line 11: TIME_SYSTEM is UT1; supported: UTC, ',
        ),
        ('QUATERNION/ANGVEL', 'SPIN/WOBBLE', 'ATTITUDE_TYPE is SPIN/WOBBLE; supported: QUATERN'),
        ('QUATERNION/ANGVEL', 'SPIN', 'line 19: the row at .* does not hold 4 numbers'),
        ('QUATERNION/ANGVEL', 'EULER_ANGLE', 'line 5: a segment has no EULER_ROT_SEQ'),
        (
            'QUATERNION/ANGVEL',
            'EULER_ANGLE\nEULER_ROT_SEQ = 331',
            'line 15: EULER_ROT_SEQ is 331; it must be three axes',
        ),
        ('REF_FRAME_B = SC_BODY_1\n', 'REF_FRAME_B = SC_BODY_1\nREF_FRAME_B = X\n', 'line 10'),
        ('2023-054T00:00:19.150001 0', '2023-054T00:00:09.150001 0', 'line 20: .* not later than'),
        ('2023-054T00:00:19.150001 0', '2023-454T00:00:19.150001 0', 'line 20: .*no day 454'),
        ('REF_FRAME_A = EME2000', 'REF_FRAME_A = LVLH', 'REF_FRAME_A is LVLH'),
        ('ANGVEL_FRAME = SC_BODY_1', 'ANGVEL_FRAME = LVLH', 'ANGVEL_FRAME is LVLH'),
        ('REF_FRAME_B = SC_BODY_1\n', '', 'a segment has no REF_FRAME_B'),
        ('18.288407', '', 'does not hold 7 numbers'),
        ('0.347679', '0.9', 'is not of length 1'),
        ('0.347679', '0.34_7679', 'does not hold 7 numbers'),
        ('0.347679', 'nan', 'does not hold 7 numbers'),
        # Left over from a file of 1.0, they say another attitude or rate.
        (
            'META_STOP',
            'ATTITUDE_DIR = B2A\nMETA_STOP',
            'ATTITUDE_DIR is B2A; .* 2.0 it must be A2B',
        ),
        (
            'META_STOP',
            'QUATERNION_TYPE = FIRST\nMETA_STOP',
            'QUATERNION_TYPE is FIRST; in version',
        ),
        ('META_STOP', 'RATE_FRAME = EME2000\nMETA_STOP', 'RATE_FRAME, of version 1.0, EME2000'),
        (
            'META_STOP',
            'RATE_FRAME = REF_FRAME_A\nMETA_STOP',
            'RATE_FRAME, of version 1.0, EME2000',
        ),
        (
            'META_STOP',
            'USEABLE_START_TIME = 2023-054T00:00:09.150002\nMETA_STOP',
            'at 2023-02-23T00:00:09.150001000 is outside the useable time .* from 2023-',
        ),
        (
            'META_STOP',
            'USEABLE_STOP_TIME = 2023-054T00:00:09\nMETA_STOP',
            'outside the useable time of its segment, to 2023-02-23T00:00:09.000000000',
        ),
    ],
)
def test_what_we_do_not_read_is_refused(tmp_path, old, new, reason):
    """In one sentence with the file's name."""
    path = written(tmp_path, MMS.replace(old, new))
    with pytest.raises(ValueError, match=f'message.aem.*{reason}'):
        attitude_at(path, '2023-02-23T00:00:09.150001')


@pytest.mark.parametrize(
    ('old', 'new', 'reason'),
    [
        ('ATTITUDE_DIR = A2B', 'ATTITUDE_DIR = C2D', 'ATTITUDE_DIR is C2D; .* 1.0 .* A2B or B2A'),
        (
            'QUATERNION_TYPE = LAST',
            'QUATERNION_TYPE = 4',
            'QUATERNION_TYPE is 4; .* LAST or FIRST',
        ),
        ('QUATERNION_TYPE = LAST\n', '', 'a segment has no QUATERNION_TYPE'),
        ('ATTITUDE_DIR = A2B\n', '', 'a segment has no ATTITUDE_DIR'),
    ],
)
def test_a_file_of_the_first_issue_must_say_what_it_means(states, tmp_path, old, new, reason):
    """It has no default for the direction nor for the position of the scalar."""
    path = write(tmp_path / 'plain.aem', states, False)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ValueError, match=f'plain.aem: line [0-9]+: {reason}'):
        attitude_at(path, nanoseconds.epoch(STAMPS_NS[7]))


def test_keywords_left_over_that_say_the_same_are_read(tmp_path):
    """As in Orekit's own example of version 2.0; rows within the useable time are read."""
    left_over = (
        'ATTITUDE_DIR = A2B\nQUATERNION_TYPE = LAST\nRATE_FRAME = SC_BODY_1\n'
        'USEABLE_START_TIME = 2023-054T00:00:09.150001\n'
        'USEABLE_STOP_TIME = 2023-054T00:00:09.150001\nMETA_STOP'
    )
    text = MMS.replace('META_STOP', left_over)
    found = attitude_at(written(tmp_path, text), '2023-02-23T00:00:09.150001')
    numbers = [0.056482, 0.209807, -0.912091, 0.347679]
    # Printed in six digits.
    np.testing.assert_allclose(found.q_ib, numbers, rtol=0.0, atol=1e-6)


def test_a_row_useable_in_another_segment_is_taken(tmp_path):
    """Two segments overlap, of which the first is useable at the epoch."""
    header, meta, data = MMS.partition('META_START')
    begin = 'USEABLE_START_TIME = 2023-054T00:00:19.150001\nMETA_STOP'
    other = data.replace('META_STOP', begin).replace('0.056482', '-0.056482')
    path = written(tmp_path, f'{header}{meta}{data}\n{meta}{other}')
    assert attitude_at(path, '2023-02-23T00:00:09.150001').q_ib[0] > 0.0


def test_ccsds_ndm_reads_what_we_write(states, tmp_path):
    """The package of that name on PyPI: each component, the scalar in its place."""
    ndm_io = pytest.importorskip('ccsds_ndm.ndm_io', reason='pip install "satdyn_ros[readers]"')
    message = ndm_io.NdmIo().from_path(write(tmp_path / 'plain.aem', states, False))
    rows = [
        row.quaternion_state for part in message.body.segment for row in part.data.attitude_state
    ]
    assert [row.epoch for row in rows] == nanoseconds.epochs(STAMPS_NS)
    found = [[getattr(row.quaternion, name) for name in ('q1', 'q2', 'q3', 'qc')] for row in rows]
    # Sixteen digits.
    np.testing.assert_allclose(found, states.q_ib, rtol=0.0, atol=1e-15)


def test_an_epoch_that_no_stamp_has_is_refused(tmp_path):
    """As `--at` may give it."""
    with pytest.raises(ValueError, match='the epoch 9999-01-01T00:00:00 is out of range'):
        attitude_at(written(tmp_path, MMS), '9999-01-01T00:00:00')


def test_an_epoch_beyond_the_rows_is_refused(tmp_path):
    """Also in a gap between segments; the nearest row is named."""
    path = written(tmp_path, MMS)
    with pytest.raises(ValueError, match=r'no attitude at .*; the nearest is 2023-02-23T00:00:19'):
        attitude_at(path, '2023-02-23T00:00:19.2')


@pytest.mark.parametrize('given', BY_OREKIT['rows'], ids=lambda g: f'{g["version"]}-{g["type"]}')
def test_every_type_is_read_as_orekit_reads_it(tmp_path, given):
    """The inertial components of a body vector, and the body rate, to the rounding of degrees."""
    path = written(tmp_path, message(given))
    found = attitude_at(path, '2023-054T00:00:00')
    vector_i = Rotation.from_quat(found.q_ib).apply(BODY_VECTOR)
    np.testing.assert_allclose(vector_i, given['vector_i'], rtol=0.0, atol=1e-6)
    if found.omega_bi_b is None:
        assert given['type'] in ('QUATERNION', 'EULER_ANGLE')
        assert given['spin_b'] == [0.0, 0.0, 0.0]
    else:
        np.testing.assert_allclose(found.omega_bi_b, given['spin_b'], rtol=0.0, atol=1e-8)


def test_a_nutating_spinner_goes_about_its_momentum(tmp_path):
    """
    Of version 1.0's SPIN/NUTATION: the rate that each row means leads to the next row.

    A free symmetric body of 60 deg/s, a quarter of it nutation; rows as its closed form has them.
    """
    nutation, about_momentum, about_z = np.radians([10.0, 15.0, 45.0])
    momentum_i = Rotation.from_euler('ZY', [0.4, 0.9])
    rows = []
    for t_s in np.arange(20) * 0.125:
        turned = Rotation.from_euler('ZXZ', [about_momentum * t_s, nutation, about_z * t_s + 0.3])
        q = momentum_i * turned
        z_i, h_b = q.apply([0.0, 0.0, 1.0]), q.inv().apply(momentum_i.apply([0.0, 0.0, 1.0]))
        alpha, delta = np.arctan2(z_i[1], z_i[0]), np.arcsin(z_i[2])
        node = Rotation.from_euler('ZX', [alpha + np.pi / 2, np.pi / 2 - delta])
        angle = (node.inv() * q).as_rotvec()[2]
        phase = np.arctan2(-h_b[1], h_b[0])
        numbers = np.degrees([alpha, delta, angle, about_z, nutation, 0.0, phase])
        numbers[5] = 2.0 * np.pi / about_momentum
        at = nanoseconds.epoch(round(t_s * 1e9))
        rows.append(' '.join([at, *(f'{x:.16e}' for x in numbers)]))
    given = {'version': '1.0', 'type': 'SPIN/NUTATION', 'frame_a': 'EME2000', 'direction': 'A2B'}
    text = message(given | {'keywords': [], 'row': 'x'})
    path = written(tmp_path, re.sub('2023-054T00:00:00 x', '\n'.join(rows), text))
    file = AttitudeFile(path)
    for k in range(19):
        first, second = (file.at(round(i * 0.125e9)) for i in (k, k + 1))
        turned = Rotation.from_quat(first.q_ib).inv() * Rotation.from_quat(second.q_ib)
        assert first.omega_bi_b is not None
        assert second.omega_bi_b is not None
        mean = (first.omega_bi_b + second.omega_bi_b) / 2.0
        # The rate of the body turns by 6 deg from row to row; by the rule of trapezia.
        assert np.linalg.norm(turned.as_rotvec() / 0.125 - mean) < 2e-4
    with pytest.raises(ValueError, match=r'message.aem: line 17: the nutation at .* takes 0 s'):
        AttitudeFile(written(tmp_path, message(given | {'keywords': [], 'row': '1 2 3 4 5 0 7'})))


@pytest.mark.parametrize(('system', 'ahead_s'), [('TAI', 37.0), ('TT', 69.184)])
def test_other_time_systems_are_turned_into_utc(tmp_path, system, ahead_s):
    """By the seconds that they were ahead of it in 2023; the useable time too."""
    useable = 'USEABLE_STOP_TIME = 2023-054T00:00:19.150001\nMETA_STOP'
    text = MMS.replace('TIME_SYSTEM = UTC', f'TIME_SYSTEM = {system}')
    file = AttitudeFile(written(tmp_path, text.replace('META_STOP', useable)))
    right = AttitudeFile(written(tmp_path, MMS))
    for at in ('09.150001', '12', '19.150001'):
        at_ns = nanoseconds.stamp_ns(f'2023-054T00:00:{at}')
        found = file.at(at_ns - round(ahead_s * 1e9))
        np.testing.assert_array_equal(found.q_ib, right.at(at_ns).q_ib)


@pytest.mark.parametrize('last', [6, 3])
@pytest.mark.parametrize(('system', 'ahead_s'), [('UTC', 0.0), ('TAI', 36.0), ('TT', 68.184)])
def test_across_a_leap_second_the_turn_goes_on_in_tai(tmp_path, system, ahead_s, last):
    """
    A row each half second of TAI about 23:59:60 at the end of 2016, which no stamp has.

    A turn of 0.2 rad/s is steady there: 00:00:00.25 is 1.75 s after 23:59:59.5.
    """
    begin_ns = nanoseconds.stamp_ns('2016-12-31T23:59:59')
    rows = ''
    for k in range(last + 1):
        if system == 'UTC':
            text = f'2016-12-31T23:59:{59 + k / 2}' if k < 4 else f'2017-01-01T00:00:0{k / 2 - 2}'
        else:
            text = nanoseconds.epoch(begin_ns + round((k / 2 + ahead_s) * 1e9))
        rows += f'{text} 0 0 {np.sin(0.05 * k)} {np.cos(0.05 * k)} 0 0 {np.degrees(0.2)}\n'
    head, data, _ = MMS.replace('TIME_SYSTEM = UTC', f'TIME_SYSTEM = {system}').partition(
        'DATA_START\n'
    )
    file = AttitudeFile(written(tmp_path, f'{head}{data}{rows}DATA_STOP\n'))
    for at_s, since_s in ((0.5, 0.5), (0.75, 0.75), (1.0, 2.0), (1.25, 2.25), (2.0, 3.0)):
        if since_s > last / 2:
            with pytest.raises(ValueError, match='has no attitude at 2017-01-01T00:00:0'):
                file.at(begin_ns + round(at_s * 1e9))
            continue
        found = file.at(begin_ns + round(at_s * 1e9))
        assert Rotation.from_quat(found.q_ib).as_rotvec()[2] == pytest.approx(0.2 * since_s)


@pytest.mark.parametrize('year', ['0001', '9999'])
def test_a_year_that_no_stamp_has_is_refused(tmp_path, year):
    """In a sentence, also where it only says that all is useable."""
    text = MMS.replace('META_STOP', f'USEABLE_STOP_TIME = {year}-01-01T00:00:00\nMETA_STOP')
    with pytest.raises(ValueError, match=rf'line \d+: the epoch {year}.* between 1677 and 2262$'):
        AttitudeFile(written(tmp_path, text))


def test_spin_from_the_body_is_refused(tmp_path):
    """The standard has no meaning for it."""
    given = next(row for row in BY_OREKIT['rows'] if row['type'] == 'SPIN')
    path = written(tmp_path, message(given | {'direction': 'B2A'}))
    with pytest.raises(ValueError, match='line 14: ATTITUDE_TYPE is SPIN; it is defined from'):
        AttitudeFile(path)


@pytest.fixture(scope='module')
def steady(tmp_path_factory):
    """Return a function that writes a steady turn of a rate, rows some seconds apart."""

    def write_turn(rate_rad_s, step_s, count, keywords='', kind='QUATERNION', version='2.0'):
        lines = []
        for k in range(count):
            q = TURN_BEGIN * Rotation.from_rotvec(k * step_s * np.asarray(rate_rad_s))
            numbers = [*q.as_quat(), *(np.degrees(rate_rad_s) if 'ANGVEL' in kind else ())]
            at = nanoseconds.epoch(round(k * step_s * 1e9))
            lines.append(' '.join([at, *(f'{x:.16e}' for x in numbers)]))
        head = MMS.partition('DATA_START')[0].replace('QUATERNION/ANGVEL', kind)
        if 'ANGVEL' not in kind:
            head = head.replace('ANGVEL_FRAME = SC_BODY_1\n', '')
        head = head.replace('META_STOP', f'{keywords}META_STOP')
        path = tmp_path_factory.mktemp('steady') / 'turn.aem'
        path.write_text('\n'.join([f'{head}DATA_START', *lines, 'DATA_STOP\n']))
        return AttitudeFile(path)

    return write_turn


TURN_BEGIN = Rotation.from_quat([0.1, -0.3, 0.2, 0.9])
RATE = np.array([0.02, -0.05, 0.03])


@pytest.mark.parametrize(
    ('keywords', 'kind', 'allowed'),
    [
        ('', 'QUATERNION', 1e-14),
        ('INTERPOLATION_METHOD = LINEAR\n', 'QUATERNION/ANGVEL', 1e-14),
        # By the remainders of the polynomials: half an angle of 0.06 rad from row to row.
        ('INTERPOLATION_METHOD = LAGRANGE\nINTERPOLATION_DEGREE = 5\n', 'QUATERNION', 1e-9),
        ('INTERPOLATION_METHOD = LAGRANGE\nINTERPOLATION_DEGREE = 5\n', 'QUATERNION/ANGVEL', 1e-9),
        ('INTERPOLATION_METHOD = HERMITE\nINTERPOLATION_DEGREE = 7\n', 'QUATERNION/ANGVEL', 1e-12),
        # As the standard's own examples have it: slopes it has none, so through one row more.
        ('INTERPOLATION_METHOD = HERMITE\nINTERPOLATION_DEGREE = 5\n', 'QUATERNION', 1e-9),
    ],
)
def test_between_rows_a_steady_turn_goes_on(steady, keywords, kind, allowed):
    """Whatever the method; its rate is that of the turn, from the rows alone too."""
    file = steady(RATE, 2.0, 12, keywords, kind)
    for at_s in (0.0, 0.5, 1.0, 9.3, 21.9, 22.0):
        q_ib, omega_bi_b = file.motion_at(round(at_s * 1e9))
        true = TURN_BEGIN * Rotation.from_rotvec(at_s * RATE)
        assert (true.inv() * Rotation.from_quat(q_ib)).magnitude() < max(allowed, 1e-14) * 3
        # The slope of a polynomial is off by its degree over a step more.
        np.testing.assert_allclose(omega_bi_b, RATE, rtol=0.0, atol=10.0 * allowed)
    assert (file.at(500_000_000).omega_bi_b is None) == (kind == 'QUATERNION')


def test_rates_give_whole_turns_from_row_to_row(steady):
    """Of a spinner of two turns and a half between rows, halfway is a turn and a quarter."""
    rate = np.array([0.0, 0.0, 0.5 * np.pi])
    file = steady(rate, 10.0, 3, '', 'QUATERNION/ANGVEL')
    q_ib, omega_bi_b = file.motion_at(5 * 10**9)
    true = TURN_BEGIN * Rotation.from_rotvec(5.0 * rate)
    assert (true.inv() * Rotation.from_quat(q_ib)).magnitude() < 1e-14
    np.testing.assert_allclose(omega_bi_b, rate, rtol=0.0, atol=1e-14)


def test_the_published_spinner_is_followed_between_its_rows(tmp_path):
    """By its printed rate from the first row on, a thousandth of a turn within five seconds."""
    file = AttitudeFile(written(tmp_path, MMS))
    first, middle = (
        file.at(nanoseconds.stamp_ns(f'2023-02-23T00:00:{s}.150001')) for s in ('09', '14')
    )
    assert first.omega_bi_b is not None
    turned = Rotation.from_quat(first.q_ib) * Rotation.from_rotvec(5.0 * first.omega_bi_b)
    assert (turned.inv() * Rotation.from_quat(middle.q_ib)).magnitude() < np.radians(0.36)


@pytest.mark.parametrize(
    ('keywords', 'kind', 'reason'),
    [
        ('INTERPOLATION_METHOD = SPLINE\n', 'QUATERNION', 'INTERPOLATION_METHOD is SPLINE; supp'),
        ('INTERPOLATION_METHOD = LAGRANGE\n', 'QUATERNION', 'DEGREE is not given; with LAGRANGE'),
        (
            'INTERPOLATION_METHOD = LAGRANGE\nINTERPOLATION_DEGREE = x\n',
            'QUATERNION',
            'INTERPOLATION_DEGREE is x; ',
        ),
        (
            'INTERPOLATION_METHOD = LAGRANGE\nINTERPOLATION_DEGREE = 3\n',
            'QUATERNION',
            'a segment has 3 rows; interpolation of degree 3 needs 4',
        ),
        (
            'INTERPOLATION_METHOD = HERMITE\nINTERPOLATION_DEGREE = 3\n',
            'QUATERNION',
            'a segment has 3 rows; interpolation of degree 3 needs 4',
        ),
    ],
)
def test_an_interpolation_that_there_is_not_is_refused(steady, keywords, kind, reason):
    """Where it is needed, with the line."""
    file = steady(RATE, 2.0, 3, keywords, kind)
    with pytest.raises(ValueError, match=f'turn.aem: line [0-9]+: .*{reason}'):
        file.at(10**9)


def as_xml(version, states, keywords=''):
    """Return a message in XML, as annex of 505.0-B has it."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<aem xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" id="CCSDS_AEM_VERS" '
        f'version="{version}">\n<header><CREATION_DATE>2023-02-14T12:00:00</CREATION_DATE>'
        '<ORIGINATOR>GSFC</ORIGINATOR></header>\n<body><segment>\n<metadata>'
        '<OBJECT_NAME>MMS</OBJECT_NAME><OBJECT_ID>2015-011A</OBJECT_ID>'
        '<CENTER_NAME>EARTH</CENTER_NAME><REF_FRAME_A>EME2000</REF_FRAME_A>'
        f'<REF_FRAME_B>SC_BODY_1</REF_FRAME_B>{keywords}<TIME_SYSTEM>UTC</TIME_SYSTEM>'
        '<START_TIME>2023-054T00:00:09.150001</START_TIME>'
        '<STOP_TIME>2023-054T00:00:19.150001</STOP_TIME></metadata>\n'
        f'<data>\n{states}\n</data></segment></body></aem>\n'
    )


def state_of(kind, *parts):
    values = ''.join(
        f'<{group}>' + ''.join(f'<{name}{u}>{x}</{name}>' for name, x in numbers) + f'</{group}>'
        for group, u, numbers in parts
    )
    return (
        f'<attitudeState><{kind}><EPOCH>2023-054T00:00:09.150001</EPOCH>{values}</{kind}>'
        '</attitudeState>'
    )


QUATERNION = list(
    zip(('QC', 'Q1', 'Q2', 'Q3'), (0.347679, 0.056482, 0.209807, -0.912091), strict=True)
)
ANGVEL = list(
    zip(('ANGVEL_X', 'ANGVEL_Y', 'ANGVEL_Z'), (-0.021029, 0.023643, 18.288407), strict=True)
)
XML = as_xml(
    '2.0',
    state_of(
        'quaternionAngVel', ('quaternion', '', QUATERNION), ('angVel', ' units="deg/s"', ANGVEL)
    ),
    '<ATTITUDE_TYPE>QUATERNION/ANGVEL</ATTITUDE_TYPE><ANGVEL_FRAME>SC_BODY_1</ANGVEL_FRAME>',
)


def test_xml_says_what_keywords_say(tmp_path):
    """The scalar first or last, known by its name; within an ndm and with a namespace too."""
    right = attitude_at(written(tmp_path, MMS), '2023-054T00:00:09.150001')
    inner = XML.partition('\n')[2].replace('<aem ', '<n:aem xmlns:n="urn:x" ')
    nested = f'<ndm>{inner.replace("</aem>", "</n:aem>")}</ndm>'
    for text in (XML, nested):
        found = attitude_at(written(tmp_path, text), '2023-054T00:00:09.150001')
        np.testing.assert_array_equal(found.q_ib, right.q_ib)
        np.testing.assert_array_equal(found.omega_bi_b, right.omega_bi_b)


def test_angles_of_the_first_issue_in_xml(tmp_path):
    """Rotations in their order, as scipy turns about axes that turn."""
    angles = ''.join(f'<rotation{k} units="deg">{10 * k}</rotation{k}>' for k in (1, 2, 3))
    state = (
        '<attitudeState><eulerAngle><EPOCH>2023-054T00:00:09.150001</EPOCH>'
        f'<rotationAngles>{angles}</rotationAngles></eulerAngle></attitudeState>'
    )
    keywords = (
        '<ATTITUDE_DIR>A2B</ATTITUDE_DIR><ATTITUDE_TYPE>EULER_ANGLE</ATTITUDE_TYPE>'
        '<EULER_ROT_SEQ>312</EULER_ROT_SEQ>'
    )
    path = written(tmp_path, as_xml('1.0', state, keywords))
    found = attitude_at(path, '2023-054T00:00:09.150001')
    right = Rotation.from_euler('ZXY', [10, 20, 30], degrees=True)
    assert (right.inv() * Rotation.from_quat(found.q_ib)).magnitude() < 1e-15 * 10


@pytest.mark.long
def test_orekit_reads_the_same_xml(tmp_path):
    """Vector and rate."""
    path = written(tmp_path, XML)
    ((row,),) = by_orekit(path)
    found = attitude_at(path, row[0])
    ours = Rotation.from_quat(found.q_ib).apply(BODY_VECTOR)
    np.testing.assert_allclose(row[1], ours, rtol=0.0, atol=1e-9)
    assert found.omega_bi_b is not None
    np.testing.assert_allclose(row[2], found.omega_bi_b, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    ('old', 'new', 'reason'),
    [
        ('version="2.0"', 'version="3.0"', 'its XML has no element aem of version 1.0 or 2.0'),
        ('<aem ', '<oem ', 'line 8: its XML ends early or is damaged'),
        ('deg/s', 'rad/s', 'line 7: ANGVEL_X is in rad/s, which is not read'),
        ('<Q1>0.056482</Q1>', '', 'line 7: the row at .* does not hold 7 numbers'),
        ('<OBJECT_ID>', '<OBJECT_NAME>X</OBJECT_NAME><OBJECT_ID>', 'line 5: OBJECT_NAME is given'),
        ('>UTC<', '>UT1<', 'line 5: TIME_SYSTEM is UT1; supported: UTC, TT, TAI'),
    ],
)
def test_what_is_wrong_in_xml_is_said_with_its_line(tmp_path, old, new, reason):
    """In one sentence, with the file."""
    assert old in XML
    with pytest.raises(ValueError, match=f'message.aem: {reason}'):
        AttitudeFile(written(tmp_path, XML.replace(old, new)))


def test_names_that_others_would_not_read_are_refused():
    """Frames that turn, and names that would break a line."""
    with pytest.raises(ValueError, match='the frame is ITRF; it must be an inertial one: EME2000'):
        Subject('SAT', frame='ITRF')
    with pytest.raises(ValueError, match='the center is'):
        Subject('SAT', center='EARTH\nCOMMENT')

"""The Attitude Ephemeris Message, read and written by others."""

import numpy as np
import pytest
from exchange.readers import BODY_VECTOR, by_orekit
from scipy.spatial.transform import Rotation

from satdyn_ros import Scenario
from satdyn_ros.base import nanoseconds
from satdyn_ros.exchange.aem import AemWriter, attitude_at
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


@pytest.fixture(scope='module')
def states():
    return TUMBLER.motion().at(np.arange(12) / 3.0)


def write(path, states, with_rates=True, segments=((0, 5), (5, 12))):
    with open(path, 'w+') as file:
        writer = AemWriter(file, Subject('SAT'), with_rates)
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
    for direction, place, numbers in (
        ('A2B', 'LAST', '0.056482 0.209807 -0.912091 0.347679'),
        ('B2A', 'FIRST', '0.347679 0.056482 0.209807 -0.912091'),
    ):
        path = written(
            tmp_path,
            MMS.replace('VERS = 2.0', 'VERS = 1.0')
            .replace('META_STOP', f'QUATERNION_TYPE = {place}\nMETA_STOP')
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
        ('CCSDS_AEM_VERS = 2.0', '<?xml version="1.0"?>', 'is not an Attitude Ephemeris Message'),
        ('TIME_SYSTEM = UTC', 'TIME_SYSTEM = TAI', 'TIME_SYSTEM is TAI; only UTC is supported'),
        ('QUATERNION/ANGVEL', 'SPIN', 'ATTITUDE_TYPE is SPIN; supported: QUATERNION and'),
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
            'the row at 2023-02-23T00:00:09.150001 is outside the useable time .* from 2023-',
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
    """It has no default for the direction nor for the place of the scalar."""
    path = write(tmp_path / 'plain.aem', states, False)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ValueError, match=f'plain.aem: {reason}'):
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
    ndm_io = pytest.importorskip('ccsds_ndm.ndm_io', reason='pip install ccsds-ndm')
    message = ndm_io.NdmIo().from_path(write(tmp_path / 'plain.aem', states, False))
    rows = [
        row.quaternion_state for part in message.body.segment for row in part.data.attitude_state
    ]
    assert [row.epoch for row in rows] == nanoseconds.epochs(STAMPS_NS)
    found = [[getattr(row.quaternion, name) for name in ('q1', 'q2', 'q3', 'qc')] for row in rows]
    # Sixteen digits.
    np.testing.assert_allclose(found, states.q_ib, rtol=0.0, atol=1e-15)


def test_an_epoch_between_rows_is_refused(tmp_path):
    """The nearest row is named."""
    path = written(tmp_path, MMS)
    with pytest.raises(ValueError, match='the nearest is 2023-02-23T00:00:19'):
        attitude_at(path, '2023-02-23T00:00:18')


def test_names_that_others_would_not_read_are_refused():
    """Frames that turn, and names that would break a line."""
    with pytest.raises(ValueError, match='the frame is ITRF; it must be an inertial one: EME2000'):
        Subject('SAT', frame='ITRF')
    with pytest.raises(ValueError, match='the center is'):
        Subject('SAT', center='EARTH\nCOMMENT')

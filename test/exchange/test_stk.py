"""The attitude file of STK against its published grammar and example."""

import re

import numpy as np
import pytest

from satdyn_ros.base.nanoseconds import stamp_ns
from satdyn_ros.exchange.ccsds import Subject
from satdyn_ros.exchange.stk import StkAttitudeWriter
from satdyn_ros.kernel import rotation

# STK's help, importfiles-01: the keywords, one on a line, then the format's name and its rows.
GRAMMAR = re.compile(
    r'stk\.v\.8\.0\n'
    r'(#.*\n)*'
    r'BEGIN Attitude\n'
    r'NumberOfAttitudePoints (?P<count>\d+) *\n'
    r'ScenarioEpoch (?P<epoch>\d{1,2} [A-Z][a-z]{2} \d{4} \d\d:\d\d:\d\d\.\d{9})\n'
    r'CentralBody (?P<body>[A-Z][a-z]+)\n'
    r'CoordinateAxes (?P<axes>J2000|ICRF)\n'
    r'(?P<format>AttitudeTimeQuaternions|AttitudeTimeQuatAngVels)\n'
    r'(?P<rows>(-?\d\S*( -?\d\S*)+\n)*)'
    r'END Attitude\n'
)
# 2002-06-01T12:00:00 UTC.
EPOCH_NS = 1_022_932_800_000_000_000


def write(path, with_rates=True, subject=None, count=4):
    """Write the body of STK's own example: it spins about z by 6 deg/s, a row each 10 s."""
    t_s = 10.0 * np.arange(count)
    q_ib = rotation.about([0.0, 0.0, 1.0], np.radians(6.0) * t_s)
    omega_bi_b = np.tile([0.0, 0.0, np.radians(6.0)], (count, 1))
    with open(path, 'w+') as file:
        writer = StkAttitudeWriter(file, subject or Subject('SAT'), with_rates)
        writer.write(EPOCH_NS + (t_s * 1e9).astype(np.int64), q_ib, omega_bi_b)
        writer.close()
    found = GRAMMAR.fullmatch(path.read_text())
    assert found is not None
    return found


def test_the_numbers_are_those_of_the_published_example(tmp_path):
    """The help's AttitudeTimeQuatAngVels example: a spin of +6 deg/s about z from identity."""
    found = write(tmp_path / 'spin.a')
    assert found['format'] == 'AttitudeTimeQuatAngVels'
    assert found['epoch'] == '1 Jun 2002 12:00:00.000000000'
    assert (found['count'], found['body'], found['axes']) == ('4', 'Earth', 'J2000')
    half, most = 0.5, 0.8660254037844
    example = [
        [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 6.0],
        [10.0, 0.0, 0.0, half, most, 0.0, 0.0, 6.0],
        [20.0, 0.0, 0.0, most, half, 0.0, 0.0, 6.0],
        [30.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 6.0],
    ]
    rows = [[float(word) for word in line.split()] for line in found['rows'].splitlines()]
    np.testing.assert_allclose(rows, example, rtol=0.0, atol=1e-12)


def test_without_rates_rows_are_shorter(tmp_path):
    """The plain format; the axes have STK's name."""
    found = write(tmp_path / 'plain.a', with_rates=False, subject=Subject('SAT', 'GCRF', 'MOON'))
    assert (found['format'], found['body']) == ('AttitudeTimeQuaternions', 'Moon')
    assert found['axes'] == 'ICRF'
    assert {len(line.split()) for line in found['rows'].splitlines()} == {5}


@pytest.mark.parametrize('count', [0, 11])
def test_the_header_counts_the_rows(tmp_path, count):
    """Which is filled in at the end."""
    found = write(tmp_path / 'count.a', count=count)
    assert int(found['count']) == len(found['rows'].splitlines()) == count


def test_seconds_past_the_epoch_count_a_leap_second(tmp_path):
    """By IERS Bulletin C 52 the last of 2016 is 23:59:60: 00:00:00 is 11 s after 23:59:50."""
    pytest.importorskip('erfa')
    begin_ns = stamp_ns('2016-12-31T23:59:50')
    with open(tmp_path / 'leap.a', 'w+') as file:
        writer = StkAttitudeWriter(file, Subject('SAT'))
        for stamps_s in ([0, 9], [10, 11]):
            writer.write(
                begin_ns + 10**9 * np.array(stamps_s),
                np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)),
                np.zeros((2, 3)),
            )
        writer.close()
    found = GRAMMAR.fullmatch((tmp_path / 'leap.a').read_text())
    assert found is not None
    assert [float(row.split()[0]) for row in found['rows'].splitlines()] == [0, 9, 11, 12]

"""OEMs in XML and ephemeris files of STK fly as the same rows in keyword = value notation."""

import re

import numpy as np
import pytest
from exchange.readers import by_orekit
from numpy.testing import assert_allclose, assert_array_equal
from orbits.test_ephemeris import EPOCH_NS, KEPLER, at, read, segment

from satdyn_ros.base.nanoseconds import stamp_ns
from satdyn_ros.orbits.ephemeris import EphemerisOrbit
from satdyn_ros.run.scenario import Scenario

MINUTES = 60.0 * np.arange(-2, 31)
T_S = np.random.default_rng(7).uniform(-120.0, 1800.0, 60)


def as_xml(*segments):
    """Return segments of an OEM, as `segment` writes them, in XML."""
    found = ''
    for text in segments:
        metadata, _, rows = text.partition('META_STOP\n')
        keywords = ''.join(
            f'<{key}>{value}</{key}>'
            for key, value in (line.split(' = ') for line in metadata.splitlines()[1:])
        )
        states = ''
        for row in rows.splitlines():
            words = row.split()
            names = ('EPOCH', 'X', 'Y', 'Z', 'X_DOT', 'Y_DOT', 'Z_DOT')
            parts = [f'<{name}>{word}</{name}>' for name, word in zip(names, words, strict=True)]
            # The order is of no matter: names say.
            states += f'<stateVector>{"".join(parts[::-1])}</stateVector>\n'
        found += (
            f'<segment>\n<metadata>{keywords}</metadata>\n<data>\n{states}'
            '<covarianceMatrix><EPOCH>x</EPOCH><CX_X>1</CX_X></covarianceMatrix></data></segment>\n'
        )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<oem xmlns="urn:ccsds:schema:ndmxml" '
        f'id="CCSDS_OEM_VERS" version="2.0"><header><ORIGINATOR>X</ORIGINATOR></header>\n<body>\n'
        f'{found}</body></oem>\n'
    )


def as_stk(t_s, more='', unit='Kilometers', boundaries=(), frame='J2000'):
    """Return rows of KEPLER as STK writes them, the epoch of its scenario at tick 0."""
    scale = {'Kilometers': 1e3, 'Meters': 1.0}[unit]
    rows = ''
    for t, r_i, v_i in zip(t_s, *KEPLER.position_velocity(t_s), strict=True):
        numbers = ' '.join(f'{x:.16e}' for x in np.concatenate([r_i, v_i]) / scale)
        rows += f' {t:.14e} {numbers}\n'
    times = ''.join(f'    {t:.9e}\n' for t in boundaries)
    inner = f'BEGIN SegmentBoundaryTimes\n{times}END SegmentBoundaryTimes\n' if times else ''
    return (
        'stk.v.11.0\n# WrittenBy    nobody\n\nBEGIN Ephemeris\n\n'
        f'NumberOfEphemerisPoints {len(t_s)}\nScenarioEpoch 01 Mar 2026 12:00:00.000000000\n'
        f'{more}CentralBody Earth\nCoordinateSystem {frame}\nDistanceUnit {unit}\n\n{inner}'
        f'EphemerisTimePosVel\n\n{rows}\nEND Ephemeris\n'
    )


def test_xml_is_the_same_message():
    """Bit for bit, of two segments; covariances are left out."""
    parts = (
        segment(MINUTES[MINUTES <= 900.0]),
        segment(MINUTES[MINUTES >= 900.0], INTERPOLATION='LAGRANGE', INTERPOLATION_DEGREE=5),
    )
    found = EphemerisOrbit(as_xml(*parts), EPOCH_NS).position_velocity(T_S)
    for values, right in zip(found, read(*parts).position_velocity(T_S), strict=True):
        assert_array_equal(values, right)


@pytest.mark.long
def test_orekit_reads_the_same_xml(tmp_path):
    """Epochs, positions and velocities."""
    path = tmp_path / 'orbit.xml'
    times = {'START_TIME': at(MINUTES[0]), 'STOP_TIME': at(MINUTES[-1])}
    text = as_xml(segment(MINUTES, OBJECT_ID='2026-001A', **times))
    text = re.sub('<covarianceMatrix>.*</covarianceMatrix>', '', text)
    path.write_text(
        text.replace('<ORIG', '<CREATION_DATE>2026-01-01T00:00:00</CREATION_DATE><ORIG')
    )
    (rows,) = by_orekit(path)
    assert [row[0][:23] for row in rows] == [at(t)[:23] for t in MINUTES]
    found = EphemerisOrbit(path.read_text(), EPOCH_NS).position_velocity(MINUTES)
    for values, right, allowed in zip(
        found, zip(*(row[1:] for row in rows), strict=True), (1e-7, 1e-9), strict=True
    ):
        assert_allclose(values, right, rtol=0.0, atol=allowed)


@pytest.mark.parametrize(
    ('old', 'new', 'reason'),
    [
        ('<oem ', '<aem ', 'line [0-9]+: its XML ends early or is damaged, mismatched tag'),
        (
            'version="2.0"',
            'version="9"',
            'its XML has no element oem of version 1.0 or 2.0 or 3.0',
        ),
        ('>EARTH<', '>MARS<', 'line 5: CENTER_NAME is MARS'),
        ('<X>', '<X units="m">', 'line 7: X is in m, which is not read'),
        ('</X_DOT>', ' 1</X_DOT>', 'line 7: the row at .* does not hold 6 numbers'),
        ('</X_DOT>', 'x</X_DOT>', 'line 7: the row at .* does not hold 6 numbers'),
    ],
)
def test_what_is_wrong_in_xml_is_said_with_its_line(old, new, reason):
    """By the sentences of the other notation."""
    text = as_xml(segment(MINUTES))
    assert old in text
    with pytest.raises(ValueError, match=f'^orbit.file: {reason}'):
        EphemerisOrbit(text.replace(old, new, 1), EPOCH_NS)


@pytest.mark.parametrize('unit', ['Meters', 'Kilometers'])
@pytest.mark.parametrize(
    ('more', 'method', 'degree'),
    [
        # What STK does where nothing is said.
        ('', 'LAGRANGE', 5),
        ('InterpolationMethod Lagrange\nInterpolationSamplesM1 7\n', 'LAGRANGE', 7),
        ('InterpolationMethod Hermite\nInterpolationSamplesM1 1\n', 'HERMITE', 3),
        ('InterpolationMethod Hermite\nInterpolationSamplesM1 3\n', 'HERMITE', 7),
        ('InterpolationMethod Lagrange\nInterpolationOrder 3\n', 'LAGRANGE', 3),
    ],
)
def test_a_file_of_stk_is_interpolated_as_it_says(unit, more, method, degree):
    """As an OEM that asks for the same; numbers of seventeen digits, so to rounding."""
    found = EphemerisOrbit(as_stk(MINUTES, more, unit), EPOCH_NS).position_velocity(T_S)
    same = read(segment(MINUTES, INTERPOLATION=method, INTERPOLATION_DEGREE=degree))
    for values, right, allowed in zip(
        found, same.position_velocity(T_S), (1e-7, 1e-9), strict=True
    ):
        assert_allclose(values, right, rtol=0.0, atol=allowed)


def test_what_says_nothing_of_place_and_velocity_is_left_out():
    """Accelerations, covariances behind the rows, and keywords of neither, as STK has them."""
    text = as_stk(MINUTES, 'BlockingFactor 20\nCovarianceFormat LowerTriangular\n')
    right = EphemerisOrbit(text, EPOCH_NS).position_velocity(T_S)
    head, mark, rows = text.partition('EphemerisTimePosVel\n\n')
    rows = rows.removesuffix('\nEND Ephemeris\n').replace('\n', ' 1e-3 2e-3 3e-3\n')
    triangle = ''.join(f'  {" 1.0" * n}\n' for n in range(2, 7))
    covariances = ''.join(f'{t} 1.0\n{triangle}\n' for t in MINUTES)
    more = (
        f'{head}{mark.replace("Vel", "VelAcc")}{rows}END EphemerisTimePosVelAcc\n\n'
        f'BEGIN CovarianceTimePosVel\n{covariances}END CovarianceTimePosVel\n\nEND Ephemeris\n'
    )
    found = EphemerisOrbit(more, EPOCH_NS).position_velocity(T_S)
    for values, same in zip(found, right, strict=True):
        assert_array_equal(values, same)


def test_a_row_of_stk_may_be_in_a_leap_second():
    """Its times are seconds that go by: the orbit is where it is that long after the epoch."""
    text = as_stk(MINUTES[2:] + 0.25).replace('01 Mar 2026 12:00', '31 Dec 2016 23:50')
    orbit = EphemerisOrbit(text, stamp_ns('2016-12-31T23:50:00'))
    t_s = np.array([595.0, 599.9, 600.0, 630.0, 1200.0])
    found, _ = orbit.position_velocity(t_s)
    right, _ = KEPLER.position_velocity(t_s + (t_s >= 600.0))
    assert_allclose(found, right, rtol=0.0, atol=1.0)


@pytest.mark.parametrize('twice', [True, False])
def test_a_segment_boundary_is_not_interpolated_across(twice):
    """Where its row stands twice or once: as two segments of an OEM that meet there."""
    t_s = np.sort(np.append(MINUTES, 900.0)) if twice else MINUTES
    found = EphemerisOrbit(as_stk(t_s, boundaries=[-120.0, 900.0, 1800.0]), EPOCH_NS)
    given = {'INTERPOLATION': 'LAGRANGE', 'INTERPOLATION_DEGREE': 5}
    same = read(
        segment(MINUTES[MINUTES <= 900.0], **given), segment(MINUTES[MINUTES >= 900.0], **given)
    )
    assert len(found.spans) == len(same.spans) == 2
    assert_allclose(
        found.position_velocity(T_S)[0], same.position_velocity(T_S)[0], rtol=0.0, atol=1e-7
    )


def test_orekit_reads_the_same_rows_of_stk(tmp_path):
    """Its own parser of these files: epochs, positions and velocities."""
    path = tmp_path / 'orbit.e'
    path.write_text(as_stk(MINUTES, 'InterpolationMethod Lagrange\nInterpolationSamplesM1 5\n'))
    (rows,) = by_orekit(path)
    assert [row[0][:23] for row in rows] == [at(t)[:23] for t in MINUTES]
    found = EphemerisOrbit(path.read_text(), EPOCH_NS).position_velocity(MINUTES)
    for values, right, allowed in zip(
        found, zip(*(row[1:] for row in rows), strict=True), (1e-7, 1e-9), strict=True
    ):
        assert_allclose(values, list(right), rtol=0.0, atol=allowed)


def test_it_is_read_beside_the_parameter_file(tmp_path):
    """As an OEM is, and the bag's scenario has its text."""
    (tmp_path / 'orbit.e').write_text(as_stk(MINUTES))
    path = tmp_path / 'scenario.yaml'
    path.write_text(
        '/**:\n  ros__parameters:\n    orbit: {type: oem, file: orbit.e}\n'
        "    time: {epoch: '2026-03-01T12:00:00Z'}\n"
    )
    scenario = Scenario.from_yaml(path)
    r_i, _ = scenario.system.orbit.position_velocity(0.0)
    assert_allclose(r_i, KEPLER.position_velocity(np.zeros(1))[0][0], rtol=0.0, atol=1e-3)
    assert Scenario.from_yaml_text(scenario.to_yaml()) == scenario


def test_a_file_in_xml_becomes_the_shorter_notation(tmp_path):
    """NASA's of the ISS has 2.9 MB; the values are the same, and so are lines in sentences."""
    path = tmp_path / 'scenario.yaml'
    path.write_text(
        '/**:\n  ros__parameters:\n    orbit: {type: oem, file: orbit.xml}\n'
        "    time: {epoch: '2026-03-01T12:00:00Z'}\n"
    )
    parts = (
        segment(MINUTES[MINUTES <= 900.0]),
        segment(MINUTES[MINUTES >= 900.0], INTERPOLATION='LAGRANGE', INTERPOLATION_DEGREE=5),
    )
    text = re.sub('(?=<[A-Z])', f'\n{" " * 12_000}', as_xml(*parts))
    assert len(text) > 2_500_000
    (tmp_path / 'orbit.xml').write_text(text)
    scenario = Scenario.from_yaml(path)
    assert len(scenario['orbit.file']) < 20_000
    found = EphemerisOrbit(scenario['orbit.file'], EPOCH_NS).position_velocity(T_S)
    for values, right in zip(found, read(*parts).position_velocity(T_S), strict=True):
        assert_array_equal(values, right)
    for old, new in (('>LAGRANGE<', '>SPLINE<'), ('>EARTH<', '>MARS<')):
        (tmp_path / 'orbit.xml').write_text(text.replace(old, new))
        line = text.partition(old)[0].count('\n') + 1
        with pytest.raises(ValueError, match=f'^orbit.file: line {line}: '):
            Scenario.from_yaml(path)
    (tmp_path / 'orbit.xml').write_text(text.replace('</oem>', ''))
    with pytest.raises(ValueError, match=r'orbit.file orbit.xml: line [0-9]+: its XML ends early'):
        Scenario.from_yaml(path)


@pytest.mark.parametrize(
    ('old', 'new', 'reason'),
    [
        ('CentralBody Earth', 'CentralBody Moon', 'line 8: CentralBody is Moon; supported: Earth'),
        ('CoordinateSystem J2000', 'CoordinateSystem Fixed', 'line 9: CoordinateSystem is Fixed'),
        ('CoordinateSystem J2000\n', '', 'CoordinateSystem is not given, which is Fixed'),
        ('DistanceUnit Kilometers', 'DistanceUnit Feet', 'line 10: DistanceUnit is Feet'),
        ('CentralBody', 'Interpolate x\nCentralBody', 'line 8: the keyword interpolate is not'),
        ('01 Mar 2026', '41 Mar 2026', 'line 7: 2026-03-41T.* is not an epoch'),
        ('01 Mar 2026', '01 Mar 9999', 'line 7: the epoch 9999-03-01.* is out of range'),
        ('\n 1.80000000000000e+03 ', '\n 8e9 ', 'line 46: 8E.9 s after ScenarioEpoch is beyond'),
        ('01 Mar 2026', '1 March 2026', 'line 7: ScenarioEpoch is 1 March 2026 12'),
        ('ScenarioEpoch', '#', 'it has no ScenarioEpoch'),
        ('EphemerisTimePosVel', 'EphemerisTimePos', 'line 12: it has EphemerisTimePos; supported'),
        (' 6.00000000000000e+01 ', ' x ', 'line 17: x is no time in seconds'),
        (' 6.00000000000000e+01 ', ' 1e300 ', 'line 17: 1e300 is no time in seconds'),
        (' 6.00000000000000e+01 ', f' 1e{"9" * 20} ', 'line 17: 1e9+ is no time in seconds'),
        (
            ' 6.00000000000000e+01 ',
            f' 60 1e{"9" * 12} ',
            'line 17: the row at .* does not hold 6 numbers',
        ),
        (' 6.00000000000000e+01 ', ' 0.0 ', 'line 17: the row at .* is not later than'),
        ('BEGIN Ephemeris', 'BEGIN Attitude', 'line 4: BEGIN Attitude is not read'),
    ],
)
def test_what_is_wrong_in_a_file_of_stk_is_said(old, new, reason):
    """In one sentence, with the line."""
    text = as_stk(MINUTES)
    assert old in text
    with pytest.raises(ValueError, match=f'^orbit.file: {reason}') as refusal:
        EphemerisOrbit(text.replace(old, new), EPOCH_NS)
    assert not re.search('[\r\n]', str(refusal.value))

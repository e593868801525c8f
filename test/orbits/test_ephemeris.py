"""Ephemeris messages are interpolated as they say, and refused where they cannot be."""

import io

import numpy as np
import pytest
from numpy.testing import assert_allclose

from satdyn_ros.base.nanoseconds import SECOND_NS, epoch, stamp_ns
from satdyn_ros.exchange.ccsds import Subject
from satdyn_ros.exchange.oem import OemWriter
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.orbits.ephemeris import EphemerisOrbit
from satdyn_ros.orbits.tabled import TabledOrbit

EPOCH = '2026-03-01T12:00:00'
EPOCH_NS = stamp_ns(EPOCH)
KEPLER = KeplerOrbit(semi_major_axis=7e6, eccentricity=0.01, inclination=1.1, raan=0.8)
HEADER = 'CCSDS_OEM_VERS = 2.0\nCREATION_DATE = 2026-01-01T00:00:00\nORIGINATOR = TEST\n'


def segment(t_s, orbit=KEPLER, system='UTC', ahead_s=0.0, **metadata):
    """Return the text of a segment with rows at times from tick 0, dated ahead_s later."""
    keywords = {
        'OBJECT_NAME': 'TEST',
        'CENTER_NAME': 'EARTH',
        'REF_FRAME': 'EME2000',
        'TIME_SYSTEM': system,
        **metadata,
    }
    lines = ['META_START', *(f'{key} = {value}' for key, value in keywords.items()), 'META_STOP']
    for t, r_i, v_i in zip(t_s, *orbit.position_velocity(t_s), strict=True):
        numbers = ' '.join(repr(float(x)) for x in np.concatenate([r_i, v_i]) / 1e3)
        lines.append(f'{at(t + ahead_s)} {numbers}')
    return '\n'.join(lines) + '\n'


def at(t_s):
    return epoch(EPOCH_NS + round(t_s * SECOND_NS))


def read(*segments):
    return EphemerisOrbit(HEADER + ''.join(segments), EPOCH_NS)


MINUTES = 60.0 * np.arange(-5, 181)
T_S = np.random.default_rng(1).uniform(-300.0, 10800.0, 200)


def test_without_a_method_it_is_hermite_of_degree_7():
    """
    A Kepler orbit from rows a minute apart.

    The eighth derivative a n^8 over 8! times 0.32 h^8 leaves 1e-6 m, the rows' digits a little.
    """
    found = read(segment(MINUTES)).position_velocity(T_S)
    for values, true, allowed in zip(
        found, KEPLER.position_velocity(T_S), (1e-6, 1e-7), strict=True
    ):
        assert_allclose(values, true, rtol=0.0, atol=allowed)


class Cubic:
    """A path of the third degree in time, one of the fourth for the fourth axis there is not."""

    @staticmethod
    def position_velocity(t_s):
        x = np.asarray(t_s)[:, None] / 1e4
        r_i = 7e6 * np.hstack([1 + x, 1 - x**2, x**3])
        v_i = 7e2 * np.hstack([1 + 0 * x, -2 * x, 3 * x**2])
        return r_i, v_i


@pytest.mark.parametrize(
    ('method', 'degree', 'path_is_followed'),
    [
        ('LAGRANGE', 3, True),
        ('LAGRANGE', 2, False),
        ('HERMITE', 3, True),
        ('LAGRANGE', 8, True),
        ('LINEAR', 1, False),
    ],
)
def test_the_degree_is_what_the_segment_says(method, degree, path_is_followed):
    """A path of the third degree is followed from the third on, to rounding; rows are uneven."""
    t_s = np.cumsum(np.random.default_rng(2).uniform(50.0, 400.0, 40)) - 600.0
    given = {'INTERPOLATION': method, 'INTERPOLATION_DEGREE': degree}
    found, _ = read(segment(t_s, Cubic, **given)).position_velocity(T_S[T_S < 5000.0])
    off_m = np.max(np.abs(found - Cubic.position_velocity(T_S[T_S < 5000.0])[0]))
    assert off_m < 1e-6 if path_is_followed else off_m > 0.1


@pytest.mark.parametrize('step_s', [60.0, 240.0])
@pytest.mark.parametrize(
    'given',
    [
        {},
        {'INTERPOLATION': 'HERMITE', 'INTERPOLATION_DEGREE': 3},
        {'INTERPOLATION': 'LAGRANGE', 'INTERPOLATION_DEGREE': 5},
        {'INTERPOLATION': 'LINEAR'},
    ],
)
def test_the_table_is_the_interpolation(step_s, given):
    """To a millimetre, however coarse: pieces end at rows where the polynomials differ."""
    source = read(segment(step_s * np.arange(-2, 91), **given))
    t_s = np.random.default_rng(3).uniform(0.0, 90 * step_s, 500)
    found = TabledOrbit(source).position_velocity(t_s)
    for values, true, allowed in zip(
        found, source.position_velocity(t_s), (1e-3, 1e-4), strict=True
    ):
        assert_allclose(values, true, rtol=0.0, atol=allowed)


@pytest.mark.parametrize(('system', 'ahead_s'), [('TAI', 37.0), ('TT', 69.184)])
def test_other_time_systems_are_ahead_of_utc(system, ahead_s):
    """Of the year 2026, by the leap seconds since 2017."""
    pytest.importorskip('erfa')
    found, _ = read(segment(MINUTES, system=system, ahead_s=ahead_s)).position_velocity(T_S)
    assert_allclose(found, KEPLER.position_velocity(T_S)[0], rtol=0.0, atol=2e-5)


def test_no_interpolation_crosses_a_manoeuvre():
    """Segments that meet are flown each by its own rows; a time between is the later one's."""
    other = KeplerOrbit(semi_major_axis=7.2e6, inclination=0.5)
    source = read(
        segment(MINUTES[MINUTES <= 3600.0]),
        'COVARIANCE_START\nEPOCH = 2026-03-01T12:00:00\n1e-3\n1 2\nCOVARIANCE_STOP\n',
        segment(MINUTES[MINUTES >= 3000.0], other, USEABLE_START_TIME=at(3600.0)),
    )
    orbit = TabledOrbit(source)
    for flown in (source.position_velocity, orbit.position_velocity):
        t_s = np.array([0.0, 3599.999, 3600.0, 3600.001, 10000.0])
        r_i, _ = flown(t_s)
        assert_allclose(r_i[:2], KEPLER.position_velocity(t_s)[0][:2], rtol=0.0, atol=1e-5)
        assert_allclose(r_i[2:], other.position_velocity(t_s)[0][2:], rtol=0.0, atol=1e-5)
    assert orbit.pieces.covered_until(0.0) == 10800.0


def test_times_outside_are_refused_by_their_epochs():
    """Before, after, in a gap; the ends themselves are inside."""
    source = read(
        segment(MINUTES[MINUTES <= 3600.0], USEABLE_STOP_TIME=at(3500.5)),
        segment(MINUTES[MINUTES >= 4000.0]),
    )
    orbit = TabledOrbit(source)
    span = 'it goes from 2026-03-01T11:55:00 to 2026-03-01T15:00:00'
    for t_s, reason in (
        (-300.5, rf'orbit.file has no position at 2026-03-01T11:54:59\.5: {span}$'),
        (10800.001, rf'orbit.file has no position at 2026-03-01T15:00:00\.001: {span}$'),
        (3700.0, 'at 2026-03-01T13:01:40: .*, with a gap between two segments there$'),
    ):
        for flown in (source.position_velocity, orbit.position_velocity):
            with pytest.raises(ValueError, match=reason):
                flown(np.array([0.0, t_s]))
    ends = np.array([-300.0, 3500.5, 4020.0, 10800.0])
    assert_allclose(orbit.position_velocity(ends)[0], KEPLER.position_velocity(ends)[0], atol=1e-5)
    assert orbit.pieces.covered_until(0.0) == 3500.5


def test_what_we_write_is_flown_again():
    """The orbit of a run that was exported."""
    file = io.StringIO()
    writer = OemWriter(file, Subject('TEST'))
    stamps_ns = EPOCH_NS + (MINUTES * SECOND_NS).astype(np.int64)
    writer.write(stamps_ns, *KEPLER.position_velocity(MINUTES))
    writer.end_segment()
    found, _ = EphemerisOrbit(file.getvalue(), EPOCH_NS).position_velocity(T_S)
    assert_allclose(found, KEPLER.position_velocity(T_S)[0], rtol=0.0, atol=1e-5)


GOOD = HEADER + segment(MINUTES[:6])


@pytest.mark.parametrize(
    ('old', 'new', 'reason'),
    [
        ('OEM', 'AEM', 'this is not an Orbit Ephemeris Message in keyword = value notation'),
        (
            'NAME = EARTH',
            'NAME = MARS BARYCENTER',
            'CENTER_NAME is MARS BARYCENTER; supported: EA',
        ),
        ('EME2000', 'ITRF2000', 'REF_FRAME is ITRF2000; supported: EME2000, GCRF, ICRF'),
        ('= UTC', '= GPS', 'TIME_SYSTEM is GPS; supported: UTC, TT, TAI'),
        ('META_STOP', 'INTERPOLATION = SPLINE\nMETA_STOP', 'INTERPOLATION is SPLINE'),
        ('META_STOP', 'INTERPOLATION_DEGREE = x\nMETA_STOP', 'INTERPOLATION_DEGREE is X'),
        (
            'META_STOP',
            'INTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = 6\nMETA_STOP',
            'a segment has 6 rows; interpolation of degree 6 needs 7',
        ),
        ('META_STOP', 'USEABLE_START_TIME = 2027-001T00:00:00\nMETA_STOP', 'no time in it is use'),
        ('TIME_SYSTEM = UTC\n', '', 'a segment has no TIME_SYSTEM'),
        ('T11:56:00', 'T11:54:00', 'the row at 2026-03-01T11:54:00.000000000 is not later'),
        ('.000000000 ', '.000000000 nan ', 'does not hold 6 numbers'),
        ('2026-03-01T11:56', '2026-13-01T11:56', 'is not an epoch'),
        (GOOD, HEADER, 'it has no positions'),
        (GOOD, '', 'it has no positions'),
    ],
)
def test_what_we_do_not_read_is_refused(old, new, reason):
    """In one sentence that names the key and what is in the file."""
    assert old in GOOD
    with pytest.raises(ValueError, match=f'^orbit.file: .*{reason}'):
        EphemerisOrbit(GOOD.replace(old, new, 1), EPOCH_NS)

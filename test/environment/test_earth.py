"""Frames and times are those of the IAU's routines, called elsewhere, and of SGP4."""

import erfa
import numpy as np
import pytest
from environment import truth
from numpy.testing import assert_allclose, assert_array_equal
from sgp4.api import Satrec

from satdyn_ros.base.nanoseconds import stamp_ns
from satdyn_ros.environment import gcrs_to_itrs, geodetic, teme_to_gcrs, terrestrial_time, turned
from satdyn_ros.environment.earth import leap_seconds_between, leap_seconds_ns


@pytest.mark.parametrize(
    ('utc', 'leap_s'),
    [
        ('1972-01-01T00:00:00', 10),
        ('1998-12-31T23:59:59.999999999', 31),
        ('1999-01-01T00:00:00', 32),
        ('2016-12-31T23:59:59', 36),
        ('2017-01-01T00:00:00', 37),
        ('2026-01-31T12:00:00', 37),
    ],
)
def test_leap_seconds(utc, leap_s):
    """
    TT is UTC, the leap seconds that the IERS announced, and 32.184 s.

    Tolerance: the fraction of a day is rounded to 1e-16, 1e-11 s.
    """
    day, fraction = terrestrial_time(stamp_ns(utc))
    passed_s = (day - 2440587.5) * 86400.0 - stamp_ns(utc) // 10**9 + fraction * 86400.0
    subsecond = stamp_ns(utc) % 10**9 * 1e-9
    assert_allclose(passed_s - subsecond, leap_s + 32.184, rtol=0.0, atol=1e-10)


def test_stamps_have_leap_seconds_from_1972_on():
    """Those that the IERS announced, of which before 1970 there is none."""
    stamps_ns = leap_seconds_ns()
    first = [stamp_ns(f'1972-{month}-01T00:00:00') for month in ('01', '07')]
    assert stamps_ns[:2].tolist() == first
    assert stamps_ns[27] == stamp_ns('2017-01-01T00:00:00')


@pytest.mark.parametrize(
    ('begin', 'end', 'leaps'),
    [
        ('2015-01-01T00:00:00', '2026-07-02T00:00:00', ['2015-07-01', '2017-01-01']),
        ('2016-12-31T23:59:59', '2017-01-01T00:00:00', ['2017-01-01']),
        ('2017-01-01T00:00:00', '2017-06-30T23:59:59', []),
    ],
)
def test_leap_seconds_between_two_stamps(begin, end, leaps):
    """Those that the IERS announced, after the first stamp and up to the other."""
    found = leap_seconds_between(stamp_ns(begin), stamp_ns(end))
    assert found == {stamp_ns(f'{day}T00:00:00'): 10**9 for day in leaps}


def test_terrestrial_time_of_many_days():
    """ERFA's own way through the calendar gives the same, on days drawn from fifty years."""
    days = np.random.default_rng(1).integers(730, 20_000, 200)
    tai_from_utc = erfa.dat(*erfa.jd2cal(2440587.5, days))
    found = terrestrial_time(days * 86_400 * 10**9)
    assert_array_equal(found[0], 2440587.5 + days)
    assert_allclose(found[1] * 86400.0, tai_from_utc + 32.184, rtol=0.0, atol=1e-10)


def test_earth_fixed_axes():
    """
    The matrix and the positions that it gives are the reference's.

    Tolerance: both are products of the same routines' matrices: rounding, 1e-16 and 1e-8 m.
    """
    matrix = gcrs_to_itrs(truth.points('epoch_ns'))
    assert_allclose(matrix, truth.points('gcrs_to_itrs'), rtol=0.0, atol=1e-15)
    r_i, r_t = truth.points('r_gcrs'), truth.points('r_itrs')
    assert_allclose(turned(matrix, r_i), r_t, rtol=0.0, atol=1e-8)
    assert_allclose(turned(matrix.swapaxes(-1, -2), r_t), r_i, rtol=0.0, atol=1e-8)


def test_positions_on_the_ellipsoid():
    """
    Latitude, longitude and height are the reference's, beside the poles too.

    The reference went the other way, from latitude to position: tolerance 1e-9 deg and 1e-7 m are
    positions to 0.1 mm, with room for the rounding of r, 1e-9 m.
    """
    latitude, longitude, height_m = geodetic(truth.points('r_itrs'))
    assert_allclose(np.degrees(latitude), truth.points('latitude_deg'), rtol=0.0, atol=1e-9)
    assert_allclose(np.degrees(longitude), truth.points('longitude_deg'), rtol=0.0, atol=1e-9)
    assert_allclose(height_m, truth.points('height_m'), rtol=0.0, atol=1e-7)


def test_two_lines_lead_to_gcrs():
    """
    SGP4's positions and velocities are where the reference has them.

    Tolerance: SGP4 in another version or on another processor differs by rounding, 1e-8 m; a
    matrix that were off by the equation of the equinoxes would be by 1e2 m.
    """
    stamps_ns = truth.points('epoch_ns', of='tle')
    matrices = teme_to_gcrs(stamps_ns)
    found = []
    for tle, at_ns in zip(truth.two_lines(), stamps_ns, strict=True):
        day, rest_ns = divmod(int(at_ns), 86_400 * 10**9)
        error, r_km, v_km_s = Satrec.twoline2rv(*tle).sgp4(2440587.5 + day, rest_ns / 86_400e9)
        assert error == 0
        found.append((r_km, v_km_s))
    r_teme, v_teme = 1e3 * np.array(found).swapaxes(0, 1)
    r_i, v_i = turned(matrices, r_teme), turned(matrices, v_teme)
    assert_allclose(r_i, truth.points('r_gcrs', of='tle'), rtol=0.0, atol=1e-6)
    assert_allclose(v_i, truth.points('v_gcrs', of='tle'), rtol=0.0, atol=1e-9)
    to_itrs = truth.points('gcrs_to_itrs', of='tle')
    assert_allclose(gcrs_to_itrs(stamps_ns), to_itrs, rtol=0.0, atol=1e-15)


def test_one_has_the_bits_of_many():
    """A time alone gives what it gives among others."""
    stamps_ns, r_i = truth.points('epoch_ns'), truth.points('r_gcrs')
    matrices = gcrs_to_itrs(stamps_ns)
    positions = geodetic(turned(matrices, r_i))
    for i, at_ns in enumerate(stamps_ns):
        assert_array_equal(gcrs_to_itrs(at_ns), matrices[i])
        assert_array_equal(geodetic(turned(matrices[i], r_i[i])), [part[i] for part in positions])

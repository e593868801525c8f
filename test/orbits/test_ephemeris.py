"""Ephemeris messages are interpolated as they say, and refused where they cannot be."""

import io
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import KroghInterpolator

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
UNEVEN = np.round(np.cumsum(np.random.default_rng(5).uniform(20.0, 70.0, 200)), 9) - 300.0
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


@pytest.mark.parametrize('frame', ['EME2000', 'J2000', 'GCRF', 'ICRF'])
def test_few_rows_in_any_frame_are_flown_again(frame):
    """Two rows a second apart: Hermite's cubic is within a n^4 / 384, 3e-8 m."""
    file = io.StringIO()
    writer = OemWriter(file, Subject('TEST', frame))
    t_s = np.array([0.0, 1.0])
    writer.write(EPOCH_NS + (t_s * SECOND_NS).astype(np.int64), *KEPLER.position_velocity(t_s))
    writer.end_segment()
    found, _ = EphemerisOrbit(file.getvalue(), EPOCH_NS).position_velocity(np.array([0.5]))
    assert_allclose(found, KEPLER.position_velocity(np.array([0.5]))[0], rtol=0.0, atol=1e-6)


GOOD = HEADER + segment(MINUTES[:6])
# Its second row.
ROW = GOOD.splitlines()[10]
WRONG = ('1_000.0', 'nan', 'inf', '1,0', '1e5e', '1d3', '٣', '0x10')


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
        ('EME2000', 'ICRF³', 'REF_FRAME is ICRF³'),
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
        # In what lines stand.
        (
            'META_STOP',
            'TIME_SYSTEM = UTC\nMETA_STOP',
            'line 9: TIME_SYSTEM is given twice, before',
        ),
        (
            'META_STOP',
            'INTERPOLATION_DEGRE = 3\nMETA_STOP',
            'line 9: INTERPOLATION_DEGRE is no key',
        ),
        ('META_START\n', '', 'line 4: OBJECT_NAME is no keyword of the header'),
        (
            'META_STOP\n',
            '',
            'line 9: a row that begins with 2026-03-01T11:55:00.0* is in the meta',
        ),
        ('META_STOP\n', 'META_STOP\nDATA_STOP\n', 'line 10: DATA_STOP stands in data without'),
        (
            ROW,
            f'INTERPOLATION = LINEAR\n{ROW}',
            'line 11: the keyword INTERPOLATION stands in the',
        ),
        (ROW, f'DATA_STOP\n{ROW}', 'line 12: a row that begins with .* is in what follows the'),
        (ROW, f'COVARIANCE_STOP\n{ROW}', 'line 11: COVARIANCE_STOP stands in the data'),
        (GOOD, GOOD + 'COVARIANCE_START\n', 'it ends within a covariance'),
        (GOOD, GOOD + 'META_START\n', 'it ends within the metadata'),
        (GOOD, GOOD + 'META_START\nMETA_STOP\n', 'it ends within data without a row'),
        # Of numbers.
        *((ROW, f'{ROW} {number} 1 1', 'line 11: .* not hold 6 numbers') for number in WRONG),
        ('META_STOP', 'INTERPOLATION_DEGREE = 0\nMETA_STOP', 'INTERPOLATION_DEGREE is 0; it must'),
        ('META_STOP', 'INTERPOLATION_DEGREE = 100\nMETA_STOP', 'whole number from 1 to 99'),
        ('META_STOP', 'INTERPOLATION_DEGREE = ٣\nMETA_STOP', 'INTERPOLATION_DEGREE is ٣; it must'),
        # Of times.
        (
            '2026-03-01T12',
            '9999-03-01T12',
            'line 15: the epoch 9999-.* out of range; it must be b',
        ),
        ('2026-03-01T12', '2026-03-0١T12', 'line 15: .* is not an epoch'),
        ('11:56:00', '11:55:60', 'line 11: 2026-03-01T11:55:60.0* is no leap second that there w'),
        ('META_STOP', 'STOP_TIME = soon\nMETA_STOP', "line 9: 'soon' is not an epoch"),
        ('2026-03-01T12', '2026-03-02T12', r'line 15: .* is 86460 s after .* turns 15\.\d times'),
        (GOOD, HEADER, 'it has no positions'),
        (GOOD, '', 'it has no positions'),
        (GOOD, 'orbit.oem', "but one line: 'orbit.oem'"),
    ],
)
def test_what_we_do_not_read_is_refused(old, new, reason):
    """In one sentence that names the key, the line and what is in the file."""
    assert old in GOOD
    with pytest.raises(ValueError, match=f'^orbit.file: .*{reason}'):
        EphemerisOrbit(GOOD.replace(old, new, 1), EPOCH_NS)


@pytest.mark.parametrize('given', ['\ufeff{}', '{}\n', 'dos'])
def test_how_a_text_is_kept_does_not_matter(given):
    """With a byte-order mark, or the line breaks of another system; ICRF3, accelerations."""
    lines = GOOD.replace('EME2000', 'ICRF3').splitlines()
    lines = [f'{line} 1e-3 .1 -2.' if line.startswith('20') else line for line in lines]
    lines.insert(1, 'COMMENT with \x85 and \u2028 inside = a keyword')
    text = '\r\n'.join(lines) if given == 'dos' else given.format('\n'.join(lines))
    found, _ = EphemerisOrbit(text, EPOCH_NS).position_velocity(np.array([-100.0]))
    assert_allclose(found, KEPLER.position_velocity(np.array([-100.0]))[0], rtol=0.0, atol=1e-5)


def hermite(t_s, rows_s, orbit, window=4):
    """Return r and v at t_s by SciPy, through as many rows before as after, or those at an end."""
    first = np.searchsorted(rows_s, t_s, side='right') - window // 2
    first = int(np.clip(first, 0, len(rows_s) - window))
    some_s = rows_s[first : first + window]
    r, v = orbit.position_velocity(some_s)
    through = KroghInterpolator(
        np.repeat(some_s - some_s[0], 2), np.stack([r, v], axis=1).reshape(-1, 3)
    )
    return through.derivatives(t_s - some_s[0], 2)


class Burn:
    """Two ellipses that meet at a manoeuvre of 5 m/s, 1617 s after tick 0."""

    AT_S = 1617.0

    def __init__(self):
        r_i, v_i = (x[0] for x in KEPLER.position_velocity(np.array([self.AT_S])))
        self.after = KeplerOrbit.from_state(r_i, v_i + np.array([3.0, 0.0, 4.0]))

    def position_velocity(self, t_s):
        is_after = (np.asarray(t_s) >= self.AT_S)[:, None]
        both = KEPLER.position_velocity(t_s), self.after.position_velocity(t_s - self.AT_S)
        return tuple(
            np.where(is_after, after, before) for before, after in zip(*both, strict=True)
        )


@pytest.mark.parametrize('rows_s', [MINUTES, UNEVEN], ids=['minutes', 'uneven'])
def test_a_manoeuvre_within_a_segment_is_what_its_rows_say(rows_s):
    """
    The table is SciPy's Hermite polynomial to a millimetre, at every instant, the rows too.

    Pieces are short where the polynomials feel the burn alone.
    """
    burn = Burn()
    orbit = TabledOrbit(read(segment(rows_s, burn)))
    inside_s = rows_s[(rows_s > 0.0) & (rows_s < 3600.0)]
    for t_s in np.concatenate([inside_s, np.random.default_rng(4).uniform(1300.0, 2000.0, 300)]):
        found = orbit.position_velocity(t_s)
        for values, true, allowed in zip(
            found, hermite(t_s, rows_s, burn), (1e-3, 1e-4), strict=True
        ):
            assert_allclose(values, true, rtol=0.0, atol=allowed)
    short = [each for each in orbit.stretches if each.length_s < 100.0]
    assert all(1000.0 < each.begin_s < each.end_s < 2200.0 for each in short[:-1])
    assert short[:-1]


def test_the_pieces_of_a_segment_are_without_a_gap():
    """They begin and end where the segment does, and each where the one before ends."""
    stretches = read(segment(UNEVEN, Burn())).stretches
    ends_s = stretches[0].begin_s, stretches[-1].end_s
    assert_allclose(ends_s, UNEVEN[[0, -1]], rtol=0.0, atol=1e-9)
    assert all(one.end_s == following.begin_s for one, following in pairwise(stretches))


LEAP_NS = stamp_ns('2017-01-01T00:00:00')


def leap_epoch(system, t_s):
    """Return by the calendar a time from a minute before the leap second that ends 2016."""
    if system == 'UTC' and 60.0 <= t_s < 61.0:
        return f'2016-12-31T23:59:{t_s:09.6f}'
    ahead_s = {'TAI': 36.0, 'TT': 68.184, 'UTC': -1.0 if t_s >= 61.0 else 0.0}[system]
    return epoch(LEAP_NS + round((t_s - 60.0 + ahead_s) * SECOND_NS))


@pytest.mark.parametrize('system', ['UTC', 'TAI', 'TT'])
@pytest.mark.parametrize('first_s', [-600.0, -599.5, -570.0])
def test_across_a_leap_second_the_orbit_goes_on_in_tai(system, first_s):
    """
    Rows each minute of TAI, one of them at the begin of the leap second, within it, or none.

    At a stamp the orbit is where a second more has brought it, by Kepler; no stamp has the leap
    second itself.  As without one the eighth derivative leaves 1e-6 m.
    """
    pytest.importorskip('erfa')
    rows_s = np.arange(first_s, 700.0, 60.0)
    rows = segment(rows_s, system=system).splitlines()
    begin = rows.index('META_STOP') + 1
    for i, t_s in enumerate(rows_s, begin):
        rows[i] = ' '.join([leap_epoch(system, t_s), *rows[i].split()[1:]])
    source = EphemerisOrbit(HEADER + '\n'.join(rows) + '\n', LEAP_NS - 60 * SECOND_NS)
    t_s = np.array([-550.0, 0.0, 45.3, 59.999, 60.0, 60.001, 61.0, 119.0, 300.0, 600.0])
    true_s = t_s + (t_s >= 60.0)
    for found in (source.position_velocity(t_s), TabledOrbit(source).position_velocity(t_s)):
        for values, true, allowed in zip(
            found, KEPLER.position_velocity(true_s), (1e-4, 1e-6), strict=True
        ):
            assert_allclose(values, true, rtol=0.0, atol=allowed)
    assert source.warning is None


def test_a_leap_second_of_another_time_system_is_refused():
    """TAI has none."""
    pytest.importorskip('erfa')
    text = segment(MINUTES[:6], system='TAI').replace('11:56:00', '11:55:60')
    with pytest.raises(ValueError, match='is a leap second, and not in UTC'):
        read(text)


CIRCLE = KeplerOrbit(semi_major_axis=6.798e6, inclination=0.9)


@pytest.mark.parametrize('step_s', [60.0, 240.0])
def test_rows_that_carry_their_interpolation_are_not_reported(step_s):
    """Of a low orbit, as they are issued."""
    assert read(segment(np.arange(0.0, 43201.0, step_s), CIRCLE)).warning is None


def test_rows_too_far_apart_are_reported():
    """
    By how much the interpolation of every other row misses one of the others, which, how far.

    SciPy's polynomial of the other rows misses it by the same.
    """
    rows_s = np.arange(0.0, 43201.0, 900.0)
    warning = read(segment(rows_s, CIRCLE)).warning
    missed_m = {
        t_s: np.linalg.norm(
            hermite(t_s, rows_s[::2], CIRCLE)[0] - CIRCLE.position_velocity(t_s)[0]
        )
        for t_s in rows_s[1:-1:2]
    }
    worst_s = max(missed_m, key=lambda t_s: missed_m[t_s])
    assert f'orbit.file has rows 900 s apart at {at(worst_s)}, ' in warning
    assert warning.endswith(f'misses the one there by {missed_m[worst_s]:.3g} m')
    assert missed_m[worst_s] > 100.0


def test_straight_lines_are_reported():
    """Half of a chord of two minutes is kilometres from the circle."""
    assert 'e+04 m' in read(segment(MINUTES, INTERPOLATION='LINEAR')).warning


class Rest:
    """A body that stays where it is."""

    @staticmethod
    def position_velocity(t_s):
        return np.tile([7e6, 0.0, 0.0], (len(t_s), 1)), np.zeros((len(t_s), 3))


LOW = KeplerOrbit(semi_major_axis=6.5e6, eccentricity=0.04)


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        (segment(MINUTES[:6], Rest), 'at 2026-03-01T11:55:00 the body .* rests, .* has no LVLH'),
        (segment(MINUTES, LOW), r'line \d+: the row at .* is within the Earth'),
        (
            segment(np.arange(0.0, 9000.0, 1500.0), CIRCLE, INTERPOLATION='LINEAR'),
            "between rows 1500 s apart, its interpolation of degree 1 is .* km from the Earth's",
        ),
        (
            segment(np.arange(0.0, 43201.0, 3600.0), CIRCLE),
            'between rows 3600 s apart, its interpolation of degree 7 is .* within the Earth',
        ),
        (
            segment(MINUTES) + segment(MINUTES[20:40]),
            'the segments of lines 4 and 196 both hold 2026-03-01T12:15:00',
        ),
    ],
    ids=['rest', 'low', 'linear', 'hermite', 'nested'],
)
def test_what_is_no_orbit_is_refused(text, reason):
    """At rest, within the Earth at a row or between two, in two positions at once."""
    with pytest.raises(ValueError, match=f'^orbit.file: .*{reason}'):
        read(text)


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('number', ['1e308', '-1e11', '1e99'])
def test_a_row_far_from_the_earth_is_refused(number):
    """Without a warning of an overflow."""
    row = ' '.join([ROW.split()[0], number, *ROW.split()[2:]])
    with pytest.raises(ValueError, match=r'orbit.file: line 11: the row at .* more than 1e'):
        EphemerisOrbit(GOOD.replace(ROW, row), EPOCH_NS)

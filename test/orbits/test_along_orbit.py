"""The tables of the environment hold what is computed directly, wherever they are asked."""

from functools import cache

import erfa
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from satdyn_ros.base.nanoseconds import SECOND_NS, stamp_ns
from satdyn_ros.environment import (
    Exponential,
    Msis,
    air_velocity,
    dipole_field,
    dipole_vector,
    gcrs_to_itrs,
    geodetic,
    igrf_field,
    sun_position,
    turned,
)
from satdyn_ros.orbits import KeplerOrbit, TabledOrbit
from satdyn_ros.orbits.along_orbit import AlongOrbit
from satdyn_ros.orbits.j2 import OblateOrbit
from satdyn_ros.orbits.tle import TwoLineOrbit

# 2026-03-01T12:00:00
EPOCH_NS = 1_772_366_400 * 10**9
# 2006-06-26T19:00:00, within minutes of the element set's epoch.
TLE_NS = 1_151_348_400 * 10**9
LOW = KeplerOrbit(semi_major_axis=6.8e6, inclination=0.9, raan=0.4)
ORBITS: dict[str, KeplerOrbit | TabledOrbit] = {
    'low': LOW,
    'eccentric': KeplerOrbit(semi_major_axis=9.6e6, eccentricity=0.3, inclination=1.1),
    # The Earth turns nine times while it turns by half a radian.
    'far': KeplerOrbit(semi_major_axis=1e9, inclination=0.5),
    'polar': KeplerOrbit(semi_major_axis=7e6, inclination=np.pi / 2.0),
    'oblate': TabledOrbit(OblateOrbit(LOW, 1.08263e-3, 6378137.0)),
    'tle': TabledOrbit(
        TwoLineOrbit(
            '1 28057U 03049A   06177.78615833  .00000060  00000-0  35940-4 0  1836\n'
            '2 28057  98.4283 247.6961 0000884  88.1964 271.9322 14.35478080140550',
            TLE_NS,
        )
    ),
}
AIR = Exponential(3e-12, 420e3, 6e4)


@cache
def tables(name, model='igrf'):
    """Return what is along an orbit, with the instant of tick 0 of the orbit."""
    return AlongOrbit(ORBITS[name], TLE_NS if name == 'tle' else EPOCH_NS, model, AIR, True)


def times_s():
    """Return times at random over a day and a half, before tick 0 too, at whole nanoseconds."""
    return np.sort(np.random.default_rng(11).uniform(-40_000.0, 90_000.0, 200)).round(9)


def direct(along, name, t_s):
    """Return what a table says, computed for each time by itself."""
    unix_ns, (r_i, v_i) = along.unix_ns(t_s), along.orbit.position_velocity(t_s)
    to_itrs = gcrs_to_itrs(unix_ns)
    r_t = turned(to_itrs, r_i)
    to_gcrs = to_itrs.swapaxes(-1, -2)
    return {
        'igrf': lambda: turned(to_gcrs, igrf_field(unix_ns, r_t)),
        'dipole': lambda: turned(to_gcrs, dipole_field(dipole_vector(along.epoch_ns), r_t)),
        'air_velocity': lambda: air_velocity(r_i, v_i, to_itrs[..., 2, :]),
        'log_density': lambda: AIR.log_density(geodetic(r_t)[2])[:, None],
        'sun': lambda: sun_position(unix_ns),
        'to_itrs': lambda: to_itrs.reshape(-1, 9),
    }[name]()


@pytest.mark.parametrize('orbit', ORBITS)
@pytest.mark.parametrize(
    'name', ['igrf', 'dipole', 'air_velocity', 'log_density', 'sun', 'to_itrs']
)
def test_a_table_is_what_is_computed_directly(orbit, name):
    """To 1e-10 of the largest value, at times at random."""
    along, t_s = tables(orbit, 'dipole' if name == 'dipole' else 'igrf'), times_s()
    table = getattr(along, 'magnetic_field' if name in ('igrf', 'dipole') else name)
    true = direct(along, name, t_s)
    found = table.values(t_s, np.arange(true.shape[1]))
    assert np.max(np.abs(found - true)) < 1e-10 * np.max(np.abs(true))


def test_the_bits_do_not_depend_on_what_was_asked_before():
    """In any order, of tables that are new or have been asked, of single times and of many."""
    t_s, columns = times_s()[:40], np.arange(3)
    right = tables('low').magnetic_field.values(t_s, columns)
    fresh = AlongOrbit(LOW, EPOCH_NS, 'igrf').magnetic_field
    for i in np.random.default_rng(12).permutation(len(t_s)):
        assert_array_equal(fresh.values(t_s[i : i + 1], columns)[0], right[i])


def true_across_the_leap_second(t_s):
    """
    Return Sun (3,) and GCRS to ITRS (9,) at a time from 2016-12-31T23:50:00 by stamps, by ERFA.

    ERFA counts the days of UTC itself: that day has 86401 s.
    """
    day = (2016, 12, 31) if t_s < 600.0 else (2017, 1, 1)
    minutes, seconds = divmod(t_s, 60.0)
    hour, minute = (23, 50 + int(minutes)) if t_s < 600.0 else (0, int(minutes) - 10)
    tt = erfa.taitt(*erfa.utctai(*erfa.dtf2d('UTC', *day, hour, minute, seconds)))
    earth_from_sun, _ = erfa.epv00(*tt)
    # Unix time, which is taken for UT1, and in which each day has 86400 s.
    days, date = erfa.cal2jd(*day)
    ut1 = days + date, (3600.0 * hour + 60.0 * minute + seconds) / 86_400.0
    to_itrs = erfa.rz(erfa.era00(*ut1), erfa.c2i06a(*tt))
    return -149_597_870_700.0 * earth_from_sun['p'], to_itrs.reshape(9)


def test_tables_end_at_a_leap_second():
    """On both sides of 2016-12-31T23:59:60 the Sun and the Earth are ERFA's, to 1e-10."""
    along = AlongOrbit(LOW, stamp_ns('2016-12-31T23:50:00'), has_sun=True)
    apart_s = np.array([1e-6, 1e-3, 0.3, 5.0, 100.0, 250.0, 500.0])
    t_s = np.sort([*(600.0 - apart_s), 600.0, *(600.0 + apart_s)])
    sun, to_itrs = map(np.array, zip(*map(true_across_the_leap_second, t_s), strict=True))
    found = along.sun.values(t_s, np.arange(3))
    assert np.max(np.abs(found - sun)) < 1e-10 * np.max(np.abs(sun))
    assert np.max(np.abs(along.to_itrs.values(t_s, np.arange(9)) - to_itrs)) < 1e-10
    for table in (along.sun, along.to_itrs, along.air_velocity):
        assert table.piece_at(600.0).begin_s == 600.0 == table.piece_at(599.9).end_s
    # By earlier rules a piece ran across.
    across = AlongOrbit(LOW, along.epoch_ns, has_sun=True, with_jumps=True).sun
    assert np.max(np.abs(across.values(t_s, np.arange(3)) - sun)) > 1e-8 * np.max(np.abs(sun))


def test_the_field_follows_the_igrf_where_its_slope_jumps():
    """To 1e-10 within minutes of a year of the model, 2015."""
    along = AlongOrbit(LOW, stamp_ns('2014-12-31T23:55:00'), 'igrf')
    t_s = np.linspace(0.0, 600.0, 61)
    true = along.modelled_field(t_s)
    found = along.magnetic_field.values(t_s, np.arange(3))
    assert np.max(np.abs(found - true)) < 1e-10 * np.max(np.abs(true))
    assert along.magnetic_field.piece_at(300.0).begin_s == 300.0


def test_the_air_of_a_day_is_its_own():
    """
    Up to midnight, where MSIS jumps by 5e-3, the table is the model to what that scatters.

    By earlier rules the last piece of a day knew the first second of the next.
    """
    msis, epoch_ns = Msis(), stamp_ns('2026-02-28T23:50:00')
    along, before = (AlongOrbit(LOW, epoch_ns, air=msis, with_jumps=x) for x in (False, True))
    t_s = np.arange(0.0, 1200.0)
    r_i, _ = LOW.position_velocity(t_s)
    unix_ns = along.unix_ns(t_s)
    positions = geodetic(turned(gcrs_to_itrs(unix_ns), r_i))
    true = msis.log_density(unix_ns // SECOND_NS, *positions)
    assert np.max(np.abs(along.log_density.values(t_s, np.arange(1))[:, 0] - true)) < 2e-5
    assert np.max(np.abs(before.log_density.values(t_s, np.arange(1))[:, 0] - true)) > 1e-3

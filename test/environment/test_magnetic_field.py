"""The field is that of other programs, and one that has no source outside the Earth."""

from datetime import datetime, timedelta

import numpy as np
import ppigrf
import pytest
from environment import truth
from numpy.testing import assert_allclose, assert_array_equal

from satdyn_ros.base.nanoseconds import stamp_ns
from satdyn_ros.environment import (
    dipole_field,
    dipole_vector,
    gcrs_to_itrs,
    igrf_field,
    igrf_warning,
    turned,
)
from satdyn_ros.environment.magnetic_field import IGRF_RADIUS_M
from satdyn_ros.kernel.rows import length


def new_year_ns(year):
    return stamp_ns(f'{year}-01-01T00:00:00')


def assert_close(B, right, share):
    """Fail where a field differs by more than a share of its size there."""
    assert np.max(length(B - right) / length(right)) < share


def test_single_positions():
    """
    IGRF and dipole are the reference's, beside the poles too.

    Tolerance: sums of 195 terms in another order, rounding: 1e-13.
    """
    stamps_ns, r_t = truth.points('epoch_ns'), truth.points('r_itrs')
    assert_close(igrf_field(stamps_ns, r_t), 1e-9 * truth.points('igrf_itrs_nT'), 1e-13)
    dipoles = [dipole_field(dipole_vector(at), r) for at, r in zip(stamps_ns, r_t, strict=True)]
    assert_close(np.array(dipoles), 1e-9 * truth.points('dipole_itrs_nT'), 1e-13)


@pytest.mark.parametrize('case', truth.cases('B_b'), ids=lambda case: case['name'])
def test_along_orbits(case):
    """
    In body axes, at the reference's positions and attitudes, the field is the reference's.

    Tolerance: attitudes and positions are given to rounding, 1e-15 of the field for each.
    """
    stamps_ns, r_i = truth.stamps_ns(case), truth.column(case['orbit'], 'r_i')
    to_itrs = gcrs_to_itrs(stamps_ns)
    r_t = turned(to_itrs, r_i)
    if case['scenario']['environment']['magnetic_field'] == 'dipole':
        B_t = dipole_field(dipole_vector(stamps_ns[0]), r_t)
    else:
        B_t = igrf_field(stamps_ns, r_t)
    B_b = truth.in_body_axes(case, turned(to_itrs.swapaxes(-1, -2), B_t))
    assert_close(B_b, truth.column(case['fields'], 'B_b'), 1e-13)


def test_another_program():
    """
    ppigrf, by Legendre functions of the latitude, has the same field from 1900 to 2030.

    At 25 dates and 20 positions drawn at random, up to seven radii out.  Tolerance: ppigrf divides
    by the sine of the colatitude, and its decimal years are in whole microseconds: 1e-9.
    """
    rng = np.random.default_rng(14)
    dates = [datetime(1900, 1, 1) + timedelta(days=float(d)) for d in rng.uniform(0, 47_400, 25)]
    stamps_ns = np.array([stamp_ns(f'{date.isoformat()}') for date in dates])
    r_t = rng.normal(size=(20, 3))
    r_t *= (rng.uniform(1.0, 7.0, 20) * IGRF_RADIUS_M / length(r_t))[:, None]
    colatitude = np.arctan2(np.hypot(r_t[:, 0], r_t[:, 1]), r_t[:, 2])
    longitude = np.arctan2(r_t[:, 1], r_t[:, 0])
    degrees = np.degrees(colatitude), np.degrees(longitude)
    parts = ppigrf.igrf_gc(1e-3 * length(r_t), *degrees, dates)
    sine, cosine, zero = np.sin(colatitude), np.cos(colatitude), np.zeros(20)
    up = np.stack([sine * np.cos(longitude), sine * np.sin(longitude), cosine], axis=-1)
    south = np.stack([cosine * np.cos(longitude), cosine * np.sin(longitude), -sine], axis=-1)
    east = np.stack([-np.sin(longitude), np.cos(longitude), zero], axis=-1)
    right = sum(B[..., None] * axis for B, axis in zip(parts, (up, south, east), strict=True))
    assert_close(igrf_field(stamps_ns[:, None], r_t), 1e-9 * right, 1e-9)


@pytest.mark.parametrize(
    'position', [[0, 0, 7e6], [0, 0, -6.5e6], [6e6, 3e6, -1e6], [-4e7, 1e6, 0]]
)
def test_the_field_has_neither_sources_nor_curl(position):
    """
    At the poles as elsewhere the derivatives are a symmetric matrix without a trace.

    By differences over h = 1e-4 r: their error is (n h / r)^2 / 6 of the derivatives, n to 13,
    and rounding leaves 1e-16 r / h.
    """
    h = 1e-4 * np.linalg.norm(position)
    at = np.array(position, float) + h * np.array([np.eye(3), -np.eye(3)])
    ahead, behind = igrf_field(new_year_ns(2026), at)
    gradient = (ahead - behind) / (2.0 * h)
    size = np.max(abs(gradient))
    assert abs(np.trace(gradient)) < 1e-6 * size
    assert_allclose(gradient, gradient.T, rtol=0.0, atol=1e-6 * size)


def test_between_the_years_it_is_linear():
    """
    Halfway in elapsed time the field is the mean, in years of unlike length and beyond 2030.

    Tolerance: rounding; in decimal years the middle of 2020 to 2025 is half a day away.
    """
    position = [4e6, -3e6, 5e6]
    for first, last in [(1900, 1905), (2020, 2025), (2025, 2030), (2026, 2034)]:
        begin_ns, end_ns = new_year_ns(first), new_year_ns(last)
        begin, middle, end = igrf_field([begin_ns, (begin_ns + end_ns) // 2, end_ns], position)
        assert_allclose(middle, 0.5 * (begin + end), rtol=1e-13)
        assert np.linalg.norm(end - begin) > 1e-8


def test_beyond_its_interval():
    """It warns outside 1900 to 2030, and is refused five years beyond; the limits are inside."""
    inside = [new_year_ns(1900), new_year_ns(2030)]
    assert igrf_warning(inside) is None
    assert igrf_warning([*inside, new_year_ns(2031)]) == (
        '2031-01-01 is outside the IGRF, which is from 1900 to 2030; the field is extrapolated'
    )
    assert igrf_warning(new_year_ns(1900) - 1)
    position = [7e6, 0.0, 0.0]
    igrf_field([new_year_ns(1895), new_year_ns(2035)], position)
    sentence = '2035-01-01 is outside the IGRF, .* extrapolated by 5 years at most'
    with pytest.raises(ValueError, match=sentence):
        igrf_field(new_year_ns(2035) + 1, position)
    with pytest.raises(ValueError, match=sentence):
        dipole_vector(new_year_ns(2035) + 1)


def test_one_has_the_bits_of_many():
    """A position alone has the field that it has among others."""
    stamps_ns, r_t = truth.points('epoch_ns'), truth.points('r_itrs')
    fields = igrf_field(stamps_ns, r_t)
    alone = [igrf_field(at, r) for at, r in zip(stamps_ns, r_t, strict=True)]
    assert_array_equal(alone, fields)

"""Element sets fly as SGP4 flies them, and what is wrong with one is said."""

import json
import threading

import numpy as np
import pytest
from cases import REFERENCE
from numpy.testing import assert_allclose

from satdyn_ros.base.nanoseconds import SECOND_NS, stamp_ns
from satdyn_ros.environment.earth import teme_to_gcrs
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits.axes_of_date import tabled_teme_to_gcrs
from satdyn_ros.orbits.tabled import TabledOrbit
from satdyn_ros.orbits.tle import TwoLineOrbit

api = pytest.importorskip('sgp4.api')
erfa = pytest.importorskip('erfa')

CBERS = (
    '1 28057U 03049A   06177.78615833  .00000060  00000-0  35940-4 0  1836',
    '2 28057  98.4283 247.6961 0000884  88.1964 271.9322 14.35478080140550',
)
# Of the verification set of Spacetrack Report 3: an orbit of twelve hours, in resonance.
MOLNIYA = (
    '1 09880U 77021A   06176.56157475  .00000421  00000-0  10000-3 0  9814',
    '2 09880  64.5968 349.3786 7069051 270.0229  16.3320  2.00813614112380',
)
EPOCH_NS = stamp_ns('2006-06-27T01:00:00')
OMM = """CCSDS_OMM_VERS = 2.0
CREATION_DATE = 2006-06-27T00:00:00
ORIGINATOR = TEST
OBJECT_NAME = CBERS 2
OBJECT_ID = 2003-049A
CENTER_NAME = EARTH
REF_FRAME = TEME
TIME_SYSTEM = UTC
MEAN_ELEMENT_THEORY = SGP4
EPOCH = 2006-06-26T18:52:04.079712
MEAN_MOTION = 14.35478080 [rev/day]
ECCENTRICITY = 0.0000884
INCLINATION = 98.4283
RA_OF_ASC_NODE = 247.6961
ARG_OF_PERICENTER = 88.1964
MEAN_ANOMALY = 271.9322
NORAD_CAT_ID = 128057123
BSTAR = 0.000035940
MEAN_MOTION_DOT = 0.00000060
MEAN_MOTION_DDOT = 0
"""


def orbit(lines=CBERS, epoch_ns=EPOCH_NS):
    return TwoLineOrbit('\n'.join(lines), epoch_ns)


@pytest.mark.parametrize('lines', [CBERS, MOLNIYA])
def test_the_table_is_sgp4_for_a_week(lines):
    """To a millimetre: the library asked at Julian dates, turned by matrices of each instant."""
    t_s = np.random.default_rng(3).uniform(0.0, 7 * 86400.0, 300)
    days = 2440587.5 + EPOCH_NS // (86400 * SECOND_NS)
    parts = (EPOCH_NS / SECOND_NS % 86400.0 + t_s) / 86400.0
    errors, r_km, v_km_s = api.Satrec.twoline2rv(*lines).sgp4_array(np.full(300, days), parts)
    assert not np.any(errors)
    to_gcrs = teme_to_gcrs(EPOCH_NS + np.rint(t_s * SECOND_NS).astype(np.int64))
    found = TabledOrbit(orbit(lines)).position_velocity(t_s)
    for values, true, allowed in zip(found, (r_km, v_km_s), (1e-3, 1e-6), strict=True):
        true = 1e3 * np.einsum('nij,nj->ni', to_gcrs, true)
        assert_allclose(values, true, rtol=0.0, atol=allowed)


def test_reference_states():
    """Those of the reference case and points, by the same libraries; their noise is 1e-6 m."""
    reference = json.loads((REFERENCE / 'environment.json').read_text())
    (case,) = (case for case in reference['cases'] if case['name'] == 'tle_cbers2')
    scenario = case['scenario']
    flown = TabledOrbit(orbit(scenario['orbit']['tle'], scenario['time']['epoch_ns']))
    r_i, v_i = flown.position_velocity(np.array([row['t'] for row in case['orbit']]))
    assert_allclose(r_i, [row['r_i'] for row in case['orbit']], rtol=0.0, atol=1e-5)
    assert_allclose(v_i, [row['v_i'] for row in case['orbit']], rtol=0.0, atol=1e-8)
    points = [point for point in reference['field_points'] if 'tle' in point]
    assert len(points) >= 8
    for point in points:
        r_i, v_i = orbit(point['tle'], point['epoch_ns']).position_velocity(np.zeros(1))
        assert_allclose(r_i[0], point['r_gcrs'], rtol=0.0, atol=1e-5)
        assert_allclose(v_i[0], point['v_gcrs'], rtol=0.0, atol=1e-8)


def test_the_published_example_of_teme():
    """
    Vallado, Crawford, Hujsak and Kelso 2006, appendix C: TEME and GCRF of 6 April 2004.

    They use the older theory of nutation with the corrections of the day, 0.05 arcsec here.
    """
    matrix = teme_to_gcrs(stamp_ns('2004-04-06T07:51:28.386009'))
    r_i = matrix @ [5094180.16210, 6127644.65950, 6380344.53270]
    assert_allclose(r_i, [5102508.9579, 6123011.4007, 6378136.9282], rtol=0.0, atol=2.5)


def test_the_turn_of_teme_is_tabulated():
    """To 1e-12 rad, seven micrometres, over the years and on both sides of a leap second."""
    t_s = np.random.default_rng(4).uniform(9e8, 1.9e9, 50)
    t_s = np.append(t_s, 1483228800.0 + np.array([-1.0, -1e-3, 0.0, 1.0]))
    true = teme_to_gcrs(np.rint(t_s * SECOND_NS).astype(np.int64))
    assert_allclose(tabled_teme_to_gcrs(t_s), true, rtol=0.0, atol=1e-12)


def test_lvlh_turns_as_the_positions_do():
    """
    The rate is that of the line and the plane of SGP4's positions, by differences.

    Over 20 s the second order leaves 2e-8 of the rate; by SGP4's velocity it would be off by 1e-9.
    """
    flown, h_s = TabledOrbit(orbit()), 5.0
    t_s = np.random.default_rng(5).uniform(0.0, 86400.0, 100)
    q = [flown.lvlh(t_s + n * h_s) for n in (-2, -1, 1, 2)]
    turns = [
        rotation.to_vector(rotation.multiply(ahead, rotation.conjugate(behind))) / (2 * n * h_s)
        for n, ahead, behind in ((1, q[2], q[1]), (2, q[3], q[0]))
    ]
    rate = (4.0 * turns[0] - turns[1]) / 3.0
    assert_allclose(flown.lvlh_rate(t_s), rate, rtol=0.0, atol=1e-11)


def test_a_velocity_is_not_quite_the_slope():
    """What is published is SGP4's own, centimetres a second from the slope of the positions."""
    flown, t_s = TabledOrbit(orbit()), np.linspace(0.0, 6000.0, 50)
    _, v_i = flown.position_velocity(t_s)
    (ahead, _), (behind, _) = (flown.position_velocity(t_s + h) for h in (0.1, -0.1))
    off = np.linalg.norm(v_i - (ahead - behind) / 0.2, axis=1)
    assert 0.01 < np.max(off) < 0.05


def test_pieces_of_two_threads_are_those_of_one():
    """SGP4 keeps what it summed up of a resonance; each piece begins anew."""
    right, t_s = TabledOrbit(orbit(MOLNIYA)), np.linspace(0.0, 3e6, 400)
    r_i, _ = right.position_velocity(t_s)
    shared, found = TabledOrbit(orbit(MOLNIYA)), {}

    def ask(name, order):
        found[name] = shared.position_velocity(t_s[order])[0][np.argsort(order)]

    orders = {'ahead': np.arange(400), 'back': np.arange(400)[::-1]}
    threads = [threading.Thread(target=ask, args=each) for each in orders.items()]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for each in found.values():
        np.testing.assert_array_equal(each, r_i)


@pytest.mark.parametrize('text', [OMM, 'xml'])
def test_an_omm_is_its_two_lines(text):
    """In both notations, with a number of nine digits; elements in decimals, so to rounding."""
    if text == 'xml':
        pairs = [line.split(' [')[0].split(' = ') for line in OMM.splitlines()[1:]]
        fields = ''.join(f'<{keyword}>{value}</{keyword}>' for keyword, value in pairs)
        text = f'<?xml version="1.0"?><omm><body>{fields}</body></omm>'
    t_s = np.linspace(0.0, 86400.0, 20)
    found = TwoLineOrbit(text, EPOCH_NS).position_velocity(t_s)[0]
    assert_allclose(found, orbit().position_velocity(t_s)[0], rtol=0.0, atol=1e-2)


def test_a_line_of_the_name_may_be_above():
    """As catalogues give it, with spaces at the ends of the lines."""
    named = orbit(['CBERS 2', f'{CBERS[0]}  ', f'{CBERS[1]} ', ''])
    assert named.elements_ns == orbit().elements_ns == stamp_ns('2006-06-26T18:52:04.079712')


@pytest.mark.parametrize(
    ('lines', 'reason'),
    [
        (CBERS[:1], 'has 1 lines; it must be two'),
        (CBERS[::-1], 'has its second line first'),
        ((CBERS[0], CBERS[0]), "line 2 of orbit.tle begins with '1 '; it must begin with '2 '"),
        ((CBERS[0][:-1], CBERS[1]), 'line 1 of orbit.tle has 68 characters; it must have 69'),
        (
            (CBERS[0], CBERS[1].replace('98.4283', '98.4284')),
            'line 2 of orbit.tle ends with the checksum 0, and its characters make 1',
        ),
        ((CBERS[0], MOLNIYA[1]), 'the lines of orbit.tle are of two satellites, 28057 and 09880'),
        (
            (
                CBERS[0].replace(' 03049A   ', ' 03049A  ').replace(' 0  1836', ' 0   1836'),
                CBERS[1],
            ),
            'line 1 of orbit.tle has its numbers in other columns',
        ),
    ],
)
def test_what_is_wrong_with_the_lines_is_said(lines, reason):
    """In one sentence that names the line."""
    with pytest.raises(ValueError, match=reason) as refusal:
        orbit(lines)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize(
    ('old', 'new', 'reason'),
    [
        ('CENTER_NAME = EARTH', 'CENTER_NAME = MARS', 'CENTER_NAME is MARS; it must be EARTH'),
        ('= SGP4', '= DSST', 'MEAN_ELEMENT_THEORY is DSST'),
        ('BSTAR = 0.000035940\n', '', 'it has no BSTAR'),
        ('= 98.4283', '= steep', 'steep'),
        ('ECCENTRICITY', 'EPOCH = 2026-01-01T00:00:00\nECCENTRICITY', 'it holds 2 element sets'),
    ],
)
def test_what_is_wrong_with_an_omm_is_said(old, new, reason):
    """By the keyword."""
    assert old in OMM
    with pytest.raises(
        ValueError, match=f'orbit.tle holds an OMM that cannot be read: .*{reason}'
    ):
        TwoLineOrbit(OMM.replace(old, new), EPOCH_NS)


def test_an_epoch_far_from_tick_0_is_told():
    """Beyond fourteen days, on either side."""
    assert orbit(epoch_ns=stamp_ns('2006-07-10T18:00:00')).warning is None
    warning = orbit(epoch_ns=stamp_ns('2006-07-11T18:00:00')).warning
    assert warning.startswith(
        'the epoch of orbit.tle, 2006-06-26T18:52:04, is 15 days from tick 0'
    )
    assert orbit(epoch_ns=stamp_ns('2006-06-01T18:00:00')).warning


def test_a_satellite_that_decayed_has_no_place():
    """Told with the time, before which it flies; a set of the verification of SGP4."""
    decaying = orbit(
        [
            '1 28872U 05037B   05333.02012661  .25992681  00000-0  24476-3 0  1534',
            '2 28872  96.4736 157.9986 0303955 244.0492 110.6523 16.46015938 10708',
        ],
        stamp_ns('2005-11-29T00:00:00'),
    )
    flown = TabledOrbit(decaying)
    assert np.all(np.isfinite(flown.position_velocity(1800.0)[0]))
    with pytest.raises(ValueError, match=r'no place for orbit.tle at 2005-11-29T.*decayed'):
        flown.position_velocity(6000.0)

"""Element sets fly as SGP4 flies them, and what is wrong with one is said."""

import json
import re
import threading
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from cases import REFERENCE
from numpy.testing import assert_allclose

from satdyn_ros.base.nanoseconds import SECOND_NS, stamp_ns
from satdyn_ros.environment.earth import teme_to_gcrs
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits.axes_of_date import tabled_teme_to_gcrs
from satdyn_ros.orbits.tabled import TabledOrbit
from satdyn_ros.orbits.tle import TwoLineOrbit, check
from satdyn_ros.run.scenario import Scenario

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


def with_checksum(line):
    """Return a line with the checksum of its characters."""
    tally = sum(int(c) if c in '0123456789' else c == '-' for c in line[:-1])
    return f'{line[:-1]}{tally % 10}'


def changed(line, column, text):
    """Return one of CBERS with other characters from a column on, counted from 1 as published."""
    lines = list(CBERS)
    old = lines[line - 1]
    new = f'{old[: column - 1]}{text}{old[column - 1 + len(text) :]}'
    lines[line - 1] = with_checksum(new)
    return '\n'.join(lines)


def as_xml(message, root='omm', units=False):
    """Return an OMM in XML, its units in attributes where they are wanted."""
    fields = ''
    for line in message.splitlines()[1:]:
        keyword, value = line.split(' = ')
        value, _, unit = value.partition(' [')
        attribute = f' units="{unit.rstrip("]")}"' if unit and units else ''
        fields += f'<{keyword}{attribute}>{value}</{keyword}>'
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><{root}><body>{fields}</body></{root.split()[0]}>'
    )


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


def as_json(message, quoted=False):
    """Return an OMM as a list of one object, its numbers between quotes where they are wanted."""
    pairs = dict(line.partition(' [')[0].split(' = ') for line in message.splitlines())
    is_number = {key for key, value in pairs.items() if re.fullmatch('[0-9.]+', value)}
    return json.dumps(
        [
            {
                key: float(value) if key in is_number and not quoted else value
                for key, value in pairs.items()
            }
            | {'DECAY_DATE': None, 'TLE_LINE0': '0 CBERS 2'}
        ]
    )


def as_csv(message):
    """Return an OMM as two rows."""
    pairs = [line.partition(' [')[0].split(' = ') for line in message.splitlines()]
    return '\r\n'.join(','.join(f'"{word}"' for word in row) for row in zip(*pairs, strict=True))


@pytest.mark.parametrize(
    'text',
    [
        OMM,
        as_xml(OMM),
        as_xml(OMM, 'omm xmlns="urn:ccsds:schema:ndmxml"', units=True),
        as_json(OMM),
        as_json(OMM, quoted=True),
        as_json(OMM)[1:-1],
        as_csv(OMM),
    ],
    ids=['keywords', 'xml', 'namespace', 'json', 'json-texts', 'json-object', 'csv'],
)
def test_an_omm_is_its_two_lines(text):
    """In each notation, with a number of nine digits; elements in decimals, so to rounding."""
    check(text)
    t_s = np.linspace(0.0, 86400.0, 20)
    found = TwoLineOrbit(text, EPOCH_NS).position_velocity(t_s)[0]
    assert_allclose(found, orbit().position_velocity(t_s)[0], rtol=0.0, atol=1e-2)


@pytest.mark.parametrize(
    ('keyword', 'value'),
    [
        ('CLASSIFICATION_TYPE', ''),
        ('ELEMENT_SET_NO', '99999999999999999999'),
        ('REV_AT_EPOCH', 'many'),
        ('NORAD_CAT_ID', 'T0042'),
        ('MEAN_MOTION_DDOT', 'nan'),
        ('EPHEMERIS_TYPE', '2'),
    ],
)
def test_what_plays_no_part_in_sgp4_is_not_read(keyword, value):
    """Whatever it says, bit for bit the same orbit; type 2 is SGP4 too."""
    kept = '\n'.join(line for line in OMM.splitlines() if not line.startswith(f'{keyword} '))
    text = f'{kept}\n{keyword} = {value}\n'
    check(text)
    t_s = np.linspace(0.0, 86400.0, 5)
    found = TwoLineOrbit(text, EPOCH_NS).position_velocity(t_s)[0]
    np.testing.assert_array_equal(found, TwoLineOrbit(OMM, EPOCH_NS).position_velocity(t_s)[0])


def test_the_published_element_sets_are_all_taken():
    """
    Those with which SGP4 was verified (Vallado and others 2006).

    The numbers 33333 to 33335 are made up, the first two so that SGP4 fails.
    """
    lines = (Path(api.__file__).parent / 'SGP4-VER.TLE').read_text().splitlines()
    sets = [pair for pair in pairwise(lines) if pair[0].startswith('1 ')]
    assert len(sets) > 30
    for first, second in sets:
        made_up = first[2:7].startswith('3333')
        pair = (line[:69] for line in (first, second))
        text = '\n'.join(with_checksum(line) if made_up else line for line in pair)
        if first[2:7] in ('33333', '33334'):
            with pytest.raises(ValueError, match=r'orbit\.tle'):
                check(text)
        else:
            check(text)


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
        ('= SGP4', '= SGP4-XP', 'MEAN_ELEMENT_THEORY is SGP4-XP'),
        ('= 98.4283', '= steep', 'INCLINATION is steep, which is not a number'),
        ('ECCENTRICITY', 'EPOCH = 2026-01-01T00:00:00\nECCENTRICITY', 'it holds 2 element sets'),
    ],
)
def test_what_is_wrong_with_an_omm_is_said(old, new, reason):
    """By the keyword."""
    assert old in OMM
    with pytest.raises(
        ValueError, match=f'orbit.tle holds an OMM that cannot be read: .*{reason}'
    ):
        check(OMM.replace(old, new))


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        (changed(1, 63, '4'), 'line 1 of orbit.tle is of ephemeris type 4, SGP4-XP; it must be 0'),
        (changed(1, 63, '6'), 'type 6, special perturbations'),
        (changed(1, 21, '000'), 'line 1 of orbit.tle has day 000.78615833 of the year 2006'),
        (changed(1, 21, '366'), 'day 366.78615833 of the year 2006; .* 1 to less than 366'),
        (changed(1, 19, '08367'), 'day 367.78615833 of the year 2008; .* 1 to less than 367'),
        (changed(1, 21, '1 7'), 'day 1 7.78615833'),
        (changed(1, 54, ' 35940+5'), r'drag term 35940\+5; it must be from -10 to 10 1/ER'),
        (
            changed(2, 9, '180.0001'),
            'line 2 of orbit.tle has the inclination 180.0001; .* 180 deg',
        ),
        (changed(2, 9, '999.9999'), 'the inclination 999.9999; it must be from 0 to 180 deg'),
        (changed(2, 9, ' 9 .4283'), 'the inclination 9 .4283, which is not a number'),
        (changed(2, 9, '   .    '), 'the inclination ., which is not a number'),
        (changed(2, 18, '360.0001'), 'the node 360.0001; it must be from 0 to 360 deg'),
        (changed(2, 35, '400.0000'), 'the argument of perigee 400.0000'),
        (changed(2, 44, '999.9999'), 'the mean anomaly 999.9999'),
        (changed(2, 53, ' 0.00000000'), 'the mean motion 0.00000000; it must be from 0.001 to 18'),
        (changed(2, 53, '19.00000000'), 'the mean motion 19.00000000'),
        (changed(2, 27, '5000000'), 'perigee of orbit.tle is 2[78].. km below the ground'),
    ],
)
def test_what_is_out_of_its_range_in_the_lines_is_said(text, reason):
    """By the line and the field's name."""
    with pytest.raises(ValueError, match=reason):
        check(text)


@pytest.mark.parametrize(
    'text',
    [
        changed(1, 19, '08366'),
        changed(1, 63, ' '),
        changed(1, 63, '2'),
        changed(1, 8, 'u'),
        changed(2, 18, '360.0000'),
        changed(2, 27, '  00884'),
        changed(2, 9, '  0.0000'),
    ],
)
def test_the_edges_of_the_ranges_are_taken(text):
    """The last day of a leap year, a rounded whole turn, blanks in place of zeros."""
    check(text)
    assert np.all(np.isfinite(TwoLineOrbit(text, EPOCH_NS).position_velocity(np.zeros(1))[0]))


@pytest.mark.parametrize('odd', ['²', '４', '४'])
def test_digits_of_other_scripts_are_refused(odd):
    """Superscript, full width and Devanagari, in lines and in keywords."""
    line = CBERS[1].replace('98.4283', f'98.{odd}283')
    with pytest.raises(ValueError, match=f"line 2 of orbit.tle has '{odd}' in column 13"):
        orbit((CBERS[0], line))
    with pytest.raises(ValueError, match=f'INCLINATION is 98.{odd}283, which is not a number'):
        check(OMM.replace('98.4283', f'98.{odd}283'))
    with pytest.raises(ValueError, match='EPOCH is'):
        check(OMM.replace('T18', f'T1{odd}'))


@pytest.mark.parametrize(
    ('keyword', 'value', 'reason'),
    [
        ('EPHEMERIS_TYPE', '4', 'EPHEMERIS_TYPE is 4, SGP4-XP; it must be 0 or 2'),
        ('INCLINATION', '400', 'INCLINATION is 400; it must be from 0 to 180 deg'),
        ('INCLINATION', '-1e-3', 'INCLINATION is -1e-3; it must be from 0'),
        ('INCLINATION', '9_8.4', 'INCLINATION is 9_8.4, which is not a number'),
        ('INCLINATION', '1.7 [rad]', 'INCLINATION is in rad; it must be in deg'),
        ('RA_OF_ASC_NODE', '360.5', 'RA_OF_ASC_NODE is 360.5'),
        ('ARG_OF_PERICENTER', '-400', 'ARG_OF_PERICENTER is -400; it must be from -360 to 360'),
        ('MEAN_ANOMALY', '1e400', 'MEAN_ANOMALY is 1e400; it must be from -360 to 360'),
        ('ECCENTRICITY', '1.0', 'ECCENTRICITY is 1.0; it must be from 0 to less than 1'),
        ('ECCENTRICITY', '-0.1', 'ECCENTRICITY is -0.1'),
        ('ECCENTRICITY', '0.1 [km]', 'ECCENTRICITY is in km; it must be without a unit'),
        ('MEAN_MOTION', 'inf', 'MEAN_MOTION is inf, which is not a number'),
        ('MEAN_MOTION', 'nan', 'MEAN_MOTION is nan'),
        ('MEAN_MOTION', '-14', 'MEAN_MOTION is -14; it must be from 0.001 to 18 rev/day'),
        ('BSTAR', '1e5', 'BSTAR is 1e5; it must be from -10 to 10 1/ER'),
        ('EPOCH', '9999-06-26T18:52:04', 'EPOCH is 9999-06-26T18:52:04; .* years 1957 to 2261'),
        ('EPOCH', '2006-000T18:52:04', 'no day 000'),
        ('EPOCH', '2006-366T18:52:04', 'no day 366'),
    ],
)
def test_what_is_out_of_its_range_in_an_omm_is_said(keyword, value, reason):
    """By the keyword, in one sentence, in both notations."""
    lines = [line for line in OMM.splitlines() if not line.startswith(f'{keyword} ')]
    message = '\n'.join([*lines, f'{keyword} = {value}'])
    for text in (message, as_xml(message, units=True)):
        with pytest.raises(ValueError, match=f'orbit.tle holds an OMM .*{reason}') as refusal:
            check(text)
        assert '\n' not in str(refusal.value)


def test_an_angle_of_an_omm_may_have_a_sign():
    """As some programs write it: the same position as a turn further."""
    lines = [line for line in OMM.splitlines() if not line.startswith('RA_OF_ASC_NODE ')]
    positions = []
    for node in ('-90.0', '270.0'):
        message = '\n'.join([*lines, f'RA_OF_ASC_NODE = {node}'])
        check(message)
        positions.append(TwoLineOrbit(message, EPOCH_NS).position_velocity(np.zeros(1))[0])
    # Rounding of 7e6 m.
    np.testing.assert_allclose(positions[0], positions[1], atol=1e-6)


def test_a_keyword_that_stands_twice_is_refused():
    """It is not known which of the values is meant."""
    with pytest.raises(ValueError, match='it has INCLINATION 2 times'):
        check(f'{OMM}INCLINATION = 12.5\n')


def test_elements_that_flew_by_earlier_rules_still_do():
    """A bag that has an SGP4-XP set is read; a new run of it is refused."""
    values = {'orbit.type': 'tle', 'orbit.tle': changed(1, 63, '4').splitlines()}
    values['time.epoch_ns'] = EPOCH_NS
    assert isinstance(Scenario(values, rules=3).system.orbit, TabledOrbit)
    with pytest.raises(ValueError, match='SGP4-XP'):
        Scenario(values)


def test_an_epoch_far_from_tick_0_is_reported():
    """Beyond fourteen days, on either side."""
    assert orbit(epoch_ns=stamp_ns('2006-07-10T18:00:00')).warning is None
    warning = orbit(epoch_ns=stamp_ns('2006-07-11T18:00:00')).warning
    assert warning.startswith(
        'the epoch of orbit.tle, 2006-06-26T18:52:04, is 15 days from tick 0'
    )
    assert orbit(epoch_ns=stamp_ns('2006-06-01T18:00:00')).warning


def test_a_satellite_that_decayed_has_no_position():
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
    with pytest.raises(ValueError, match=r'no position for orbit.tle at 2005-11-29T.*decayed'):
        flown.position_velocity(6000.0)
    # To a millisecond where the library itself says so.
    end_s = flown.pieces.piece_at(1800.0).end_s
    while flown.pieces.known_rows(np.array([end_s + 1.0]))[0]:
        end_s = flown.pieces.piece_at(end_s + 1.0).end_s
    satellite = api.Satrec.twoline2rv(*decaying.text.splitlines())
    at_s = np.array([end_s - 1e-3, end_s + 1e-3])
    # Day 333 of the elements is 29 November.
    since_days = at_s / 86400.0 - 0.02012661
    errors, *_ = satellite.sgp4_array(
        np.full(2, satellite.jdsatepoch), satellite.jdsatepochF + since_days
    )
    assert errors.tolist() == [0, 6]

"""Texts with units: factors as published, what fits, and what is refused."""

import math
from decimal import Decimal

import pytest

from satdyn_ros.base.key import Key
from satdyn_ros.base.units import Unfit, fitting, in_trade, in_unit, is_quantity, unit_of


def one(text, unit):
    """Return the number of a text in a unit."""
    found = in_unit(text, unit)
    assert not isinstance(found, list)
    return float(found)


# Text, unit, value: NIST SP 811 (2008), appendix B.8, to the digits printed there where they are
# not exact; the au by the IAU (2012), the rest by definition.
PUBLISHED = [
    ('1 deg', 'rad', 1.745329e-2),
    ('1 arcmin', 'rad', 2.908882e-4),
    ('1 arcsec', 'rad', 4.848137e-6),
    ('1 rev', 'rad', 6.283185),
    ('1 rpm', 'rad/s', 1.047198e-1),
    ('1 deg/s', 'rad/s', 1.745329e-2),
    ('1 min', 's', 60.0),
    ('1 h', 's', 3600.0),
    ('1 d', 's', 86400.0),
    ('1 ft', 'm', 0.3048),
    ('1 lb', 'kg', 0.45359237),
    ('1 au', 'm', 149597870700.0),
    ('1 G', 'T', 1e-4),
    ('1 gauss', 'T', 1e-4),
    ('1 nT', 'T', 1e-9),
    ('1 sfu', 'W/m^2/Hz', 1e-22),
    # IEEE/ASTM SI 10 (2010).
    ('1 Oe', 'A/m', 79.57747),
    ('1 MiB', 'byte', 1048576.0),
    ('1 ppm', '', 1e-6),
]


@pytest.mark.parametrize(('text', 'unit', 'value'), PUBLISHED)
def test_factors_are_those_that_are_published(text, unit, value):
    """Half a unit of the seventh digit, the last that the table prints."""
    assert one(text, unit) == pytest.approx(value, rel=5e-7)


# IEEE Std 952: 1 deg/sqrt(h) is 60 deg/h/sqrt(Hz), which is 1/60 deg/s/sqrt(Hz).
@pytest.mark.parametrize(
    ('text', 'unit', 'same'),
    [
        ('1 deg/sqrt(h)', 'deg/h/sqrt(Hz)', 60.0),
        ('1 deg/s/sqrt(Hz)', 'deg/sqrt(h)', 60.0),
        ('1 deg/h/sqrt(h)', 'deg/h^1.5', 1.0),
        ('3600 rev/h', 'rpm', 60.0),
        ('1 kg m^2 s^-2', 'J', 1.0),
        ('1 N/(A m)', 'T', 1.0),
        ('2 km^3/s^2', 'm^3/s^2', 2e9),
        ('1 g cm^2', 'kg m^2', 1e-7),
    ],
)
def test_products_and_roots_have_the_factors_of_their_parts(text, unit, same):
    """The nearest double, whatever the roots in between."""
    assert one(text, unit) == same


@pytest.mark.parametrize(
    ('text', 'plain'),
    [
        ('0.15°/√h', '0.15 deg/sqrt(h)'),
        ('5 N·m', '5 N m'),
        ('5 Nm', '5 N m'),
        ('30 mNms', '30 mN m s'),
        ('2 A m²', '2 A m^2'),
        ('2 A m2', '2 A m^2'),
        ('3 µT', '3 uT'),
        ('4 s-1', '4 1/s'),
        ('51.6deg', '51.6 deg'),
        ('−3 deg', '-3 deg'),
        ('300 dps', '300 deg/s'),
        ('0.5 deg/hr', '0.5 deg/h'),
    ],
)
def test_the_spellings_of_datasheets_are_read(text, plain):
    """The same number as of the plain spelling."""
    unit = plain.partition(' ')[2]
    assert in_unit(text, unit) == in_unit(plain, unit)


def test_an_angle_is_rounded_once():
    """Half a turn is the double nearest to pi, and a decimal of kilometres is exact in metres."""
    assert one('180 deg', 'rad') == math.pi
    assert in_unit('0.1 km', 'm') == Decimal(100)
    assert in_unit('0.1 min', 's') == 6


def test_whole_names_come_before_prefixes():
    """The min is no milli-inch, d no prefix, ft no femtotonne, G no giga."""
    for name, unit in {'min': 's', 'd': 's', 'ft': 'm', 'G': 'T', 'Pa': 'N/m^2'}.items():
        assert unit_of(name).powers == unit_of(unit).powers


@pytest.mark.parametrize(
    ('text', 'unit', 'says'),
    [
        ('100 Hz', 'rad/s', 'Hz is of another dimension than rad/s'),
        ('100 rpm', 'Hz', 'rpm is of another dimension than Hz'),
        ('5 N m/rad', 'N m', 'another dimension'),
        ('420 kms', 'm', 'there is no unit kms, the nearest is km'),
        ('1 kg/s m', 'kg', 'two ways'),
        ('5', 'm', 'a number and its unit'),
        ('5 m^', 'm', 'is no unit'),
        ('5 m)', 'm', 'is no unit'),
        ('5 ' + '(' * 250, 'm', 'at most'),
        ('nan m', 'm', 'a number and its unit'),
        ('1_000 m', 'm', 'a number and its unit'),
        ('[1, 2', 'm', 'a number and its unit'),
    ],
)
def test_what_is_in_no_unit_of_the_dimension_is_refused(text, unit, says):
    """The sentence names what is wrong with it."""
    with pytest.raises(Unfit, match=says):
        in_unit(text, unit)


def test_a_refusal_names_the_units_that_fit():
    """Hz for a rate of turn: rev/s and rpm are what was meant."""
    key = Key('rotor.max_speed', 'double', 0.0, 'rad/s', '')
    with pytest.raises(ValueError, match=r'rotor.max_speed.*100 Hz.*rev/s, rpm, deg/s'):
        key.checked('100 Hz')
    assert fitting('N m s', ('N m s/rad',)).endswith('mN m/rpm')


def test_bounds_hold_for_what_a_text_comes_to():
    """The sentence shows the text and the number in the key's unit."""
    key = Key('i', 'double', 0.0, 'rad', '', low=0.0, high=math.pi)
    assert key.checked('180 deg') == math.pi
    with pytest.raises(ValueError, match=r"i is '180.1 deg', 3.1433.* rad; it must be an angle"):
        key.checked('180.1 deg')


def test_a_list_has_units_throughout():
    """Each entry a text, 0 aside, or one text for all; a number without a unit is refused."""
    key = Key('w', 'double_array', None, 'N m', '', lengths=(3,))
    assert key.checked(['5 mN m', 0, '0']) == (0.005, 0.0, 0.0)
    assert key.checked('[5, 3e0, -.2] mN m') == (0.005, 0.003, -0.0002)
    with pytest.raises(ValueError, match='3 must have one too'):
        key.checked(['5 mN m', '2 mN m', 3])
    with pytest.raises(ValueError, match='list of 3 numbers'):
        key.checked('5 mN m')


def test_whole_numbers_stay_exact():
    """2^53 + 1 is no double; half a byte is no number of bytes."""
    key = Key('n', 'integer', 0, 'byte', '')
    assert key.checked(f'{2**53 + 1} byte') == 2**53 + 1
    assert key.checked('1.5 kB') == 1500
    with pytest.raises(ValueError, match='an integer'):
        key.checked('0.5 byte')


def test_a_text_stays_a_text():
    """Names, choices and plain numbers in quotes are read as before."""
    assert Key('t', 'string', '', '', '').checked('5 m') == '5 m'
    assert Key('t', 'texts', (), '', '').checked(['420 km']) == ('420 km',)
    with pytest.raises(ValueError, match='must be a number'):
        Key('x', 'double', 0.0, 'm', '').checked('5')
    assert not is_quantity('5')


def test_a_key_of_ones_own_may_have_a_unit_that_is_not_known():
    """Its own word is taken, and no other."""
    key = Key('mine', 'double', 0.0, 'furlong', '')
    assert key.checked('5 furlong') == 5.0
    with pytest.raises(ValueError, match='units that fit: furlong'):
        key.checked('5 m')


@pytest.mark.parametrize(
    ('values', 'unit', 'trade', 'text'),
    [
        (math.radians(51.6), 'rad', '', '51.6 deg'),
        (math.radians(6 / 3600), 'rad', '', '6 arcsec'),
        (6378137.0, 'm', '', '6378.14 km'),
        (5.0, 'm', '', ''),
        (0.00023, 'N m', '', '0.23 mN m'),
        ([1e-8, -5e-7], 'N m s', '', '[0.01, -0.5] uN m s'),
        (100.0, 'N m s', '', ''),
        (1e-5, 'kg m^2', '', '100 g cm^2'),
        (math.pi, 'rad/s', 'rpm', '30 rpm'),
        ([3e-4, 0.0], '', 'ppm', '[300, 0] ppm'),
        (5.0, 'furlong', '', ''),
        (0.0, 'N m', '', ''),
    ],
)
def test_the_unit_of_the_trade(values, unit, trade, text):
    """Of several the largest in which it is a tenth or more; none where that is the unit of SI."""
    assert in_trade(values, unit, trade) == text

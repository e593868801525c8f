"""What is likely in another unit raises a warning; what looks like it and is right does not."""

import pytest

from satdyn_ros.run.events import Event, Request, Reset, Timeout, warnings
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.shipped import names


def orbit(**elements):
    """Return an orbit's keys."""
    return {f'orbit.{name}': value for name, value in elements.items()}


def rate(*omega):
    """Return a rate's key."""
    return {'initial.angular_velocity': omega}


def gyro(**sizes):
    """Return the keys of a gyro with a name of its own."""
    of_it = {f'sensors.g.{name}': value for name, value in sizes.items()}
    return {'sensors.names': ['g'], 'sensors.g.type': 'gyro', **of_it}


# What is doubtful and what the sentence says, then its right neighbour.
KILOMETRES = 'if kilometres are meant, 6.87814e+06'
CASES = {
    'a in km': (
        orbit(semi_major_axis=6878.137),
        ['orbit.semi_major_axis is 6878.14 m', KILOMETRES],
        orbit(semi_major_axis=6878137.0),
    ),
    'an altitude': (
        orbit(semi_major_axis=500e3),
        ['is 500000 m (from the centre; orbit.altitude is from the surface)'],
        orbit(altitude=500e3),
    ),
    'an ellipse in the ground': (
        orbit(type='kepler', semi_major_axis=7e6, eccentricity=0.1),
        ['goes 78.14 km below the surface of the Earth'],
        orbit(type='kepler', semi_major_axis=7e6, eccentricity=0.05),
    ),
    'around the Moon in km': (
        orbit(mu=4.9028e12, semi_major_axis=1838.0),
        ['if kilometres are meant, 1.838e+06', 'below the surface of the Moon'],
        orbit(mu=4.9028e12, semi_major_axis=1838e3),
    ),
    'mu of the Earth in km': (
        orbit(mu=398600.4418),
        ['orbit.mu is 398600 m^3/s^2', 'the Earth in km^3/s^2', '3.986e+14'],
        orbit(mu=3.986e14),
    ),
    'mu of the Moon in km': (
        orbit(mu=4902.8),
        ['orbit.mu is 4902.8 m^3/s^2', 'the Moon in km^3/s^2', '4.9028e+12'],
        orbit(mu=4.9028e12),
    ),
    'mu of Mars in km': (
        orbit(mu=42828.0),
        ['orbit.mu is 42828 m^3/s^2', 'Mars in km^3/s^2', '4.28284e+13'],
        orbit(mu=4.2828e13),
    ),
    'mu of the Sun in km': (
        orbit(mu=1.327e11, semi_major_axis=1.496e11),
        ['orbit.mu is 1.327e+11 m^3/s^2', 'the Sun in km^3/s^2', '1.32712e+20'],
        orbit(mu=1.327e20, semi_major_axis=1.496e11),
    ),
    'mu of a planet, mu of an asteroid': (
        orbit(mu=398600.4418),
        ['orbit.mu'],
        orbit(mu=446000.0, semi_major_axis=20e3),  # Eros, in m^3/s^2
    ),
    'rates in degrees': (
        rate(5.0, -6.0, 4.0),
        ['8.77496 rad/s', 'if [5.0, -6.0, 4.0] are degrees, it is [0.08727, -0.1047, 0.06981]'],
        rate(0.08727, -0.1047, 0.06981),
    ),
    'a fast rate in degrees': (rate(0.0, 0.0, 30.5), ['30.5 rad/s'], rate(0.0, 0.0, 6.2832)),
    'a small rate': (rate(0.0, 3.0, 0.0), ['[0, 0.05236, 0]'], rate(0.0, 1.0, 0.0)),
    'an angle beyond a turn': (
        orbit(raan=10.0),
        ['orbit.raan is 10 rad, 573 deg; if 10 are degrees, it is 0.1745'],
        orbit(raan=0.1745),
    ),
    'an anomaly': (orbit(true_anomaly=12.0), ['is 12 rad'], orbit(true_anomaly=6.28)),
    'a negative angle': (
        orbit(argument_of_periapsis=-9.5),
        ['orbit.argument_of_periapsis is -9.5 rad'],
        orbit(argument_of_periapsis=-1.5),
    ),
    'an inclination': (orbit(inclination=3.0), ['is 3 rad'], orbit(inclination=1.0)),
    'an epoch in seconds': (
        {'time.epoch_ns': 1769860800},
        ['time.epoch_ns is 1769860800', 's are meant, 2026-01-31T12:00:00', '1769860800000000000'],
        {'time.epoch_ns': 1769860800 * 10**9},
    ),
    'an epoch in milliseconds': (
        {'time.epoch_ns': 1769860800 * 10**3},
        ['ms are meant, 2026-01-31T12:00:00'],
        {'time.epoch_ns': 1},
    ),
    'angles in place of the attitude': (
        {'initial.roll_pitch_yaw': [5.0, 0.0, -10.0]},
        ['[5.0, 0.0, -10.0] rad', 'it is [0.08727, 0, -0.1745]'],
        {'initial.roll_pitch_yaw': [1.0, 0.0, -0.5]},
    ),
    'an altitude in km': (
        orbit(altitude=420),
        ['orbit.altitude is 420 m; if kilometres are meant, 420000'],
        orbit(altitude=420e3),
    ),
    'the geostationary altitude in km': (
        orbit(altitude=35786),
        ['if kilometres are meant, 3.5786e+07'],
        orbit(altitude=35786e3),
    ),
    'a wheel in turns a minute': (
        {'rotor.mode': 'motor', 'rotor.inertia': 1.0, 'rotor.max_speed': 6000.0},
        ['rotor.max_speed is 6000 rad/s, 57295.8 rpm; if rpm is meant, it is 628.3'],
        # The flywheel of the space station's attitude control has 6600 rpm.
        {'rotor.mode': 'motor', 'rotor.inertia': 1.0, 'rotor.max_speed': 691.0},
    ),
    'a wheel with a name': (
        {
            **{'rotor.names': ['x'], 'rotor.x.mode': 'free', 'rotor.x.inertia': 1.0},
            'rotor.x.speed': -3000.0,
        },
        ['rotor.x.speed is -3000 rad/s'],
        {'rotor.names': ['x'], 'rotor.x.mode': 'free', 'rotor.x.inertia': 1.0},
    ),
    'an exclusion of a sensor with a name': (
        {'sensors.names': ['s'], 'sensors.s.type': 'star_tracker', 'sensors.s.earth_exclusion': 3},
        ['sensors.s.earth_exclusion is 3 rad'],
        {'sensors.names': ['s'], 'sensors.s.type': 'star_tracker'},
    ),
    'the angle random walk of a data sheet': (
        gyro(noise_density=0.15),
        ['sensors.g.noise_density is 0.15 rad/s/sqrt(Hz)', 'deg/sqrt(h) is meant', '4.363e-05'],
        # 0.05 deg/s/sqrt(Hz), that of the L3GD20 (ST, data sheet), is much for a gyro.
        gyro(noise_density=8.7e-4),
    ),
    'the bias instability of a data sheet': (
        gyro(bias_instability=0.3),
        ["it is 1.454e-06, or '0.3 deg/h'"],
        gyro(bias_instability=1.5e-6),
    ),
    'the field in nanotesla': (
        {
            **{'sensors.names': ['magnetometer'], 'environment.magnetic_field': 'dipole'},
            'sensors.magnetometer.noise': 15.0,
        },
        ["it is 1.5e-08, or '15 nT'"],
        {
            **{'sensors.names': ['magnetometer'], 'environment.magnetic_field': 'dipole'},
            'sensors.magnetometer.noise': 1.5e-8,
        },
    ),
    'w first': (
        {'initial.attitude': [1.0, 0.0, 0.0, 0.0]},
        ['initial.attitude is [1.0, 0.0, 0.0, 0.0], half a turn about x', 'x, y, z, w'],
        {'initial.attitude': [0.0, 1.0, 0.0, 0.0]},
    ),
    'w first of a sensor': (
        {'sensors.names': ['gyro'], 'sensors.gyro.mounting': [1.0, 0.0, 0.0, 0.0]},
        ['sensors.gyro.mounting is [1.0, 0.0, 0.0, 0.0], half a turn about x'],
        {'sensors.names': ['gyro'], 'sensors.gyro.mounting': [0.0, 0.0, 0.0, 1.0]},
    ),
}


@pytest.mark.parametrize(('doubtful', 'said', 'right'), CASES.values(), ids=CASES)
def test_a_doubt_and_its_right_neighbour(doubtful, said, right):
    """One sentence names key, value and likely meaning; the same in the right unit is silent."""
    (sentence,) = Scenario(doubtful).warnings
    for part in said:
        assert part in sentence
    assert Scenario(right).warnings == ()


def test_both_in_kilometres():
    """Of mu and a in km, which make the right period, each is named."""
    mu, a = Scenario(orbit(mu=398600.4418, semi_major_axis=6878.137)).warnings
    assert 'orbit.mu is 398600' in mu
    assert KILOMETRES in a


@pytest.mark.parametrize('name', names())
def test_the_shipped_scenarios_raise_no_doubt(name):
    """What is shipped means what it says."""
    assert Scenario.from_yaml(name).warnings == ()


def test_an_event_after_the_end():
    """The last tick of a run of 600 is 599; what follows from the run is no order of the user."""
    events: list[Event] = [Reset(599), Reset(600), Timeout(700, 'torque')]
    (sentence,) = warnings(events, 600, Scenario({'publish.rate': 10.0}))
    assert sentence.startswith('the Reset at 60 s (tick 600) does not act: the run ends at 60 s')


def test_a_request_in_degrees():
    """What a request gives is doubted as a scenario is, and what it does not give is not again."""
    scenario = Scenario({'publish.rate': 10.0, 'orbit.raan': 10.0})
    events = [Request(20, rate(5.0, -6.0, 4.0)), Request(30, rate(0.05, -0.06, 0.04))]
    (sentence,) = warnings(events, 600, scenario)
    assert sentence.startswith('the Request at 2 s: initial.angular_velocity is 8.77496 rad/s')


@pytest.mark.parametrize(
    ('given', 'text'),
    [
        (orbit(semi_major_axis=6878.137), '6878.137 km'),
        (orbit(mu=398600.4418), '398600.4418 km^3/s^2'),
        ({'orbit.inclination': 3.0}, '3 deg'),
        ({'initial.angular_velocity': [0, 0, 30]}, '[0.0, 0.0, 30.0] deg/s'),
        ({'time.epoch_ns': 1_772_323_200}, '1772323200 s'),
        (orbit(altitude=420), '420 km'),
        ({'initial.roll_pitch_yaw': [5.0, 0.0, 10.0]}, '[5.0, 0.0, 10.0] deg'),
    ],
)
def test_the_text_that_would_have_been_right_is_named_and_is_taken(given, text):
    """What the sentence quotes, given for the key, raises no doubt about it again."""
    (key,) = given
    (sentence,) = Scenario(given).warnings_about([key])
    assert f"'{text}'" in sentence
    assert not Scenario({**given, key: text}).warnings_about([key])


@pytest.mark.parametrize(
    ('name', 'given', 'text'),
    [
        ('orbit.inclination', 51.6, '51.6 deg'),
        ('sensors.s.cross_boresight', 6, '6 arcsec'),
        ('sensors.s.earth_exclusion', 25.0, '25 deg'),
    ],
)
def test_a_refusal_names_the_text_that_would_have_been_right(name, given, text):
    """An angle that radians do not allow."""
    around = {'sensors.names': ['s'], 'sensors.s.type': 'star_tracker'}
    with pytest.raises(ValueError, match=f"{name} is {given}; .* is meant, '{text}'"):
        Scenario({**around, name: given})
    assert not Scenario({**around, name: text}).warnings_about([name])


def test_a_doubt_goes_with_the_key_in_whose_place_it_is():
    """What was doubtful of the altitude is forgotten with it."""
    doubtful = Scenario(orbit(altitude=420))
    assert doubtful.with_values({'publish.rate': 10.0}).warnings == doubtful.warnings
    assert not doubtful.with_values({'orbit.semi_major_axis': 7e6}).warnings
    assert not doubtful.with_values({'orbit.altitude': '420 km'}).warnings

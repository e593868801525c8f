"""One validated description: what is allowed, what is refused and how."""

import re

import numpy as np
import pytest

from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import KeplerOrbit
from satdyn_ros.run.keys import KEYS
from satdyn_ros.run.scenario import Scenario

TYPED = {'orbit': {'type': 'fixed', 'gradient': 1e-6}}


@pytest.mark.parametrize(
    ('nested', 'sentence'),
    [
        ({'publish': {'rate': -1}}, 'publish.rate is -1; it must be a number above 0 and at most'),
        ({'publish': {'rate': 0}}, 'publish.rate is 0; it must be a number above 0'),
        ({'publish': {'rate': float('nan')}}, 'publish.rate is nan'),
        ({'publish': {'rate': '100'}}, "publish.rate is '100'; it must be a number"),
        ({'publish': {'topics': ['attitude', 'x']}}, 'publish.topics is .*; it must be a list of'),
        ({'orbit': {'mu': float('inf')}}, 'orbit.mu is inf; it must be a number above 0 m'),
        ({'orbit': {'mu': 0.0}}, 'orbit.mu is 0.0'),
        (
            {'orbit': {'type': 'kepler', 'eccentricity': 1.0}},
            'orbit.eccentricity is 1.0; .*below 1',
        ),
        ({'orbit': {'type': 'kepler', 'eccentricity': -0.1}}, 'orbit.eccentricity is -0.1'),
        ({'orbit': {'type': 'elliptic'}}, "orbit.type is 'elliptic'; it must be one of fixed"),
        ({'body': {'inertia': [1, 2]}}, 'body.inertia is .*; it must be a list of 3 or 6 or 9'),
        ({'body': {'inertia': [1, 1, 3]}}, 'body.inertia is .*must not exceed the sum'),
        ({'body': {'inertia': [1, 1, -1]}}, 'body.inertia is .*must be positive'),
        ({'body': {'inertia': [1, 1, float('nan')]}}, 'body.inertia is .*nan'),
        ({'body': {'inertia': 5}}, 'body.inertia is 5; it must be a list'),
        ({'body': {'mass': 5}}, 'body.mass is not a parameter of a scenario'),
        ({'initial': {'attitude': [0, 0, 0, 1.001]}}, 'initial.attitude is .*it must be a unit'),
        ({'initial': {'attitude': [0, 0, 0, 0]}}, 'initial.attitude is .*must not be zero'),
        ({'initial': {'frame': 'lvlh'}} | TYPED, 'initial.frame is lvlh; with orbit.type fixed'),
        ({'rotor': {'axis': [0, 0, 0]}}, 'rotor.axis is .*must not be zero'),
        ({'rotor': {'mode': 'free'}}, 'rotor.inertia is 0; with rotor.mode free it must be'),
        ({'rotor': {'mode': 'free', 'inertia': 900.0}}, 'rotor.inertia is 900; .*below 900'),
        ({'rotor': {'momentum': 1.0}}, 'rotor.momentum is 1.0; with rotor.mode none'),
        ({'orbit': {'eccentricity': 0.1}}, 'orbit.eccentricity is 0.1; with orbit.type circular'),
        ({'orbit': {'gradient': 0.1}}, 'orbit.gradient is 0.1; .*it belongs to fixed'),
        ({'body': {'weight_moment': [0, 0, 1]}}, 'body.weight_moment is .*it belongs to fixed'),
        ({'orbit': {'type': 'fixed', 'raan': 1.0}}, 'orbit.raan is 1.0; .*circular and kepler'),
        ({'torque': {'names': ['a/b']}}, r"torque.names has 'a/b'; a name has letters, digits"),
        ({'torque': {'names': ['2nd']}}, r"torque.names has '2nd'; .* not begin with a digit"),
        (
            {'torque': {'names': ['a', 'b', 'a']}},
            'torque.names has a twice; each may be given once',
        ),
        ({'torque': {'names': 'drag'}}, "torque.names is 'drag'; it must be a list of different"),
        ({'time': {'epoch_ns': 1.5}}, 'time.epoch_ns is 1.5; it must be an integer'),
        ({'time': {'epoch_ns': -1}}, 'time.epoch_ns is -1'),
        ({'time': {'epoch_ns': 2**63 - 1}}, 'time.epoch_ns is 9223372036854775807; it must be an'),
        ({'time': {'epoch_ns': 2**31 * 10**9 - 1}}, 'the second tick then comes after the last'),
        ({'publish': {'rate': 1e-300}}, 'publish.rate is 1e-300 .*the second tick then comes'),
        ({'time': {'factor': 1e-12}}, 'time.factor is 1e-12 and publish.rate 100; their product'),
        ({'time': {'factor': 5e-324}}, 'time.factor is 4.94066e-324 and publish.rate 100'),
        ({'publish': {'topics': [1, 2]}}, r'publish.topics is \[1, 2\]; it must be a list of'),
        ({'publish': {'topics': [True]}}, r'publish.topics is \[True\]; it must be a list of'),
        ({'publish': {'topics': [1.5]}}, r'publish.topics is \[1.5\]; it must be a list of'),
        ({'publish': {'topics': ['a' * 9999]}}, r'publish.topics is .{100}\.\.\.; it must be a'),
        ({'frames': {'body': 'a\ud800'}}, r"frames.body is 'a\\ud800'; it must be a non-empty"),
        ({'body': {'inertia': [b'1', b'1', b'1']}}, 'body.inertia is .*; it must be a list of 3'),
        ({'orbit': {'inclination': 51.6}}, 'orbit.inclination is 51.6; it must be an angle in ra'),
        ({'orbit': {'raan': 180.0}}, 'orbit.raan is 180.0; it must be an angle in radians, at le'),
        ({'orbit': {'true_anomaly': 1e300}}, 'orbit.true_anomaly is 1e.300; it must be an angle'),
        (
            {'orbit': {'mu': 1e300}},
            r'orbit.mu 1e.300; the orbital rate at pericentre is then .* rad/s',
        ),
        (
            {'orbit': {'type': 'kepler', 'eccentricity': 1.0 - 1e-16}},
            'the orbital rate at pericentre is then',
        ),
        (
            {'initial': {'angular_velocity': [1e20, 1, 0]}},
            'initial.angular_velocity is .*at most 1e.08 rad/s',
        ),
        ({'initial': {'attitude': [1e300, 0, 0, 0]}}, 'initial.attitude is .*norm must be finite'),
        ({'rotor': {'axis': [1e300, 0, 0]}}, 'rotor.axis is .*norm must be finite'),
        ({'time': {'publish_clock': 1}}, 'time.publish_clock is 1; it must be true or false'),
        ({'record': {'directory': ''}}, "record.directory is ''; it must be a non-empty"),
        ({'motion': {'method': 'exact'}}, 'motion.method is exact, but there is no closed form'),
    ],
)
def test_refused(nested, sentence):
    """What is not allowed is refused by one sentence: the key, what was given, what is allowed."""
    with pytest.raises(ValueError, match=sentence) as refusal:
        Scenario.from_dict(nested)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize(
    'nested',
    [
        {'orbit': {'mu': 1e-6, 'semi_major_axis': 1.0}},
        {'orbit': {'mu': 1.0, 'semi_major_axis': 1.0}, 'publish': {'rate': 0.01}},
        {'orbit': {'type': 'kepler', 'eccentricity': 0.99}},
        {'body': {'inertia': [1e12, 1e12, 1.0]}},
        {'body': {'inertia': [1e-9, 1e-9, 1e-9]}},
        {'publish': {'topics': []}},
        {'publish': {'topics': None}},
    ],
)
def test_unusual_and_allowed(nested):
    """Problems without dimensions, extreme bodies and a run that publishes nothing are legal."""
    Scenario.from_dict(nested)


def test_what_is_rarely_meant_is_doubted():
    """Degrees for radians, and an orbit within the Earth; the default raises no warning."""
    assert Scenario().warnings == ()
    assert Scenario({'orbit.mu': 1e-6, 'orbit.semi_major_axis': 1.0}).warnings == ()
    (spin,) = Scenario({'initial.angular_velocity': [0.0, 0.0, 30.0]}).warnings
    assert spin.startswith('initial.angular_velocity is 30 rad/s, 4.77 turns a second')
    (orbit,) = Scenario({'orbit.semi_major_axis': 500e3}).warnings
    assert orbit.endswith('goes 5878 km below the surface of the Earth')


def test_altitude_and_epoch_in_place_of_others():
    """They are the semi-major axis and the stamp of tick 0, and written as these."""
    orbit, time = '{altitude: 622000}', '{epoch: 2026-03-01T00:00:00Z}'
    text = f'/**: {{ros__parameters: {{orbit: {orbit}, time: {time}}}}}'
    scenario = Scenario.from_yaml_text(text)
    plain = Scenario({'orbit.semi_major_axis': 7000137.0, 'time.epoch_ns': 1772323200 * 10**9})
    assert scenario == plain
    assert scenario.to_yaml() == plain.to_yaml()
    assert not {'altitude', 'epoch'} & set(scenario.to_yaml().replace(':', '').split())
    assert Scenario.from_yaml_text(scenario.to_yaml()) == scenario
    # What a node shows of all keys loads again, and a change replaces what it stands for.
    assert Scenario(scenario.values) == scenario
    assert scenario.with_values({'orbit.altitude': 500e3})['orbit.semi_major_axis'] == 6878137.0
    assert scenario.with_values({'time.epoch': '1970-01-01T00:00:01.5Z'}).epoch_ns == 1500000000


@pytest.mark.parametrize(
    ('given', 'sentence'),
    [
        (
            {'orbit.altitude': 5e5, 'orbit.semi_major_axis': 7e6},
            'orbit.altitude is 500000.0 and orbit.semi_major_axis 7000000.0; only one of the two',
        ),
        (
            {'time.epoch': '2026-03-01T00:00:00', 'time.epoch_ns': 1},
            'time.epoch is 2026-03-01T00:00:00 and time.epoch_ns 1; only one of the two',
        ),
        (
            {'orbit.altitude': 5e5, 'orbit.type': 'kepler'},
            'orbit.altitude is 500000.0; with orbit.type kepler only its default is allowed',
        ),
        ({'orbit.altitude': -1.0}, 'orbit.altitude is -1.0; it must be a number at least 0 m'),
        (
            {'time.epoch': 'tomorrow'},
            "time.epoch is 'tomorrow'; it must be empty or an epoch in UTC, such as 2026-03-01T",
        ),
        (
            {'time.epoch': '1970-01-01T00:00:00Z'},
            'time.epoch is 1970-01-01T00:00:00Z, and then time.epoch_ns is 0, which is not a time',
        ),
        (
            {'time.epoch': '1970-001T00:00:00.0000000001', 'time.epoch_ns': 0},
            'time.epoch is 1970-001T00:00:00.0000000001, and then time.epoch_ns is 0, which is',
        ),
        (
            {'time.epoch': '1969-12-31T23:59:59.999999999'},
            'time.epoch is 1969-12-31T23:59:59.999999999, and then time.epoch_ns is -1; it must',
        ),
        (
            {'time.epoch': '1969-01-01T00:00:00'},
            'time.epoch is 1969-01-01T00:00:00, and then time.epoch_ns is -31536000000000000; it',
        ),
    ],
)
def test_altitude_and_epoch_refused(given, sentence):
    """One or the other, where it belongs, within what the other allows."""
    with pytest.raises(ValueError, match=re.escape(sentence)):
        Scenario(given)


WING = {'surface.names': ['wing'], 'surface.wing.area': 0.1}
GYRO = {'sensors.names': ['gyro', 'g2'], 'sensors.g2.type': 'gyro'}
OF_A_GYRO = (
    'noise_density, bias_random_walk, initial_bias, bias_instability, bias_correlation_time, '
    'scale_factor, misalignment, resolution'
)


@pytest.mark.parametrize(
    ('given', 'sentence'),
    [
        ({'body.dipol': [0.0, 0.0, 1.0]}, 'of a scenario; the nearest is body.dipole'),
        ({'publish.rates': 3}, 'of a scenario; the nearest is publish.rate'),
        ({'inertia': [1, 1, 1]}, 'of a scenario; the nearest is body.inertia'),
        ({'enviroment.sun': 'ephemeris'}, 'the nearest is environment.sun; a key of a torque of'),
        (
            WING | {'surface.wing.centre': [0, 0, 0]},
            'surface.wing.centre is not a parameter of a scenario; surface.wing has area, normal, '
            'position, drag_coefficient, specular, diffuse',
        ),
        (GYRO | {'sensors.gyro.arw': 1}, f'mounting, frame_id, divisor, {OF_A_GYRO}, max_rate'),
        (
            GYRO | {'sensors.g2.arw': 1},
            f'g2 has type, part, mounting, frame_id, divisor, {OF_A_GYRO}',
        ),
        (
            {'rotor.names': ['a'], 'rotor.a.mass': 1},
            'rotor.a has part, mode, axis, momentum, inertia, ',
        ),
        (
            {'rotor.names': ['a', 'b'], 'rotor.c.mode': 'motor'},
            'rotor.c.mode is given, but rotor.names has no c; it has a, b',
        ),
        ({'torque.names': 5, 'torque.a.x': 1}, 'torque.names has no a'),
        (
            {'pulse.torque': 1.0},
            'a key of a torque of your own needs --torque MODULE:CLASS',
        ),
        ({'publish.topics': ['atitude']}, '; the nearest to atitude is attitude'),
        ({'x' * 10**6: 1}, 'the nearest is '),
    ],
)
def test_a_key_that_there_is_not_is_refused_with_those_that_there_are(given, sentence):
    """The nearest one; of a plate, a rotor or a sensor, all."""
    with pytest.raises(ValueError, match=re.escape(sentence)):
        Scenario(given)


def test_every_key_has_a_default_that_holds():
    """The table's defaults pass the table's own checks and make a scenario."""
    for key in KEYS.values():
        assert key.checked(key.default) == key.default
        assert key.meaning
    assert dict(Scenario().values) == {name: key.default for name, key in KEYS.items()}


def test_attitude_is_normalised():
    """A quaternion off by less than 1e-6 is taken as its unit; a unit one keeps its bits."""
    near = Scenario.from_dict({'initial.attitude': [0.0, 0.0, 0.6 + 3e-7, 0.8]})
    assert abs(np.linalg.norm(near['initial.attitude']) - 1.0) < 1e-15
    unit = tuple(float(x) for x in rotation.normalise([0.1, 0.2, 0.3, 0.9]))
    assert Scenario.from_dict({'initial.attitude': unit})['initial.attitude'] == unit


@pytest.mark.parametrize('name', ['initial.attitude', 'sensors.star_tracker.mounting'])
def test_a_quaternion_of_four_or_five_digits_is_normalised_and_it_is_said_once(name):
    """Up to a ten-thousandth off; what is made of the scenario has its unit and says no more."""
    half = Scenario({'sensors.names': ['star_tracker'], name: [0.70711, 0.0, 0.0, 0.70711]})
    np.testing.assert_allclose(half[name], [0.5**0.5, 0.0, 0.0, 0.5**0.5], rtol=1e-15)
    said = f'{name} is [0.70711, 0.0, 0.0, 0.70711], of norm 1.000005; it is divided by it'
    assert half.warnings == (said,)
    assert half.with_values({'publish.rate': 1.0}).warnings == (said,)
    assert Scenario(half.values).warnings == ()
    assert half.with_values({name: [0.0, 0.0, 0.0, 1.0]}).warnings == ()
    assert (
        Scenario({'sensors.names': ['star_tracker'], name: [0.0, 0.0, 0.6 + 3e-7, 0.8]}).warnings
        == ()
    )
    for given, norm in ((1.00010001, '1.0001'), (1.001, '1.001'), (1.0 - 1.01e-4, '0.999899')):
        with pytest.raises(
            ValueError, match=rf', of norm {norm}; it must be .* to within 0\.0001$'
        ):
            Scenario({'sensors.names': ['star_tracker'], name: [0.0, 0.0, 0.0, given]})


@pytest.mark.parametrize(
    ('values', 'sentence'),
    [
        (
            {'body.inertia': [1.0, 2.0, 3.0 * (1.0 + 1e-9)]},
            'body.inertia is [1, 2, 3.0000000030000002]; the largest of its principal moments, '
            '3.000000003, must not exceed the sum of the others, 1 and 2, which is 3',
        ),
        (
            {'orbit.raan': 12.56638},
            'orbit.raan is 12.56638; it must be an angle in radians, at least -12.5664 and at '
            "most 12.566370614359172; where deg is meant, '12.56638 deg'",
        ),
        (
            {'orbit.raan': 12.6},
            'orbit.raan is 12.6; it must be an angle in radians, at least -12.5664 and at '
            "most 12.5664; where deg is meant, '12.6 deg'",
        ),
        (
            {'rotor.mode': 'motor', 'rotor.inertia': 900.0 * (1.0 + 1e-9)},
            'rotor.inertia is 900.000001; with rotor.mode motor it must be above 0 and below 900 '
            'kg m^2, the most that body.inertia allows',
        ),
        (
            {
                'rotor.mode': 'motor',
                'rotor.inertia': 1.0,
                'rotor.max_speed': 5.0,
                'rotor.speed': -5.00000001,
            },
            'rotor.speed is -5.00000001; it must be at most rotor.max_speed, 5 rad/s, in either '
            'direction',
        ),
        (
            {'frames.body': True},
            'frames.body is True; it must be a non-empty string; a text that ROS takes for a '
            "truth or a number must be quoted, as 'y' or '1'",
        ),
    ],
)
def test_a_refusal_shows_the_digits_that_are_its_reason(values, sentence):
    """Six digits where they are enough, and as many as it takes where they are not."""
    with pytest.raises(ValueError) as refused:
        Scenario(values)
    assert str(refused.value) == sentence


def test_default_attitude_is_what_it_says():
    """The default is 5 deg of roll and 10 deg of pitch to LVLH, at rest there."""
    scenario = Scenario()
    angles = np.degrees(rotation.roll_pitch_yaw(scenario['initial.attitude']))
    np.testing.assert_allclose(angles, [5.0, 10.0, 0.0], atol=1e-12)
    states = scenario.motion().at(0.0)
    degrees = np.degrees(rotation.roll_pitch_yaw(states.q_lb)[0])
    np.testing.assert_allclose(degrees, [5, 10, 0], atol=1e-12)
    # At rest in LVLH: the body's inertial rate is LVLH's, n about the orbit normal.
    rate_i = rotation.rotate(states.q_ib[0], states.omega_bi_b[0])
    orbit = scenario.system.orbit
    assert isinstance(orbit, KeplerOrbit)
    np.testing.assert_allclose(rate_i, [0, 0, orbit.mean_motion], atol=1e-18)


def test_fixed_direction_starts_inertial():
    """Without an orbit the initial frame is inertial, and the first integrals are those of it."""
    scenario = Scenario.from_dict(TYPED | {'initial': {'angular_velocity': [0.0, 0.001, 0.0]}})
    assert scenario['initial.frame'] == 'inertial'
    states = scenario.motion().at([0.0, 500.0, 1000.0])
    integrals = scenario.integrals(states)
    assert set(integrals) == {'energy', 'area', 'fourth'}
    assert np.all(states.r_i == 0.0)


def test_other_initial_conditions_keep_the_body():
    """The system is made again only where a key of it changes."""
    scenario = Scenario.from_dict({'rotor': {'mode': 'constant_momentum', 'momentum': 1.0}})
    turned = scenario.with_values({'initial.angular_velocity': (0.0, 0.0, 0.1)})
    assert turned.system is scenario.system
    assert turned.initial_state.omega_bi_b[2] > 0.09
    assert turned.with_values({'rotor.momentum': 2.0}).system.rotors[0].momentum == 2.0

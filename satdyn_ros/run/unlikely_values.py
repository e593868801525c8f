"""
What is allowed and rarely meant, most of it another unit: each in one sentence.

A sentence names the key, the value and what may have been meant, as a number in SI and as the text
with its unit.  values: every key by its dotted name.
"""

import math
from collections.abc import Container, Iterator, Mapping
from typing import Any

from ..actuators import ACTUATORS
from ..base.key import Key
from ..base.nanoseconds import SECOND_NS, epoch, stamp_ns
from ..base.sentences import written
from ..base.units import in_trade
from ..orbits.kepler import EARTH_MU, EARTH_RADIUS_M
from . import environment, orbits, sensors
from .keys import KEYS

# Gravitational parameter [m^3/s^2] and equatorial radius [m]: EGM96, DE440, IAU 2015.
_CENTRES = {
    'the Earth': (EARTH_MU, EARTH_RADIUS_M),
    'the Moon': (4.9028e12, 1_737_400.0),
    'Mars': (4.282837e13, 3_396_190.0),
    'the Sun': (1.32712440018e20, 695_700_000.0),
}
# What tables of these differ by, in their shortest form.
_SAME_MU = 1e-3
# Of an orbit within its centre a semi-major axis below this is more likely one in kilometres, one
# above it an altitude [m].
_LEAST_ALTITUDE_M = 1e5
# Above the first a body rate is rarely meant, nor in whole numbers above the second [rad/s].
_FAST_RAD_S, _FAST_AND_ROUND_RAD_S = 10.0, 2.0
# An angle in radians is seldom a whole number but 0 and 1.
_LEAST_ROUND_RAD = 2.0
# Lower no satellite flies; the geostationary ring is at fewer kilometres [m].
_LOWEST_M = 50e3
# What no wheel and no such sensor on the market has, and the unit in which data sheets have it.
_LARGEST = {
    'rotor.speed': (1500.0, 'rpm'),
    'rotor.max_speed': (1500.0, 'rpm'),
    'sensors.gyro.noise_density': (2e-3, 'deg/sqrt(h)'),
    'sensors.gyro.bias_random_walk': (1e-3, 'deg/h/sqrt(h)'),
    'sensors.gyro.bias_instability': (1e-2, 'deg/h'),
    'sensors.magnetometer.noise': (1e-4, 'nT'),
    'sensors.magnetometer.bias_random_walk': (1e-4, 'nT/sqrt(s)'),
    'sensors.magnetometer.bias_instability': (1e-4, 'nT'),
}
_FIRST_NS, _LAST_NS = stamp_ns('2000-01-01T00:00:00'), stamp_ns('2100-01-01T00:00:00')


def warnings(values: Mapping[str, Any], rules: int, typed: Container[str] = ()) -> tuple[str, ...]:
    """
    Return what is doubtful about the values of a scenario, by the rules of its run.

    typed: the keys given with a unit, which is then no other than was meant.
    """
    checks = (_rate, _angles, _equipment, _attitudes, _orbit, _environment, _epoch)
    found = [sentence for check in checks for sentence in check(values)]
    of_units = [sentence for check in _OF_UNITS for sentence in check(values)]
    meant = {sentence for sentence in of_units if sentence.partition(' ')[0] in typed}
    return (*_text(values, rules), *(sentence for sentence in found if sentence not in meant))


def in_place(given: Mapping[str, Any], typed: Container[str]) -> Iterator[str]:
    """Yield what is doubtful about keys that are given in place of others, before they are."""
    altitude_m, angles = given['orbit.altitude'], given['initial.roll_pitch_yaw']
    if 0.0 < altitude_m < _LOWEST_M and abs(given['orbit.mu'] / EARTH_MU - 1.0) < _SAME_MU:
        yield (
            f'orbit.altitude is {altitude_m:g} m; if kilometres are meant, '
            f"{altitude_m * 1e3:g}, or '{written(altitude_m)} km'"
        )
    if 'initial.roll_pitch_yaw' not in typed and any(map(_is_in_degrees, angles)):
        in_radians = ', '.join(f'{math.radians(x):.4g}' for x in angles)
        yield (
            f'initial.roll_pitch_yaw is {list(angles)} rad; if these are degrees, it is '
            f"[{in_radians}], or '{list(angles)} deg'"
        )


def _rate(values) -> Iterator[str]:
    given = values['initial.angular_velocity']
    rate, is_round = math.hypot(*given), all(x.is_integer() for x in given)
    if rate > _FAST_RAD_S or (is_round and rate > _FAST_AND_ROUND_RAD_S):
        in_degrees = ', '.join(f'{math.radians(x):.4g}' for x in given)
        yield (
            f'initial.angular_velocity is {rate:g} rad/s, {rate / math.tau:.3g} turns a second; '
            f'it is in radians: if {list(given)} are degrees, it is [{in_degrees}], or '
            f"'{list(given)} deg/s'"
        )


def _angles(values) -> Iterator[str]:
    for name, key in _keys(values):
        if key.unit != 'rad' or key.kind != 'double':
            continue
        angle = values[name]
        if _is_in_degrees(angle):
            yield (
                f'{name} is {angle:g} rad, {math.degrees(angle):.4g} deg; if {angle:g} are '
                f"degrees, it is {math.radians(angle):.4g}, or '{written(angle)} deg'"
            )


def _is_in_degrees(angle: float) -> bool:
    return (angle.is_integer() and abs(angle) >= _LEAST_ROUND_RAD) or abs(angle) > math.tau


def _equipment(values) -> Iterator[str]:
    for name, key in _keys(values):
        largest, trade = _LARGEST.get(key.name, (math.inf, ''))
        value = values[name]
        if trade and abs(value) > largest:
            text = f'{written(value)} {trade}'
            yield (
                f'{name} is {value:g} {key.unit}, {in_trade(value, key.unit, trade)}; if '
                f"{trade} is meant, it is {key.checked(text):.4g}, or '{text}'"
            )


def _keys(values) -> Iterator[tuple[str, Key]]:
    """Yield all keys by name, those of sensors and rotors with other names as in the table."""
    yield from KEYS.items()
    for name, kind in sensors.kinds(values).items():
        for key in kind.keys if name != kind.kind else ():
            yield f'sensors.{name}.{key.name}', KEYS[f'sensors.{kind.kind}.{key.name}']
    for name in values['rotor.names']:
        for leaf in ('speed', 'max_speed'):
            yield f'rotor.{name}.{leaf}', KEYS[f'rotor.{leaf}']


def _attitudes(values) -> Iterator[str]:
    mountings = (f'sensors.{name}.mounting' for name in values['sensors.names'])
    for name in ('initial.attitude', *mountings):
        if abs(values[name][0]) == 1.0:
            yield (
                f'{name} is {list(values[name])}, half a turn about x; the order is x, y, z, w: '
                'the identity is [0, 0, 0, 1]'
            )


def _text(values, rules) -> Iterator[str]:
    if values['time.epoch_ns']:
        yield from orbits.warnings(values, rules)


def _orbit(values) -> Iterator[str]:
    if values['orbit.reference_radius'] != EARTH_RADIUS_M and not values['orbit.j2']:
        yield 'orbit.reference_radius is given, but without orbit.j2 it has no effect'
    ellipse = orbits.type_of(values).ellipse(values)
    if ellipse is None:
        return
    mu, a_m, e, name = ellipse
    lowest_m = a_m * (1.0 - e)
    for centre, (centre_mu, radius_m) in _CENTRES.items():
        in_km = abs(mu * 1e9 / centre_mu - 1.0) < _SAME_MU
        if in_km:
            yield (
                f'orbit.mu is {mu:g} m^3/s^2, which is that of {centre} in km^3/s^2; in m^3/s^2 '
                f"that is {centre_mu:g}, or '{written(mu)} km^3/s^2'"
            )
        if (in_km or abs(mu / centre_mu - 1.0) < _SAME_MU) and lowest_m < radius_m:
            meant = (
                f"if kilometres are meant, {a_m * 1e3:g}, or '{written(a_m)} km'"
                if a_m < _LEAST_ALTITUDE_M
                else 'from the centre; orbit.altitude is from the surface'
            )
            hint = f' ({meant})' if name in KEYS else ''
            yield (
                f'{name} is {a_m:g} m{hint}; the orbit then goes '
                f'{(radius_m - lowest_m) / 1e3:.4g} km below the surface of {centre}'
            )


def _environment(values) -> Iterator[str]:
    yield from environment.without_effect(values)
    for kind in ACTUATORS.values():
        yield from kind.without_effect(values)
    if values['environment.magnetic_field'] != 'none' and values['time.epoch_ns']:
        from ..environment import igrf_warning

        if sentence := igrf_warning(values['time.epoch_ns']):
            yield f'environment.magnetic_field: {sentence}'


def _epoch(values) -> Iterator[str]:
    given = values['time.epoch_ns']
    for unit, factor in (('s', SECOND_NS), ('ms', 10**6), ('us', 10**3)):
        if _FIRST_NS <= given * factor <= _LAST_NS:
            yield (
                f'time.epoch_ns is {given}, {given / SECOND_NS:.4g} s after 1970; if '
                f'{unit} are meant, {epoch(given * factor)[:19]}, it is {given * factor}, or '
                f"'{given} {unit}'"
            )


# What raises no doubt where the unit is typed.
_OF_UNITS = _rate, _angles, _equipment, _epoch

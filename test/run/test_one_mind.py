"""
The check of many scenarios at once is of one mind with that of one.

Values are drawn on both sides of every rule: many refuses what Scenario refuses, and nothing else.
"""

import inspect
import traceback
from typing import Any

import numpy as np
import pytest

from satdyn_ros.dynamics import inertia
from satdyn_ros.dynamics.flexible import Mode
from satdyn_ros.dynamics.rotor import MODES
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import ORBIT_TYPES
from satdyn_ros.orbits.kepler import EARTH_MU
from satdyn_ros.run import checks, environment, modes, orbits, rotors, sensors
from satdyn_ros.run.in_place import OF_ATTITUDE
from satdyn_ros.run.keys import KEYS, NAMES_OF_EACH, keys_of
from satdyn_ros.run.many import many
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.torques.rods import checks_of_rods

RUNS = 12
BASES: dict[str, dict[str, Any]] = {
    'circular': {'rotor.mode': 'constant_momentum', 'rotor.momentum': -5.0},
    'kepler': {'orbit.type': 'kepler', 'rotor.mode': 'motor', 'rotor.inertia': 0.5},
    'fixed': {'orbit.type': 'fixed', 'initial.frame': 'inertial', 'rotor.mode': 'none'},
}

# Others have their values, or a sweep does not vary them.
OTHERS_GIVE_WAY = ('orbit.altitude', *OF_ATTITUDE)
# Four rows, a minute apart.
EPHEMERIS = '\n'.join(
    [
        'CCSDS_OEM_VERS = 2.0',
        'CREATION_DATE = 2026-01-01T00:00:00',
        'ORIGINATOR = TEST',
        'META_START',
        'OBJECT_NAME = TEST',
        'CENTER_NAME = EARTH',
        'REF_FRAME = EME2000',
        'TIME_SYSTEM = UTC',
        'INTERPOLATION = HERMITE',
        'INTERPOLATION_DEGREE = 3',
        'META_STOP',
        *(f'2026-03-01T12:0{minute}:00 7000 {450 * minute} 0 0 7.5 0' for minute in range(4)),
        '',
    ]
)


def judged(common, varied):
    """
    Return the error with which each run is refused by itself, None: it is not.  many agrees.

    common: values of all runs, beside the defaults; varied: a list of values, one for each.
    """
    keys = keys_of({name: common.get(name, ()) for name in NAMES_OF_EACH})
    values = {name: key.default for name, key in keys.items()} | common
    arrays = {name: np.array(some, float) for name, some in varied.items()}
    rows = [
        dict(zip(arrays, row, strict=True))
        for row in zip(*(some.tolist() for some in arrays.values()), strict=True)
    ]
    found = [refusal(values | row) for row in rows]
    scenarios, valid = many(values | arrays, len(rows))
    assert list(valid) == [error is None for error in found], [common, rows, found]
    assert len(scenarios['initial.attitude']) == sum(valid)
    return found


def refusal(given):
    # Of keys that are given in place of others only the others may be.
    given = {k: x for k, x in given.items() if k not in ('orbit.altitude', 'time.epoch')}
    try:
        Scenario(given)
    except ValueError as error:
        return error
    return None


# -- a draw for each rule: what all runs have in common, and what varies among them ---------------


def near(draw, border, smallest=1e-14):
    """Return numbers on both sides of a border, to where rounding decides."""
    off = 10.0 ** draw.uniform(np.log10(smallest), 0.0, RUNS) * draw.choice([-1.0, 1.0], RUNS)
    return border * (1.0 + off)


def vectors(draw):
    return draw.normal(size=(RUNS, 3))


def units(draw):
    scales = near(draw, 1.0 + draw.choice([-1e-4, 1e-4]), smallest=1e-9)
    scales[:3] = 0.0, 1e-200, 1e200
    attitudes = rotation.normalise(draw.normal(size=(RUNS, 4)))
    if draw.random() < 0.5:
        return {}, {'initial.attitude': scales[:, None] * attitudes}
    return {}, {'rotor.axis': scales[::-1, None] * vectors(draw)}


def belongs(draw):
    kind, mode = draw.choice(['fixed', 'circular', 'kepler']), draw.choice(MODES)
    names = ('a', 'b') if draw.random() < 0.5 else ()
    prefix = rotors.prefixes(names)[-1]
    common: dict[str, Any] = {
        'orbit.type': str(kind),
        'initial.frame': 'inertial',
        'rotor.names': names,
        f'{prefix}.mode': str(mode),
    }
    if mode in ('free', 'motor'):
        common[f'{prefix}.inertia'] = 0.5
    choosing = [name for name, *_ in (*checks.BELONGS, *rotors.belongs(names))]
    choosing += rotors.OF_THE_ONE
    varied = {}
    for name in draw.choice(choosing, 3, replace=False):
        default = rotors.default(name)
        is_number = isinstance(default, float | int) or (default and isinstance(default[0], float))
        if name not in (*common, 'orbit.altitude') and is_number:
            some = draw.random(RUNS) < 0.3
            varied[str(name)] = [
                (np.array(default) * 1.01 + 0.01 if is_given else default) for is_given in some
            ]
    return common, varied or {'orbit.gradient': [0.0, 1e-6] * (RUNS // 2)}


def of_sensors(draw):
    names = ('gyro', 'star_tracker', 'magnetometer')[: draw.choice([1, 2, 2, 2, 3])]
    common = {
        'sensors.names': names,
        'sensors.gyro.noise_density': float(draw.choice([0.0, 1e-3])),
        'sensors.star_tracker.earth_exclusion': float(draw.choice([0.0, 0.5])),
        'sensors.star_tracker.sun_exclusion': float(draw.choice([0.0, 0.5], p=[0.7, 0.3])),
        'orbit.type': str(draw.choice(['fixed', 'circular'])),
        'initial.frame': 'inertial',
    }
    return common, {'initial.angular_velocity': vectors(draw)}


def of_torques(draw):
    common = {'torque.names': ('control', str(draw.choice(['drag', '2nd'])))}
    return common, {'initial.angular_velocity': vectors(draw)}


def of_thrusters(draw):
    varied = {'thruster.t1.time_constant': near(draw, 1e-6)}
    varied['thruster.t1.time_constant'][:3] = 0.0
    return {'thruster.names': ('t1',)}, varied


def orbit(draw):
    if draw.random() < 0.5:
        mu = EARTH_MU * near(draw, 1.0 + draw.choice([-1e-4, 1e-4]), smallest=1e-9)
        return {'orbit.type': 'oem', 'orbit.file': EPHEMERIS}, {'orbit.mu': mu}
    r_i = 7e6 * vectors(draw)
    escape = np.sqrt(2.0 * EARTH_MU / np.linalg.norm(r_i, axis=1))
    v_i = rotation.normalise(vectors(draw)) * (escape * near(draw, 1.0))[:, None]
    # Towards the centre, and at it.
    v_i[:3] = 1e-4 * r_i[:3]
    r_i[:1] = 0.0
    return {'orbit.type': 'state'}, {'orbit.position': r_i, 'orbit.velocity': v_i}


def of_environment(draw):
    common = {
        'orbit.type': str(draw.choice(['fixed', 'circular'], p=[0.2, 0.8])),
        'initial.frame': 'inertial',
        'environment.magnetic_field': str(draw.choice(['none', 'dipole'])),
        'surface.names': ('tail',)[: draw.integers(2)],
    }
    prefix = 'surface.tail' if common['surface.names'] else 'surface'
    mirrored = draw.uniform(0.0, 1.0, RUNS)
    scattered = np.minimum((1.0 - mirrored) * near(draw, 1.0), 1.0)
    varied = {f'{prefix}.specular': mirrored, f'{prefix}.diffuse': np.maximum(scattered, 0.0)}
    if draw.random() < 0.5:
        common['environment.atmosphere'] = 'exponential'
        varied['environment.density'] = draw.choice([0.0, 1e-12], RUNS, p=[0.1, 0.9])
        varied['environment.scale_height'] = draw.choice([0.0, 6e4], RUNS, p=[0.1, 0.9])
    if common['orbit.type'] == 'circular':
        off = draw.choice([-1e-4, 1e-4])
        varied['orbit.mu'] = EARTH_MU * (1.0 + off * near(draw, 1.0, smallest=1e-9))
    return common, varied


def body(draw):
    moments = 10.0 ** draw.uniform(-1.0, 3.0, (RUNS, 3))
    large = near(draw, 1.0, smallest=1e-15)
    # The largest is the sum of the others, or the smallest is next to nothing.
    moments[::2, 2] = (moments[::2, 0] + moments[::2, 1]) * large[::2]
    moments[1::2, 0] = 1e-13 * moments[1::2, 1] * large[1::2]
    moments[1::2, 2] = moments[1::2, 1]
    moments[:2] = draw.choice([0.0, -1.0, 1.0, 1e308], (2, 3))
    match draw.integers(3):
        case 0:
            return {}, {'body.inertia': moments}
        case 1:
            products = draw.choice([0.0, 1e-3, 1.0], (RUNS, 3)) * vectors(draw)
            return {}, {'body.inertia': np.hstack([moments, products])}
    rows = moments[:, None, :] * np.eye(3)
    rows[::2] = rotation.matrix(rotation.normalise(draw.normal(size=(RUNS // 2, 4))))
    rows[::2] = rows[::2] @ (moments[::2, :, None] * np.swapaxes(rows[::2], -1, -2))
    rows[:, 0, 1] *= 1.0 + draw.choice([0.0, 1e-14, 1e-12], RUNS)
    return {}, {'body.inertia': rows.reshape(RUNS, 9)}


def of_rotors(draw):
    names = ('a', 'b', 'c')[: draw.choice([1, 2, 2, 2, 3])]
    prefixes = rotors.prefixes(names)
    common: dict[str, Any] = {'rotor.names': names}
    varied = {}
    # Bodies that are none, too: what they leave to the rotors cannot be computed.
    moments = draw.choice([800.0, 900.0, 600.0, 0.0], (RUNS, 3), p=[0.32, 0.32, 0.32, 0.04])
    varied['body.inertia'] = moments
    for prefix in prefixes:
        common[f'{prefix}.mode'] = str(draw.choice(['free', 'motor']))
        axes = draw.choice([0.0, 1.0, -1.0], (RUNS, 3))
        axes[~axes.any(axis=1), 0] = 1.0
        varied[f'{prefix}.axis'] = axes
        # About a principal axis that no other rotor has, the moment itself is the most.
        most = np.max(np.abs(axes) * moments, axis=1) / draw.choice([1, len(prefixes)])
        share = near(draw, 1.0, 1e-12)
        # All of it leaves nothing that could be solved for.
        share[:3] = 1.0
        varied[f'{prefix}.inertia'] = np.maximum(most * share, 0.0)
        varied[f'{prefix}.speed'] = near(draw, 100.0) * draw.choice([-1.0, 1.0], RUNS)
        if common[f'{prefix}.mode'] == 'motor':
            varied[f'{prefix}.max_speed'] = draw.choice([0.0, 100.0], RUNS)
    return common, varied


def of_modes(draw):
    names = ('a', 'b', 'c')[: draw.choice([1, 2, 2, 3])]
    moments = draw.choice([800.0, 900.0, 600.0], (RUNS, 3))
    common: dict[str, Any] = {'flexible.names': names}
    varied = {'body.inertia': moments}
    if draw.random() < 0.5:
        common |= {'rotor.mode': 'free', 'rotor.inertia': 1.0, 'rotor.axis': (0.6, 0.0, 0.8)}
    for name in names:
        axes = np.eye(3)[draw.integers(0, 3, RUNS)]
        # Along a principal axis that no other mode has, all of its moment is the most.
        most = np.max(axes * moments, axis=1) / draw.choice([1, len(names)])
        size = np.sqrt(np.maximum(most * near(draw, 1.0, 1e-12), 0.0))
        varied[f'flexible.{name}.coupling'] = axes * size[:, None]
        varied[f'flexible.{name}.frequency'] = draw.choice([0.0, 2.0], RUNS, p=[0.1, 0.9])
    return common, varied


def of_rods(draw):
    saturation = draw.uniform(0.1, 1.0, RUNS)
    return {'hysteresis.names': ('a',)}, {
        'hysteresis.a.coercive_force': draw.choice([0.0, 12.0], RUNS, p=[0.2, 0.8]),
        'hysteresis.a.saturation': saturation,
        'hysteresis.a.remanence': draw.choice([0.0, 1.0], RUNS, p=[0.2, 0.8])
        * saturation
        * near(draw, 1.0),
    }


def ticks(draw):
    rate = float(10.0 ** draw.uniform(-12.0, 3.0))
    common = {
        'publish.rate': rate,
        'time.epoch_ns': int(draw.choice([0, KEYS['time.epoch_ns'].high])),
        'time.factor': float(draw.choice([0.0, min(1e6, 1e-9 / rate * draw.choice([0.9, 1.1]))])),
    }
    return common, {'initial.attitude': rotation.normalise(draw.normal(size=(RUNS, 4)))}


def frame(draw):
    common = {
        'orbit.type': str(draw.choice(['fixed', 'circular', 'kepler'])),
        'initial.frame': str(draw.choice(['inertial', 'lvlh'])),
    }
    return common, {'initial.angular_velocity': vectors(draw)}


def turns(draw):
    rate_hz = float(draw.choice([1e-2, 100.0, 1.0 / 3.0]))
    common = {'publish.rate': rate_hz, 'orbit.type': str(draw.choice(['circular', 'kepler']))}
    rates = near(draw, 1e6 * rate_hz)
    if draw.random() < 0.5:
        return common, {'initial.angular_velocity': rates[:, None] * rotation.IDENTITY[1:]}
    varied = {'orbit.mu': 10.0 ** draw.uniform(10.0, 20.0, RUNS)}
    e = np.zeros(RUNS)
    if common['orbit.type'] == 'kepler':
        varied['orbit.eccentricity'] = e = draw.uniform(0.0, 0.999, RUNS)
    at_pericentre = np.sqrt((1.0 + e) / (1.0 - e)) / (1.0 - e)
    varied['orbit.semi_major_axis'] = np.cbrt(varied['orbit.mu'] * (at_pericentre / rates) ** 2)
    varied['orbit.semi_major_axis'][:2] = 5e-324, 1e308
    return common, varied


DRAWS = {
    checks.units: units,
    checks.belongs: belongs,
    orbits.checks: orbit,
    environment.checks: of_environment,
    sensors.checks: of_sensors,
    checks.torques: of_torques,
    checks.thrusters: of_thrusters,
    checks.body: body,
    rotors.checks: of_rotors,
    modes.checks: of_modes,
    modes.checks_of_kinds: of_modes,
    environment.checks_of_torques: of_rods,
    checks.ticks: ticks,
    checks.frame: frame,
    checks.turns_a_tick: turns,
}


@pytest.mark.parametrize(
    'check',
    [checks.units, *checks.ALL_CHECKS],
    ids=lambda check: f'{check.__module__}.{check.__name__}',
)
def test_one_and_many_are_refused_alike(check):
    """What is drawn for a check is refused by both or by neither, and each sentence is said."""
    draw = np.random.default_rng(1)
    found = [error for _ in range(16) for error in judged(*DRAWS[check](draw))]
    assert None in found
    of_others = {
        checks.body: inertia.checks,
        orbits.checks: ORBIT_TYPES['oem'].checks,
        environment.checks_of_torques: checks_of_rods,
        modes.checks_of_kinds: Mode.checks,
    }
    function = of_others.get(check, check)
    ends = [list(traceback.walk_tb(error.__traceback__))[-1] for error in found if error]
    said = {line for frame, line in ends if frame.f_code is function.__code__}
    assert len(said) == inspect.getsource(function).count('raise ValueError') > 0


def test_each_key_is_refused_alike():
    """Numbers at the bounds of each key that a sweep varies, next to them and beyond any."""
    for base in BASES.values():
        for name, key in KEYS.items():
            if name.split('.')[0] not in ('body', 'rotor', 'orbit', 'initial', 'motion'):
                continue
            if key.kind not in ('double', 'double_array') or name in OTHERS_GIVE_WAY:
                continue
            bounds = [key.low, key.high, key.above, key.below, 0.0]
            numbers = [np.nextafter(bound, to) for bound in bounds for to in (-np.inf, np.inf)]
            numbers += [*bounds, np.nan]
            default = np.array(base.get(name, key.default))
            values = [np.where(np.arange(default.size) == 0, x, default) for x in numbers]
            found = judged(base, {name: np.reshape(values, (-1, *default.shape))})
            assert str(found[-1]).startswith(f'{name} is ')

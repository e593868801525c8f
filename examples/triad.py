"""
Determine the attitude from magnetometer and Sun sensors in a bag, and compare it with the truth.

Make a bag, and read it:
    satdyn simulate config/cubesat_leo.yaml --duration 6000 --rate 2 -o bags/triad
    python examples/triad.py bags/triad
Two directions, of the Sun and of the magnetic field, known in inertial axes and measured in the
body's, determine the attitude.  TRIAD (Black, A passive system for determining the attitude of a
satellite, 1964) makes a triad of axes of either pair; the attitude turns one into the other.
Where no sensor sees the Sun, as in the shadow, the gyro carries the last attitude on.
"""

import argparse
from pathlib import Path

import numpy as np
from geometry_msgs.msg import QuaternionStamped, Vector3Stamped
from mcap.reader import make_reader
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Imu, MagneticField

from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.environment import sun_direction
from satdyn_ros.kernel import rotation
from satdyn_ros.sensors import Gyro, Magnetometer, SunSensor

# Directions nearer to each other, or to opposite ones, determine a turn about them badly [rad].
LEAST_ANGLE = np.radians(15.0)
REPORT_EACH_S = 600.0
_NS = 10**9


def triad(first_b, second_b, first_i, second_i):
    """
    Return q_ib (4,) from two directions (3,) in body and in inertial axes.

    It turns the first exactly, the second as far as their angle is what it should be: the first
    is to be the better known.
    """
    return rotation.from_matrix(_axes(first_i, second_i) @ _axes(first_b, second_b).T)


def _axes(first, second):
    """Return the axes, columns of (3, 3): along the first, and square to both."""
    x, z = first / np.linalg.norm(first), np.cross(first, second)
    z = z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def is_wide(one, other):
    """Return whether two directions determine an attitude."""
    cosine = one @ other / np.linalg.norm(one) / np.linalg.norm(other)
    return abs(cosine) < np.cos(LEAST_ANGLE)


def attitudes(stamps_ns, field_b, sun_b, rate_b, field_i, sun_i):
    """
    Return q_ib (N, 4) at stamps (N,), and whether each was determined, not carried on, (N,).

    Measurements are (N, 3), in body axes: sun_b nan where the Sun is not seen, rate_b the mean
    rate since the stamp before.  q_ib is nan before the first that is determined.
    """
    q_ib, found = np.full((len(stamps_ns), 4), np.nan), np.zeros(len(stamps_ns), bool)
    for i, (B_b, s_b) in enumerate(zip(field_b, sun_b, strict=True)):
        if not np.isnan(s_b[0]) and is_wide(field_i[i], sun_i[i]):
            q_ib[i], found[i] = triad(s_b, B_b, sun_i[i], field_i[i]), True
        elif i:
            dt = (stamps_ns[i] - stamps_ns[i - 1]) / _NS
            q_ib[i] = rotation.multiply(q_ib[i - 1], rotation.from_vector(rate_b[i] * dt))
    return q_ib, found


def known(scenario, stamps_ns):
    """Return field and direction of the Sun, (N, 3) each, in inertial axes, where the orbit is."""
    return known_field(scenario, stamps_ns), known_sun(scenario, stamps_ns)


def known_field(scenario, stamps_ns):
    """Return the magnetic field [T] (N, 3) in inertial axes, where the orbit is at stamps (N,)."""
    t_s = (stamps_ns - scenario.epoch_ns) / _NS
    return scenario.system.environment.magnetic_field.values(t_s, np.arange(3))


def known_sun(scenario, stamps_ns):
    """Return the direction of the Sun (N, 3) in inertial axes, where the orbit is."""
    system, t_s = scenario.system, (stamps_ns - scenario.epoch_ns) / _NS
    r_i, _ = system.orbit.position_velocity(t_s)
    s_i, _ = sun_direction(r_i, system.environment.sun.values(t_s, np.arange(3)))
    return s_i


def read(bag, scenario):
    """Return stamps (N,), measured field, Sun and rate (N, 3) in body axes, and the true q_ib."""
    suns = [name for name, one in scenario.sensors.items() if isinstance(one, SunSensor)]
    magnetometer, gyro = (
        next(name for name, one in scenario.sensors.items() if isinstance(one, kind))
        for kind in (Magnetometer, Gyro)
    )
    columns = {
        'attitude': (QuaternionStamped, 'quaternion', 'xyzw'),
        magnetometer: (MagneticField, 'magnetic_field', 'xyz'),
        gyro: (Imu, 'angular_velocity', 'xyz'),
        **{name: (Vector3Stamped, 'vector', 'xyz') for name in suns},
    }
    heard: dict[str, dict[int, list[float]]] = {name: {} for name in columns}
    for file in sorted(Path(bag).glob('*.mcap')):
        with file.open('rb') as stream:
            for _, channel, message in make_reader(stream).iter_messages(
                [f'/{name}' for name in columns]
            ):
                name = channel.topic.lstrip('/')
                kind, part, axes = columns[name]
                content = deserialize_message(message.data, kind)
                stamp_ns = content.header.stamp.sec * _NS + content.header.stamp.nanosec
                heard[name][stamp_ns] = [getattr(getattr(content, part), x) for x in axes]
    stamps_ns = np.array(sorted(heard[magnetometer].keys() & heard[gyro].keys()))

    def table(name, nothing):
        return np.array([heard[name].get(stamp, nothing) for stamp in stamps_ns.tolist()])

    def in_body_axes(name):
        return rotation.rotate(scenario.sensors[name].mounting, table(name, [np.nan] * 3))

    sun_b = np.full((len(stamps_ns), 3), np.nan)
    for name in suns:
        sun_b = np.where(np.isnan(sun_b), in_body_axes(name), sun_b)
    measured = in_body_axes(magnetometer), sun_b, in_body_axes(gyro)
    return stamps_ns, *measured, table('attitude', [np.nan] * 4)


def main():
    """Print how far the attitude is off, and whether the Sun was seen."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('bag', help='with a magnetometer, sun sensors, a gyro, and attitude')
    bag = parser.parse_args().bag
    scenario = RecordedRun(bag).scenario
    stamps_ns, field_b, sun_b, rate_b, truth = read(bag, scenario)
    q_ib, found = attitudes(stamps_ns, field_b, sun_b, rate_b, *known(scenario, stamps_ns))
    t_s = (stamps_ns - stamps_ns[0]) / _NS
    error_deg = np.degrees(rotation.angle_between(q_ib, truth))
    for i in range(0, len(t_s), max(1, int(np.searchsorted(t_s, REPORT_EACH_S)))):
        how = 'Sun and field' if found[i] else 'gyro'
        how = 'the Sun was not seen yet' if np.isnan(error_deg[i]) else how
        print(f'{t_s[i]:6.0f} s  error {error_deg[i]:6.2f} deg  {how}')
    carried = ~found & ~np.isnan(error_deg)
    for name, rows in (('Sun and field', found), ('gyro', carried)):
        if np.any(rows):
            median, most = np.median(error_deg[rows]), np.max(error_deg[rows])
            print(f'{name}: median error {median:.2f} deg, at most {most:.2f} deg')


if __name__ == '__main__':
    main()

import subprocess
import sys

import numpy as np
import pytest
from commands import dipole_command, motor_command, thruster_command, torque_command
from messages.drawn_samples import (
    EPOCH_NS,
    FRAMES,
    SWITCHES_S,
    SYSTEMS,
    THRUSTERS,
    part,
    samples,
)
from messages.readers import canonical, default, read
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import NavSatStatus

from satdyn_ros import environment
from satdyn_ros.actuators import Equipment
from satdyn_ros.dynamics.system import State
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.messages import cdr, contents
from satdyn_ros.messages.incoming import pack_command
from satdyn_ros.run.samples import Samples
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.topics import TOPICS

PACKED = [name for name, topic in TOPICS.items() if topic.role in ('state', 'clock')]
CASES = [
    (flight, topic)
    for flight, system in SYSTEMS.items()
    for topic in PACKED
    if not TOPICS[topic].lacking(system)
]


def packer(flight, topic):
    return contents.message(TOPICS[topic], FRAMES[flight], SYSTEMS[flight])


def stamp(of, i):
    return {'sec': int(of.stamps_ns[i]) // 10**9, 'nanosec': int(of.stamps_ns[i]) % 10**9}


def header(of, i, frame_id):
    return {'stamp': stamp(of, i), 'frame_id': frame_id}


def xyz(v):
    return dict(zip('xyz', v, strict=True))


def xyzw(q):
    return dict(zip('xyzw', q, strict=True))


def body_rotation(of, i):
    return Rotation.from_quat(of.states.q_ib[i])


def lvlh_rotation(of, i):
    """Return LVLH to inertial from what LVLH means: along track, minus the normal, nadir."""
    r, v = of.states.r_i[i], of.states.v_i[i]
    nadir, normal = -r / np.linalg.norm(r), np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    return Rotation.from_matrix(np.stack([np.cross(-normal, nadir), -normal, nadir], axis=-1))


def near(values, size):
    """
    Return what compares equal to within 1e-13 of a size.

    The expectation takes another path of some dozen operations, each rounding to 1.1e-16.
    """
    return [pytest.approx(value, rel=0.0, abs=1e-13 * size) for value in values]


def quaternion(turn, like):
    """Return the one of the two quaternions of a rotation that is next to another."""
    q = turn.as_quat()
    return xyzw(near(q if q @ like > 0.0 else -q, 1.0))


def nadir_b(of, i):
    if of.system.orbit.has_lvlh:
        r = of.states.r_i[i]
        nadir_i = -r / np.linalg.norm(r)
    else:
        nadir_i = np.array([0.0, 0.0, -1.0])
    return body_rotation(of, i).inv().apply(nadir_i)


def expected_attitude(of, i, frames):
    q = xyzw(of.states.q_ib[i])
    return {'header': header(of, i, frames.inertial), 'quaternion': q}


def expected_angular_velocity(of, i, frames):
    return {
        'header': header(of, i, frames.body),
        'body_frame_id': frames.body,
        'reference_frame_id': frames.inertial,
        'velocity': {'angular': xyz(of.states.omega_bi_b[i])},
    }


def expected_imu(of, i, frames):
    return {
        'header': header(of, i, frames.body),
        'orientation': xyzw(of.states.q_ib[i]),
        'angular_velocity': xyz(of.states.omega_bi_b[i]),
        'linear_acceleration_covariance': [-1.0] + [0.0] * 8,
    }


def expected_odometry(of, i, frames):
    v_b = body_rotation(of, i).inv().apply(of.states.v_i[i])
    return {
        'header': header(of, i, frames.inertial),
        'child_frame_id': frames.body,
        'pose': {
            'pose': {
                'position': xyz(of.states.r_i[i]),
                'orientation': xyzw(of.states.q_ib[i]),
            }
        },
        'twist': {
            'twist': {'linear': xyz(near(v_b, 8e3)), 'angular': xyz(of.states.omega_bi_b[i])}
        },
    }


def expected_attitude_lvlh(of, i, frames):
    turn = lvlh_rotation(of, i).inv() * body_rotation(of, i)
    return {
        'header': header(of, i, frames.orbital),
        'quaternion': quaternion(turn, of.states.q_lb[i]),
    }


def expected_gravity_gradient(of, i, frames):
    orbit, c_b = of.system.orbit, -nadir_b(of, i)
    if orbit.has_lvlh:
        gradient = 3.0 * orbit.mu / np.linalg.norm(of.states.r_i[i]) ** 3
    else:
        gradient = orbit.gradient
    torque = gradient * np.cross(c_b, of.system.inertia @ c_b)
    return {'header': header(of, i, frames.body), 'wrench': {'torque': xyz(near(torque, 1e-3))}}


def expected_rotor(of, i, frames):
    turns, driven = (
        of.system.rotors[0].mode in ('free', 'motor'),
        of.system.rotors[0].mode == 'motor',
    )
    return {
        'header': header(of, i, frames.body),
        'name': ['rotor'],
        'position': list(of.states.rotor_angle[i]) if turns else [],
        'velocity': list(of.states.rotor_speed[i]) if turns else [],
        'effort': [of.system.rotor_torque[0]] if driven else [],
    }


def expected_tf(of, i, frames):
    def transform(child, rotation):
        return default(
            'geometry_msgs/msg/TransformStamped',
            header=header(of, i, frames.inertial),
            child_frame_id=child,
            transform={'translation': xyz(of.states.r_i[i]), 'rotation': rotation},
        )

    body = transform(frames.body, xyzw(of.states.q_ib[i]))
    if not of.system.orbit.has_lvlh:
        return {'transforms': [body]}
    earth = []
    if frames.has_earth:
        turn = earth_rotation(of, i)
        like = rotation.from_matrix(turn.as_matrix())
        earth = [transform(frames.earth, quaternion(turn, like))]
        earth[0]['transform']['translation'] = xyz((0.0, 0.0, 0.0))
    q_il = rotation.multiply(of.states.q_ib[i], rotation.conjugate(of.states.q_lb[i]))
    lvlh = transform(frames.orbital, quaternion(lvlh_rotation(of, i), q_il))
    return {'transforms': [lvlh, *earth, body]}


def position_and_time(of, i):
    return of.states.r_i[i], EPOCH_NS + round(1e9 * of.states.orbit_s[i])


def earth_rotation(of, i):
    """Return ITRS to inertial, from the functions that the tables are made of."""
    _, unix_ns = position_and_time(of, i)
    return Rotation.from_matrix(environment.gcrs_to_itrs(unix_ns).T)


def expected_magnetic_field(of, i, frames):
    r_i, _ = position_and_time(of, i)
    to_inertial = earth_rotation(of, i)
    g_t = environment.dipole_vector(EPOCH_NS)
    B_i = to_inertial.apply(environment.dipole_field(g_t, to_inertial.inv().apply(r_i)))
    B_b = body_rotation(of, i).inv().apply(B_i)
    return {'header': header(of, i, frames.body), 'magnetic_field': xyz(near(B_b, 1e-4))}


def expected_sun_direction(of, i, frames):
    r_i, unix_ns = position_and_time(of, i)
    s_i, _ = environment.sun_direction(r_i, environment.sun_position(unix_ns))
    s_b = body_rotation(of, i).inv().apply(s_i)
    return {'header': header(of, i, frames.body), 'vector': xyz(near(s_b, 1.0))}


def expected_sunlight(of, i, frames):
    r_i, unix_ns = position_and_time(of, i)
    sun_i = environment.sun_position(unix_ns)
    nearness = 149_597_870_700.0 / np.linalg.norm(sun_i - r_i)
    lux = 128_000.0 * nearness**2 * environment.lit_fraction(r_i, sun_i)
    return {'header': header(of, i, frames.body), 'illuminance': near([lux], 1e5)[0]}


def expected_geodetic(of, i, frames):
    r_i, _ = position_and_time(of, i)
    *angles, height_m = environment.geodetic(earth_rotation(of, i).inv().apply(r_i))
    latitude, longitude = near(np.degrees(angles), 1e3)
    return {
        'header': header(of, i, frames.earth),
        'status': {'status': NavSatStatus.STATUS_FIX},
        'latitude': latitude,
        'longitude': longitude,
        'altitude': near([height_m], 1e7)[0],
    }


def thrust_and_impulse(of, i, time_constant):
    """Return the parts of a thrust and of the impulse so far, by the textbook's exponentials."""
    opens_s, closes_s = SWITCHES_S
    t_s = of.states.orbit_s[i]
    on_s, off_s = max(0.0, min(t_s, closes_s) - opens_s), max(0.0, t_s - closes_s)
    if not time_constant:
        return float(opens_s <= t_s < closes_s), on_s
    risen = 1.0 - np.exp(-on_s / time_constant)
    left = risen * np.exp(-off_s / time_constant)
    return left if off_s else risen, on_s - time_constant * left


def expected_thruster(of, i, frames):
    parts = {n: thrust_and_impulse(of, i, each.time_constant) for n, each in THRUSTERS.items()}
    used = 2.0 * parts['pp'][1] / (9.80665 * 60.0)
    return {
        'header': header(of, i, frames.body),
        'name': ['pp', 'mm'],
        'position': [pytest.approx(used, rel=1e-12), pytest.approx(np.nan, nan_ok=True)],
        'velocity': [],
        'effort': near([2.0 * parts['pp'][0], parts['mm'][0]], 1.0),
    }


def expected_thruster_wrench(of, i, frames):
    force, torque = np.zeros((2, 3))
    for each in THRUSTERS.values():
        part, _ = thrust_and_impulse(of, i, each.time_constant)
        force += part * each.thrust * np.array(each.direction)
        torque += part * each.thrust * np.cross(each.position, each.direction)
    wrench = {'force': xyz(near(force, 1.0)), 'torque': xyz(near(torque, 1.0))}
    return {'header': header(of, i, frames.body), 'wrench': wrench}


def expected_clock(of, i, frames):
    return {'clock': stamp(of, i)}


EXPECTED = {
    'attitude': expected_attitude,
    'angular_velocity': expected_angular_velocity,
    'imu': expected_imu,
    'odometry': expected_odometry,
    'attitude_lvlh': expected_attitude_lvlh,
    'gravity_gradient': expected_gravity_gradient,
    'magnetic_field': expected_magnetic_field,
    'sun_direction': expected_sun_direction,
    'sunlight': expected_sunlight,
    'geodetic': expected_geodetic,
    'rotor': expected_rotor,
    'thruster': expected_thruster,
    'thruster_wrench': expected_thruster_wrench,
    'tf': expected_tf,
    'clock': expected_clock,
}


@pytest.mark.parametrize(
    ('flight', 'topic'), [case for case in CASES if case[1] in EXPECTED], ids=str
)
def test_every_reader_reads_what_the_states_are(flight, topic):
    """
    What rclpy, rosbags and mcap_ros2 find in each field is what the state and the frames say.

    Fields that copy the state are equal; those that take a formula are near (see above).
    """
    of, type_name = samples(flight), TOPICS[topic].type
    rows = packer(flight, topic).pack(of)
    assert rows.shape == (len(of),)
    for i in (0, 17, len(of) - 1):
        expected = EXPECTED[topic](of, i, FRAMES[flight])
        if topic != 'tf':
            expected = default(type_name, **expected)
        for message in read(type_name, rows[i].tobytes()).values():
            assert message == expected


@pytest.mark.parametrize(('flight', 'topic'), CASES, ids=str)
def test_bytes_are_those_that_ros_writes(flight, topic):
    """Read and written again by rclpy the bytes are the same, the padding apart, which is zero."""
    rows = packer(flight, topic).pack(samples(flight))
    for row in rows[::13]:
        assert row.tobytes() == canonical(TOPICS[topic].type, row.tobytes())


@pytest.mark.parametrize(('flight', 'topic'), CASES, ids=str)
def test_blocks_of_any_size_give_the_same_bytes(flight, topic):
    """A message does not depend on the ticks that are packed together with it."""
    of, pack = samples(flight), packer(flight, topic).pack
    whole = pack(of).tobytes()
    for size in (1, 7, 32):
        blocks = [part(of, slice(k, k + size)) for k in range(0, len(of), size)]
        assert b''.join(pack(block).tobytes() for block in blocks) == whole


@pytest.mark.long
def test_published_quaternions_are_unit():
    """Those of a propagated tumble are unit to rounding, in each topic."""
    system = SYSTEMS['ellipse, motor']
    motion = Propagation(system, State(np.array([0.5, 0.5, 0.5, 0.5]), np.full(3, 0.1), 0.0, 0.0))
    states = motion.at(np.arange(500) * 0.7)
    of = Samples(0, np.arange(500) * 700_000_000, states, system)
    for topic in (name for name in PACKED if not TOPICS[name].lacking(system)):
        rows = packer('ellipse, motor', topic).pack(of)
        for name in rows.dtype.names:
            if rows[name].shape == (500, 4) and 'color' not in name:
                assert np.abs(np.linalg.norm(rows[name], axis=1) - 1.0).max() < 1e-15, name


def test_without_orbit_there_is_no_attitude_to_lvlh():
    """The refusal names the parameters and what is allowed."""
    with pytest.raises(ValueError, match=r'attitude_lvlh and orbit\.type is fixed'):
        packer('fixed, constant momentum', 'attitude_lvlh')


def test_diagnostics_have_no_rows():
    """The one topic whose messages differ in length says so."""
    with pytest.raises(ValueError, match='/diagnostics has no constant layout'):
        packer('circle, no rotor', 'diagnostics')


def test_an_input_torque_is_a_wrench_in_the_body_frame():
    """The recorded input, byte for byte as ROS writes it; stamps to the nanosecond."""
    frames = FRAMES['ellipse, motor']
    data = pack_command(1_700_000_000_000_000_007, torque_command(0, (0.1, -0.2, 0.3)), frames)
    expected = default(
        'geometry_msgs/msg/WrenchStamped',
        header={'stamp': {'sec': 1_700_000_000, 'nanosec': 7}, 'frame_id': frames.body},
        wrench={'torque': xyz((0.1, -0.2, 0.3))},
    )
    for message in read('geometry_msgs/msg/WrenchStamped', data).values():
        assert message == expected
    assert data == canonical('geometry_msgs/msg/WrenchStamped', data)


def test_an_input_rotor_torque_is_a_number():
    """The recorded input, byte for byte as ROS writes it."""
    command = motor_command(0, {'rotor': -0.125})
    data = pack_command(0, command, FRAMES['ellipse, motor'], 'rotor_torque')
    for message in read('std_msgs/msg/Float64', data).values():
        assert message == {'data': -0.125}
    assert data == canonical('std_msgs/msg/Float64', data)


@pytest.mark.parametrize(
    'command',
    [
        thruster_command(0, a=0.03, longer=0.0),
        torque_command(0, (0.1, -0.2, 0.3)),
        dipole_command(0, (0.1, -0.2, 0.3)),
        motor_command(0, {'a': 0.125, 'longer': -3.0}),
        motor_command(0, speeds={'a': 0.125}),
    ],
)
def test_a_command_comes_back_from_its_message(command):
    """From the bytes, as from the message that rclpy makes of them."""
    values = {'magnetorquer.max_dipole': [1.0, 1.0, 1.0], 'thruster.names': ['a', 'longer']}
    equipment = Equipment(Scenario(values).values, ())
    actuator = equipment.of_topic[command.topic]
    data = pack_command(5, command, FRAMES['circle, no rotor'])
    assert data == canonical(actuator.message, data)
    assert actuator.read(command.topic, cdr.read(actuator.message, data)) == command.value


def test_packing_needs_no_ros():
    """Definitions, hashes and packing come with the package: nothing of ROS is imported."""
    program = (
        'import sys\n'
        "for name in ('rclpy', 'geometry_msgs', 'std_msgs', 'ament_index_python'):\n"
        '    sys.modules[name] = None\n'
        'from satdyn_ros.messages import cdr\n'
        'from satdyn_ros.messages.incoming import pack_command\n'
        "print(cdr.Message('std_msgs/msg/Float64', {'data': 2.0}).rows(1).tobytes().hex())"
    )
    result = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True)
    assert result.stdout.strip() == '000100000000000000000040', result.stderr

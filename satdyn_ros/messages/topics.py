"""The table of topics: the name, content and purpose of each, and how samples become messages."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..dynamics.system import System
from ..run.scenario import Frames
from . import cdr, contents

Packer = cdr.Message


@dataclass(frozen=True)
class Topic:
    """
    A topic.

    name: as ROS resolves it in the node's namespace, absolute for /tf, /clock and /diagnostics.
    role: 'state' (one message per tick, chosen by publish.topics), 'sensor' (chosen by
    sensors.names), 'latched' (one message), 'clock', 'input' or 'diagnostics'.
    frame: which of the scenario's frames its header names ('inertial', 'orbital', 'body'), or ''.
    says: its content in words, with units.  content: its message for given frames and System; None
    for the sensors (measured.py) and /diagnostics, which has no constant layout.
    """

    name: str
    type: str
    role: str
    frame: str
    says: str
    content: Callable[[Frames, System], dict[str, Any]] | None

    def packer(self, frames: Frames, system: System) -> Packer:
        """
        Return what packs samples of a system: pack(samples) -> rows (N,), each one message.

        The inputs pack contents.Inputs.  ValueError: the system has no such topic, or the topic
        no constant layout.
        """
        if self.content is None:
            raise ValueError(f'{self.name} has no constant layout; publish {self.type} objects')
        return Packer(self.type, self.content(frames, system))


def pack_torque(stamp_ns: int, torque_b: Sequence[float] | np.ndarray, frames: Frames) -> bytes:
    """Return the message of the input torque: torque_b (3,) [N m] in body axes."""
    inputs = contents.Inputs(np.array([stamp_ns]), np.array([torque_b], float))
    return _torque_packer(frames).pack(inputs).tobytes()


def pack_rotor_torque(torque: float) -> bytes:
    """Return std_msgs/Float64, the input rotor_torque [N m] in bags of version 0.1."""
    inputs = contents.Inputs(np.array([0]), np.array([torque], float))
    return ROTOR_TORQUE.pack(inputs).tobytes()


def pack_rotor_command(stamp_ns: int, torques: Mapping[str, float], frames: Frames) -> bytes:
    """Return the message of the input rotor_command: torques [N m] by rotor."""
    inputs = contents.Inputs(np.array([stamp_ns]), np.array([list(torques.values())], float))
    return _command_packer(frames, tuple(torques)).pack(inputs).tobytes()


def rotor_command_of(data: bytes) -> dict[str, float]:
    """Return the torques [N m] by rotor of a message; ValueError: it is not a JointState."""
    reader = cdr.Reader(data)
    reader.numbers('int32', 2)
    reader.string()
    names = [reader.string() for _ in range(reader.count())]
    _positions, _velocities, efforts = (
        reader.numbers('float64', count) if (count := reader.count()) else [] for _ in range(3)
    )
    return dict(zip(names, efforts, strict=True))


def pack_tf_static(stamp_ns: int, frames: Frames) -> bytes:
    """Return the message of /tf_static."""
    inputs = contents.Inputs(np.array([stamp_ns]), np.empty((1, 0)))
    return TOPICS['tf_static'].packer(frames, _ANY).pack(inputs).tobytes()


def tf_with_sensors(frames: Frames, system: System) -> Packer:
    """Return what packs /tf as it is in bags of the rules 0 and 1."""
    return Packer(TOPICS['tf'].type, contents.tf_with_sensors(frames, system))


@cache
def _command_packer(frames, names):
    return Packer(TOPICS['rotor_command'].type, contents.rotor_command(frames, names))


@cache
def _torque_packer(frames):
    return TOPICS['torque'].packer(frames, _ANY)


_TABLE = (
    Topic(
        'attitude',
        'geometry_msgs/msg/QuaternionStamped',
        'state',
        'inertial',
        'attitude, body to inertial',
        contents.attitude,
    ),
    Topic(
        'angular_velocity',
        'geometry_msgs/msg/VelocityStamped',
        'state',
        'body',
        'rate of the body relative to inertial in body axes [rad/s]; the linear part is zero',
        contents.angular_velocity,
    ),
    Topic(
        'imu',
        'sensor_msgs/msg/Imu',
        'state',
        'body',
        'attitude, body to inertial; body rate [rad/s]; the acceleration is marked absent',
        contents.imu,
    ),
    Topic(
        'odometry',
        'nav_msgs/msg/Odometry',
        'state',
        'inertial',
        'position [m] and attitude in inertial; orbital velocity [m/s] and body rate [rad/s] in '
        'body axes',
        contents.odometry,
    ),
    Topic(
        'attitude_lvlh',
        'geometry_msgs/msg/QuaternionStamped',
        'state',
        'orbital',
        'attitude, body to LVLH; not for orbit.type fixed',
        contents.attitude_lvlh,
    ),
    Topic(
        'gravity_gradient',
        'geometry_msgs/msg/WrenchStamped',
        'state',
        'body',
        'gravity-gradient torque on the body in body axes [N m]; the force is zero',
        contents.gravity_gradient,
    ),
    Topic(
        'rotor',
        'sensor_msgs/msg/JointState',
        'state',
        'body',
        'angle [rad], speed relative to the body [rad/s] and motor torque after its limits [N m] '
        'of all rotors; arrays are empty where no rotor has such a value',
        contents.rotor,
    ),
    Topic(
        'markers',
        'visualization_msgs/msg/MarkerArray',
        'state',
        'body',
        'body and body axes, and the directions of nadir, rate and momentum',
        contents.marker_array,
    ),
    Topic(
        '/tf',
        'tf2_msgs/msg/TFMessage',
        'state',
        'inertial',
        'inertial to LVLH, where there is an orbit; inertial to body',
        contents.tf,
    ),
    Topic(
        '/tf_static',
        'tf2_msgs/msg/TFMessage',
        'latched',
        'body',
        'body to each sensor: its mounting, once, stamped by tick 0, for whoever comes later too; '
        'only with sensors',
        contents.tf_static,
    ),
    Topic(
        'gyro',
        'sensor_msgs/msg/Imu',
        'sensor',
        '',
        'body rate [rad/s] as the gyro measures it, in its axes, with its covariance; all else is '
        'marked absent',
        None,
    ),
    Topic(
        'star_tracker',
        'sensor_msgs/msg/Imu',
        'sensor',
        '',
        'attitude, sensor to inertial, as the star tracker measures it, with its covariance in '
        'sensor axes, stamped by its exposure; everything else is marked absent',
        None,
    ),
    Topic(
        '/clock',
        'rosgraph_msgs/msg/Clock',
        'clock',
        '',
        'the stamp of the samples that follow',
        contents.clock,
    ),
    Topic(
        '/diagnostics',
        'diagnostic_msgs/msg/DiagnosticArray',
        'diagnostics',
        '',
        'drift of the first integrals, pacing, recorder, inputs and connections, once per second',
        None,
    ),
    Topic(
        'torque',
        'geometry_msgs/msg/WrenchStamped',
        'input',
        'body',
        'torque on the body in body axes [N m], held until the next one or the timeout',
        contents.torque_input,
    ),
    Topic(
        'rotor_command',
        'sensor_msgs/msg/JointState',
        'input',
        'body',
        'motor torques by name (effort [N m]), held until the next one or the timeout; rotors '
        'not named keep theirs',
        None,
    ),
)

# For the messages that are the same with any.
_ANY = System(np.eye(3))

# The input of version 0.1 in place of rotor_command: the motor torque on its one rotor.
ROTOR_TORQUE = Packer('std_msgs/msg/Float64', contents.rotor_torque_input())

# By the names in publish.topics: without a slash.
TOPICS: dict[str, Topic] = {topic.name.lstrip('/'): topic for topic in _TABLE}

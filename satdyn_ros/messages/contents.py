"""
The content of each topic's messages, as input to cdr.Message.

Each reads like its message: constants stand as they are, and what changes from tick to tick is a
function of the samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..dynamics.system import System
from ..kernel import rotation
from ..run.samples import Stamped
from ..run.scenario import Frames
from ..torques.gravity_gradient import gravity_gradient as gradient_torque
from . import markers


@dataclass(frozen=True, eq=False)
class Inputs(Stamped):
    """What an input topic received: stamps_ns (N,) and torques [N m], (N, 3), (N, R) or (N,)."""

    stamps_ns: np.ndarray
    torques: np.ndarray


def attitude(frames: Frames, system: System) -> dict[str, Any]:
    """Return geometry_msgs/QuaternionStamped: q_ib."""
    return {'header': header(frames.inertial), 'quaternion': _q_ib}


def angular_velocity(frames: Frames, system: System) -> dict[str, Any]:
    """Return geometry_msgs/VelocityStamped: omega_bi_b; the linear part is left at zero."""
    return {
        'header': header(frames.body),
        'body_frame_id': frames.body,
        'reference_frame_id': frames.inertial,
        'velocity': {'angular': _omega_bi_b},
    }


def imu(frames: Frames, system: System) -> dict[str, Any]:
    """Return sensor_msgs/Imu: q_ib and omega_bi_b, without acceleration."""
    # REP-145: a covariance of zeros is unknown, one that begins with -1 marks an absent quantity.
    return {
        'header': header(frames.body),
        'orientation': _q_ib,
        'angular_velocity': _omega_bi_b,
        'linear_acceleration_covariance': [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    }


def odometry(frames: Frames, system: System) -> dict[str, Any]:
    """Return nav_msgs/Odometry: r_i and q_ib; v and omega_bi_b in body axes."""
    return {
        'header': header(frames.inertial),
        'child_frame_id': frames.body,
        'pose': {'pose': {'position': _r_i, 'orientation': _q_ib}},
        'twist': {'twist': {'linear': _v_b, 'angular': _omega_bi_b}},
    }


def attitude_lvlh(frames: Frames, system: System) -> dict[str, Any]:
    """Return geometry_msgs/QuaternionStamped: q_lb.  ValueError: there is no LVLH."""
    if not system.orbit.has_lvlh:
        raise ValueError(
            'publish.topics has attitude_lvlh and orbit.type is fixed, which has no LVLH; '
            'use circular or kepler, or leave the topic out'
        )
    return {'header': header(frames.orbital), 'quaternion': _q_lb}


def gravity_gradient(frames: Frames, system: System) -> dict[str, Any]:
    """Return geometry_msgs/WrenchStamped: the torque on the body."""
    return {'header': header(frames.body), 'wrench': {'torque': _gravity_gradient}}


def rotor(frames: Frames, system: System) -> dict[str, Any]:
    """Return sensor_msgs/JointState: all rotors; an array is empty where none has its values."""
    rotors = system.rotors
    turns = any(rotor.turns_freely for rotor in rotors)
    driven = any(rotor.mode == 'motor' for rotor in rotors)
    return {
        'header': header(frames.body),
        'name': [rotor.label for rotor in rotors],
        'position': [_rotor_angle(i) for i in range(len(rotors))] if turns else [],
        'velocity': [_rotor_speed(i) for i in range(len(rotors))] if turns else [],
        'effort': [_rotor_torque(i) for i in range(len(rotors))] if driven else [],
    }


def marker_array(frames: Frames, system: System) -> dict[str, Any]:
    """Return visualization_msgs/MarkerArray."""
    return markers.content(header(frames.body), system)


def tf(frames: Frames, system: System) -> dict[str, Any]:
    """Return tf2_msgs/TFMessage: inertial to LVLH, where there is an orbit; inertial to body."""
    orbital = [_transform(frames.inertial, frames.orbital, _q_il, _r_i)]
    body = _transform(frames.inertial, frames.body, _q_ib, _r_i)
    return {'transforms': [*(orbital if system.orbit.has_lvlh else []), body]}


def tf_static(frames: Frames, system: System) -> dict[str, Any]:
    """Return tf2_msgs/TFMessage: body to each sensor."""
    mounted = [_transform(frames.body, frame_id, q_bs) for frame_id, q_bs in frames.sensors]
    return {'transforms': mounted}


def tf_with_sensors(frames: Frames, system: System) -> dict[str, Any]:
    """Return tf2_msgs/TFMessage as in bags of the rules 0 and 1, whose tf has the sensors."""
    parts = tf(frames, system), tf_static(frames, system)
    return {'transforms': [transform for part in parts for transform in part['transforms']]}


def clock(frames: Frames, system: System) -> dict[str, Any]:
    """Return rosgraph_msgs/Clock: the stamp."""
    return {'clock': _STAMP}


def torque_input(frames: Frames, system: System) -> dict[str, Any]:
    """Return geometry_msgs/WrenchStamped of Inputs."""
    return {'header': header(frames.body), 'wrench': {'torque': _torques}}


def rotor_torque_input() -> dict[str, Any]:
    """Return std_msgs/Float64 of Inputs."""
    return {'data': _torques}


def rotor_command(frames: Frames, names: Sequence[str]) -> dict[str, Any]:
    """Return sensor_msgs/JointState of Inputs (N, R): motor torques of the rotors of names."""
    efforts = [_torque_of(i) for i in range(len(names))]
    return {'header': header(frames.body), 'name': list(names), 'effort': efforts}


def _seconds(samples):
    return samples.seconds[0]


def _nanoseconds(samples):
    return samples.seconds[1]


_STAMP = {'sec': _seconds, 'nanosec': _nanoseconds}


def header(frame_id: str) -> dict[str, Any]:
    """Return std_msgs/Header: the samples' stamps, and a frame id."""
    return {'stamp': _STAMP, 'frame_id': frame_id}


def _transform(frame_id, child_frame_id, rotation, translation=None):
    return {
        'header': header(frame_id),
        'child_frame_id': child_frame_id,
        'transform': {'translation': translation, 'rotation': rotation},
    }


def _q_ib(samples):
    return samples.states.q_ib


def _q_lb(samples):
    return samples.states.q_lb


def _q_il(samples):
    return samples.states.orbit.lvlh(samples.states.orbit_s)


def _omega_bi_b(samples):
    return samples.states.omega_bi_b


def _r_i(samples):
    return samples.states.r_i


def _v_b(samples):
    return rotation.rotate(rotation.conjugate(samples.states.q_ib), samples.states.v_i)


def _gravity_gradient(samples):
    states = samples.states
    gradient = states.orbit.gradient_at(states.orbit_s)
    return gradient_torque(samples.system.inertia, states.c_b, gradient)


def _rotor_angle(i):
    return lambda samples: samples.states.rotor_angle[:, i]


def _rotor_speed(i):
    return lambda samples: samples.states.rotor_speed[:, i]


def _rotor_torque(i):
    def effort(samples):
        is_motor = samples.system.rotors[i].mode == 'motor'
        return samples.system.rotor_torque[i] if is_motor else np.nan

    return effort


def _torques(inputs):
    return inputs.torques


def _torque_of(i):
    return lambda inputs: inputs.torques[:, i]

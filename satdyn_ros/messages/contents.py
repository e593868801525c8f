"""
The content of each topic's messages, as input to cdr.Message.

Each reads like its message: constants stand as they are, and what changes from tick to tick is a
function of the samples.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..dynamics.system import System
from ..kernel import rotation
from ..run.scenario import Frames
from ..run.topics import Topic
from ..torques.thrust import thrust_of
from . import cdr, markers


class _Layout(NamedTuple):
    """
    What is alike in the messages of a type.

    fields: those of the quantities that a topic shows, in its order, and more that it may not
    show.  constants: what else differs
    from the message's defaults, given the frames.
    """

    fields: tuple[str, ...]
    constants: Callable[[Frames], dict[str, Any]] = lambda frames: {}


_LAYOUTS = {
    'geometry_msgs/msg/QuaternionStamped': _Layout(('quaternion',)),
    'geometry_msgs/msg/VelocityStamped': _Layout(
        ('velocity.angular',),
        lambda frames: {'body_frame_id': frames.body, 'reference_frame_id': frames.inertial},
    ),
    'geometry_msgs/msg/WrenchStamped': _Layout(('wrench.torque', 'wrench.force')),
    'nav_msgs/msg/Odometry': _Layout(
        (
            'pose.pose.orientation',
            'twist.twist.angular',
            'pose.pose.position',
            'twist.twist.linear',
        ),
        lambda frames: {'child_frame_id': frames.body},
    ),
    'geometry_msgs/msg/Vector3Stamped': _Layout(('vector',)),
    'sensor_msgs/msg/Illuminance': _Layout(('illuminance',)),
    'sensor_msgs/msg/MagneticField': _Layout(('magnetic_field',)),
    # A fix is valid from STATUS_FIX (0) on; the message's default is STATUS_UNKNOWN (-2).
    'sensor_msgs/msg/NavSatFix': _Layout(
        ('latitude', 'longitude', 'altitude'), lambda frames: {'status': {'status': 0}}
    ),
    # REP-145: a covariance of zeros is unknown, one that begins with -1 marks an absent quantity.
    'sensor_msgs/msg/Imu': _Layout(
        ('orientation', 'angular_velocity'),
        lambda frames: {'linear_acceleration_covariance': [-1.0, *[0.0] * 8]},
    ),
}


def fields(topic: Topic) -> dict[str, tuple[str, ...]]:
    """Return the fields of a topic's messages that hold what it shows, and their columns."""
    if topic.name in _OF_THEIR_OWN or not topic.shows:
        return {}
    columns = (quantity.columns for quantity in topic.shows)
    if topic.fields:
        return {
            f'{field}[{i}]': (column,)
            for field, names in zip(topic.fields, columns, strict=True)
            for i, column in enumerate(names)
        }
    return dict(zip(_LAYOUTS[topic.type].fields, columns, strict=False))


def message(topic: Topic, frames: Frames, system: System) -> cdr.Message:
    """
    Return what packs samples of a system for a topic: pack(samples) -> rows (N,), each a message.

    ValueError: the system has no such topic, or the topic no constant layout.
    """
    if why := topic.lacking(system):
        raise ValueError(f'publish.topics has {topic.name} and {why}')
    if topic.name in _OF_THEIR_OWN:
        return cdr.Message(topic.type, _OF_THEIR_OWN[topic.name](frames, system))
    if topic.fields:
        return cdr.Message(topic.type, _joint_states(topic, frames))
    if not topic.shows:
        raise ValueError(f'{topic.name} has no constant layout; publish {topic.type} objects')
    return cdr.Message(topic.type, _of_quantities(topic, frames))


def geodetic_without_status(topic: Topic, frames: Frames) -> dict[str, Any]:
    """Return sensor_msgs/NavSatFix as in bags of rules below 4, with the default status."""
    return _of_quantities(topic, frames) | {'status': {}}


def _joint_states(topic, frames):
    """Return sensor_msgs/JointState of what a topic shows of its joints."""
    content = {'header': header(getattr(frames, topic.frame)), 'name': [*topic.joints]}
    for field, quantity in zip(topic.fields, topic.shows, strict=True):
        content[field] = [_component(quantity, i) for i in range(len(topic.joints))]
    return content


def _component(quantity, i):
    return lambda samples: quantity.of(samples)[:, i]


def _of_quantities(topic, frames):
    layout = _LAYOUTS[topic.type]
    content = {'header': header(getattr(frames, topic.frame)), **layout.constants(frames)}
    for path, quantity in zip(layout.fields, topic.shows, strict=False):
        fill(content, path, _column(quantity))
    return content


def _column(quantity):
    if len(quantity.columns) != 1:
        return quantity.of
    return lambda samples: quantity.of(samples)[:, 0]


def fill(content: dict[str, Any], path: str, column: Any) -> None:
    """Let content have a column, or columns, at a path, such as 'wrench.torque'."""
    *outer, last = path.split('.')
    for name in outer:
        content = content.setdefault(name, {})
    content[last] = column


def _rotor(frames: Frames, system: System) -> dict[str, Any]:
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


def _thruster(frames: Frames, system: System) -> dict[str, Any]:
    """Return sensor_msgs/JointState: of each thruster thrust and propellant used."""
    names = [*thrust_of(system).thrusters]
    return {
        'header': header(frames.body),
        'name': names,
        'position': [_propellant(k) for k in range(len(names))],
        'effort': [_thrust(k) for k in range(len(names))],
    }


def _propellant(k):
    return lambda samples: thrust_of(samples.system).propellant_used(samples.states.orbit_s)[:, k]


def _thrust(k):
    return lambda samples: thrust_of(samples.system).thrusts(samples.states.orbit_s)[:, k]


def _markers(frames: Frames, system: System) -> dict[str, Any]:
    return markers.content(header(frames.body), system)


def _tf(frames: Frames, system: System) -> dict[str, Any]:
    """Return tf2_msgs/TFMessage: inertial to LVLH and Earth, where they are, and to body."""
    transforms = []
    if system.orbit.has_lvlh:
        transforms.append(_transform(frames.inertial, frames.orbital, _q_il, _r_i))
    if frames.has_earth and system.environment is not None:
        transforms.append(_transform(frames.inertial, frames.earth, _q_ie))
    transforms.append(_transform(frames.inertial, frames.body, _q_ib, _r_i))
    return {'transforms': transforms}


def _tf_static(frames: Frames, system: System) -> dict[str, Any]:
    """Return tf2_msgs/TFMessage: body to each sensor."""
    mounted = [_transform(frames.body, frame_id, q_bs) for frame_id, q_bs in frames.sensors]
    return {'transforms': mounted}


def tf_with_sensors(frames: Frames, system: System) -> dict[str, Any]:
    """Return tf2_msgs/TFMessage as in bags of the rules 0 and 1, whose tf has the sensors."""
    parts = _tf(frames, system), _tf_static(frames, system)
    return {'transforms': [transform for part in parts for transform in part['transforms']]}


def _clock(frames: Frames, system: System) -> dict[str, Any]:
    """Return rosgraph_msgs/Clock: the stamp."""
    return {'clock': _STAMP}


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


def _q_il(samples):
    return samples.states.orbit.lvlh(samples.states.orbit_s)


def _q_ie(samples):
    return rotation.from_matrix(samples.to_itrs.swapaxes(-1, -2))


def _r_i(samples):
    return samples.states.r_i


def _rotor_angle(i):
    return lambda samples: samples.states.rotor_angle[:, i]


def _rotor_speed(i):
    return lambda samples: samples.states.rotor_speed[:, i]


def _rotor_torque(i):
    def effort(samples):
        torques = samples.states.rotor_torque
        if torques is not None:
            return torques[:, i]
        is_motor = samples.system.rotors[i].mode == 'motor'
        return samples.system.rotor_torque[i] if is_motor else np.nan

    return effort


# Of topics whose messages hold more, or other, than quantities.
_OF_THEIR_OWN: dict[str, Callable[[Frames, System], dict[str, Any]]] = {
    'rotor': _rotor,
    'thruster': _thruster,
    'markers': _markers,
    '/tf': _tf,
    '/tf_static': _tf_static,
    '/clock': _clock,
}

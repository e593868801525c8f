"""The messages that come in, one by one: torques on body and rotors, dipoles of torquers."""

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from ..dynamics.system import System
from ..run.scenario import Frames
from ..run.topics import MAGNETORQUERS, TOPICS
from . import cdr, contents

# The input of version 0.1 in place of rotor_command: the motor torque on its one rotor.
ROTOR_TORQUE = cdr.Message('std_msgs/msg/Float64', contents.rotor_torque_input())
# For the messages that are the same with any.
_ANY = System(np.eye(3))


def pack_torque(stamp_ns: int, torque_b: Sequence[float] | np.ndarray, frames: Frames) -> bytes:
    """Return the message of the input torque: torque_b (3,) [N m] in body axes."""
    return _pack('torque', stamp_ns, torque_b, frames)


def pack_dipole(stamp_ns: int, dipole_b: Sequence[float] | np.ndarray, frames: Frames) -> bytes:
    """Return the message of magnetorquer_command: dipole_b (3,) [A m^2] in body axes."""
    return _pack(MAGNETORQUERS, stamp_ns, dipole_b, frames)


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


@cache
def _command_packer(frames, names):
    return cdr.Message(TOPICS['rotor_command'].type, contents.rotor_command(frames, names))


def _pack(name, stamp_ns, vector, frames):
    inputs = contents.Inputs(np.array([stamp_ns]), np.array([vector], float))
    return _packer(name, frames).pack(inputs).tobytes()


@cache
def _packer(name, frames):
    return contents.message(TOPICS[name], frames, _ANY)

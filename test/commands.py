"""Commands, by the names that they have on the textbook page."""

from satdyn_ros.actuators import Command
from satdyn_ros.actuators.wheels import MotorCommands


def torque_command(tick, torque_b, until_tick=None, topic='torque'):
    """Return a torque on the body [N m] (3,), body axes."""
    return Command(tick, topic, torque_b, until_tick)


def motor_command(tick, torques=None, until_tick=None, speeds=None):
    """Return torques [N m] or speeds [rad/s] of motors, by rotor."""
    return Command(tick, 'rotor_command', MotorCommands(torques or {}, speeds or {}), until_tick)


def thruster_command(tick, **on_times):
    """Return on-times [s], by thruster."""
    return Command(tick, 'thruster_command', on_times)


def dipole_command(tick, dipole_b, until_tick=None):
    """Return a dipole of the magnetorquers [A m^2] (3,), body axes."""
    return Command(tick, 'magnetorquer_command', dipole_b, until_tick)

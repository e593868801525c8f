"""The context in which a process takes part in ROS."""

import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import rclpy
from rclpy.context import Context
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.signals import SignalHandlerOptions


def init(arguments: Sequence[str] = (), context: Context | None = None) -> None:
    """
    Initialise a context, by default that of the process, without handlers of signals.

    arguments: the name of the program, --ros-args and what follows.  OSError: ROS cannot write its
    log.
    """
    # A service of the system has no HOME, and ROS looks nowhere else for the home directory.
    if not os.environ.get('HOME'):
        # The user of a container may have none.
        with suppress(RuntimeError):
            os.environ['HOME'] = str(Path.home())
    try:
        rclpy.init(
            args=list(arguments), context=context, signal_handler_options=SignalHandlerOptions.NO
        )
    except rclpy_implementation.RCLError as error:
        if 'log directory' not in str(error) and 'logging directory' not in str(error):
            raise
        raise OSError(
            f'ROS has no folder for its log; ROS_LOG_DIR must name one to write to: {error}'
        ) from error

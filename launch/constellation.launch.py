"""
Many satellites from one parameter file, a node for each of its sections /namespace/node.

Each reads what is under /** and what is under its own section, and has frames of its own
in the common inertial one: sat1/lvlh and sat1/base_link for /sat1/satdyn.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from satdyn_ros.ros.launching import constellation

CONFIG = Path(__file__).parent.parent / 'config'


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'params_file',
                default_value=str(CONFIG / 'constellation.yaml'),
                description='a ROS 2 parameter file with a section /namespace/node per satellite',
            ),
            OpaqueFunction(function=start),
        ]
    )


def start(context):
    """Return a node for each satellite of the file."""
    params_file = LaunchConfiguration('params_file').perform(context)
    return [Node(**keywords) for keywords in constellation(params_file)]

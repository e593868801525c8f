"""
Many satellites from one parameter file, a node for each of its sections /namespace/node.

Each reads what is under /** and what is under its own section, and has frames of its own
in the common inertial one: sat1/lvlh and sat1/base_link for /sat1/satdyn.
"""

from pathlib import Path

import yaml
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

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
    """Return a node for each section of the file but /**."""
    params_file = LaunchConfiguration('params_file').perform(context)
    sections = yaml.safe_load(Path(params_file).read_text())
    return [satellite(name, params_file) for name in sections if name != '/**']


def satellite(full_name, params_file):
    """Return the node of the satellite with this full name."""
    namespace, _, name = full_name.rpartition('/')
    prefix = namespace.strip('/')
    frames = {'frames.orbital': f'{prefix}/lvlh', 'frames.body': f'{prefix}/base_link'}
    return Node(
        package='satdyn_ros',
        executable='satdyn_node',
        namespace=namespace,
        name=name,
        parameters=[frames, params_file],
        output='screen',
    )

"""One satellite, with RViz, the live page or the Foxglove bridge beside it if wanted."""

from functools import partial
from pathlib import Path

from ament_index_python.resources import has_resource
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from satdyn_ros.ros.launching import composed, one_satellite, page_hindrance

CONFIG = Path(__file__).parent.parent / 'config'
ACTIONS = {'Node': Node, 'ExecuteProcess': ExecuteProcess}
SWITCH = {'default_value': 'false', 'choices': ['true', 'false']}
ARGUMENTS = [
    DeclareLaunchArgument(
        'params_file',
        default_value=str(CONFIG / 'default.yaml'),
        description='the scenario: a ROS 2 parameter file, or the name of a shipped one',
    ),
    DeclareLaunchArgument(
        'namespace',
        default_value='',
        description='of the node, which chooses the satellite where params_file has several',
    ),
    DeclareLaunchArgument(
        'record',
        default_value='',
        choices=['', 'true', 'false'],
        description='whether to record from the first tick; empty: as params_file says',
    ),
    DeclareLaunchArgument(
        'rate', default_value='', description='publish.rate [Hz]; empty: as params_file says'
    ),
    DeclareLaunchArgument('rviz', **SWITCH, description='start RViz'),
    DeclareLaunchArgument(
        'watch',
        **SWITCH,
        description='serve the live page of satdyn watch on http://127.0.0.1:8090/',
    ),
    DeclareLaunchArgument(
        'foxglove',
        **SWITCH,
        description='start the Foxglove bridge; config/foxglove_layout.json shows the scene',
    ),
]


def generate_launch_description():
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=start)])


def start(context):
    """Return what to start for the arguments' values."""
    given = {each.name: LaunchConfiguration(each.name).perform(context) for each in ARGUMENTS}
    pushed = LaunchConfiguration('ros_namespace', default='').perform(context)
    given['namespace'] = composed(pushed, given['namespace'])
    actions = one_satellite(
        **given,
        rviz_config=str(CONFIG / 'satdyn.rviz'),
        is_installed=partial(has_resource, 'packages'),
        page_hindrance=page_hindrance,
    )
    return [ACTIONS[action](**keywords) for action, keywords in actions]

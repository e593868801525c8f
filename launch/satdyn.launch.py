"""One satellite, with RViz or the Foxglove bridge beside it if wanted."""

import sys
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from satdyn_ros import Scenario

CONFIG = Path(__file__).parent.parent / 'config'
ARGUMENTS = [
    DeclareLaunchArgument(
        'params_file',
        default_value=str(CONFIG / 'default.yaml'),
        description='the scenario: a ROS 2 parameter file',
    ),
    DeclareLaunchArgument('namespace', default_value='', description='of the node'),
    DeclareLaunchArgument(
        'record',
        default_value='',
        choices=['', 'true', 'false'],
        description='whether to record from the first tick; empty: as params_file says',
    ),
    DeclareLaunchArgument(
        'rate', default_value='', description='publish.rate [Hz]; empty: as params_file says'
    ),
    DeclareLaunchArgument(
        'rviz', default_value='false', choices=['true', 'false'], description='start RViz'
    ),
    DeclareLaunchArgument(
        'watch',
        default_value='false',
        choices=['true', 'false'],
        description='serve the live page of satdyn watch on http://127.0.0.1:8090/',
    ),
    DeclareLaunchArgument(
        'foxglove',
        default_value='false',
        choices=['true', 'false'],
        description='start the Foxglove bridge; config/foxglove_layout.json shows the scene',
    ),
]


def generate_launch_description():
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=start)])


def start(context):
    """Return the nodes for the arguments' values."""
    given = {
        argument.name: LaunchConfiguration(argument.name).perform(context)
        for argument in ARGUMENTS
    }
    namespace, params_file = given['namespace'], given['params_file']
    rviz, foxglove = given['rviz'] == 'true', given['foxglove'] == 'true'
    if rviz:
        check_installed('rviz2', 'rviz')
    if foxglove:
        check_installed('foxglove_bridge', 'foxglove')

    overrides = {}
    if given['record']:
        overrides['record.enabled'] = given['record'] == 'true'
    if given['rate']:
        try:
            overrides['publish.rate'] = float(given['rate'])
        except ValueError:
            raise ValueError(f'rate is {given["rate"]!r}; it must be a number [Hz]') from None
    scenario = Scenario.from_yaml(params_file)
    if rviz or foxglove:
        shown = dict.fromkeys([*scenario.topics, 'markers', 'tf'])
        overrides['publish.topics'] = list(shown)

    nodes = [
        Node(
            package='satdyn_ros',
            executable='satdyn_node',
            namespace=namespace,
            parameters=[params_file, overrides] if overrides else [params_file],
            output='screen',
        )
    ]
    if rviz:
        frames = scenario.frames
        frame = frames.inertial if scenario.is_fixed else frames.orbital
        nodes.append(
            Node(
                package='rviz2',
                executable='rviz2',
                namespace=namespace,
                arguments=[
                    '--display-config',
                    str(CONFIG / 'satdyn.rviz'),
                    '--fixed-frame',
                    frame,
                ],
            )
        )
    if given['watch'] == 'true':
        name = '/'.join(['', *filter(None, namespace.split('/')), 'satdyn'])
        command = [sys.executable, '-m', 'satdyn_ros.cli.main', 'watch', '--node', name]
        nodes.append(ExecuteProcess(cmd=command, output='screen'))
    if foxglove:
        nodes.append(Node(package='foxglove_bridge', executable='foxglove_bridge'))
    return nodes


def check_installed(package, argument):
    """Raise unless a package is there: launch leaves running what started ahead of an error."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        raise ValueError(f'{argument} is true, but {package} is not installed') from None

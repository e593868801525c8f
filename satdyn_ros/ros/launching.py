"""What the launch files start: names of actions of launch, and their keyword arguments."""

import re
import sys
from collections.abc import Callable
from typing import Any

from ..base.ros_yaml import read_text
from ..run.parameter_file import parameters_of_section, parameters_of_yaml, sections_of_yaml
from ..run.scenario import Scenario
from ..run.shipped import scenario_path

_FULL_NAME = re.compile(r'(/[A-Za-z_][A-Za-z0-9_]*)+')


def one_satellite(
    params_file: str,
    namespace: str,
    record: str,
    rate: str,
    rviz: str,
    watch: str,
    foxglove: str,
    rviz_config: str,
    is_installed: Callable[[str], object],
) -> list[tuple[str, dict[str, Any]]]:
    """
    Return what satdyn.launch.py starts, in order, for the texts of its arguments.

    rviz_config: the path of RViz's configuration.  is_installed: whether there is a package of a
    name.  ValueError, in one sentence: a text is not allowed, or a package is missing.
    """
    # launch leaves running what started ahead of an error.
    for argument, given, package in (
        ('rviz', rviz, 'rviz2'),
        ('foxglove', foxglove, 'foxglove_bridge'),
    ):
        if given == 'true' and not is_installed(package):
            raise ValueError(f'{argument} is true, but {package} is not installed')

    overrides: dict[str, Any] = {}
    if record:
        overrides['record.enabled'] = record == 'true'
    if rate:
        overrides['publish.rate'] = _number(rate)
    path, text, origin = _read(params_file)
    scenario = Scenario({**parameters_of_yaml(text, origin), **overrides})
    if 'true' in (rviz, foxglove):
        overrides['publish.topics'] = list(dict.fromkeys([*scenario.topics, 'markers', 'tf']))

    actions: list[tuple[str, dict[str, Any]]] = [
        (
            'Node',
            {
                'package': 'satdyn_ros',
                'executable': 'satdyn_node',
                'namespace': namespace,
                'parameters': [path, overrides] if overrides else [path],
                'output': 'screen',
            },
        )
    ]
    if rviz == 'true':
        frames = scenario.frames
        frame = frames.inertial if scenario.is_fixed else frames.orbital
        shown = ['--display-config', rviz_config, '--fixed-frame', frame]
        node = {'package': 'rviz2', 'executable': 'rviz2', 'namespace': namespace}
        actions.append(('Node', node | {'arguments': shown}))
    if watch == 'true':
        name = '/'.join(['', *filter(None, namespace.split('/')), 'satdyn'])
        command = [sys.executable, '-m', 'satdyn_ros.cli.main', 'watch', '--node', name]
        actions.append(('ExecuteProcess', {'cmd': command, 'output': 'screen'}))
    if foxglove == 'true':
        bridge = {'package': 'foxglove_bridge', 'executable': 'foxglove_bridge'}
        actions.append(('Node', bridge))
    return actions


def constellation(params_file: str) -> list[dict[str, Any]]:
    """
    Return the keyword arguments of each Node of constellation.launch.py: one a satellite.

    ValueError, in one sentence: the file cannot be read, or names no satellite.
    """
    path, text, origin = _read(params_file)
    # By full name: /satdyn and satdyn are one.
    satellites: dict[str, dict[str, Any]] = {}
    for name, section in sections_of_yaml(text, origin).items():
        full_name = f'/{str(name).removeprefix("/")}'
        if '*' in full_name:
            continue
        if not _FULL_NAME.fullmatch(full_name):
            raise ValueError(
                f'{origin} has the section {name}; it must be named /** or /namespace/node'
            )
        own = satellites.setdefault(full_name, {})
        own.update(parameters_of_section(section, origin))
    if not satellites:
        raise ValueError(
            f'{origin} has no section of a satellite; it must have one that is named '
            '/namespace/node'
        )
    return [_satellite(full_name, own, path) for full_name, own in satellites.items()]


def _satellite(full_name, own, path):
    namespace, _, name = full_name.rpartition('/')
    prefix = namespace.removeprefix('/')
    frames = {'frames.orbital': f'{prefix}/lvlh', 'frames.body': f'{prefix}/base_link'}
    added = {key: frame for key, frame in frames.items() if namespace and key not in own}
    return {
        'package': 'satdyn_ros',
        'executable': 'satdyn_node',
        'namespace': namespace,
        'name': name,
        # The file first: rcl gives a section that comes later the last word, and launch gives what
        # is added a section of the satellite's name, which must not come ahead of /**.
        'parameters': [path, added] if added else [path],
        'output': 'screen',
    }


def _read(params_file):
    """Return the path, the text and the name in errors of a file, or of a shipped one by name."""
    try:
        path = scenario_path(params_file)
        return str(path), read_text(path, 'the scenario'), f'params_file: {path}'
    except ValueError as error:
        raise ValueError(f'params_file: {error}') from None


def _number(text):
    """Return a number, or the text that is none, which the check of its key refuses."""
    try:
        return float(text)
    except ValueError:
        return text

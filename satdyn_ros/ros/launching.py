"""What the launch files start: names of actions of launch, and their keyword arguments."""

import socket
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ..run.parameter_file import ParameterFile, scenario_text, without_rclpys
from ..run.scenario import Scenario
from ..run.shipped import scenario_path

# Of the live page.
_PORT = 8090


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
    page_hindrance: Callable[[], str],
) -> list[tuple[str, dict[str, Any]]]:
    """
    Return what satdyn.launch.py starts, in order, for the texts of its arguments.

    rviz_config: the path of RViz's configuration.  is_installed: whether there is a package of a
    name.  page_hindrance: what would end the live page at once.  ValueError, in one sentence: a
    text is not allowed, or what is to start cannot.
    """
    # launch leaves running what started ahead of an error.
    for argument, given, package in (
        ('rviz', rviz, 'rviz2'),
        ('foxglove', foxglove, 'foxglove_bridge'),
    ):
        if given == 'true' and not is_installed(package):
            raise ValueError(f'{argument} is true, but {package} is not installed')
    if watch == 'true' and (hindrance := page_hindrance()):
        raise ValueError(f'watch is true, but {hindrance}')

    overrides: dict[str, Any] = {}
    if record:
        overrides['record.enabled'] = record == 'true'
    if rate:
        overrides['publish.rate'] = _number(rate)
    path, file = _read(params_file)
    parts = [part for part in namespace.split('/') if part]
    full_name = '/'.join(['', *parts, 'satdyn']) if parts else file.full_name()
    scenario = Scenario({**without_rclpys(file.flown(full_name)), **overrides})
    if 'true' in (rviz, foxglove):
        overrides['publish.topics'] = list(dict.fromkeys([*scenario.topics, 'markers', 'tf']))

    actions: list[tuple[str, dict[str, Any]]] = [('Node', _node(full_name, path, overrides))]
    namespace = full_name.rpartition('/')[0]
    if rviz == 'true':
        frames = scenario.frames
        frame = frames.inertial if scenario.is_fixed else frames.orbital
        shown = ['--display-config', rviz_config, '--fixed-frame', frame]
        node = {'package': 'rviz2', 'executable': 'rviz2', 'namespace': namespace}
        actions.append(('Node', node | {'arguments': shown}))
    if watch == 'true':
        command = [sys.executable, '-m', 'satdyn_ros.cli.main', 'watch', '--node', full_name]
        command += ['--port', str(_PORT)]
        actions.append(('ExecuteProcess', {'cmd': command, 'output': 'screen'}))
    if foxglove == 'true':
        bridge = {'package': 'foxglove_bridge', 'executable': 'foxglove_bridge'}
        actions.append(('Node', bridge))
    return actions


def page_hindrance() -> str:
    """Return why satdyn watch cannot start here, or nothing."""
    if not find_spec('aiohttp'):
        return 'aiohttp is not installed'
    with socket.socket() as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(('127.0.0.1', _PORT))
        except OSError as error:
            return f'port {_PORT} cannot be used: {error.strerror}'
    return ''


def constellation(params_file: str) -> list[dict[str, Any]]:
    """
    Return the keyword arguments of each Node of constellation.launch.py: one a satellite.

    ValueError, in one sentence: the file cannot be read, or names no satellite, or one that is
    not allowed.
    """
    path, file = _read(params_file)
    if not file.satellites:
        raise ValueError(
            f'{file.origin} has no section of a satellite; it must have one that is named '
            '/namespace/node'
        )
    for name in file.satellites:
        try:
            Scenario(without_rclpys(file.flown(name)))
        except ValueError as error:
            raise ValueError(f'{file.origin}, {name}: {error}') from None
    return [_node(name, path) for name in file.satellites]


def _node(full_name, path, overrides=None):
    namespace, _, name = full_name.rpartition('/')
    node = {
        'package': 'satdyn_ros',
        'executable': 'satdyn_node',
        'namespace': namespace,
        'name': name,
        # Read by the node itself: rcl gives what stands in later sections of the file, or as an
        # integer, the last word over what launch adds.
        'arguments': ['--params-file', path],
        'output': 'screen',
    }
    return node | ({'parameters': [overrides]} if overrides else {})


def _read(params_file):
    """Return the path of a file, or of a shipped one by name, and what it says."""
    try:
        path = str(scenario_path(params_file))
        text = scenario_text(path)
    except ValueError as error:
        raise ValueError(f'params_file: {error}') from None
    origin = f'params_file: {path}'
    return path, ParameterFile.of_texts([(text, origin)], {origin: Path(path).parent})


def _number(text):
    """Return a number, or the text that is none, which the check of its key refuses."""
    try:
        return float(text)
    except ValueError:
        return text

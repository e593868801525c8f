"""What the launch files start: names of actions of launch, and their keyword arguments."""

import socket
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ..run.parameter_file import ParameterFile, folder_of, scenario_text, without_rclpys
from ..run.scenario import Scenario
from ..run.shipped import scenario_path

# Of the live page.
_PORT = 8090
_BRIDGE = {'package': 'foxglove_bridge', 'executable': 'foxglove_bridge'}


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

    Parameters
    ----------
    params_file, namespace, record, rate, rviz, watch, foxglove : str
        the arguments of satdyn.launch.py
    rviz_config : str
        the path of RViz's configuration
    is_installed : function
        of a name: whether there is a package of it
    page_hindrance : function
        returns what would end the live page at once, empty: nothing

    Raises
    ------
    ValueError
        a text is not allowed, or what is to start cannot; in one sentence
    """
    given = {'rviz': rviz, 'watch': watch, 'foxglove': foxglove}
    beside = [name for name, text in given.items() if text == 'true']
    _check_can_start(beside, is_installed, page_hindrance)
    path, file = _read(params_file)
    parts = [part for part in namespace.split('/') if part]
    full_name = '/'.join(['', *parts, 'satdyn']) if parts else file.full_name()
    section = _section(file, full_name)
    overrides = _overrides(record, rate)
    scenario = Scenario({**without_rclpys(file.flown(full_name, section)), **overrides})
    if {'rviz', 'foxglove'} & {*beside}:
        overrides['publish.topics'] = list(dict.fromkeys([*scenario.topics, 'markers', 'tf']))
    namespace, _, name = full_name.rpartition('/')
    node = _node(namespace, name, path, overrides)
    if section != full_name:
        node['arguments'] += ['--section', section]
    actions: list[tuple[str, dict[str, Any]]] = [('Node', node)]
    if 'rviz' in beside:
        actions.append(('Node', _rviz(scenario, namespace, rviz_config)))
    if 'watch' in beside:
        actions.append(('ExecuteProcess', _page(full_name)))
    if 'foxglove' in beside:
        actions.append(('Node', _BRIDGE))
    return actions


def _overrides(record, rate):
    """Return what takes the place of what the file says, by key."""
    overrides: dict[str, Any] = {}
    if record:
        overrides['record.enabled'] = record == 'true'
    if rate:
        overrides['publish.rate'] = _number(rate)
    return overrides


def _check_can_start(beside, is_installed, page_hindrance):
    """Refuse what would fail, since launch leaves running what started ahead of an error."""
    for argument, package in (('rviz', 'rviz2'), ('foxglove', 'foxglove_bridge')):
        if argument in beside and not is_installed(package):
            raise ValueError(f'{argument} is true, but {package} is not installed')
    if 'watch' in beside and (hindrance := page_hindrance()):
        raise ValueError(f'watch is true, but {hindrance}')


def _rviz(scenario, namespace, config):
    frames = scenario.frames
    frame = frames.inertial if scenario.is_fixed else frames.orbital
    shown = ['--display-config', config, '--fixed-frame', frame]
    node = {'package': 'rviz2', 'executable': 'rviz2', 'namespace': namespace}
    return node | {'arguments': shown}


def _page(full_name):
    command = [sys.executable, '-m', 'satdyn_ros.cli.main', 'watch', '--node', full_name]
    command += ['--port', str(_PORT)]
    return {'cmd': command, 'output': 'screen'}


def composed(pushed: str, namespace: str) -> str:
    """Return a namespace below one that is pushed, '': none is; one that is absolute stays."""
    return namespace if namespace.startswith('/') else f'{pushed}/{namespace}'


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

    Their namespaces are relative, so that launch puts a pushed one before them.  ValueError, in
    one sentence: the file cannot be read, or names no satellite, or one that is not allowed.
    """
    path, file = _read(params_file)
    if not file.satellites:
        raise ValueError(
            f'{file.origin} has no section of a satellite; it must have one that is named '
            '/namespace/node'
        )
    nodes = []
    for full_name in file.satellites:
        try:
            scenario = Scenario(without_rclpys(file.flown(full_name)))
        except ValueError as error:
            raise ValueError(f'{file.origin}, {full_name}: {error}') from None
        namespace, _, name = full_name.lstrip('/').rpartition('/')
        bags = Path(scenario['record.directory'], folder_of(full_name))
        of_many = {'record.directory': str(bags)} if file.satellites[1:] else {}
        node = _node(namespace, name, path, of_many)
        node['arguments'] += ['--section', full_name]
        nodes.append(node)
    return nodes


def _section(file, full_name):
    """Return the satellite of a file that a node in pushed namespaces flies, or its own name."""
    parts = full_name.split('/')
    tails = [f'/{"/".join(parts[i:])}' for i in range(1, len(parts) - 1)]
    return next((name for name in tails if name in file.satellites), full_name)


def _node(namespace, name, path, overrides):
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

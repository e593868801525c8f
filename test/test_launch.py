"""The launch files: parsed everywhere, and their nodes built where launch_ros is installed."""

import ast
import importlib
import inspect
import json
import runpy
from pathlib import Path
from typing import Any

import pytest
import yaml
from rosbags.typesys import Stores, get_typestore

from satdyn_ros.ros.launching import constellation, one_satellite
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.topics import TOPICS

ROOT = Path(__file__).parent.parent
CONFIG = ROOT / 'config'


def parse(name):
    return ast.parse((ROOT / 'launch' / name).read_text())


def calls(tree, function):
    """Return the calls of a function by its bare name, in order."""
    return [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, 'id', None) == function
    ]


@pytest.mark.parametrize(
    ('name', 'arguments', 'function'),
    [
        (
            'satdyn.launch.py',
            {'params_file', 'namespace', 'record', 'rate', 'rviz', 'watch', 'foxglove'},
            one_satellite,
        ),
        ('constellation.launch.py', {'params_file'}, constellation),
    ],
)
def test_arguments_are_declared(name, arguments, function):
    """What the documentation offers as NAME:=VALUE is declared, described and understood."""
    declared = calls(parse(name), 'DeclareLaunchArgument')
    assert {call.args[0].value for call in declared} == arguments
    assert all('description' in {keyword.arg for keyword in call.keywords} for call in declared)
    understood = set(inspect.signature(function).parameters)
    assert understood - {'rviz_config', 'is_installed', 'page_hindrance'} == arguments


DECIDES = (
    ast.If,
    ast.IfExp,
    ast.BoolOp,
    ast.Compare,
    ast.Match,
    ast.For,
    ast.While,
    ast.Try,
    ast.With,
    ast.Lambda,
)


@pytest.mark.parametrize('name', ['satdyn.launch.py', 'constellation.launch.py'])
def test_a_file_only_calls(name):
    """It decides nothing, so that what it starts is tested where launch is not installed."""
    tree = list(ast.walk(parse(name)))
    assert [ast.unparse(node) for node in tree if isinstance(node, DECIDES)] == []
    assert [node.ifs for node in tree if isinstance(node, ast.comprehension) and node.ifs] == []
    own = [
        (str(node.module), alias.name)
        for node in tree
        if isinstance(node, ast.ImportFrom) and (node.module or '').startswith('satdyn_ros.')
        for alias in node.names
    ]
    assert own
    for module, function in own:
        assert callable(getattr(importlib.import_module(module), function))


@pytest.mark.parametrize('name', ['satdyn.launch.py', 'constellation.launch.py'])
def test_files_it_names_exist(name):
    """No launch file points at a configuration that is not shipped."""
    named = [
        node.value
        for node in ast.walk(parse(name))
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and Path(node.value).suffix in {'.yaml', '.rviz'}
    ]
    assert named
    assert [file for file in named if not (CONFIG / file).is_file()] == []


def started(name, **arguments):
    """Return the nodes of a launch file, built where launch_ros is installed."""
    pytest.importorskip(
        'launch_ros', reason=f'{name} is not run here: launch is in no wheel of ROS 2'
    )
    from launch import LaunchContext

    description = runpy.run_path(str(ROOT / 'launch' / name))['generate_launch_description']()
    context = LaunchContext()
    for argument in description.get_launch_arguments():
        default = ''.join(part.text for part in argument.default_value)
        context.launch_configurations[argument.name] = default
    context.launch_configurations.update(arguments)
    return description.entities[-1].visit(context)


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """Return the folder whose files are the names of the installed packages."""
    index = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    return index


@pytest.mark.parametrize(
    ('name', 'arguments', 'nodes'),
    [
        ('satdyn.launch.py', {}, 1),
        ('satdyn.launch.py', {'rviz': 'true', 'foxglove': 'true', 'watch': 'true'}, 4),
        ('constellation.launch.py', {}, 8),
    ],
)
def test_nodes_are_built(packages, name, arguments, nodes):
    """The file yields a node for everything it promises."""
    for package in ('rviz2', 'foxglove_bridge'):
        (packages / package).touch()
    assert len(started(name, **arguments)) == nodes


@pytest.mark.parametrize(
    ('argument', 'package'), [('rviz', 'rviz2'), ('foxglove', 'foxglove_bridge')]
)
def test_nothing_starts_where_a_package_is_missing(packages, argument, package):
    """Launch would leave running, without a word, what had started ahead of the error."""
    (packages / {'rviz2': 'foxglove_bridge', 'foxglove_bridge': 'rviz2'}[package]).touch()
    with pytest.raises(ValueError, match=f'{argument} is true, but {package} is not installed'):
        started('satdyn.launch.py', rviz='true', foxglove='true')


@pytest.fixture
def layout():
    return json.loads((CONFIG / 'foxglove_layout.json').read_text())


def strings(node):
    """Return every string of a JSON tree, keys too."""
    if isinstance(node, dict):
        yield from node
        node = list(node.values())
    if isinstance(node, list):
        for value in node:
            yield from strings(value)
    elif isinstance(node, str):
        yield node


def test_foxglove_layout_shows_published_topics(layout):
    """Every panel's topic is one of the node or its sensors, every field one of its message."""
    store = get_typestore(Stores.ROS2_JAZZY)
    topics = Scenario.from_yaml('cubesat_leo').topic_table.values()
    types = {f'/{topic.name.lstrip("/")}': topic.type for topic in topics}
    paths = [text for text in strings(layout['configById']) if text.startswith('/')]
    assert len(paths) > 10
    for path in paths:
        topic, *fields = path.partition('.@')[0].split('.')
        message: Any = types[topic]
        for field in fields:
            _, detail = dict(store.get_msgdef(message).fields)[field.partition('[')[0]]
            message = detail if isinstance(detail, str) else detail[0]


def test_foxglove_layout_places_every_panel(layout):
    """No panel is configured and not shown, or shown and not configured, on a tab too."""
    arrangement = {'row', 'column', 'direction', 'splitPercentage', 'first', 'second'}
    panels = layout['configById'].values()
    shown = [
        layout['layout'],
        *(tab['layout'] for panel in panels for tab in panel.get('tabs', [])),
    ]
    assert set(strings(shown)) - arrangement == set(layout['configById'])


def test_rviz_config_shows_published_topics():
    """Every display subscribes to a topic of the node with the type that it draws."""
    manager = yaml.safe_load((CONFIG / 'satdyn.rviz').read_text())['Visualization Manager']
    drawn = {
        display['Topic']['Value']: display['Class'].partition('/')[2]
        for display in manager['Displays']
        if 'Topic' in display
    }
    assert set(drawn) == {'markers', 'odometry'}
    for topic, display in drawn.items():
        assert TOPICS[topic].type.endswith(f'/{display}')

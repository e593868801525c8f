"""The launch files: parsed everywhere, and their nodes built where launch_ros is installed."""

import ast
import importlib.util
import json
from pathlib import Path

import pytest
import yaml
from rosbags.typesys import Stores, get_typestore

from satdyn_ros.messages.topics import TOPICS

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
    ('name', 'arguments'),
    [
        (
            'satdyn.launch.py',
            {'params_file', 'namespace', 'record', 'rate', 'rviz', 'watch', 'foxglove'},
        ),
        ('constellation.launch.py', {'params_file'}),
    ],
)
def test_arguments_are_declared(name, arguments):
    """What the documentation offers as NAME:=VALUE is what the file declares, each described."""
    declared = calls(parse(name), 'DeclareLaunchArgument')
    assert {call.args[0].value for call in declared} == arguments
    assert all('description' in {keyword.arg for keyword in call.keywords} for call in declared)


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


@pytest.mark.parametrize(
    ('name', 'nodes'), [('satdyn.launch.py', 3), ('constellation.launch.py', 8)]
)
def test_nodes_are_built(name, nodes):
    """Where launch_ros is installed the file yields a node for everything it promises."""
    pytest.importorskip('launch_ros', reason='launch is not among the wheels of ROS 2')
    from launch import LaunchContext

    spec = importlib.util.spec_from_file_location('launch_file', ROOT / 'launch' / name)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    context = LaunchContext()
    context.launch_configurations.update(rviz='true', foxglove='true')
    built = [entity.visit(context) for entity in module.generate_launch_description().entities]
    assert len(built[-1]) == nodes


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
    """Every panel's topic is one the node publishes, and every field a field of its message."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {f'/{topic.name.lstrip("/")}': topic.type for topic in TOPICS.values()}
    paths = [text for text in strings(layout['configById']) if text.startswith('/')]
    assert len(paths) > 10
    for path in paths:
        topic, *fields = path.partition('.@')[0].split('.')
        message = types[topic]
        for field in fields:
            _, detail = dict(store.get_msgdef(message).fields)[field.partition('[')[0]]
            message = detail if isinstance(detail, str) else detail[0]


def test_foxglove_layout_places_every_panel(layout):
    """No panel is configured and not shown, or shown and not configured."""
    places = {'row', 'column', 'direction', 'splitPercentage', 'first', 'second'}
    assert set(strings(layout['layout'])) - places == set(layout['configById'])


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

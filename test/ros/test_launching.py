"""What the launch files start, without launch: it is data."""

import socket
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
import rclpy

from satdyn_ros.cli.command_line import parser
from satdyn_ros.ros.launching import composed, constellation, one_satellite, page_hindrance
from satdyn_ros.ros.parameters import given_parameters
from satdyn_ros.run import shipped
from satdyn_ros.run.keys import KEYS
from satdyn_ros.run.parameter_file import ParameterFile
from satdyn_ros.run.scenario import Scenario

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / 'config'
DEFAULT = str(CONFIG / 'default.yaml')
# As satdyn.launch.py has them where nothing is given.
TEXTS = {
    'params_file': DEFAULT,
    'namespace': '',
    'record': '',
    'rate': '',
    'rviz': 'false',
    'watch': 'false',
    'foxglove': 'false',
}


def started(installed=('rviz2', 'foxglove_bridge'), hindrance='', **given):
    """Return the actions of one satellite where these packages are installed."""
    return one_satellite(
        **(TEXTS | given),
        rviz_config='of_rviz',
        is_installed=installed.__contains__,
        page_hindrance=lambda: hindrance,
    )


def overridden(**given):
    """Return what the node is given in place of what its file says."""
    (_, node), *_ = started(**given)
    assert node['arguments'] == ['--params-file', given.get('params_file', DEFAULT)]
    return dict(*node.get('parameters', []))


@pytest.fixture
def file(tmp_path):
    """Return a function that writes a parameter file and returns its path."""

    def write(text):
        path = tmp_path / 'given.yaml'
        path.write_text(text)
        return str(path)

    return write


def test_the_launch_files_are_understood_without_ros():
    """Neither launch nor rclpy is loaded for it."""
    program = (
        'import sys, satdyn_ros.ros.launching\n'
        "print({'rclpy', 'launch', 'launch_ros'} & set(sys.modules) or 'none')"
    )
    result = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True)
    assert (result.returncode, result.stdout.strip()) == (0, 'none'), result.stderr


def test_a_node_alone_where_nothing_is_given():
    """Its file is all that it is given."""
    assert started() == [
        (
            'Node',
            {
                'package': 'satdyn_ros',
                'executable': 'satdyn_node',
                'namespace': '',
                'name': 'satdyn',
                'arguments': ['--params-file', DEFAULT],
                'output': 'screen',
            },
        )
    ]


def test_everything_beside_the_node(file):
    """In order: the node, RViz in its namespace, the live page, the Foxglove bridge."""
    path = file('/**: {ros__parameters: {publish.topics: [imu, tf]}}')
    beside = {'rviz': 'true', 'watch': 'true', 'foxglove': 'true'}
    actions = started(params_file=path, namespace='sat1', **beside)
    assert [action for action, _ in actions] == ['Node', 'Node', 'ExecuteProcess', 'Node']
    node, rviz, watch, bridge = (keywords for _, keywords in actions)
    assert (node['namespace'], node['name']) == ('/sat1', 'satdyn')
    assert node['arguments'] == ['--params-file', path]
    assert node['parameters'] == [{'publish.topics': ['imu', 'tf', 'markers']}]
    assert rviz == {
        'package': 'rviz2',
        'executable': 'rviz2',
        'namespace': '/sat1',
        'arguments': ['--display-config', 'of_rviz', '--fixed-frame', 'sat1/lvlh'],
    }
    assert watch['output'] == 'screen'
    assert watch['cmd'][:3] == [sys.executable, '-m', 'satdyn_ros.cli.main']
    assert bridge == {'package': 'foxglove_bridge', 'executable': 'foxglove_bridge'}


@pytest.mark.parametrize('argument', ['rviz', 'foxglove'])
def test_what_draws_the_scene_gets_its_topics(argument):
    """Each of the two needs the markers and the transforms, beside what the file has."""
    topics = overridden(**{argument: 'true'})['publish.topics']
    assert topics == [*Scenario.from_yaml(DEFAULT).topics, 'markers', 'tf']
    assert Scenario({'publish.topics': topics}).topics == tuple(topics)


@pytest.mark.parametrize('namespace', ['fleet/sat1', '/fleet/sat1', '/fleet/sat1/'])
def test_the_live_page_finds_the_node(namespace):
    """By its full name, in a command that there is."""
    _, (_, keywords) = started(watch='true', namespace=namespace)
    given = parser().parse_args(keywords['cmd'][3:])
    assert (given.command, given.node) == ('watch', '/fleet/sat1/satdyn')
    _, (_, keywords) = started(watch='true')
    assert '/satdyn' in keywords['cmd']


def test_rviz_looks_from_a_frame_that_the_node_sends(file):
    """LVLH under the file's name for it; where there is none, the inertial one."""
    renamed = file('/**: {ros__parameters: {frames: {orbital: o, inertial: i}}}')
    _, (_, rviz) = started(rviz='true', params_file=renamed)
    assert rviz['arguments'][-1] == 'o'
    fixed = file('/**: {ros__parameters: {orbit: {type: fixed}, frames: {inertial: i}}}')
    _, (_, rviz) = started(rviz='true', params_file=fixed)
    assert rviz['arguments'][-1] == 'i'


def test_arguments_take_the_place_of_what_the_file_says():
    """Each as its key has it: a truth, a number."""
    assert overridden(record='true') == {'record.enabled': True}
    assert overridden(record='false', rate='50') == {'record.enabled': False, 'publish.rate': 50.0}
    assert type(overridden(rate='50')['publish.rate']) is float


@pytest.mark.parametrize(
    ('rate', 'shown'),
    [
        ('-5', '-5.0'),
        ('0', '0.0'),
        ('nan', 'nan'),
        ('inf', 'inf'),
        ('1e9', '1000000000.0'),
        ('abc', "'abc'"),
    ],
)
def test_a_rate_that_is_not_allowed_is_refused(rate, shown):
    """By the sentence that the key has, before anything starts."""
    with pytest.raises(ValueError) as refused:
        started(rate=rate)
    allowed = KEYS['publish.rate'].allowed
    assert allowed.startswith('a number above 0')
    assert str(refused.value) == f'publish.rate is {shown}; it must be {allowed}'


def test_the_rate_given_is_the_one_that_is_judged(file):
    """One that the file must not have does no harm where it is not used, as for the node."""
    path = file('/**: {ros__parameters: {publish: {rate: -1.0}}}')
    assert overridden(params_file=path, rate='20') == {'publish.rate': 20.0}
    with pytest.raises(ValueError, match=r'publish.rate is -1.0; it must be a number'):
        started(params_file=path)


@pytest.mark.parametrize(
    ('argument', 'package', 'other'),
    [('rviz', 'rviz2', 'foxglove_bridge'), ('foxglove', 'foxglove_bridge', 'rviz2')],
)
def test_a_package_that_is_missing_is_named(argument, package, other):
    """With the argument that wants it; who does not want it does not need it."""
    with pytest.raises(ValueError, match=f'^{argument} is true, but {package} is not installed$'):
        started(installed=[other], rviz='true', foxglove='true')
    assert len(started(installed=[])) == 1


def test_nothing_starts_where_the_live_page_cannot():
    """It would die at once, and the node fly on; who does not want it does not need it."""
    with pytest.raises(ValueError, match=r'^watch is true, but the port is taken$'):
        started(watch='true', hindrance='the port is taken')
    assert len(started(hindrance='the port is taken')) == 1


def test_a_port_that_is_taken_hinders_the_live_page():
    """The one that the page would listen on."""
    pytest.importorskip('aiohttp', reason='without it there is no page')
    _, (_, keywords) = started(watch='true')
    port = parser().parse_args(keywords['cmd'][3:]).port
    with socket.socket() as listener:
        # Where another program has it already, it is as good as taken.
        with suppress(OSError):
            listener.bind(('127.0.0.1', port))
            listener.listen()
        assert page_hindrance() == f'port {port} cannot be used: Address already in use'


BOTH = pytest.mark.parametrize(
    'read', [lambda path: started(params_file=path), constellation], ids=['one', 'many']
)


@BOTH
@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('', 'is not a parameter file: it must have sections such as /**'),
        ('- 1', 'is not a parameter file: it must have sections such as /**'),
        ('/**: {', 'is not YAML at line '),
    ],
)
def test_a_file_that_is_no_parameter_file_is_refused(read, file, text, sentence):
    """One sentence names the argument, the file and what is wrong with it."""
    path = file(text)
    with pytest.raises(ValueError) as refused:
        read(path)
    assert str(refused.value).startswith(f'params_file: {path} {sentence}')
    assert '\n' not in str(refused.value)


@BOTH
def test_a_file_that_cannot_be_read_is_refused(read, tmp_path):
    """One that is missing, a folder, and a name that nothing has."""
    for path, reason in (
        (tmp_path / 'none.yaml', 'No such file or directory'),
        (tmp_path, 'it is a directory, not a file'),
    ):
        with pytest.raises(ValueError) as refused:
            read(str(path))
        assert str(refused.value) == f'params_file: the scenario {path} cannot be read: {reason}'
    for name in ('defualt', ''):
        with pytest.raises(ValueError, match=rf'^params_file: the scenario {name} is neither a f'):
            read(name)


@pytest.mark.parametrize('name', shipped.names())
def test_a_shipped_scenario_is_given_by_its_path(name):
    """In its log the node then says which file it read."""
    (_, node), *_ = started(params_file=name)
    assert node['arguments'] == ['--params-file', str(CONFIG / f'{name}.yaml')]


def test_the_constellation():
    """Eight nodes, each with its section, and its bags in a folder of its own."""
    path = str(CONFIG / 'constellation.yaml')
    nodes = constellation(path)
    assert nodes == [
        {
            'package': 'satdyn_ros',
            'executable': 'satdyn_node',
            'namespace': f'sat{k}',
            'name': 'satdyn',
            'arguments': ['--params-file', path, '--section', f'/sat{k}/satdyn'],
            'output': 'screen',
            'parameters': [{'record.directory': f'sat{k}'}],
        }
        for k in range(1, 9)
    ]
    assert constellation('constellation') == nodes


def test_each_satellite_gets_what_is_its_own():
    """What the node reads under its full name is what rcl would, and frames of its own."""
    for node in constellation('constellation'):
        option, path, *_ = node['arguments']
        listener = rclpy.create_node(
            node['name'], namespace=node['namespace'], cli_args=['--ros-args', option, path]
        )
        given = given_parameters(listener)
        full_name = listener.get_fully_qualified_name()
        listener.destroy_node()
        file = ParameterFile.read([path])
        assert given == file.parameters(full_name)
        own = {
            'frames.orbital': 'lvlh',
            'frames.body': 'base_link',
            'sensors.gyro.frame_id': 'gyro',
        }
        given |= {key: f'{full_name[1:5]}/{frame}' for key, frame in own.items()}
        assert file.flown(full_name) == given
        assert given['sensors.seed'] == int(full_name[4])


def test_the_namespace_chooses_the_satellite(file):
    """Its sections are checked, those of others are not; one that the file has is named by it."""
    path = file(
        '/**: {ros__parameters: {publish.rate: 10}}\n'
        '/sat1/satdyn: {ros__parameters: {publish.rate: 20}}\n'
        '/sat2/satdyn: {ros__parameters: {publish.rate: -1}}\n'
    )
    (_, node), *_ = started(params_file=path, namespace='sat1', rviz='true', rate='50')
    assert (node['namespace'], node['name']) == ('/sat1', 'satdyn')
    assert node['parameters'][0]['publish.rate'] == 50.0
    with pytest.raises(ValueError, match=r'publish\.rate is -1; it must be a number above 0'):
        started(params_file=path, namespace='/sat2')
    with pytest.raises(ValueError, match=r'has 2 satellites.*namespace:=.*/sat1/satdyn'):
        started(params_file=path)
    with pytest.raises(ValueError, match=r'given\.yaml, /sat2/satdyn: publish\.rate is -1'):
        constellation(path)


@pytest.mark.parametrize(
    ('pushed', 'namespace', 'full'),
    [
        ('', '', ''),
        ('', 'deep', 'deep'),
        ('/b', '', 'b'),
        ('/b', 'deep', 'b/deep'),
        ('/a/b', 'c/d', 'a/b/c/d'),
        ('/b', '/deep', 'deep'),
    ],
)
def test_a_pushed_namespace_stands_before_the_given_one(pushed, namespace, full):
    """As launch has it for every node: an absolute one stays as it is."""
    (_, node), (_, rviz), (_, watch), *_ = started(
        namespace=composed(pushed, namespace), rviz='true', watch='true'
    )
    assert node['namespace'].strip('/') == rviz['namespace'].strip('/') == full
    assert rviz['arguments'][-1] == f'{full}/lvlh'.lstrip('/')
    assert f'/{full}/satdyn'.replace('//', '/') in watch['cmd']


def test_a_satellite_flies_in_pushed_namespaces(file):
    """With its own section, and frames of the node's namespace; one of that name prevails."""
    text = '/sat1/satdyn: {ros__parameters: {frames.orbital: o}}\n/sat2/satdyn: {}\n'
    for more, section in (
        ('', ['--section', '/sat2/satdyn']),
        ('/fleet/sat2/satdyn: {}', []),
    ):
        path = file(text + more)
        given = {'params_file': path, 'rviz': 'true'}
        (_, node), (_, rviz) = started(namespace=composed('/fleet', 'sat2'), **given)
        assert (node['namespace'], node['arguments'][2:]) == ('/fleet/sat2', section)
        assert rviz['arguments'][-1] == 'fleet/sat2/lvlh'
    _, (_, rviz) = started(namespace='/fleet/sat1', **given)
    assert rviz['arguments'][-1] == 'o'
    # A pushed namespace alone chooses too.
    (_, node), _ = started(namespace=composed('/sat1', ''), **given)
    assert (node['namespace'], node['arguments'][2:]) == ('/sat1', [])


def test_the_one_satellite_of_a_file_is_started_under_its_name(file):
    """A dump of /sat1/satdyn flies as that; for another namespace it is refused."""
    path = file('/sat1/satdyn: {ros__parameters: {publish.rate: 20}}')
    (_, node), (_, watch) = started(params_file=path, watch='true')
    assert (node['namespace'], node['name']) == ('/sat1', 'satdyn')
    assert '/sat1/satdyn' in watch['cmd']
    with pytest.raises(ValueError, match=r'no section for this node, /sat2/satdyn; it has /sat1/'):
        started(params_file=path, namespace='sat2')


def test_patterns_name_no_satellite(file):
    """What is for many nodes is for those that other sections name."""
    path = file(
        '/**: {ros__parameters: {}}\n'
        '/*/satdyn: {ros__parameters: {}}\n'
        '/a/b/sat: {ros__parameters: {}}\n'
        '/c/**: {ros__parameters: {}}\n'
    )
    (node,) = constellation(path)
    assert (node['namespace'], node['name']) == ('a/b', 'sat')
    # Alone it needs no folder.
    assert 'parameters' not in node


@pytest.mark.parametrize('text', ['{}', '/**: {ros__parameters: {}}', '/*/satdyn: {}'])
def test_a_file_without_a_satellite_is_refused(file, text):
    """Nothing would start, without a word."""
    path = file(text)
    with pytest.raises(ValueError) as refused:
        constellation(path)
    assert str(refused.value) == (
        f'params_file: {path} has no section of a satellite; it must have one that is named '
        '/namespace/node'
    )


def test_a_satellite_without_a_namespace(file):
    """/satdyn and satdyn are one node, as for rcl."""
    path = file('satdyn: {ros__parameters: {}}\n/satdyn: {}\nsat1/satdyn: {}')
    alone, other = constellation(path)
    assert (alone['namespace'], alone['name']) == ('', 'satdyn')
    assert (other['namespace'], other['name']) == ('sat1', 'satdyn')


@pytest.mark.parametrize('name', ['/sat1/', '//satdyn', '/sat 1/satdyn', '5'])
def test_a_section_whose_name_is_not_one_of_a_node_is_refused(file, name):
    """One sentence names the section, before a node starts."""
    path = file(f'/ok/satdyn: {{}}\n{name}: {{}}')
    with pytest.raises(ValueError) as refused:
        constellation(path)
    assert str(refused.value) == (
        f'params_file: {path} has the section {name}; it must be named /** or /namespace/node'
    )


@pytest.mark.parametrize(
    ('section', 'sentence'),
    [
        ('sat1: {satdyn: {}}', 'a section with more than ros__parameters'),
        ('/sat1/satdyn: 3', 'a section with more than ros__parameters'),
        ('/sat1/satdyn: {ros__parameters: {}, more: {}}', 'a section with more than ros__par'),
        ('/sat1/satdyn: {ros__parameters: 3}', 'must be keys and values'),
    ],
)
def test_a_section_that_is_no_satellites_is_refused(file, section, sentence):
    """Before a node starts under another name than its file's, or without its parameters."""
    with pytest.raises(ValueError, match=rf'params_file: .*{sentence}'):
        constellation(file(f'/ok/satdyn: {{}}\n{section}'))

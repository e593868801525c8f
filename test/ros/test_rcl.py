"""Parameter files are read as a bare node gets them from rcl: its words, sections and order."""

import re
import signal
from contextlib import contextmanager

import pytest
import rclpy
from rcl_interfaces.srv import GetParameters
from rclpy.impl.implementation_singleton import rclpy_implementation
from ros.live import PATIENCE_S, Participant, start

from satdyn_ros.base import rcl_yaml
from satdyn_ros.ros.parameters import given_parameters
from satdyn_ros.ros.start import main
from satdyn_ros.run.parameter_file import ParameterFile, yaml_of_parameters

REFUSES = pytest.raises(
    (rclpy_implementation.RCLError, rclpy_implementation.RCLInvalidROSArgsError)
)


@pytest.fixture
def bare(tmp_path):
    """Return a function: what a node of no parameters gets from files, and its full name."""

    def read(texts, name='satdyn', namespace='', remaps=()):
        arguments = ['--ros-args']
        for number, text in enumerate(texts):
            path = tmp_path / f'{number}.yaml'
            path.write_text(text)
            arguments += ['--params-file', str(path)]
        for remap in remaps:
            arguments += ['-r', remap]
        node = rclpy.create_node(name, namespace=namespace, cli_args=arguments)
        try:
            return given_parameters(node), node.get_fully_qualified_name()
        finally:
            node.destroy_node()

    return read


TRUTHS = 'y Y yes Yes YES on On ON true True TRUE n N no No NO off Off OFF false False FALSE'
TEXTS = (
    'yEs tRUE t f null Null NULL ~ + . -. 0x 0b11 0o17 1_000 1_0.5 1:30 190:20:30 1d3 1e 1e+ e3 '
    '0x1.fp 2026-03-01 12:30:45 a_b /x <<  1e400 -1e400 1e-400 -.nan .iNf 0x1p9999'
)
NUMBERS = (
    '5 +5 -5 -0 00 010 -010 08 09 0x10 0X1F -0x10 9223372036854775807 9223372036854775808 '
    '-9223372036854775808 -9223372036854775809 99999999999999999999 0x7fffffffffffffff '
    '0xffffffffffffffff 1. .5 -.5 +.5 1e3 1E3 1e+3 1e-3 1.e3 .5e3 -.5E-3 08.5 0e9 -0e-999 0x1p3 '
    '0x1.8p1 0x.8 0x1P-2 -0x1p3 inf Inf INF infinity -inf +inf .inf -.inf +.inf .Inf .INF +.Inf '
    'nan NaN NAN .nan .NaN .NAN nan(12) 2.2250738585072014e-308 1.7976931348623157e308'
)
OTHERS = [
    "'y'",
    "'5'",
    '"5"',
    '""',
    '!!str 5',
    '!!float 5',
    '!!int a',
    '&anchor 5',
    '|\n      5',
    '>-\n      5',
    '|-\n      y',
    'a b',
    '1 # and a comment',
    '[1, 2]',
    '[1.0, .5, -.5, 1e3]',
    '[010, 0x10]',
    '[y, off]',
    "['y', x, ~, '1']",
    '[1, ]',
    '{a: [1, 2], b: 3}',
    "{1: 2, y: 3, '5': 4, ~: 5, 1.50: 6}",
    '{a: 1, a: 2}',
    '{a: {b: 1}, a.b: 2, a: {b: 3, c: 4}}',
]
WORDS = [*TRUTHS.split(), *TEXTS.split(), *NUMBERS.split(), *OTHERS]


def with_value(given):
    return f'/**:\n  ros__parameters:\n    key: {given}\n    last: 1\n'


def with_types(parameters):
    """Return values that differ by their types too, and nan that is itself."""
    return {name: repr(value) for name, value in parameters.items()}


@pytest.mark.parametrize('given', WORDS)
def test_a_word_is_what_it_is_to_rcl(bare, given):
    """The same type and the same bits."""
    parameters, _ = bare([with_value(given)])
    assert parameters['last'] == 1
    ours = rcl_yaml.sections([(with_value(given), 'ours')])['/**']
    assert with_types(ours) == with_types(parameters)


REFUSED_BY_BOTH = {
    '': "has at line 3 a key without a value; an empty text is ''",
    '[x, y]': r"has at line 3 key with a text \(x\) and a truth \(y\) in one list; .*, as 'y'",
    '[a, 1]': r'has at line 3 key with a text \(a\) and an integer \(1\) in one list',
    "[1, '']": r'has at line 3 key with a text \(\) and an integer \(1\) in one list',
    '[~, 1.5]': r'has at line 3 key with a float \(1.5\) and a text \(~\) in one list',
    '[y, 1]': r'has at line 3 key with a truth \(y\) and an integer \(1\)',
    '[[1], [2]]': 'has at line 3 a list or keys in a list, which no parameter can be',
    '{? [1] : 2}': 'has at line 3 a key that is not a word',
    '{"": 2}': 'has at line 3 a key that is not a word',
    '-': 'is not YAML at line 3',
    '[,]': 'is not YAML at line 3',
    '@x': 'is not YAML at line 3',
}


@pytest.mark.parametrize(('given', 'sentence'), REFUSED_BY_BOTH.items())
def test_what_rcl_cannot_read_is_refused(bare, given, sentence):
    """By a sentence that says what to write in its place, where rcl names a line."""
    with REFUSES:
        bare([with_value(given)])
    with pytest.raises(ValueError, match=f'^ours {sentence}'):
        rcl_yaml.sections([(with_value(given), 'ours')])


def test_what_is_taken_beyond_rcl(bare):
    """As the page on parameters has it: mixed lists, very small numbers, empty groups, aliases."""
    with REFUSES:
        bare([with_value('[0, 0, 0.002]')])
    assert bare([with_value('1e-310')])[0]['key'] == '1e-310'
    for given in ('{}', '{a: &a 1, b: *a}'):
        with REFUSES:
            bare([with_value(given)])
    for given, values in (
        ('[0, 0, 0.002]', {'key': [0, 0, 0.002]}),
        ('1e-310', {'key': 1e-310}),
        ('{}', {}),
        ('{a: &a [1], b: *a}', {'key.a': [1], 'key.b': [1]}),
    ):
        ours = rcl_yaml.sections([(with_value(given), 'ours')])['/**']
        assert ours == values | {'last': 1}


@pytest.mark.parametrize('given', ['[[1, 2]]', '[1, [2]]', '[{a: 1}]'])
def test_what_rcl_reads_without_sense_is_refused(bare, given):
    """It takes [[1, 2]] for [1, 2] and [{a: 1}] for the list a."""
    assert bare([with_value(given)])[0]['last'] == 1
    with pytest.raises(ValueError, match='a list or keys in a list'):
        rcl_yaml.sections([(with_value(given), 'ours')])


def section(name, **values):
    parameters = ', '.join(f'{key}: {value}' for key, value in values.items())
    return f'"{name}": {{ros__parameters: {{{parameters}}}}}\n'


NAMES = [
    '/**',
    '**',
    '/*',
    '*',
    '/**/satdyn',
    '/*/satdyn',
    '*/satdyn',
    '/sat1/*',
    '/sat1/**',
    '/sat1/satdyn',
    'sat1/satdyn',
    '/satdyn',
    'satdyn',
    '/mysat',
    '/**/sat1/satdyn',
    '/*/sat1/satdyn',
    '/sat1/**/satdyn',
    '/fleet/*/satdyn',
    '/fleet/**/satdyn',
    '/*/*',
    '/*/**',
    '/**/**',
    '/sat10/satdyn',
]
NODES = [
    {},
    {'namespace': '/sat1'},
    {'namespace': '/fleet/sat1'},
    {'remaps': ['__node:=mysat']},
    {'remaps': ['__ns:=/sat1']},
    {'remaps': ['satdyn:__ns:=/fleet']},
]


@pytest.mark.parametrize('node', NODES, ids=str)
def test_each_name_of_a_section_matches_the_nodes_that_rcl_gives_it(bare, node):
    """Each section has a parameter of its own."""
    text = ''.join(section(name, **{f'p{k}': k}) for k, name in enumerate(NAMES))
    parameters, full_name = bare([text], **node)
    assert 1 < len(parameters) < len(NAMES)
    assert ParameterFile.of_texts([(text, 'ours')]).parameters(full_name) == parameters


@pytest.mark.parametrize(
    'name', ['/sat*/satdyn', '/sat1*', '***', 'sat 1/satdyn', '5', '/', '/5/satdyn', '/a//b']
)
def test_a_name_that_rcl_refuses_is_refused(bare, name):
    """One sentence names the section."""
    with REFUSES:
        bare([section(name, a=1)])
    with pytest.raises(ValueError, match=re.escape(f'ours has the section {name}; it must be')):
        rcl_yaml.sections([(section(name, a=1), 'ours')])


ORDERS = {
    'the wildcard last': [section('/satdyn', r=20) + section('/**', r=10)],
    'the wildcard first': [section('/**', r=10) + section('/satdyn', r=20)],
    'four': [
        section('/satdyn', r=1)
        + section('/**', r=2, a=1)
        + section('/**/satdyn', r=3, b=1)
        + section('satdyn', r=4)
    ],
    'a section twice': [section('/**', r=1, a=1) + section('/**', r=2, b=2)],
    'a section twice, about another': [
        section('/**', r=1, a=1) + section('/satdyn', r=2) + section('/**', r=3)
    ],
    'a group twice': ['/**: {ros__parameters: {initial: {a: 1}, initial: {b: 2}}}'],
    'a key twice': ['/**: {ros__parameters: {a: 1, a: 2}}'],
    'nested names': ['fleet: {sat1: {satdyn: {ros__parameters: {a: 1}}}, satdyn: {}}'],
    'nested wildcards': ['/**: {satdyn: {ros__parameters: {a: 1}}}'],
    'empty sections': ['/**: {}\n/satdyn: {ros__parameters: {}}\n' + section('/**', a=1)],
    'two files': [section('/**', r=1, a=1), section('/**', r=2, b=2)],
    'two files, the first has more to say': [
        section('/satdyn', r=1) + section('/**', r=2),
        section('/satdyn', r=5),
    ],
    'two files, the second has more to say': [
        section('/**', r=1, a=3),
        section('/**', r=2) + section('/satdyn', r=3, lengths='[1.0, 2.0]'),
    ],
    'lists of two lengths': [section('/**', r='[1, 2, 3]'), section('/**', r='[4, 5]')],
}


@pytest.mark.parametrize('texts', ORDERS.values(), ids=ORDERS)
def test_sections_and_files_are_merged_as_rcl_merges_them(bare, texts):
    """A section stands where its name first stood; of what is given twice the last counts."""
    if any('fleet' in text for text in texts):
        with pytest.raises(ValueError, match='a section with more than ros__parameters'):
            ParameterFile.of_texts([(text, 'ours') for text in texts])
        texts = [text.replace(', satdyn: {}', '') for text in texts]
        parameters, full_name = bare(texts, namespace='fleet/sat1')
    else:
        parameters, full_name = bare(texts)
    assert parameters
    ours = ParameterFile.of_texts([(text, 'ours') for text in texts])
    assert ours.parameters(full_name) == parameters


@pytest.mark.parametrize(
    ('first', 'second', 'kept'),
    [('10', '5.0', 10), ('10.0', '5', 5), ('[1, 2]', '[5.0]', [1, 2]), ('[1, 2]', '[]', [1, 2])],
)
def test_a_parameter_that_is_given_twice_as_two_kinds_is_refused(bare, first, second, kept):
    """Of the two rcl keeps an integer, whichever is the later."""
    texts = [section('/**', r=first), section('/**', r=second)]
    assert bare(texts)[0] == {'r': kept}
    with pytest.raises(ValueError, match=r'^b has at line 1 r, given as an? .* and as an? '):
        ParameterFile.of_texts(zip(texts, 'ab', strict=True))


def test_what_is_written_is_the_same_to_rcl(bare):
    """Texts that it would take for true or a number are quoted, and no others."""
    texts = [*TRUTHS.split(), *TEXTS.split(), *NUMBERS.split(), '', 'x', 'a b', "it's", 'a: b']
    values = {'a.texts': texts, 'b.c.numbers': [1e-7, 1e20, -0.0], 'd': True, 'e': 5, 'f': 'y'}
    text = yaml_of_parameters(values)
    assert bare([text])[0] == values
    assert ParameterFile.of_texts([(text, 'ours')]).parameters('/satdyn') == values
    assert yaml_of_parameters({'f': 'y', 'g': 'x'}).endswith("    f: 'y'\n    g: x\n")


@contextmanager
def started(arguments, directory, namespace):
    """Yield a participant beside a node, and a list that holds its log in the end."""
    process = start(arguments, directory)
    log: list[str] = []
    participant = Participant(namespace)
    try:
        yield participant, log
    finally:
        participant.close()
        process.send_signal(signal.SIGINT)
        log.append(process.communicate(timeout=PATIENCE_S)[1])
    assert process.returncode == 0, log


def test_a_node_reads_its_sections_of_several_files(tmp_path):
    """
    Its namespace comes by --ros-args; -p prevails over all; use_sim_time is rclpy's own.

    Frames that are for all nodes, or for none, get its namespace, those of -p do not.
    """
    common = {'publish.rate': 10, 'use_sim_time': 'true', 'step.ticks': 2, 'frames.orbital': 'o'}
    texts = [
        section('/**', **common) + section('/**/satdyn', **{'body.inertia': '[20, 30, 40.5]'}),
        section('/two_files/satdyn', **{'publish.rate': 50, 'torque.timeout': 3})
        + section('/sat2/satdyn', **{'publish.rate': 30}),
    ]
    arguments = []
    for number, text in enumerate(texts):
        path = tmp_path / f'{number}.yaml'
        path.write_text(text)
        arguments += ['--params-file', str(path)]
    of_ros = tmp_path / 'of_ros.yaml'
    of_ros.write_text(section('/**', **{'frames.body': 'b'}))
    arguments += ['--ros-args', '-r', '__ns:=/two_files', '-p', 'torque.timeout:=7.0']
    arguments += ['--params-file', str(of_ros), '-p', 'sensors.names:=[gyro, star_tracker]']
    arguments += ['-p', 'sensors.gyro.frame_id:=g']
    with started(arguments, tmp_path, '/two_files') as (participant, log):
        assert participant.get('publish.rate') == 50.0
        assert participant.get('step.ticks') == 2
        assert participant.get('torque.timeout') == 7.0
        assert participant.get('use_sim_time') is True
        assert list(participant.get('body.inertia')) == [20.0, 30.0, 40.5]
        assert participant.get('frames.orbital') == 'two_files/o'
        assert participant.get('frames.body') == 'two_files/b'
        assert participant.get('sensors.gyro.frame_id') == 'g'
        assert participant.get('sensors.star_tracker.frame_id') == 'two_files/star_tracker'
    assert '/two_files/satdyn does not use the section /sat2/satdyn' in log[0]


def test_a_file_with_one_satellite_names_the_node(tmp_path):
    """Without a name by --ros-args it flies as its section is named."""
    path = tmp_path / 'one.yaml'
    path.write_text(section('/named/mysat', **{'publish.rate': 20.0}))
    with started(['--params-file', str(path)], tmp_path, '/named') as (participant, _):
        request = GetParameters.Request(names=['publish.rate'])
        answer = participant.call(GetParameters, 'mysat/get_parameters', request)
        assert answer.values[0].double_value == 20.0


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['--satellite', '/c'], r'two\.yaml has no satellite /c; it has /a/satdyn, /b$'),
        (['--ros-args', '-r', '__ns:=/c'], r'no section for this node, /c/satdyn; it has /a/satd'),
        (['--satellite', '/a', '--ros-args', '-r', '__node:=b'], 'both name the node; one of the'),
        (
            ['--satellite', '/b', '--ros-args', '-p', 'initial.angular_velocity:=[0,0,0.002]'],
            r'Sequence should be of same type.*; in a list every number must have a point, as in ',
        ),
    ],
    ids=['no such', 'no section', 'two', 'mixed'],
)
def test_a_node_that_is_not_named_well_is_refused(tmp_path, arguments, sentence):
    """Exit code 2 and a sentence."""
    path = tmp_path / 'two.yaml'
    path.write_text(section('/a/satdyn', **{'step.ticks': 2}) + section('/b'))
    process = start(['--params-file', str(path), *arguments], tmp_path)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    # Ahead of it may stand what rcl logs.
    line = errors.splitlines()[-1]
    assert line.startswith('satdyn node: ')
    assert re.search(sentence, line), line


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['--section', '/c'], r'two\.yaml has no satellite /c; it has /a/satdyn, /b$'),
        (['--satellite', '/a', '--section', '/b'], r'--satellite and --section both choose a sat'),
    ],
)
def test_a_section_that_is_not_chosen_well_is_refused(tmp_path, capsys, arguments, sentence):
    """Exit code 2 and a sentence, before ROS begins."""
    path = tmp_path / 'two.yaml'
    path.write_text(section('/a/satdyn', **{'step.ticks': 2}) + section('/b'))
    assert main(['--params-file', str(path), *arguments]) == 2
    assert re.search(sentence, capsys.readouterr().err.strip())


def test_an_unknown_option_is_refused_in_one_line(capsys):
    """As by every other command."""
    with pytest.raises(SystemExit) as end:
        main(['--speed', '2'])
    assert end.value.code == 2
    said = 'satdyn node: unrecognized arguments: --speed 2; see satdyn node --help\n'
    assert capsys.readouterr().err == said

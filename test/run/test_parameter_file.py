"""A parameter file is read as ROS reads it, and what a scenario writes loads again."""

import random

import pytest
import yaml

from satdyn_ros.run.parameter_file import parameters_of_record, yaml_of_parameters
from satdyn_ros.run.scenario import Scenario


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('a: [1', 'is not YAML at line'),
        ('- 1', 'is not a parameter file'),
        ('/other/*:\n  ros__parameters: {}', 'has no section for this node'),
        ('/**:\n  publish: {}', 'a section with more than ros__parameters'),
        ('/**:\n  ros__parameters: 3', 'must be keys and values'),
        ('/**:\n  ros__parameters: {publish: {rates: 3}}', 'publish.rates is not a parameter'),
    ],
)
def test_broken_file(tmp_path, text, sentence):
    """A file that is not a scenario is refused in one sentence that names it or the key."""
    file = tmp_path / 'scenario.yaml'
    file.write_text(text)
    with pytest.raises(ValueError, match=sentence):
        Scenario.from_yaml(file)


def test_missing_file(tmp_path):
    """A file that is not there, or a directory, is refused in one sentence."""
    for path in (tmp_path / 'none.yaml', tmp_path):
        with pytest.raises(ValueError, match='cannot be read'):
            Scenario.from_yaml(path)


def test_an_empty_section_has_no_parameters():
    """As for ROS, which takes {} for one and refuses nothing at all."""
    assert Scenario.from_yaml_text('/**: {}') == Scenario()
    with pytest.raises(ValueError, match='a section with more than ros__parameters'):
        Scenario.from_yaml_text('/**:')


def test_dump_loads_again():
    """The text of a scenario gives the scenario back, to the last bit."""
    scenario = Scenario.from_dict(
        {
            'orbit': {'type': 'kepler', 'eccentricity': 0.1, 'mu': 1.0 / 3.0 * 1e14},
            'rotor': {'mode': 'free', 'inertia': 0.1, 'axis': [1, 1, 0], 'speed': -1e-7},
            'initial': {'attitude': [0.6, 0.0, 0.0, 0.8]},
            'publish': {'topics': ['/tf', 'rotor']},
        }
    )
    assert Scenario.from_yaml_text(scenario.to_yaml()) == scenario
    assert scenario.topics == ('tf', 'rotor')


PIECES = [
    *'ab0.-:#\'"\\|>%@`{}[],&*!?~= \n\t\r\0\x07\x1b\x7f\x80\x85\x9f\xa0\xe9',
    *'\u2028\u2029\u4e2d\ufeff\ufffd\ufffe\U0001f600\U0010ffff',
    ' \n',
    '\n ',
    '---\n',
    'true',
    'null',
    '1:2',
    '<<',
    'several words ' * 20,
    'x' * 1200,
]


@pytest.mark.parametrize('load', [yaml.safe_load, lambda text: yaml.load(text, yaml.CSafeLoader)])
def test_every_text_loads_again(load):
    """Whatever its characters, as a value and in a list: by PyYAML, by libyaml and by us."""
    draw = random.Random(1)
    for length in (1, 1, 1, 2, 2, 3, 5, 30) * 40:
        text = ''.join(draw.choices(PIECES, k=length))
        values = {'orbit.file': text, 'orbit.tle': ['\xe9', text], 'publish.rate': 1.0}
        written = yaml_of_parameters(values)
        orbit = {'file': text, 'tle': ['\xe9', text]}
        section = {'ros__parameters': {'orbit': orbit, 'publish': {'rate': 1.0}}}
        assert load(written) == {'/**': section}
        assert parameters_of_record(written, 'a record') == values


def test_text_in_any_language_takes_its_own_size():
    """A line is not blown up by escapes, and stays a line that can be read."""
    text = 'COMMENT caf\xe9 \u4e2d\u6587 \U0001f600\n' * 3
    assert yaml_of_parameters({'orbit.file': text}).endswith(
        'file: |\n' + ''.join(f'        {line}\n' for line in text.splitlines())
    )


def test_integers_and_exponents_are_numbers():
    """A list of integers, a mixed one, and 4e14 without a point are numbers, as for ROS."""
    text = """
    /satdyn:
      ros__parameters:
        use_sim_time: false
        body.inertia: [6, 8.0, 9]
        orbit: {mu: 4e14}
        initial: {attitude: [0, 0, 0, 1]}
    """
    scenario = Scenario.from_yaml_text(text)
    assert scenario['body.inertia'] == (6.0, 8.0, 9.0)
    assert scenario['orbit.mu'] == 4e14
    assert scenario['initial.attitude'] == (0.0, 0.0, 0.0, 1.0)


def test_the_satellites_of_a_file():
    """Chosen by full name, or by namespace where the node is satdyn; alone it needs no choice."""
    text = """
    /**: {ros__parameters: {step.ticks: 3, publish.rate: 10}}
    /*/satdyn: {ros__parameters: {orbit.raan: 1}}
    /sat4/satdyn: {ros__parameters: {publish.rate: 20}}
    """
    alone = Scenario.from_yaml_text(text)
    assert (alone['step.ticks'], alone['orbit.raan'], alone['publish.rate']) == (3, 1.0, 20.0)
    assert alone.warnings == ()
    text += '/mysat: {ros__parameters: {publish.rate: 30}}'
    with pytest.raises(
        ValueError, match=r'^f has 2 satellites.*--satellite.*: /sat4/satdyn, /mysat$'
    ):
        Scenario.from_yaml_text(text, 'f')
    for given in ('/sat4', 'sat4', '/sat4/satdyn'):
        found = Scenario.from_yaml_text(text, 'f', satellite=given)
        assert found == alone
        assert found.warnings == ('f: /sat4/satdyn does not use the section /mysat',)
        # They stay with what is made of it.
        assert found.with_values({'publish.rate': 1.0}).warnings == found.warnings
    other = Scenario.from_yaml_text(text, 'f', satellite='/mysat')
    assert (other['publish.rate'], other['orbit.raan']) == (30.0, 0.0)
    assert other.warnings == ('f: /mysat does not use the sections /*/satdyn, /sat4/satdyn',)
    for given in ('/sat1', 'satdyn', '', '/sat4/mysat'):
        with pytest.raises(
            ValueError, match=r'^f has no satellite .*; it has /sat4/satdyn, /mysat$'
        ):
            Scenario.from_yaml_text(text, 'f', satellite=given)


def test_satellites_in_namespaces_have_frames_of_their_own():
    """Under theirs, unless their own section gives them; what all have in common is inertial."""
    text = """
    /**: {ros__parameters: {frames: {inertial: i, orbital: o}, sensors.names: [gyro]}}
    /a/b/mysat: {}
    /sat4/satdyn: {ros__parameters: {frames: {body: own}}}
    /satdyn: {}
    """
    keys = 'frames.inertial', 'frames.orbital', 'frames.body', 'sensors.gyro.frame_id'
    for satellite, *frames in (
        ('/a/b/mysat', 'i', 'a/b/o', 'a/b/base_link', 'a/b/gyro'),
        ('/sat4', 'i', 'sat4/o', 'own', 'sat4/gyro'),
        ('/satdyn', 'i', 'o', 'base_link', 'gyro'),
    ):
        scenario = Scenario.from_yaml_text(text, satellite=satellite)
        assert [scenario[key] for key in keys] == frames
    # A file for any node as well.
    unnamed = Scenario.from_yaml_text('/**: {}', satellite='/sat4')
    assert unnamed.frames.body == 'sat4/base_link'
    for wrong, shown in (('5', '5'), ("''", "''")):
        with pytest.raises(ValueError, match=rf'frames\.body is {shown}; it must be a non-empty'):
            Scenario.from_yaml_text(
                f'/**: {{ros__parameters: {{frames.body: {wrong}}}}}\n/a/b: {{}}'
            )


def test_a_section_of_another_node_is_no_satellite():
    """One with none of our groups of keys; a misspelt key is reported, not ignored."""
    text = """
    /sat4/satdyn: {ros__parameters: {publish.rate: 20}}
    /controller: {ros__parameters: {gain: 2.0, limits: {torque: 1.0}, use_sim_time: true}}
    """
    alone = Scenario.from_yaml_text(text, 'f')
    assert alone['publish.rate'] == 20.0
    assert alone.warnings == ('f: /sat4/satdyn does not use the section /controller',)
    with pytest.raises(ValueError, match=r'^f has no satellite /controller; it has /sat4/satdyn$'):
        Scenario.from_yaml_text(text, 'f', satellite='/controller')
    for misspelt in (
        '/mysat: {ros__parameters: {publish.rte',
        '/satdyn: {ros__parameters: {bdy.a',
    ):
        with pytest.raises(ValueError, match=r'is not a parameter of a scenario'):
            Scenario.from_yaml_text(misspelt + ': 20}}')


def test_any_satellite_of_a_file_that_names_none():
    """It gets the sections that match it; without a choice it is /satdyn."""
    text = """
    /**: {ros__parameters: {publish.rate: 10}}
    /*/satdyn: {ros__parameters: {publish.rate: 20}}
    """
    assert Scenario.from_yaml_text(text)['publish.rate'] == 10.0
    assert Scenario.from_yaml_text(text).warnings == (
        'scenario: /satdyn does not use the section /*/satdyn',
    )
    assert Scenario.from_yaml_text(text, satellite='/a')['publish.rate'] == 20.0
    with pytest.raises(ValueError, match=r"the satellite '/a b' must be a full name or a namesp"):
        Scenario.from_yaml_text(text, satellite='/a b')


def test_what_earlier_versions_wrote_of_a_rotor_called_y():
    """In a bag it is a name still; a parameter file with it is refused, as by rcl."""
    written = yaml_of_parameters({'rotor.names': ('x', 'y')})
    earlier = written.replace("'y'", 'y')
    assert earlier != written
    for text in (written, earlier):
        assert parameters_of_record(text, 'bag') == {'rotor.names': ['x', 'y']}
    with pytest.raises(
        ValueError, match=r"a text that ROS takes for true, .* must be quoted, as 'y'"
    ):
        Scenario.from_yaml_text(earlier)
    with pytest.raises(ValueError, match='bag has no section'):
        parameters_of_record('a: 1', 'bag')

"""YAML files: numbers as ROS has them, and one sentence, soon, for whatever must not be read."""

import pytest
import yaml

from satdyn_ros.base import ros_yaml

BOMB = 'a: &a [x, x, x, x, x, x, x, x, x]\n' + ''.join(
    f'{name}: &{name} [{", ".join([f"*{before}"] * 9)}]\n'
    for before, name in zip('abcdefgh', 'bcdefghi', strict=True)
)
MERGE_BOMB = 'a: &a {x: 1}\n' + ''.join(
    f'{name}: &{name} {{<<: [{", ".join([f"*{before}"] * 99)}]}}\n'
    for before, name in zip('abcdefgh', 'bcdefghi', strict=True)
)
REFUSED = {
    'a bomb of aliases': (BOMB, f'has more than the {ros_yaml.MOST_VALUES} values allowed'),
    'a bomb of merges': (MERGE_BOMB, f'has more than the {ros_yaml.MOST_VALUES} values allowed'),
    'a list of itself': ('&a [*a]', 'has the alias *a for something not complete'),
    'a key of itself': ('&a {*a : 1}', 'has the alias *a for something not complete'),
    'an alias of nothing': ('[*a]', 'has the alias *a for something not complete'),
    'depth': ('[' * 100_000, 'is nested deeper than the 64 levels allowed'),
    'depth of lines': ('\n'.join(' ' * i + 'a:' for i in range(80)), 'is nested deeper than'),
    'size': ('a' * 50_000_000, f'is larger than the {ros_yaml.LARGEST_BYTES} bytes allowed'),
    'values': (
        '[' + '1,' * 900_000 + ']',
        f'has more than the {ros_yaml.MOST_VALUES} values allowed',
    ),
    'a number to the base of sixty': ('1' + ':1' * 400_000, 'has an unquoted text of more than'),
    'two documents': ('a\n---\nb', 'is not YAML at line 2'),
    'an object of Python': ('!!python/object/apply:os.system [exit]', 'is not YAML'),
} | {
    value: (value, 'has a value that does not suit its tag')
    for value in ('!!bool maybe', '!!int abc', '!!float ""', '!!timestamp now', '!!int "0x"')
}


@pytest.mark.parametrize(('text', 'reason'), REFUSED.values(), ids=REFUSED)
def test_hostile_texts_are_refused_in_one_sentence(text, reason):
    """Nothing is built of them: a bomb of 9^9 values costs as little as a word."""
    with pytest.raises(ValueError, match='the file ') as refusal:
        ros_yaml.load(text, 'the file')
    assert reason in str(refusal.value)
    assert '\n' not in str(refusal.value)
    assert len(str(refusal.value)) < 200


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('{at_s: 1, torque: [0, 0, 1], torque: [0, 0, 2]}', 'gives torque twice, again at line 1'),
        ('- a: 1\n- b: {c: 1,\n  d: 2,\n  c: 3}', 'gives c twice, again at line 4; it must be'),
        ('a: 1\n"a": 2', 'gives a twice, again at line 2'),
    ],
)
def test_a_key_given_twice_is_refused(text, reason):
    """PyYAML would keep the last without a word."""
    with pytest.raises(ValueError, match=f'^the file {reason}'):
        ros_yaml.load(text, 'the file')


def test_a_key_may_stand_in_two_mappings_and_beside_a_merge():
    """Each has one of its own, which prevails over the merged one."""
    assert ros_yaml.load('[{a: 1}, {a: 2}]', 'two') == [{'a': 1}, {'a': 2}]
    text = 'b: {c: {<<: *z, x: 2}}'
    assert ros_yaml.load(f'z: &z {{x: 1, y: 3}}\n{text}', 'one')['b']['c'] == {'x': 2, 'y': 3}


def test_numbers_without_digits_on_one_side():
    """As strtod has them, and not the words that look alike."""
    assert ros_yaml.load('[.5, -.5, +.5, 1., -1.]', 'numbers') == [0.5, -0.5, 0.5, 1.0, -1.0]
    assert ros_yaml.load('[-., .e3]', 'words') == ['-.', '.e3']


def test_a_device_is_not_read():
    """It may have no end, as /dev/zero; a test of the commands tries each kind at each door."""
    with pytest.raises(ValueError, match='the scenario /dev/zero cannot be read: it is a device'):
        ros_yaml.read_text('/dev/zero', 'the scenario')


def test_aliases_of_a_moderate_size_are_allowed():
    """What yaml.dump writes where the same list stands twice."""
    torque = [0.0, 0.0, 0.01]
    text = yaml.safe_dump([{'at_s': 1, 'torque': torque}, {'at_s': 2, 'torque': torque}])
    assert '*' in text
    assert [entry['torque'] for entry in ros_yaml.load(text, 'events')] == [torque, torque]
    assert ros_yaml.load('a: &a {x: 1}\nb: {<<: *a, y: 2}', 'merged')['b'] == {'x': 1, 'y': 2}


def test_what_a_bag_holds_may_be_as_large_as_the_bag():
    """Its bytes were read already; of values it may have so many that each costs as before."""
    text = f'[{"1," * (ros_yaml.MOST_VALUES - 1)}1]'
    with pytest.raises(ValueError, match=r'^a bag has more than the [0-9]+ values allowed'):
        ros_yaml.load(text, 'a bag', size=len(text))
    assert (
        len(ros_yaml.load(text, 'a bag', size=40 * ros_yaml.MOST_VALUES)) == ros_yaml.MOST_VALUES
    )
    long = '"' + ros_yaml.LARGEST_BYTES * 'x' + '"'
    with pytest.raises(ValueError, match=r'^a file is larger than the [0-9]+ bytes allowed$'):
        ros_yaml.load(long, 'a file')
    assert ros_yaml.load(long, 'a bag', size=len(long)) == long[1:-1]


@pytest.mark.parametrize('text', ['{dipole: [5, 3, 2] mA m^2}', 'a:\n  b: [5, 3] deg\n  c: 1\n'])
def test_a_list_with_its_unit_must_be_quoted(text):
    """YAML takes it for a list and something else; the sentence says how it is written."""
    with pytest.raises(ValueError, match=r"a list with its unit is quoted, as in '\[5, 3, 2\] mA"):
        ros_yaml.load(text, 'a file')

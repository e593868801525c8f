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

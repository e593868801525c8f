"""Parameter files without ROS; test/ros/test_rcl.py compares the same with rcl."""

import pytest

from satdyn_ros.base import rcl_yaml


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('', 'a.yaml is not a parameter file: it must have sections such as'),
        ('- 1', 'a.yaml is not a parameter file: it must have sections such as'),
        ('/**:', 'a.yaml has at line 1 a section with more than ros__parameters in it, or none'),
        (
            '/**: {a: {}}',
            'a.yaml has at line 1 a section with more than ros__parameters in it, or',
        ),
        ('/**: {ros__parameters: }', 'ros__parameters of a.yaml must be keys and values'),
        (
            '/**: {ros__parameters: &a {b: *a}}',
            r'a.yaml has the alias \*a for something not compl',
        ),
        ('/**: {}\n---\n/**: {}', 'a.yaml is not YAML at line 2'),
        ('/**: {ros__parameters: {a: {b: 1}, a: {b: 1.0}}}', 'a.yaml has at line 1 a.b, given'),
    ],
)
def test_what_is_no_parameter_file_is_refused(text, sentence):
    """One sentence names the file, and the line where there is one."""
    with pytest.raises(ValueError, match=f'^{sentence}') as refused:
        rcl_yaml.sections([(text, 'a.yaml')])
    assert '\n' not in str(refused.value)


def test_a_long_name_is_matched_soon():
    """A regular expression in place of it would not end before the world does."""
    assert not rcl_yaml.matches('/**/*' * 10_000 + '/end', '/name' * 200)
    assert rcl_yaml.matches('/**/*' * 200 + '/**', '/name' * 200)

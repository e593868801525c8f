"""A parameter file is read as ROS reads it, and what a scenario writes loads again."""

import pytest
import yaml

from satdyn_ros.run.scenario import Scenario


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('a: [1', 'is not YAML at line'),
        ('- 1', 'is not a parameter file'),
        ('other:\n  ros__parameters: {}', 'has no section for this node'),
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


def test_sections_in_order(tmp_path):
    """The section of the node's name says more than the one for all nodes."""
    file = tmp_path / 'two.yaml'
    file.write_text(
        yaml.safe_dump(
            {
                'satdyn': {'ros__parameters': {'publish': {'rate': 5.0}}},
                '/**': {'ros__parameters': {'publish': {'rate': 7.0}, 'step': {'ticks': 3}}},
            }
        )
    )
    scenario = Scenario.from_yaml(file)
    assert (scenario['publish.rate'], scenario['step.ticks']) == (5.0, 3)

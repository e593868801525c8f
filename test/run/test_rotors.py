"""Rotors by name: which descriptions make a scenario, and what each refusal says."""

import numpy as np
import pytest

from satdyn_ros.run.scenario import Scenario

FREE = {'mode': 'free', 'axis': [1.0, 0.0, 0.0], 'inertia': 300.0}
MOTOR = FREE | {'mode': 'motor'}
UNIT_AXES = np.eye(3).tolist()


def named(**rotors):
    """Return the nested parameters of rotors by their names."""
    return {'rotor': {'names': list(rotors)} | rotors}


@pytest.mark.parametrize('name', ['rw-x', '1x', 'rw x', 'räd', 'rw.x'])
def test_a_name_that_is_no_identifier_is_refused(name):
    """The name becomes part of parameters, columns and messages."""
    with pytest.raises(ValueError, match=r'rotor\.names has .*letters, digits and _') as refusal:
        Scenario.from_dict({'rotor': {'names': [name]}})
    assert repr(name) in str(refusal.value)


@pytest.mark.parametrize(
    'name',
    [
        'names',
        'mode',
        'axis',
        'momentum',
        'inertia',
        'speed',
        'friction',
        'max_torque',
        'max_speed',
        'speed_gain',
        'position',
    ],
)
def test_a_name_that_is_a_key_is_refused(name):
    """rotor.mode would be both a rotor and the mode of one."""
    with pytest.raises(ValueError, match=f"rotor.names has '{name}'; .*none of names, part, mode"):
        Scenario.from_dict({'rotor': {'names': [name]}})


@pytest.mark.parametrize(
    ('nested', 'sentence'),
    [
        ({'rotor': {'names': ['a', 'a']}}, r'rotor\.names has a twice; each may be given once'),
        ({'rotor': {'names': ['']}}, r"rotor\.names is \[''\]"),
        ({'rotor': {'names': 'a'}}, r"rotor\.names is 'a'"),
        ({'rotor': {'names': ['a'], 'b': FREE}}, r'rotor\.b\.\w+ is given, .*names has no b'),
        ({'rotor': {'b': FREE}}, r'rotor\.b\.\w+ is given, but rotor\.names has no b'),
        (named(a=FREE | {'mass': 1.0}), r'rotor\.a\.mass is not a parameter of a scenario'),
        (named(a=FREE) | {'rotor.mode': 'free'}, r'rotor\.mode is free; with rotor\.names'),
        (named(a=FREE | {'inertia': 0.0}), r'rotor\.a\.inertia is 0; with rotor\.a\.mode free'),
        # 800 kg m^2 about the axis leave 200 to a third rotor of 300.
        (named(a=FREE, b=FREE, c=FREE), r'rotor\.c\.inertia is 300; .*below 200 kg m\^2'),
        (named(a=FREE | {'max_torque': 1.0}), r'rotor\.a\.max_torque is 1\.0; .*to motor'),
        (named(a={'friction': 1.0}), r'rotor\.a\.friction is 1\.0; .*free and motor'),
        (named(a=FREE | {'friction': -1.0}), r'rotor\.a\.friction is -1\.0'),
        (named(a=FREE | {'axis': [0.0, 0.0, 0.0]}), r'rotor\.a\.axis is .*not be zero'),
        (
            named(a=MOTOR | {'max_speed': 1.0, 'speed': -2.0}),
            r'rotor\.a\.speed is -2; .*rotor\.a\.max_speed, 1 rad/s',
        ),
    ],
)
def test_refused(nested, sentence):
    """One sentence says which key of which rotor, and what is allowed."""
    rotor = nested.pop('rotor')
    given = {'rotor': rotor | {k.removeprefix('rotor.'): v for k, v in nested.items()}}
    with pytest.raises(ValueError, match=sentence) as refusal:
        Scenario.from_dict(given)
    assert '\n' not in str(refusal.value)


def test_inertia_is_what_the_others_leave_about_skew_axes_too():
    """With three wheels and one askew, K = I - sum J a a^T must be positive definite."""
    askew = {'mode': 'free', 'axis': [1.0, 1.0, 1.0]}
    wheels = {
        name: {'mode': 'free', 'axis': axis, 'inertia': 300.0}
        for name, axis in zip('xyz', UNIT_AXES, strict=True)
    }
    K = np.diag([800.0, 900.0, 600.0]) - 300.0 * np.eye(3)
    largest = 3.0 / np.sum(1.0 / np.diag(K))  # 1 / (a . K^-1 a)
    for inertia, holds in ((0.999 * largest, True), (1.001 * largest, False)):
        carrier = K - inertia * np.ones((3, 3)) / 3.0
        assert (np.linalg.eigvalsh(carrier)[0] > 0.0) == holds
        given = named(**wheels, askew=askew | {'inertia': inertia})
        if holds:
            assert Scenario.from_dict(given)['rotor.askew.inertia'] == inertia
        else:
            with pytest.raises(ValueError, match=r'rotor\.askew\.inertia is'):
                Scenario.from_dict(given)


def test_sixteen_rotors_of_all_modes():
    """Each has its description, and the states have a column for each in their order."""
    modes = ['none', 'constant_momentum', 'free', 'motor'] * 4
    rotors = {}
    for i, mode in enumerate(modes):
        turns = {'inertia': 1.0 + i, 'speed': float(i)} if mode in ('free', 'motor') else {}
        held = {'momentum': float(i)} if mode == 'constant_momentum' else {}
        rotors[f'r{i}'] = {'mode': mode, 'axis': UNIT_AXES[i % 3], **turns, **held}
    scenario = Scenario.from_dict(named(**rotors))
    assert [rotor.name for rotor in scenario.system.rotors] == list(rotors)
    assert [rotor.mode for rotor in scenario.system.rotors] == modes
    assert [rotor.momentum for rotor in scenario.system.rotors][1::4] == [1.0, 5.0, 9.0, 13.0]
    speeds = [i if mode in ('free', 'motor') else np.nan for i, mode in enumerate(modes)]
    np.testing.assert_array_equal(scenario.initial_state.rotor_speed, speeds)
    assert Scenario.from_yaml_text(scenario.to_yaml()) == scenario


def test_dump_loads_again():
    """The text of a scenario with named rotors gives it back, to the last bit."""
    limits = {'friction': 1.0 / 3.0, 'max_torque': 1e-3, 'max_speed': 600.0, 'speed': -1e-7}
    nested = named(rw_x=MOTOR | limits | {'axis': [1, 1, 0]}, ring=FREE | {'axis': [0, 0, 1]})
    scenario = Scenario.from_dict(nested)
    again = Scenario.from_yaml_text(scenario.to_yaml())
    assert again == scenario
    assert dict(again.values) == dict(scenario.values)

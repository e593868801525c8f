"""Every key with a unit takes a text with one: in a file, a sweep, an event, a request, Python."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import motor_command, torque_command
from other_units import OTHER

from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.base.key import Key
from satdyn_ros.run import events
from satdyn_ros.run.keys import KEYS, NAMES_OF_EACH, keys_of
from satdyn_ros.run.many import many
from satdyn_ros.run.parameter_file import ParameterFile
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.sweep.plan import Plan
from satdyn_ros.sweep.sweep_keys import SWEEP_KEYS
from satdyn_ros.sweep.variation import variation

SHIPPED = Path(__file__).parents[2] / 'config' / 'default.yaml'
_ALL = keys_of(
    {key: ('one',) for key in NAMES_OF_EACH},
    sensors={'fine': 'gyro'},
).values()
WITH_UNIT = [key for key in (*_ALL, *SWEEP_KEYS.values()) if key.unit]


@pytest.mark.parametrize('key', WITH_UNIT, ids=lambda key: key.name)
def test_a_key_takes_another_unit_of_its_dimension_and_no_other(key: Key):
    """By a file, by the grid of a sweep and by Python the same number; the refusal names units."""
    unit, factor = OTHER[key.unit]
    count = max(key.lengths, default=0)
    text = f'[{", ".join(["2"] * count)}] {unit}' if count else f'2 {unit}'
    # A double rounds the factor and the product.
    value: Any = key.checked(text)
    assert value == pytest.approx((2.0 * factor,) * count if count else 2.0 * factor, rel=4e-16)

    file = ParameterFile.of_texts(
        [(f"/**: {{ros__parameters: {{{key.name}: '{text}'}}}}", 'a file')]
    )
    assert key.checked(file.parameters('/satdyn')[key.name]) == value
    assert variation(key, {'values': [text, text]}).grid == (value, value)
    if count:
        assert key.checked([f'2 {unit}'] * (count - 1) + [0]) == (*value[1:], 0.0)
    wrong = 'Hz' if key.unit != 'Hz' and key.unit != '1/s' else 'rpm'
    with pytest.raises(ValueError, match=f'{wrong} is of another dimension than .* that fit: '):
        key.checked(text.replace(unit, wrong))
    kinds: dict[str, type] = {'integer': int, 'double': float, 'double_array': tuple}
    assert isinstance(value, kinds[key.kind])


# What lets the rotor be what a key is about.
_WITH_ROTOR: dict[str, dict[str, Any]] = {
    'rotor.momentum': {'rotor.mode': 'constant_momentum'},
    'rotor.speed': {'rotor.mode': 'motor', 'rotor.inertia': 1.0},
}


@pytest.mark.parametrize(
    'key',
    [key for key in WITH_UNIT if key.changes == 'service' and key.name in KEYS],
    ids=lambda key: key.name,
)
def test_a_request_takes_another_unit_of_its_dimension(key: Key):
    """By an events file, and as Python asks for it: what then is in force is the same in SI."""
    scenario = Scenario(_WITH_ROTOR.get(key.name, {}))
    unit, factor = OTHER[key.unit]
    text = f'[0, 2, 0] {unit}' if key.lengths else f'2 {unit}'
    value = [0.0, 2.0 * factor, 0.0] if key.lengths else 2.0 * factor
    file = f'- {{at_s: 0, request: {{{key.name}: "{text}"}}}}'
    (event,) = events.from_yaml_text(file, scenario)
    assert isinstance(event, events.Request)
    asked, plain = Simulation(scenario, [event]), Simulation(scenario)
    plain.request({key.name: value})
    by_text = Simulation(scenario)
    by_text.request({key.name: text})
    for simulation in (asked, plain, by_text):
        simulation.advance(1)
    for one in (asked, by_text):
        for name in (key.name, 'initial.attitude'):
            assert one.conditions[name] == pytest.approx(plain.conditions[name], rel=4e-16)


def test_a_file_in_units_is_the_scenario_in_si():
    """All defaults, each as a text with the unit of its key, make the default scenario."""
    given = {
        key.name: f'{list(key.default) if key.lengths else key.default} {key.unit}'
        for key in KEYS.values()
        if key.unit and key.default != ()
    }
    assert Scenario(given) == Scenario()
    assert set(Scenario(given).typed) == set(given)


SHEET = """
/**:
  ros__parameters:
    body: {inertia: '[45, 45, 9] g m^2', dipole: [10 mA m^2, '0', -5 mA m^2]}
    rotor:
      names: [rw_x]
      rw_x: {mode: motor, axis: [1.0, 0.0, 0.0], inertia: 100 g cm^2, max_speed: 6000 rpm,
             max_torque: 1 mN m, speed_gain: 5 Hz, friction: 1e-6 mN m/rpm}
    magnetorquer: {max_dipole: '[0.2, 0.2, 0.2] A m^2'}
    thruster: {names: [t1], t1: {thrust: 25 mN, position: '[10, 0, 0] cm'}}
    environment: {magnetic_field: dipole}
    orbit: {type: circular, altitude: 420 km, inclination: 51.6 deg}
    initial: {roll_pitch_yaw: [5 deg, 0 deg, 10 deg], angular_velocity: '[0, 0.5, 0] deg/s'}
    sensors: {names: [gyro], seed: 3, gyro: {noise_density: 0.15 deg/sqrt(h)}}
    publish: {rate: 10 Hz}
    time: {epoch: '2026-03-01T00:00:00Z'}
    torque: {timeout: 0.5 min}
"""
EVENTS = """
- {at_s: 0.05 min, torque: '[0, 0, 5] uN m'}
- {at_s: 3 s, rotor_torque: {rw_x: 2 uN m}, until_s: 0.1 min}
- {at_s: 4, rotor_speed: {rw_x: 60 rpm}}
- {at_s: 4.5 s, magnetorquer: [50 mA m^2, 0, 0]}
- {at_s: 4.8 s, thrusters: {t1: 30 ms}}
- {at_s: 5000 ms, request: {initial.angular_velocity: '[0, 0, 6] deg/s'}}
"""


def test_events_take_what_is_typed():
    """Times in minutes and milliseconds fall on their ticks, commands come in SI."""
    found: list[Any] = [*events.from_yaml_text(EVENTS, Scenario.from_yaml_text(SHEET))]
    torque, rotor, speed, dipole, pulse, request = found
    assert torque == torque_command(30, (0.0, 0.0, 5e-6), until_tick=330)
    assert rotor == motor_command(30, {'rw_x': 2e-6}, until_tick=60)
    assert speed.value.speeds == {'rw_x': pytest.approx(math.tau, rel=4e-16)}
    assert (dipole.value, dipole.tick, request.tick) == ((0.05, 0.0, 0.0), 45, 50)
    assert (pulse.tick, pulse.value) == (48, {'t1': 0.03})


def test_a_bag_holds_si_and_what_was_typed(tmp_path):
    """Its scenario reads back as the same; the request in it is in rad/s."""
    scenario = Scenario.from_yaml_text(SHEET)
    for _ in simulate(scenario, 6, tmp_path / 'bag', events.from_yaml_text(EVENTS, scenario)):
        pass
    run = RecordedRun(tmp_path / 'bag')
    assert run.scenario == scenario
    (request,) = (event for event in run.events if isinstance(event, events.Request))
    rate = [0.0, 0.0, pytest.approx(6.0 * math.pi / 180.0, rel=4e-16)]
    assert request.values == {'initial.angular_velocity': rate}
    assert run.scenario.typed == scenario.typed
    assert scenario.typed['rotor.rw_x.max_speed'] == '6000 rpm'


def test_python_takes_what_is_typed():
    """from_dict, with_values, step and request; a torque of 5 mN m is 0.005 N m."""
    scenario = Scenario.from_yaml_text(SHEET).with_values({'orbit.altitude': '500 km'})
    assert scenario['orbit.semi_major_axis'] == 6878137.0
    assert scenario.typed['orbit.altitude'] == '500 km'
    mine, plain = Simulation(scenario), Simulation(scenario)
    a = mine.step(
        torque_b=['5 uN m', 0, 0],
        rotor_torque={'rw_x': '1 uN m'},
        dipole_b='[1, 0, 0] mA m^2',
        thrusters={'t1': '30 ms'},
    )
    b = plain.step(
        torque_b=[5e-6, 0, 0],
        rotor_torque={'rw_x': 1e-6},
        dipole_b=[1e-3, 0, 0],
        thrusters={'t1': 0.03},
    )
    assert np.array_equal(a.omega_bi_b, b.omega_bi_b)
    assert mine.step(rotor_speed={'rw_x': '60 rpm'}).rotor_speed[0] > 0.0
    mine.request({'initial.roll_pitch_yaw': ['0', '0', '90 deg'], 'initial.frame': 'inertial'})
    mine.advance(1)
    assert mine.state.q_ib == pytest.approx([0, 0, math.sqrt(0.5), math.sqrt(0.5)], abs=1e-15)
    with pytest.raises(ValueError, match='units that fit: rev/s, rpm'):
        mine.request({'initial.angular_velocity': '[0, 0, 1] Hz'})


def test_a_sweep_takes_what_is_typed():
    """Every way to vary."""
    key = KEYS['orbit.inclination']
    assert variation(key, {'linspace': ['0 deg', '90 deg', 2]}).grid == (0.0, math.pi / 2)
    drawn = variation(key, {'uniform': ['90 deg', '180 deg']}).values_of_draws(np.ones(1))
    assert drawn.tolist() == [math.pi]
    drawn = variation(key, {'normal': ['90 deg', '90 deg']}).values_of_draws(np.ones(1))
    assert drawn.tolist() == [math.pi]
    with pytest.raises(ValueError, match='units that fit: deg'):
        variation(key, {'normal': ['90 deg', '1 Hz']})


def test_a_sweep_file_takes_what_is_typed(tmp_path):
    """Angles in place of the attitude beside a height in place of the axis, alone and as many."""
    file = tmp_path / 'sweep.yaml'
    (tmp_path / 'scenario.yaml').write_text(SHEET)
    file.write_text(
        """
scenario: scenario.yaml
duration_s: 5 min
vary:
  initial.roll_pitch_yaw: {values: ['[0, 0, 90] deg', [90 deg, '0', 0 deg]]}
  orbit.altitude: {linspace: [400 km, 500 km, 2]}
"""
    )
    plan = Plan.from_yaml(file)
    assert plan.duration_s == 300.0
    assert Plan.from_text(plan.to_text()).values(3) == plan.values(3)
    alone = [plan.scenario_of(plan.values(run)) for run in range(4)]
    half = math.sqrt(0.5)
    assert alone[1]['initial.attitude'] == pytest.approx((0.0, 0.0, half, half), abs=1e-15)
    assert alone[2]['initial.attitude'] == pytest.approx((half, 0.0, 0.0, half), abs=1e-15)
    assert [each['orbit.semi_major_axis'] for each in alone] == [6778137.0, 6878137.0] * 2
    columns = {name: np.array(x) for name, x in plan.values_of(range(4)).items()}
    together, valid = many(plan.changed(columns), 4)
    assert valid.all()
    for row, each in enumerate(alone):
        assert tuple(together['initial.attitude'][row, 0]) == each['initial.attitude']


def test_a_sweep_does_not_vary_what_is_pointed_at(tmp_path):
    """It is resolved with the scenario, once."""
    file = tmp_path / 'sweep.yaml'
    file.write_text(
        f'scenario: {SHIPPED}\nduration_s: 5\nvary: {{initial.pointing: {{values: [nadir]}}}}\n'
    )
    with pytest.raises(ValueError, match=r'initial\.pointing varies; it must be the same'):
        Plan.from_yaml(file)


def test_texts_are_texts_as_before():
    """A name that reads as a quantity stays a name."""
    frames = Scenario({'frames.body': '5 m', 'record.directory': '2 km'})
    assert (frames['frames.body'], frames['record.directory']) == ('5 m', '2 km')
    assert not frames.typed
    assert not Key('a', 'string', '', '', '').has_unit('5 m')

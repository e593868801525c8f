"""Parts of the catalogue: what each says, and that a scenario takes it where nothing else is."""

import math
from typing import Any

import pytest
import yaml

from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.run import parts
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.sweep.plan import Plan

# What a part fits into.
AROUND: dict[str, Any] = {
    'environment.magnetic_field': 'dipole',
    'time.epoch': '2026-03-01T00:00:00Z',
}
# Momentum [N m s], torque [N m] and turns a minute, as the sources that the parts name state.
WHEELS = {
    'wheel_2_mNms': (1.77e-3, 0.23e-3, 8000),
    'wheel_10_mNms': (10.8e-3, 1e-3, 6000),
    'wheel_4_Nms': (4.0, 75e-3, 6000),
}
# Angle random walk [deg/sqrt(h)], lowest Allan deviation [deg/h] and range [deg/s].
GYROS = {
    'mems_gyro': (0.26, 5.1, 450),
    'tactical_gyro': (0.15, 0.3, 400),
    'fibre_optic_gyro': (0.012, 0.05, 490),
}
# Across and about the boresight [arcsec].
STAR_TRACKERS = {'star_tracker_6_arcsec': (6, 40), 'star_tracker_1_arcsec': (1, 8)}
# Thrust [N], specific impulse [s] and least impulse [N s].
THRUSTERS = {
    'cold_gas_thruster_55_mN': (55e-3, 65, 0.55e-3),
}
OTHERS = {'magneto_inductive_magnetometer', 'torquers_200_mAm2'}
DEG, ARCSEC = math.pi / 180, math.pi / 648000


def test_every_part_is_typed_here():
    """None is shipped whose figures are not compared with its source."""
    typed = {*WHEELS, *GYROS, *STAR_TRACKERS, *THRUSTERS, *OTHERS}
    assert typed == {*parts.catalogue()}
    assert all(part.says.endswith('.') and len(part.values) for part in parts.catalogue().values())


@pytest.mark.parametrize('name', WHEELS)
def test_a_wheel_has_the_momentum_of_its_class(name):
    """Three digits of its inertia are stated."""
    momentum, torque, rpm = WHEELS[name]
    scenario = Scenario({'rotor.part': name})
    assert scenario['rotor.mode'] == 'motor'
    assert scenario['rotor.max_torque'] == pytest.approx(torque, rel=1e-15)
    assert scenario['rotor.max_speed'] == pytest.approx(rpm * math.pi / 30, rel=1e-15)
    held = scenario['rotor.inertia'] * scenario['rotor.max_speed']
    assert held == pytest.approx(momentum, rel=2e-3)


@pytest.mark.parametrize('name', GYROS)
def test_a_gyro_has_the_allan_deviation_of_its_class(name):
    """Its slope where noise is all, and its lowest point, which data sheets call instability."""
    walk, lowest, largest = GYROS[name]
    scenario = Scenario({'sensors.names': ['gyro'], 'sensors.gyro.part': name})
    gyro: Any = scenario.sensors['gyro']
    # IEEE Std 952: N / sqrt(tau), so that N deg/sqrt(h) is 60 N deg/h over 1 s.
    over_a_second = gyro.allan_deviation(1.0)
    assert over_a_second == pytest.approx(60 * walk * DEG / 3600, rel=0.03)
    found = min(gyro.allan_deviation(10 ** (k / 100)) for k in range(600))
    assert found == pytest.approx(lowest * DEG / 3600, rel=5e-3)
    assert scenario['sensors.gyro.max_rate'] == pytest.approx(largest * DEG, rel=1e-15)


@pytest.mark.parametrize('name', STAR_TRACKERS)
def test_a_star_tracker_has_the_accuracy_of_its_class(name):
    scenario = Scenario({'sensors.names': ['star_tracker'], 'sensors.star_tracker.part': name})
    across, about = STAR_TRACKERS[name]
    of_each = [across * ARCSEC] * 2 + [about * ARCSEC]
    variances = scenario.sensors['star_tracker'].variances
    assert [math.sqrt(x) for x in variances] == pytest.approx(of_each, rel=1e-14)


@pytest.mark.parametrize('name', THRUSTERS)
def test_a_thruster_has_the_impulse_of_its_class(name):
    thrust, specific_impulse, impulse = THRUSTERS[name]
    scenario = Scenario({'thruster.names': ['t'], 'thruster.t.part': name})
    found = [scenario[f'thruster.t.{leaf}'] for leaf in ('thrust', 'specific_impulse')]
    assert found == pytest.approx([thrust, specific_impulse], rel=1e-15)
    assert found[0] * scenario['thruster.t.min_on_time'] == pytest.approx(impulse, rel=1e-15)


def test_a_magnetometer_and_torquers_have_the_figures_of_their_class():
    """15 nT, 75 counts to a microtesla, 800 uT; 0.2 A m^2 along each axis."""
    given = {'sensors.names': ['field'], 'magnetorquer.part': 'torquers_200_mAm2', **AROUND}
    scenario = Scenario(given | {'sensors.field.part': 'magneto_inductive_magnetometer'})
    found = [scenario[f'sensors.field.{leaf}'] for leaf in ('noise', 'resolution', 'max_field')]
    assert found == pytest.approx([15e-9, 1e-6 / 75, 800e-6], rel=3e-3)
    assert scenario['sensors.field.type'] == 'magnetometer'
    assert scenario['magnetorquer.max_dipole'] == pytest.approx((0.2, 0.2, 0.2), rel=1e-15)


SHEET = """
/**:
  ros__parameters:
    body: {inertia: '[45, 45, 9] g m^2'}
    rotor:
      names: [rw_x, rw_y]
      rw_x: {part: wheel_2_mNms, axis: [1.0, 0.0, 0.0]}
      rw_y: {part: wheel_2_mNms, max_torque: 0.1 mN m, speed: 1000 rpm}
    sensors:
      names: [fine, gyro]
      seed: 5
      fine: {part: tactical_gyro, max_rate: 0.0, integrating: false}
      gyro: {part: mems_gyro, divisor: 2}
    magnetorquer: {part: torquers_200_mAm2}
    thruster:
      names: [a, b]
      a: {part: cold_gas_thruster_55_mN, position: '[0, 10, 5] cm'}
      b: {part: cold_gas_thruster_55_mN, thrust: 30 mN}
    time: {epoch: '2026-03-01T00:00:00Z'}
"""


def test_what_is_stated_comes_before_what_its_part_says():
    """Even where that is the default of the key; what is not stated is the part's."""
    scenario = Scenario.from_yaml_text(SHEET)
    assert scenario['rotor.rw_x.max_torque'] == 0.23e-3
    assert scenario['rotor.rw_y.max_torque'] == 1e-4
    assert scenario['rotor.rw_y.axis'] == (0.0, 1.0, 0.0)
    assert scenario['sensors.fine.type'] == 'gyro'
    assert (scenario['sensors.fine.max_rate'], scenario['sensors.fine.integrating']) == (0, False)
    assert scenario['sensors.gyro.max_rate'] == pytest.approx(450 * DEG)
    assert scenario['thruster.a.thrust'] == 0.055
    assert (scenario['thruster.b.thrust'], scenario['thruster.b.min_on_time']) == (0.03, 0.01)
    # The part alone is as if it had not been given.
    assert not any(x for name, x in scenario.values.items() if name.endswith('.part'))


def test_a_bag_holds_the_values_and_names_the_parts(tmp_path):
    """Its parameter file is that of the values: it loads where the catalogue is another."""
    scenario = Scenario.from_yaml_text(SHEET)
    for _ in simulate(scenario, 0.1, tmp_path / 'bag'):
        pass
    run = RecordedRun(tmp_path / 'bag')
    assert run.scenario == scenario
    assert run.scenario.typed['rotor.rw_x.part'] == 'wheel_2_mNms'
    assert run.scenario.typed['rotor.rw_x.max_speed'] == '8000 rpm'
    text = run.scenario.to_yaml()
    assert 'part' not in yaml.safe_load(text)['/**']['ros__parameters']['rotor']['rw_x']
    assert Scenario.from_yaml_text(text) == scenario


def test_a_new_part_gives_what_it_says_whatever_was_before():
    scenario = Scenario({'rotor.part': 'wheel_2_mNms'})
    other = scenario.with_values({'rotor.part': 'wheel_4_Nms', 'rotor.max_torque': '50 mN m'})
    assert other == Scenario({'rotor.part': 'wheel_4_Nms', 'rotor.max_torque': 0.05})


@pytest.mark.parametrize(
    ('given', 'sentence'),
    [
        (
            {'rotor.part': 'wheel_2_mNm'},
            r"rotor\.part is 'wheel_2_mNm'; it must be a part of a rotor in .*config/parts; the "
            'nearest is wheel_2_mNms',
        ),
        ({'rotor.part': 'mems_gyro'}, 'part of a rotor in .*config/parts; the nearest is wheel'),
        (
            {'sensors.names': ['a'], 'sensors.a.part': 'gyro'},
            'part of a sensor in .*; the nearest is mems_gyro',
        ),
        (
            {'sensors.names': ['a'], 'sensors.a.type': 'magnetometer', 'sensors.a.part': 'gyro'},
            'part of a magnetometer in .*; the nearest is magneto_inductive_magnetometer',
        ),
        (
            {'sensors.names': ['sun_sensor'], 'sensors.sun_sensor.part': 'x'},
            'part of a sun_sensor in .*; there is none',
        ),
        (
            {'thruster.names': ['t'], 'thruster.t.part': 'gas'},
            r'thruster\.t\.part .* a part of a thruster in .*; the nearest is cold_gas_thruster_',
        ),
        (
            {'thruster.names': ['t'], 'thruster.s.part': 'cold_gas_thruster_55_mN'},
            'thruster.names has no s',
        ),
        ({'rotor.part': 3}, r'rotor\.part is 3; it must be a text'),
        ({'sensors.gyro.part': 'mems_gyro'}, r'sensors\.gyro\.part is given, and sensors\.names'),
        ({'rotor.names': ['a'], 'rotor.b.part': 'wheel_4_Nms'}, 'rotor.names has no b'),
        ({'rotor.names': ['a'], 'rotor.part': 'wheel_4_Nms'}, r'use rotor\.a\.part'),
    ],
)
def test_what_is_no_part_is_refused_in_one_sentence(given, sentence):
    """It names the key, the folder of the parts and the nearest that fits."""
    with pytest.raises(ValueError, match=sentence):
        Scenario(given)


def test_a_sweep_does_not_vary_a_part(tmp_path):
    """What it says is in the scenario already."""
    (tmp_path / 'scenario.yaml').write_text(SHEET)
    file = tmp_path / 'sweep.yaml'
    file.write_text(
        'scenario: scenario.yaml\nduration_s: 5\n'
        'vary: {rotor.rw_x.part: {values: [wheel_2_mNms, wheel_10_mNms]}}\n'
    )
    with pytest.raises(ValueError, match=r'rotor\.rw_x\.part varies; it must be the same'):
        Plan.from_yaml(file)

"""The loop closed by reaction wheels: their speeds in, their torques out."""

import subprocess
import sys

import numpy as np
import pytest
import yaml
from ros.live import PATIENCE_S, ROOT

from satdyn_ros.kernel import rotation
from satdyn_ros.run.parameter_file import ParameterFile

CONFIG = ROOT / 'config' / 'three_wheels.yaml'
PYRAMID = ROOT / 'config' / 'pyramid.yaml'
# Ten times as fast as the clock; no torque ends while a message is less than two seconds late.
CHANGES = {'publish.rate': 20.0, 'time.factor': 10.0, 'torque.timeout': 20.0}


def run(scenario, *arguments):
    """Return the exit code and what the controller says."""
    command = [sys.executable, 'examples/wheel_controller.py', str(scenario), *arguments]
    ran = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=300.0 + PATIENCE_S
    )
    return ran.returncode, ran.stdout + ran.stderr


def brought_to_rest(scenario, values, live):
    """Return the node's scenario and its wheels' names and speeds, once the satellite rests."""
    node, participant = live(values)
    attitudes, rates = participant.listen('attitude'), participant.listen('angular_velocity')
    rotors = participant.listen('rotor')
    code, said = run(scenario, '--ros-args', '-r', f'__ns:={node.namespace}')
    assert code == 0, said

    def rests():
        if not (attitudes and rates and rotors):
            return False
        q, omega = attitudes[-1].quaternion, rates[-1].velocity.angular
        error_rad = rotation.angle_between(rotation.IDENTITY, [q.x, q.y, q.z, q.w])
        rate_rad_s = np.linalg.norm([omega.x, omega.y, omega.z])
        return np.degrees(error_rad) < 0.1 and np.degrees(rate_rad_s) < 0.01

    participant.wait_until(rests, 'rest')
    return node.scenario, list(rotors[-1].name), np.array(rotors[-1].velocity)


@pytest.mark.long
def test_wheels_alone_bring_the_tumbling_cubesat_to_rest(live):
    """
    It comes to rest at the target, and the wheels then hold the momentum that the body had.

    From outside comes the gravity gradient's torque alone: 3 n^2 (0.02 kg m^2) / 2 = 4e-8 N m at
    most, 1.2e-4 N m s in the 3000 s after which the controller gives up.  At rest the body holds
    0.04 kg m^2 times 1.7e-4 rad/s, and 1.7e-3 rad off target turn 2.6e-3 N m s by 5e-6.
    """
    values = ParameterFile.read([CONFIG]).parameters('/satdyn') | CHANGES
    scenario, names, speeds = brought_to_rest(CONFIG, values, live)
    system, state = scenario.system, scenario.initial_state
    before_i = rotation.rotate(state.q_ib, system.inertia @ state.omega_bi_b)
    assert names == ['rw_x', 'rw_y', 'rw_z']
    np.testing.assert_allclose(1e-5 * speeds, before_i, atol=1.2e-4 + 7e-6 + 5e-6)


@pytest.mark.long
def test_four_wheels_turn_the_satellite_and_keep_their_alternate_spin(live, tmp_path):
    """
    The pseudo-inverse gives no torque to the combination of wheels that does not turn the body.

    With a = (a_1 - a_2 + a_3 - a_4) = 0 the sum s_1 - s_2 + s_3 - s_4 of the speeds, 400 rad/s at
    the start, then changes by friction alone, which is off here: what is left is rounding, of
    1e-16 of 400 rad/s in each of some 1e5 steps and commands.
    """
    values = ParameterFile.read([PYRAMID]).parameters('/satdyn') | CHANGES
    values |= {f'rotor.rw_{number}.friction': 0.0 for number in (1, 2, 3, 4)}
    without_friction = tmp_path / 'without_friction.yaml'
    without_friction.write_text(yaml.safe_dump({'/**': {'ros__parameters': values}}))
    _, names, speeds = brought_to_rest(without_friction, values, live)
    assert names == ['rw_1', 'rw_2', 'rw_3', 'rw_4']
    assert speeds @ [1.0, -1.0, 1.0, -1.0] == pytest.approx(400.0, abs=1e-8)


@pytest.mark.long
@pytest.mark.parametrize(
    ('limit', 'value', 'said'),
    [
        ('max_torque', 1e-4, 'saturates at 0.0001 N m'),
        ('max_speed', 50.0, 'saturates at 50 rad/s'),
    ],
)
def test_says_when_a_wheel_saturates(limit, value, said, live, tmp_path):
    """A tenth of the torque is too weak, and 50 rad/s hold less than the body's momentum."""
    values = ParameterFile.read([CONFIG]).parameters('/satdyn') | CHANGES
    values |= {f'rotor.{name}.{limit}': value for name in ('rw_x', 'rw_y', 'rw_z')}
    node, participant = live(values)
    participant.hear(participant.listen('rotor'), 1)  # it may have to compile first
    weak = tmp_path / 'weak.yaml'
    weak.write_text(yaml.safe_dump({'/**': {'ros__parameters': values}}))
    arguments = ('--timeout', '10', '--ros-args', '-r', f'__ns:={node.namespace}')
    code, output = run(weak, *arguments)
    assert code == 1
    assert said in output


@pytest.mark.parametrize('names', [[], ['rw_x', 'rw_y']])
def test_too_few_wheels_are_refused(names, tmp_path):
    """Motors about two axes cannot point a satellite, and it says so instead of starting."""
    values = {'rotor.names': names}
    for name, axis in zip(names, np.eye(3).tolist(), strict=False):
        values |= {f'rotor.{name}.mode': 'motor', f'rotor.{name}.axis': axis}
        values |= {f'rotor.{name}.inertia': 1.0}
    few = tmp_path / 'few.yaml'
    few.write_text(yaml.safe_dump({'/**': {'ros__parameters': values}}))
    code, said = run(few)
    assert code == 2
    assert 'their axes must span space' in said
    assert 'Traceback' not in said

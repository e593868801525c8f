"""The loop closed by the measurements alone: sensors, estimator, controller, torque."""

import subprocess
import sys

import numpy as np
import pytest
from geometry_msgs.msg import QuaternionStamped
from ros.live import PATIENCE_S, ROOT, stamp_ns

from satdyn_ros.kernel import rotation
from satdyn_ros.run.parameter_file import ParameterFile
from satdyn_ros.run.scenario import Scenario

CONFIG = ROOT / 'config' / 'cubesat_sensors.yaml'
# A turn of 20 degrees, which a machine with much else to do sees through too.
CHANGES = {
    'initial.attitude': rotation.about([0.0, 0.0, 1.0], np.radians(20.0)).tolist(),
    'initial.angular_velocity': [0.0, 0.0, 0.01],
}
LEO = ROOT / 'config' / 'cubesat_leo.yaml'
# The Sun comes into view after 3 minutes, and the shadow after 18.
LEO_CHANGES = {'publish.rate': 1.0, 'time.epoch': '2008-09-20T13:30:00Z'}


def start(program, namespace, *arguments):
    command = [sys.executable, f'examples/{program}.py', *arguments, '--ros-args', '-r']
    return subprocess.Popen([*command, f'__ns:={namespace}'], cwd=ROOT, stdout=subprocess.PIPE)


@pytest.mark.long
def test_the_satellite_is_pointed_by_its_estimate(live):
    """It settles where the estimate says, and truth and estimate agree within 5 arc minutes."""
    values = ParameterFile.read([CONFIG]).parameters('/satdyn') | CHANGES
    node, participant = live(values)
    estimator = start('estimator', node.namespace, str(CONFIG))
    controller = start('controller', node.namespace, '--estimate', '--timeout', '300')
    try:
        assert controller.wait(300.0 + PATIENCE_S) == 0
        truth = participant.hear(participant.listen('attitude'), 1)[0].quaternion
        error_rad = rotation.angle_between(rotation.IDENTITY, [truth.x, truth.y, truth.z, truth.w])
        assert np.degrees(error_rad) < 0.1 + 5.0 / 60.0
    finally:
        for process in (estimator, controller):
            process.kill()
            process.communicate()


@pytest.mark.long
def test_field_and_sun_give_the_attitude(live, tmp_path):
    """
    A minute after the first estimate it is within 3 degrees of the true one of the same stamp.

    The filter states a sigma of 0.6 degrees there: it does not know the biases yet.
    """
    values = ParameterFile.read([LEO]).parameters('/satdyn') | LEO_CHANGES
    epoch_ns = Scenario(values).epoch_ns
    values |= {'time.epoch': '', 'time.epoch_ns': epoch_ns, 'time.factor': 10.0}
    node, participant = live(values)
    truths = participant.listen('attitude')
    estimates: list[QuaternionStamped] = []
    participant.node.create_subscription(
        QuaternionStamped, 'estimate/attitude', estimates.append, 1000
    )
    estimator = start(
        'estimator', node.namespace, str(tmp_path / f'{node.namespace.strip("/")}.yaml')
    )
    try:
        participant.hear(estimates, 60)
        last = estimates[-1]
        participant.wait_until(
            lambda: stamp_ns(last) in map(stamp_ns, truths), 'the truth of the estimate'
        )
        (truth,) = (some for some in truths if stamp_ns(some) == stamp_ns(last))
        q, p = (
            [x.quaternion.x, x.quaternion.y, x.quaternion.z, x.quaternion.w] for x in (last, truth)
        )
        assert np.degrees(rotation.angle_between(q, p)) < 3.0
    finally:
        estimator.kill()
        estimator.communicate()

"""The loop closed by the measurements alone: sensors, estimator, controller, torque."""

import subprocess
import sys

import numpy as np
import pytest
from ros.live import PATIENCE_S, ROOT

from satdyn_ros.kernel import rotation
from satdyn_ros.run.parameter_file import ParameterFile

CONFIG = ROOT / 'config' / 'cubesat_sensors.yaml'
# A turn of 20 degrees, which a machine with much else to do sees through too.
CHANGES = {
    'initial.attitude': rotation.about([0.0, 0.0, 1.0], np.radians(20.0)).tolist(),
    'initial.angular_velocity': [0.0, 0.0, 0.01],
}


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

"""The tumbling of a CubeSat, damped by magnetorquers and the field that it measures alone."""

import re
import subprocess
import sys

import numpy as np
import pytest
from ros.live import PATIENCE_S, ROOT

from satdyn_ros.run.parameter_file import ParameterFile
from satdyn_ros.run.scenario import Scenario

PAGE = (ROOT / 'docs' / 'how-to' / 'detumble.md').read_text()
(FILE,) = re.findall(r'^```yaml detumble\.yaml\n(.*?)^```$', PAGE, re.MULTILINE | re.DOTALL)
ORBIT_S = 5544.0


@pytest.mark.long
def test_a_cubesat_is_detumbled_within_an_orbit(live):
    """
    From 10 deg/s to less than 0.2, at 1 Hz in lockstep: the same flight on every machine.

    The loop ends when the field has been slow for half an orbit: the body then is, about any axis.
    """
    values = ParameterFile.of_texts([(FILE, 'detumble.yaml')]).parameters('/satdyn')
    scenario = Scenario(values)
    # A node is not to spend the patience of the loop on its compiler.
    scenario.motion().at(0.0)
    at_tick_0 = {'time.epoch': '', 'time.epoch_ns': scenario.epoch_ns, 'time.factor': 1e-6}
    node, participant = live(values | at_tick_0)
    rates = participant.listen('angular_velocity')
    command = [sys.executable, 'examples/bdot.py', '--lockstep']
    done = subprocess.run(
        [*command, '--ros-args', '-r', f'__ns:={node.namespace}'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=10 * PATIENCE_S,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    samples = int(done.stdout.split()[-2])
    assert samples < ORBIT_S
    participant.wait_until(lambda: len(rates) >= samples, 'the samples')
    first, last = (
        np.degrees(np.linalg.norm([omega.x, omega.y, omega.z]))
        for omega in (rates[0].velocity.angular, rates[-1].velocity.angular)
    )
    assert first > 9.9
    assert last < 0.2

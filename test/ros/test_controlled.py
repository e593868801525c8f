"""A controller in the node: it commands at ticks, as a file of a user's own says."""

import numpy as np

from satdyn_ros.actuators import Command
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify

DAMPER = """
class Damper:
    period_s, needs_truth = 0.1, True

    def __init__(self, gain):
        self.gain = gain

    def command(self, sample):
        if sample.t_s > 3.0:
            raise RuntimeError('no more')
        return {'torque_b': (-self.gain * sample.omega_bi_b).tolist()}
"""
FREE = {
    'orbit.type': 'fixed',
    'initial.frame': 'inertial',
    'initial.angular_velocity': [0.01, 0.02, 0.03],
    'publish.rate': 50.0,
    'publish.topics': ['angular_velocity'],
    'record.enabled': True,
}


def test_it_damps_and_its_failure_ends_the_node_in_a_sentence(live, tmp_path):
    """Every fifth tick has its command; the bag up to the last tick verifies without it."""
    (tmp_path / 'damper.py').write_text(DAMPER)
    made = ['--controller', 'damper.py:Damper', '--controller-parameter', 'gain=500.0']
    node, participant = live(FREE, options=made)
    participant.wait_until(lambda: node.process.poll() is not None, 'the end of the node')
    code, errors = node.end()
    assert code == 1
    where = rf'the controller damper:Damper failed at 3.1 s in {tmp_path / "damper.py"}, line 10'
    assert f'the ticks have ended: {where}: RuntimeError: no more' in errors
    assert 'Traceback' not in errors

    (directory,) = tmp_path.glob('satdyn_*_*')
    verdict = verify(directory)
    assert verdict.same_bytes, str(verdict)
    run = RecordedRun(directory)
    commands = [event for event in run.events if isinstance(event, Command)]
    assert [event.tick for event in commands] == [*range(0, 155, 5)]
    sizes = [np.linalg.norm(event.value) for event in commands]
    assert sizes == sorted(sizes, reverse=True)

import os
from pathlib import Path

import pytest
from ros.live import LiveNode, Participant

from satdyn_ros.run.scenario import Scenario

os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(Path(__file__).parent / 'discovery.xml')


@pytest.fixture(scope='session', autouse=True)
def _ros(ros):
    # A node is not to spend the patience of a test on its compiler.
    Scenario().motion().at(0.0)


@pytest.fixture
def live(tmp_path):
    """Return a function that starts a node and a participant beside it; both end with the test."""
    running = []

    def begin(values=None, **kwargs):
        node = LiveNode(tmp_path, values or {}, **kwargs)
        participant = Participant(node.namespace)
        running.append((node, participant))
        return node, participant

    yield begin
    for node, participant in running:
        participant.close()
        node.end()


@pytest.fixture(scope='module')
def live_pair():
    """Return two participants that share nothing but the wire."""
    pair = Participant('/pair'), Participant('/pair')
    yield pair
    for participant in pair:
        participant.close()

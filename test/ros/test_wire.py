"""The wire is standard: a participant of another vendor, without ROS, receives its messages."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from ros.live import EPOCH_NS, PATIENCE_S

from satdyn_ros.run.simulation import Simulation

LOOPBACK = """
<CycloneDDS><Domain><General>
<Interfaces><NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast>
</General><Discovery>
<ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers>
</Discovery></Domain></CycloneDDS>
"""


def test_cyclonedds_hears_the_attitude(live):
    """Stamps, frame and the numbers' bits are those of the engine, without a gap."""
    pytest.importorskip('cyclonedds')
    node, _ = live({'publish.topics': ['attitude']})
    program = Path(__file__).parent / 'cyclone_listener.py'
    listener = subprocess.run(
        [
            *(sys.executable, str(program), f'rt{node.namespace}/attitude'),
            *(os.environ['ROS_DOMAIN_ID'], '50'),
        ],
        env=os.environ | {'CYCLONEDDS_URI': LOOPBACK},
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE_S,
    )
    assert listener.returncode == 0, listener.stderr
    heard = [line.split() for line in listener.stdout.splitlines()]
    assert len(heard) >= 50
    ticks = [(int(stamp_ns) - EPOCH_NS) // 10**7 for stamp_ns, *_ in heard]
    assert ticks == list(range(ticks[0], ticks[-1] + 1))
    _, samples = Simulation(node.scenario).advance(ticks[-1] + 1)
    for tick, (_, frame, *numbers) in zip(ticks, heard, strict=True):
        assert frame == 'inertial'
        assert [float.fromhex(x) for x in numbers] == samples.states.q_ib[tick].tolist()

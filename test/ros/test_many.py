"""Many satellites: namespaces and processes, or one executor."""

import pytest
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from ros.live import EPOCH_NS, PATIENCE_S, Participant, expected, raw_stamp_ns

from satdyn_ros.bag.verify import verify
from satdyn_ros.ros.node import SatdynNode
from satdyn_ros.run.scenario import Scenario

COUNT = 8
# Eight nodes share the machine with whatever else runs.
RATE_HZ = 10


def values(i):
    """Return the parameters of satellite i: its own frames and its own position on the orbit."""
    return {
        'time.epoch_ns': EPOCH_NS,
        'publish.rate': float(RATE_HZ),
        'publish.topics': ['attitude'],
        'orbit.true_anomaly': 0.7 * i,
        'frames.body': f'sat{i}/base_link',
    }


@pytest.mark.long
def test_eight_nodes_side_by_side_keep_apart(live):
    """Each stream is that of its own scenario, and a request reaches one alone."""
    begun = [live(values(i), namespace=f'/sat{i}') for i in range(COUNT)]
    heard = [participant.listen('attitude', raw=True) for _, participant in begun]
    for (_, participant), messages in zip(begun, heard, strict=True):
        participant.hear(messages, 3, COUNT * PATIENCE_S)
    assert begun[3][1].request({'initial.attitude': [0.0, 0.0, 0.0, 1.0]})[0]
    for i, ((node, participant), messages) in enumerate(zip(begun, heard, strict=True)):
        participant.hear(messages, 10)
        ticks = (raw_stamp_ns(messages[-1]) - EPOCH_NS) // (10**9 // RATE_HZ) + 1
        packed = expected(node.scenario, 'attitude', ticks)
        as_alone = [packed[raw_stamp_ns(data)] == data for data in messages]
        assert all(as_alone) == (i != 3)
    for node, _ in begun:
        code, errors = node.end()
        unexpected = [line for line in errors.splitlines() if not line.startswith('[INFO] ')]
        assert (code, unexpected) == (0, [])


def test_nodes_composed_in_one_process(tmp_path):
    """Three satellites and a listener share an executor; each ends alone and closes its bag."""
    nodes = [
        SatdynNode(
            {'record.directory': str(tmp_path), 'record.enabled': True},
            namespace=f'/composed{i}',
            parameter_overrides=[Parameter(name, value=x) for name, x in values(i).items()],
        )
        for i in range(3)
    ]
    listener = Participant('/composed1')
    executor = SingleThreadedExecutor()
    for node in (*nodes, listener.node):
        executor.add_node(node)
    heard = listener.listen('attitude', raw=True)
    try:
        while len(heard) < 10:
            executor.spin_once()
        executor.remove_node(nodes[0])
        nodes[0].destroy_node()
        while len(heard) < 20:
            executor.spin_once()
        packed = expected(Scenario(values(1)), 'attitude', 10000)
        assert all(packed[raw_stamp_ns(data)] == data for data in heard)
    finally:
        executor.shutdown()
        for node in nodes:
            node.destroy_node()
        listener.close()
    bags = sorted(tmp_path.glob('satdyn_*_*'))
    assert len(bags) == 3
    assert all(verify(bag).same_bytes for bag in bags)

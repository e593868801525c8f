"""Nodes that begin and end again and again in one process leave nothing behind."""

import json
import os
import subprocess
import sys

import pytest
from ros.live import ROOT

PROGRAM = """
import json, sys, threading
import rclpy
from ros.process import descriptor_count, memory_bytes
from satdyn_ros.ros.node import SatdynNode

count, directory = int(sys.argv[1]), sys.argv[2]
held = []
for number in range(count):
    rclpy.init()
    values = {'publish.rate': 1000.0, 'record.enabled': True, 'record.directory': directory}
    node = SatdynNode(values, namespace=f'restart{number % 7}')
    while node.count_publishers('attitude') == 0:
        pass
    rclpy.spin_once(node, timeout_sec=0.01)
    node.destroy_node()
    rclpy.shutdown()
    held.append((memory_bytes(), descriptor_count(), threading.active_count()))
print(json.dumps(held))
"""
# The allocator's slack over a few starts; the buffer of a chunk alone is more.
ALLOWED_BYTES = 1_000_000


@pytest.mark.parametrize('count', [8, pytest.param(200, marks=pytest.mark.torture)])
def test_starts_and_stops_in_one_process(tmp_path, capsys, count):
    """Threads and descriptors are as few at the end as at the start, and memory is flat."""
    result = subprocess.run(
        [sys.executable, '-c', PROGRAM, str(count), str(tmp_path)],
        env=os.environ | {'PYTHONPATH': f'{ROOT}:{ROOT / "test"}'},
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    assert 'Traceback' not in result.stderr
    held = json.loads(result.stdout.splitlines()[-1])
    half = count // 2
    assert held[-1][1:] == held[half][1:]
    growth = (held[-1][0] - held[half][0]) / (count - 1 - half)
    with capsys.disabled():
        print(f'\n{count} starts and stops: {growth:.0f} bytes each in the second half')
    assert growth < ALLOWED_BYTES
    assert len(list(tmp_path.glob('*/metadata.yaml'))) == count

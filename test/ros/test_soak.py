"""A node that runs for hours: no gap, flat memory and descriptors, a bag that verifies."""

import numpy as np
import pytest
from ros.live import EPOCH_NS
from ros.process import descriptors, memory_bytes

from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag

RATE_HZ, FACTOR = 10, 1000
VALUES = {
    'publish.rate': float(RATE_HZ),
    'publish.topics': ['attitude', 'angular_velocity'],
    'time.factor': float(FACTOR),
    'record.enabled': True,
}
# The allocator's own slack.
ALLOWED_BYTES = 20_000_000


@pytest.mark.long
@pytest.mark.parametrize(
    ('hours', 'split_s'), [(1, 1200.0), pytest.param(24, 7200.0, marks=pytest.mark.torture)]
)
def test_soak(live, tmp_path, capsys, hours, split_s):
    """Hours at a thousand times the wall clock, split into files."""
    node, participant = live(VALUES | {'record.max_duration_s': split_s})
    heard = participant.listen('attitude', raw=True, depth=100)
    participant.hear(heard, 1)
    held, of_bag, others = [], [], []
    end_ns = EPOCH_NS + hours * 3600 * 10**9
    while _stamp_ns(heard) < end_ns:
        del heard[:-1]
        participant.spin(0.5)
        held.append(memory_bytes(node.process.pid))
        opened = descriptors(node.process.pid)
        of_bag.append(sum(str(tmp_path) in name for name in opened))
        others.append(len(opened) - of_bag[-1])
    code, errors = node.end()
    assert code == 0
    assert 'Traceback' not in errors

    (directory,) = tmp_path.glob('satdyn_*_*')
    stamps_ns = Bag(directory).messages(f'{node.namespace}/attitude').log_times_ns
    gaps = np.count_nonzero(np.diff(stamps_ns.astype(np.int64)) != 10**9 // RATE_HZ)
    half = held[len(held) // 2 :]
    growth = max(half) - half[0]
    files = len(list(directory.glob('*.mcap')))
    with capsys.disabled():
        print(
            f'\n{len(stamps_ns)} ticks, {hours} h at factor {FACTOR}: {gaps} gaps, {files} files, '
            f'{growth / 1e6:.1f} MB more in the second half'
        )
    assert gaps == 0
    assert files > hours * 3600 / split_s
    assert growth < ALLOWED_BYTES
    # One file may still be being closed while the next is open and metadata.yaml is written.
    assert max(of_bag) <= 3
    assert len(set(others[len(others) // 2 :])) == 1
    verdict = verify(directory)
    assert verdict.is_true, str(verdict)
    assert verdict.same_bytes


def _stamp_ns(heard):
    data = heard[-1]
    return int.from_bytes(data[4:8], 'little') * 10**9

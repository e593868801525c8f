"""What a first-time user sees: the line of the node that starts, and README's subscriber."""

import os
import re
import subprocess
import sys

from ros.live import ROOT

(SUBSCRIBER,) = re.findall(
    r'## In ROS.*?```python\n(.*?)```', (ROOT / 'README.md').read_text(encoding='utf-8'), re.S
)


def test_a_warm_node_says_in_one_line_what_it_does(live):
    """Topics, rate, epoch and bag; nothing else stands on stderr until it ends."""
    node, participant = live({'publish.topics': ['attitude', 'odometry'], 'publish.rate': 20.0})
    participant.hear(participant.listen('attitude'), 3)
    code, errors = node.end()
    assert code == 0
    line, last = errors.splitlines()
    assert 'attitude, odometry at 20 Hz' in line
    assert '2023-11-14 22:13:20 UTC; not recording' in line
    assert 'lateness' in last


def test_the_subscriber_of_the_readme_hears_a_node_each_time(live):
    """Whenever it is started, it prints a quaternion."""
    _, participant = live({}, namespace='/')
    participant.hear(participant.listen('attitude'), 1)
    for _ in range(5):
        done = subprocess.run(
            [sys.executable, '-c', SUBSCRIBER], env=os.environ, capture_output=True, text=True
        )
        assert done.stdout.startswith('geometry_msgs.msg.Quaternion('), done.stderr

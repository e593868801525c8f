"""What a first-time user sees: the line of the node that starts."""


def test_a_warm_node_says_in_one_line_what_it_does(live):
    """Topics, rate, epoch and bag; nothing else stands on stderr until it ends."""
    node, participant = live({'publish.topics': ['attitude', 'odometry'], 'publish.rate': 20.0})
    participant.hear(participant.listen('attitude'), 3)
    code, errors = node.end()
    assert code == 0
    line, last = errors.splitlines()
    assert 'attitude, odometry at 20 Hz' in line
    assert '2023-11-14 22:13:20.000000 UTC; not recording' in line
    assert 'lateness' in last

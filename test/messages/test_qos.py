import pytest
import yaml
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos

from satdyn_ros.messages import qos


@pytest.mark.parametrize(
    ('rate_hz', 'depth'),
    [(100, 100), (1 / 3, 10), (10, 10), (10.5, 11), (10_000, 10_000), (1e9, 20_000), (0, 20_000)],
)
def test_state_topics_keep_one_second_of_ticks(rate_hz, depth):
    """Reliable and volatile, keep last one wall second, 10 to 20 000; 0 is as fast as it goes."""
    expected = qos.Qos(depth, reliability='reliable', durability='volatile', history='keep_last')
    assert qos.state_topics(rate_hz) == expected


@pytest.mark.parametrize('profile', [qos.state_topics(100), qos.INPUTS, qos.CLOCK])
def test_text_is_what_rosbag2_reads_and_another_program_writes(profile):
    """Another program's reader finds the profile, and its writer writes the same mapping."""
    (parsed,) = parse_qos(profile.to_yaml())
    assert parsed.depth == profile.depth
    words = (parsed.history.name, parsed.reliability.name, parsed.durability.name)
    assert words == ('KEEP_LAST', profile.reliability.upper(), 'VOLATILE')
    assert yaml.safe_load(profile.to_yaml()) == dump_qos_v9([parsed])


def test_text_is_that_of_a_recorded_bag():
    """The layout of rosbag2 0.26.5, key for key and without an end of line."""
    forever = '    sec: 9223372036\n    nsec: 854775807\n'
    assert qos.Qos(7).to_yaml() == (
        '- history: keep_last\n  depth: 7\n  reliability: reliable\n  durability: volatile\n'
        f'  deadline:\n{forever}  lifespan:\n{forever}  liveliness: automatic\n'
        f'  liveliness_lease_duration:\n{forever}  avoid_ros_namespace_conventions: false'
    )

"""The managed node, driven over the wire by the services that `ros2 lifecycle` calls."""

from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from ros.live import EPOCH_NS, stamp_ns
from rosbags.highlevel import AnyReader

RATE_HZ = 50.0
PERIOD_NS = 20_000_000


def managed(live, values):
    return live({'publish.rate': RATE_HZ} | values, module='lifecycle_node')


def state(participant):
    return participant.call(GetState, 'satdyn/get_state', GetState.Request()).current_state.label


def change(participant, label):
    """Ask for a transition by its name, as `ros2 lifecycle set` does; return whether it worked."""
    request = ChangeState.Request(transition=Transition(label=label))
    return participant.call(ChangeState, 'satdyn/change_state', request).success


def own_services(participant, node):
    nodes = participant.node.get_node_names_and_namespaces
    participant.wait_until(lambda: ('satdyn', node.namespace) in nodes(), 'the node')
    names = participant.node.get_service_names_and_types_by_node('satdyn', node.namespace)
    return {name.rpartition('/')[2] for name, _ in names}


def bag_stamps_ns(directory):
    """Return the stamps of a bag's attitudes, as read by rosbags."""
    with AnyReader([directory]) as reader:
        connections = [c for c in reader.connections if c.topic.endswith('/attitude')]
        return [
            stamp_ns_of(reader.deserialize(data, connection.msgtype))
            for connection, _, data in reader.messages(connections)
        ]


def stamp_ns_of(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def test_ticks_follow_the_transitions(live, tmp_path):
    """No tick but in active; none is skipped; each cleanup leaves a whole bag and nothing else."""
    bags = tmp_path / 'bags'
    values = {'record.enabled': True, 'record.directory': str(bags)}
    node, participant = managed(live, values)
    heard = participant.listen('attitude')
    assert state(participant) == 'unconfigured'
    before = own_services(participant, node)

    assert change(participant, 'configure')
    assert state(participant) == 'inactive'
    participant.spin(0.3)
    assert not heard
    assert change(participant, 'activate')
    assert state(participant) == 'active'
    participant.hear(heard, 5)
    assert 'set_initial_conditions' in own_services(participant, node)

    assert change(participant, 'deactivate')
    assert state(participant) == 'inactive'
    participant.spin(0.3)
    count = len(heard)
    for success, sentence in (participant.trigger('step'), participant.switch('pause', False)):
        assert not success
        assert sentence == 'the node is inactive; ticks pass while it is active'
    participant.spin(0.3)
    assert len(heard) == count
    assert change(participant, 'activate')
    participant.hear(heard, 5)
    assert change(participant, 'deactivate')
    participant.spin(0.3)
    stamps_ns = [stamp_ns(message) for message in heard]
    assert stamps_ns == list(range(stamps_ns[0], stamps_ns[-1] + 1, PERIOD_NS))

    assert change(participant, 'cleanup')
    assert state(participant) == 'unconfigured'
    (bag,) = bags.iterdir()
    assert bag_stamps_ns(bag) == list(range(EPOCH_NS, stamps_ns[-1] + 1, PERIOD_NS))
    participant.wait_until(lambda: own_services(participant, node) == before)
    participant.wait_until(lambda: participant.node.count_publishers('attitude') == 0)

    # What the file says by then.
    node.write(node.values | {'publish.rate': RATE_HZ / 2})
    assert change(participant, 'configure')
    heard.clear()
    assert change(participant, 'activate')
    first, second = participant.hear(heard, 2)[:2]
    assert stamp_ns(second) - stamp_ns(first) == 2 * PERIOD_NS
    assert participant.get('publish.rate') == RATE_HZ / 2
    assert change(participant, 'shutdown')
    assert state(participant) == 'finalized'
    (other,) = set(bags.iterdir()) - {bag}
    assert bag_stamps_ns(other)[0] == EPOCH_NS
    code, errors = node.end()
    assert code == 0
    assert 'Traceback' not in errors


def test_what_fails_leaves_the_node_unconfigured(live, tmp_path):
    """A scenario that is refused, and a bag that cannot be made, each in a sentence."""
    (tmp_path / 'file').write_text('')
    node, participant = managed(live, {'body.inertia': [1.0, 1.0, 5.0]})
    assert not change(participant, 'configure')
    assert state(participant) == 'unconfigured'
    node.write({'record.enabled': True, 'record.directory': str(tmp_path / 'file')})
    assert change(participant, 'configure')
    assert not change(participant, 'activate')
    assert state(participant) == 'unconfigured'
    node.write({})
    assert change(participant, 'configure')
    assert change(participant, 'activate')
    heard = participant.listen('attitude')
    participant.hear(heard, 3)
    code, errors = node.end()
    assert code == 0
    assert 'body.inertia' in errors
    assert str(tmp_path / 'file') in errors
    assert 'Traceback' not in errors


def test_transitions_that_are_not_to_be_had_are_answered(live):
    """By their ids too; the node goes on to say which there are."""
    _, participant = managed(live, {})
    for transition in (
        Transition(id=Transition.TRANSITION_ACTIVATE),
        Transition(id=200),
        Transition(label='none'),
    ):
        request = ChangeState.Request(transition=transition)
        assert not participant.call(ChangeState, 'satdyn/change_state', request).success
    states = participant.call(
        GetAvailableStates, 'satdyn/get_available_states', GetAvailableStates.Request()
    ).available_states
    assert {State.PRIMARY_STATE_INACTIVE, State.PRIMARY_STATE_FINALIZED} <= {s.id for s in states}
    found = participant.call(
        GetAvailableTransitions,
        'satdyn/get_available_transitions',
        GetAvailableTransitions.Request(),
    ).available_transitions
    assert {each.transition.label for each in found} == {'configure', 'shutdown'}

"""The node under the names of simulation_interfaces; skipped where that is not installed."""

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Vector3
from rclpy.action import ActionClient
from ros.live import stamp_ns
from scipy.spatial.transform import Rotation

msg = pytest.importorskip('simulation_interfaces.msg')
srv = pytest.importorskip('simulation_interfaces.srv')
action = pytest.importorskip('simulation_interfaces.action')

RESULT = msg.Result
STATE = msg.SimulationState


def call(participant, kind, name, **fields):
    """Call a service with nested values of its request; return its answer."""
    return participant.call(kind, f'satdyn/{name}', kind.Request(**fields))


def test_features_are_those_that_answer(live):
    """State of the simulation and of the one entity, steps, and a reset of the state alone."""
    _, participant = live()
    participant.hear(participant.listen('attitude'), 1)
    features = call(participant, srv.GetSimulatorFeatures, 'get_simulator_features').features
    assert sorted(features.features) == [10, 11, 20, 22, 24, 25, 26, 31, 32, 33]
    filters = msg.EntityFilters(filter='sat')
    found = call(participant, srv.GetEntities, 'get_entities', filters=filters)
    assert (found.result.result, list(found.entities)) == (RESULT.RESULT_OK, ['satdyn'])
    found = call(participant, srv.GetEntitiesStates, 'get_entities_states', filters=filters)
    assert list(found.entities) == ['satdyn']
    (state,) = found.states
    position = state.pose.position
    for kind, radius, code, names in (
        (msg.Bounds.TYPE_SPHERE, 1e6, RESULT.RESULT_OK, ['satdyn']),
        (msg.Bounds.TYPE_SPHERE, 1.0, RESULT.RESULT_OK, []),
        (msg.Bounds.TYPE_BOX, 1e6, RESULT.RESULT_FEATURE_UNSUPPORTED, []),
    ):
        # Beside it by a thousand times what it travels while this is asked.
        points = [Vector3(x=position.x, y=position.y, z=position.z + 5e5), Vector3(x=radius)]
        filters = msg.EntityFilters(bounds=msg.Bounds(type=kind, points=points))
        found = call(participant, srv.GetEntities, 'get_entities', filters=filters)
        assert (found.result.result, list(found.entities)) == (code, names)
    filters = msg.EntityFilters(tags=msg.TagsFilter(tags=['a']))
    found = call(participant, srv.GetEntities, 'get_entities', filters=filters)
    assert found.result.result == RESULT.RESULT_FEATURE_UNSUPPORTED


def test_the_simulation_is_paused_stepped_and_played(live):
    """A step returns when its ticks have come; one while playing, and a stop, are refused."""
    _, participant = live({'publish.rate': 50.0})

    def state():
        return call(participant, srv.GetSimulationState, 'get_simulation_state').state.state

    def change(wanted):
        asked = STATE(state=wanted)
        answer = call(participant, srv.SetSimulationState, 'set_simulation_state', state=asked)
        return answer.result.result

    def step(steps):
        return call(participant, srv.StepSimulation, 'step_simulation', steps=steps).result

    heard = participant.listen('attitude')
    participant.hear(heard, 3)
    assert state() == STATE.STATE_PLAYING
    assert change(STATE.STATE_PLAYING) == 101
    assert step(1).result == RESULT.RESULT_OPERATION_FAILED
    assert change(STATE.STATE_STOPPED) == RESULT.RESULT_FEATURE_UNSUPPORTED
    assert change(STATE.STATE_PAUSED) == RESULT.RESULT_OK
    assert state() == STATE.STATE_PAUSED
    participant.spin(0.2)
    last_ns = stamp_ns(heard[-1])
    assert step(7).result == RESULT.RESULT_OK
    participant.hear(heard, 0)
    participant.wait_until(lambda: stamp_ns(heard[-1]) == last_ns + 7 * 20_000_000)
    assert step(0).result == RESULT.RESULT_OPERATION_FAILED
    assert change(STATE.STATE_PLAYING) == RESULT.RESULT_OK
    participant.hear(heard, 3)


def test_the_state_is_read_set_and_reset_in_inertial_axes(live):
    """The twist is in the header's frame, as the standard has it; odometry's is in body axes."""
    _, participant = live({'publish.rate': 20.0, 'publish.topics': ['odometry']})
    heard = participant.listen('odometry')
    participant.hear(heard, 3)
    assert participant.switch('pause', True)[0]
    participant.spin(0.2)
    read = call(participant, srv.GetEntityState, 'get_entity_state', entity='satdyn')
    assert read.result.result == RESULT.RESULT_OK
    (shown,) = (m for m in heard if stamp_ns(m) == stamp_ns(read.state))
    assert read.state.header.frame_id == shown.header.frame_id == 'inertial'
    assert read.state.pose == shown.pose.pose
    turn = Rotation.from_quat(xyzw(read.state.pose.orientation))
    for ours, theirs in (
        (shown.twist.twist.linear, read.state.twist.linear),
        (shown.twist.twist.angular, read.state.twist.angular),
    ):
        # Roundings of 7.6 km/s.
        np.testing.assert_allclose(turn.apply(xyz(ours)), xyz(theirs), rtol=0.0, atol=1e-11)

    wanted = read.state
    wanted.twist.angular.z = 0.25
    answer = call(
        participant,
        srv.SetEntityState,
        'set_entity_state',
        **{'entity': 'satdyn', 'state': wanted},
        **{f: True for f in ('set_pose', 'set_twist') if hasattr(srv.SetEntityState.Request, f)},
    )
    assert answer.result.result == RESULT.RESULT_OK, answer.result.error_message
    for steps in (0, 1):
        if steps:
            step = call(participant, srv.StepSimulation, 'step_simulation', steps=steps)
            assert step.result.result == RESULT.RESULT_OK
        read = call(participant, srv.GetEntityState, 'get_entity_state', entity='satdyn')
        np.testing.assert_allclose(
            xyz(read.state.twist.angular), xyz(wanted.twist.angular), rtol=0.0, atol=1e-15
        )
    r, a = xyz(read.state.pose.position), xyz(read.state.acceleration.linear)
    assert np.cross(r, a) == pytest.approx(np.zeros(3), abs=1.0)
    assert np.linalg.norm(a) == pytest.approx(3.986004418e14 / np.dot(r, r), rel=1e-9)
    assert participant.get('initial.frame') == 'inertial'

    wanted.header.frame_id = 'map'
    answer = call(
        participant, srv.SetEntityState, 'set_entity_state', entity='satdyn', state=wanted
    )
    assert answer.result.result == RESULT.RESULT_FEATURE_UNSUPPORTED
    wanted.header.frame_id = ''
    wanted.pose.orientation.w += 1.0
    request = {'entity': 'satdyn', 'state': wanted}
    if hasattr(srv.SetEntityState.Request, 'set_pose'):
        request['set_pose'] = True
    answer = call(participant, srv.SetEntityState, 'set_entity_state', **request)
    assert answer.result.result == srv.SetEntityState.Response.INVALID_POSE
    assert 'initial.attitude' in answer.result.error_message
    answer = call(participant, srv.GetEntityState, 'get_entity_state', entity='other')
    assert answer.result.result == RESULT.RESULT_NOT_FOUND
    for scope, code in ((1, RESULT.RESULT_FEATURE_UNSUPPORTED), (2, RESULT.RESULT_OK)):
        answer = call(participant, srv.ResetSimulation, 'reset_simulation', scope=scope)
        assert answer.result.result == code
    # Those of the file, at once.
    assert 'initial conditions of the scenario' in answer.result.error_message
    read = call(participant, srv.GetEntityState, 'get_entity_state', entity='satdyn')
    assert np.linalg.norm(xyz(read.state.twist.angular)) < 2e-3


def test_a_pause_ends_a_step(live):
    """The step says how far it came, and the node stays paused."""
    _, participant = live({'publish.rate': 50.0})
    heard = participant.listen('attitude')
    participant.hear(heard, 1)
    assert participant.switch('pause', True)[0]
    client = participant.node.create_client(srv.StepSimulation, 'satdyn/step_simulation')
    participant.wait_until(client.service_is_ready)
    participant.wait_until_known('satdyn')
    future = client.call_async(srv.StepSimulation.Request(steps=10**9))
    participant.hear(heard, 5)
    paused = STATE(state=STATE.STATE_PAUSED)
    answer = call(participant, srv.SetSimulationState, 'set_simulation_state', state=paused)
    assert answer.result.result == RESULT.RESULT_OK
    participant.wait_until(future.done)
    assert future.result().result.result == RESULT.RESULT_OPERATION_FAILED
    assert 'of 1000000000 ticks passed' in future.result().result.error_message


def test_the_action_tells_of_each_step_and_can_be_cancelled(live):
    """A goal while playing, or of no step, is aborted with a sentence; a node ends during one."""
    node, participant = live({'publish.rate': 50.0})
    heard = participant.listen('attitude')
    participant.hear(heard, 1)
    client = ActionClient(participant.node, action.SimulateSteps, 'satdyn/simulate_steps')
    participant.wait_until(client.server_is_ready)

    def begin(steps):
        feedback = []
        goal = action.SimulateSteps.Goal(steps=steps)
        sent = client.send_goal_async(goal, lambda message: feedback.append(message.feedback))
        participant.wait_until(sent.done)
        assert sent.result().accepted
        return sent.result(), feedback

    def end(goal):
        result = goal.get_result_async()
        participant.wait_until(result.done)
        answer = result.result()
        return answer.status, answer.result.result.result, answer.result.result.error_message

    failed = GoalStatus.STATUS_ABORTED, RESULT.RESULT_OPERATION_FAILED
    *codes, sentence = end(begin(3)[0])
    assert tuple(codes) == failed
    assert 'not paused' in sentence
    assert participant.switch('pause', True)[0]
    *codes, sentence = end(begin(0)[0])
    assert tuple(codes) == failed
    assert 'steps is 0' in sentence

    participant.spin(0.2)
    last_ns = stamp_ns(heard[-1])
    goal, feedback = begin(7)
    assert end(goal) == (GoalStatus.STATUS_SUCCEEDED, RESULT.RESULT_OK, '')
    participant.wait_until(lambda: len(feedback) == 7)
    counts = [(message.completed_steps, message.remaining_steps) for message in feedback]
    assert counts == [(n, 7 - n) for n in range(1, 8)]
    participant.wait_until(lambda: stamp_ns(heard[-1]) == last_ns + 7 * 20_000_000)

    goal, feedback = begin(10**9)
    participant.wait_until(lambda: feedback)
    cancelled = goal.cancel_goal_async()
    participant.wait_until(cancelled.done)
    assert cancelled.result().goals_canceling
    status, _, sentence = end(goal)
    assert status == GoalStatus.STATUS_CANCELED
    assert 'of 1000000000 ticks passed' in sentence
    assert participant.trigger('step')[0]

    _, feedback = begin(10**9)
    participant.wait_until(lambda: feedback)
    code, errors = node.end()
    assert (code, 'Traceback' in errors) == (0, False), errors
    client.destroy()


def xyz(vector):
    return [vector.x, vector.y, vector.z]


def xyzw(quaternion):
    return [quaternion.x, quaternion.y, quaternion.z, quaternion.w]

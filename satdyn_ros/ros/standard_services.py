"""The services and the action of simulation_interfaces (REP 410), where that is installed."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import (
    Bounds,
    Result,
    SimulationState,
    SimulatorFeatures,
)
from simulation_interfaces.msg import (
    EntityState as EntityStateMessage,
)
from simulation_interfaces.srv import (
    GetEntities,
    GetEntitiesStates,
    GetEntityState,
    GetSimulationState,
    GetSimulatorFeatures,
    ResetSimulation,
    SetEntityState,
    SetSimulationState,
    StepSimulation,
)

from ..base.nanoseconds import SECOND_NS
from ..run.entity import (
    EntityState,
    accelerations,
    matching,
    restarted,
    touches,
    why_not_reset,
)
from ..run.samples import Samples
from ..run.scenario import Scenario
from .pacing import Pacing
from .services import Services, create_deferred

_FEATURES = (
    'ENTITY_STATE_GETTING',
    'ENTITY_STATE_SETTING',
    'SIMULATION_RESET',
    'SIMULATION_RESET_STATE',
    'SIMULATION_STATE_GETTING',
    'SIMULATION_STATE_SETTING',
    'SIMULATION_STATE_PAUSE',
    'STEP_SIMULATION_SINGLE',
    'STEP_SIMULATION_MULTIPLE',
    'STEP_SIMULATION_ACTION',
)
_NO_STEPS = 'steps is 0; it must be an integer at least 1'


class StandardServices:
    """
    The node's services under the names of the standard, beside its own: one entity, the satellite.

    latest(): samples, and the row of them that was published last; None: none yet.
    """

    def __init__(
        self,
        node: Node,
        services: Services,
        pacing: Pacing,
        scenario: Scenario,
        latest: Callable[[], tuple[Samples, int] | None],
    ):
        self._node, self._name = node, node.get_name()
        self._services, self._pacing = services, pacing
        self._latest = latest
        self._inertial = scenario.frames.inertial
        self._first = {name: scenario[name] for name in scenario.initial_conditions}
        for kind, name, answer in (
            (GetSimulatorFeatures, 'get_simulator_features', self._features),
            (GetSimulationState, 'get_simulation_state', self._state),
            (SetSimulationState, 'set_simulation_state', self._set_state),
            (GetEntities, 'get_entities', self._entities),
            (GetEntitiesStates, 'get_entities_states', self._entities_states),
            (GetEntityState, 'get_entity_state', self._entity_state),
        ):
            node.create_service(kind, f'~/{name}', answer)
        create_deferred(node, StepSimulation, '~/step_simulation', self._step)
        create_deferred(node, ResetSimulation, '~/reset_simulation', self._reset)
        create_deferred(node, SetEntityState, '~/set_entity_state', self._set_entity_state)
        ActionServer(
            node,
            SimulateSteps,
            '~/simulate_steps',
            lambda goal: SimulateSteps.Result(),
            # A goal that cannot be read would lock another one for good.
            callback_group=ReentrantCallbackGroup(),
            handle_accepted_callback=self._simulate_steps,
            cancel_callback=self._cancel_steps,
        )

    def _features(self, request, response):
        response.features.features = [getattr(SimulatorFeatures, name) for name in _FEATURES]
        return response

    # -- the passing of ticks --------------------------------------------------------------------

    def _state(self, request, response):
        response.state.state = self._now
        response.result.result = Result.RESULT_OK
        return response

    @property
    def _now(self):
        is_paused = self._pacing.is_paused
        return SimulationState.STATE_PAUSED if is_paused else SimulationState.STATE_PLAYING

    def _set_state(self, request, response):
        wanted = request.state.state
        if wanted not in (SimulationState.STATE_PAUSED, SimulationState.STATE_PLAYING):
            sentence = 'the time never restarts: the node can be paused or playing'
            response.result = _result(Result.RESULT_FEATURE_UNSUPPORTED, sentence)
        elif wanted == self._now and not self._pacing.is_stepping:
            response.result = _result(SetSimulationState.Response.ALREADY_IN_TARGET_STATE, '')
        else:
            refusal = self._services.pause(wanted == SimulationState.STATE_PAUSED)
            failed = SetSimulationState.Response.STATE_TRANSITION_ERROR
            response.result = _result(failed if refusal else Result.RESULT_OK, refusal)
        return response

    def _step(self, request, reply):
        if request.steps == 0:
            return reply(
                StepSimulation.Response(result=_result(Result.RESULT_OPERATION_FAILED, _NO_STEPS))
            )
        self._services.step(request.steps, _answering(StepSimulation, reply))

    def _simulate_steps(self, goal):
        steps = goal.request.steps

        def answer(refusal):
            # Who asked, or this node, may have gone.
            with suppress(rclpy_implementation.RCLError, rclpy_implementation.InvalidHandle):
                if self._node.executor is not None:
                    goal.execute(lambda goal: _concluded(goal, refusal))

        def passed(number):
            feedback = SimulateSteps.Feedback(
                completed_steps=number, remaining_steps=steps - number
            )
            with suppress(rclpy_implementation.RCLError, rclpy_implementation.InvalidHandle):
                goal.publish_feedback(feedback)

        if steps == 0:
            return answer(_NO_STEPS)
        self._services.step(steps, answer, passed)

    def _cancel_steps(self, goal):
        # The steps of a goal that is not over are those in progress; a pause ends them.
        self._pacing.pause()
        return CancelResponse.ACCEPT

    def _reset(self, request, reply):
        if refusal := why_not_reset(request.scope):
            result = _result(Result.RESULT_FEATURE_UNSUPPORTED, refusal)
            return reply(ResetSimulation.Response(result=result))
        restarts = (
            'the motion restarts from the initial conditions of the scenario; the time and the '
            'orbit continue'
        )
        self._services.request(
            lambda: self._first, _answering(ResetSimulation, reply, done=lambda: restarts)
        )

    # -- the satellite ---------------------------------------------------------------------------

    def _entities(self, request, response):
        response.entities, response.result = self._filtered(request.filters)
        return response

    def _entities_states(self, request, response):
        entities, result = self._filtered(request.filters)
        for entity in entities:
            latest, result = self._found(entity)
            if latest is not None:
                response.entities, response.states = [entity], [self._message(*latest)]
        response.result = result
        return response

    def _filtered(self, filters):
        """Return the names of the entities that filters leave, and the result."""
        bounds = filters.bounds
        if filters.categories or filters.tags.tags:
            sentence = 'entities can be filtered only by their names and by a sphere'
            return [], _result(Result.RESULT_FEATURE_UNSUPPORTED, sentence)
        if bounds.type not in (Bounds.TYPE_EMPTY, Bounds.TYPE_SPHERE):
            sentence = f'the bounds are of type {bounds.type}; only TYPE_SPHERE is supported'
            return [], _result(Result.RESULT_FEATURE_UNSUPPORTED, sentence)
        try:
            found = matching(self._name, filters.filter)
            if found and bounds.type == Bounds.TYPE_SPHERE:
                found = self._within(bounds.points)
        except ValueError as error:
            return [], _result(Result.RESULT_OPERATION_FAILED, str(error))
        return found, _result(Result.RESULT_OK, '')

    def _within(self, points):
        """Return the entities in a sphere; ValueError: it is none, or no tick has come yet."""
        if len(points) != 2:
            raise ValueError(f'the sphere has {len(points)} points; it must have 2')
        latest, result = self._found(self._name)
        if latest is None:
            raise ValueError(result.error_message)
        samples, row = latest
        centre, (x, _, _) = (np.array([point.x, point.y, point.z]) for point in points)
        return [self._name] if touches(samples.states.r_i[row], centre, float(x)) else []

    def _entity_state(self, request, response):
        latest, response.result = self._found(request.entity)
        if latest is not None:
            response.state = self._message(*latest)
        return response

    def _message(self, samples, row):
        entity, message = EntityState.of(samples.states, row), EntityStateMessage()
        linear, angular = accelerations(samples.system, samples.states, row)
        message.header.frame_id = self._inertial
        seconds, nanoseconds = divmod(int(samples.stamps_ns[row]), SECOND_NS)
        message.header.stamp = Time(sec=seconds, nanosec=nanoseconds)
        for vector, numbers in (
            (message.pose.position, entity.position),
            (message.pose.orientation, entity.q_ib),
            (message.twist.linear, entity.velocity),
            (message.twist.angular, entity.rate),
            (message.acceleration.linear, linear),
            (message.acceleration.angular, angular),
        ):
            for name, number in zip('xyzw', numbers.tolist(), strict=False):
                setattr(vector, name, number)
        return message

    def _set_entity_state(self, request, reply):
        latest, result = self._found(request.entity)
        if latest is None:
            return reply(SetEntityState.Response(result=result))
        frame_id = request.state.header.frame_id
        if frame_id not in ('', self._inertial):
            sentence = (
                f'the frame is {frame_id}; the state of {self._name} is set in {self._inertial}'
            )
            result = _result(Result.RESULT_FEATURE_UNSUPPORTED, sentence)
            return reply(SetEntityState.Response(result=result))
        samples, row = latest
        entity = EntityState.of(samples.states, row)
        self._services.request(
            lambda: _requested(request, entity),
            _answering(
                SetEntityState,
                reply,
                {'initial.attitude': SetEntityState.Response.INVALID_POSE},
                lambda: _not_taken(request, entity),
            ),
        )

    def _found(self, name):
        """Return samples and their row now, if there is such an entity, and the result."""
        if name != self._name:
            return None, _result(Result.RESULT_NOT_FOUND, f'the only entity is {self._name}')
        latest = self._latest()
        if latest is None:
            return None, _result(Result.RESULT_OPERATION_FAILED, 'no tick has come yet')
        # What restarts acts at the next tick; of it the satellite is there already.
        if self._services.restarted and self._services.restarted[0] == self._pacing.tick:
            latest = restarted(self._services.restarted[1], *latest), 0
        return latest, _result(Result.RESULT_OK, '')


def _result(code, sentence):
    return Result(result=code, error_message=sentence)


def _concluded(goal, refusal):
    """End a goal, refusal: why not all its ticks passed, '': they did; return its result."""
    if goal.is_cancel_requested:
        goal.canceled()
    elif refusal:
        goal.abort()
    else:
        goal.succeed()
    code = Result.RESULT_OPERATION_FAILED if refusal else Result.RESULT_OK
    return SimulateSteps.Result(result=_result(code, refusal))


def _requested(request, entity) -> Mapping[str, Any]:
    """Return what a request asks for; what it leaves out is that of the entity."""
    state, sets = request.state, _flags(request)
    if sets['pose']:
        q = state.pose.orientation
        entity = replace(entity, q_ib=np.array([q.x, q.y, q.z, q.w]))
    if sets['twist']:
        rate = state.twist.angular
        entity = replace(entity, rate=np.array([rate.x, rate.y, rate.z]))
    return entity.request()


def _not_taken(request, entity) -> str:
    """Return in a sentence what a request asks for in vain, '': nothing."""
    state, sets = request.state, _flags(request)
    asked = (
        ('position', sets['pose'], state.pose.position, entity.position),
        ('linear velocity', sets['twist'], state.twist.linear, entity.velocity),
    )
    left = [name for name, is_set, v, has in asked if is_set and [v.x, v.y, v.z] != has.tolist()]
    left += ['acceleration'] if sets['acceleration'] else []
    return (
        f'ignored: {", ".join(left)}, which follow from the orbit and the torques' if left else ''
    )


def _flags(request):
    """Return what a request sets; versions before 2.1 have no flags: pose and twist are set."""
    return {
        what: getattr(request, f'set_{what}', what != 'acceleration')
        for what in ('pose', 'twist', 'acceleration')
    }


def _answering(kind, reply, codes=MappingProxyType({}), done=lambda: ''):
    """
    Return what answers a request with OK, or with the sentence that refuses it.

    codes: of sentences by the key with which they begin.  done(): what is said with OK.
    """

    def answer(refusal):
        failed = codes.get(refusal.split(' ')[0], Result.RESULT_OPERATION_FAILED)
        code = failed if refusal else Result.RESULT_OK
        reply(kind.Response(result=_result(code, refusal or done())))

    return answer

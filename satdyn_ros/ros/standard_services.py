"""The services of simulation_interfaces (REP 410), where that package is installed."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.node import Node
from simulation_interfaces.msg import Result, SimulationState, SimulatorFeatures
from simulation_interfaces.srv import (
    GetEntities,
    GetEntityState,
    GetSimulationState,
    GetSimulatorFeatures,
    ResetSimulation,
    SetEntityState,
    SetSimulationState,
    StepSimulation,
)

from ..base.nanoseconds import SECOND_NS
from ..run.entity import EntityState, matching, why_not_reset
from ..run.samples import Samples
from ..run.scenario import Frames
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
)


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
        frames: Frames,
        latest: Callable[[], tuple[Samples, int] | None],
    ):
        self._name = node.get_name()
        self._services, self._pacing = services, pacing
        self._frames, self._latest = frames, latest
        for kind, name, answer in (
            (GetSimulatorFeatures, 'get_simulator_features', self._features),
            (GetSimulationState, 'get_simulation_state', self._state),
            (SetSimulationState, 'set_simulation_state', self._set_state),
            (GetEntities, 'get_entities', self._entities),
            (GetEntityState, 'get_entity_state', self._entity_state),
        ):
            node.create_service(kind, f'~/{name}', answer)
        create_deferred(node, StepSimulation, '~/step_simulation', self._step)
        create_deferred(node, ResetSimulation, '~/reset_simulation', self._reset)
        create_deferred(node, SetEntityState, '~/set_entity_state', self._set_entity_state)

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
        elif wanted == self._now:
            response.result = _result(SetSimulationState.Response.ALREADY_IN_TARGET_STATE, '')
        else:
            refusal = self._services.pause(wanted == SimulationState.STATE_PAUSED)
            failed = SetSimulationState.Response.STATE_TRANSITION_ERROR
            response.result = _result(failed if refusal else Result.RESULT_OK, refusal)
        return response

    def _step(self, request, reply):
        if request.steps == 0:
            sentence = 'steps is 0; it must be an integer at least 1'
            return reply(
                StepSimulation.Response(result=_result(Result.RESULT_OPERATION_FAILED, sentence))
            )
        self._services.step(request.steps, _answering(StepSimulation, reply))

    def _reset(self, request, reply):
        if refusal := why_not_reset(request.scope):
            result = _result(Result.RESULT_FEATURE_UNSUPPORTED, refusal)
            return reply(ResetSimulation.Response(result=result))
        self._services.reset(_answering(ResetSimulation, reply))

    # -- the satellite ---------------------------------------------------------------------------

    def _entities(self, request, response):
        filters = request.filters
        if filters.categories or filters.tags.tags or filters.bounds.type:
            sentence = 'entities can be filtered by their names alone'
            response.result = _result(Result.RESULT_FEATURE_UNSUPPORTED, sentence)
            return response
        try:
            response.entities = matching(self._name, filters.filter)
            response.result.result = Result.RESULT_OK
        except ValueError as error:
            response.result = _result(Result.RESULT_OPERATION_FAILED, str(error))
        return response

    def _entity_state(self, request, response):
        latest, response.result = self._found(request.entity)
        if latest is None:
            return response
        samples, row = latest
        entity, state = EntityState.of(samples.states, row), response.state
        state.header.frame_id = self._frames.inertial
        seconds, nanoseconds = divmod(int(samples.stamps_ns[row]), SECOND_NS)
        state.header.stamp = Time(sec=seconds, nanosec=nanoseconds)
        for vector, numbers in (
            (state.pose.position, entity.position),
            (state.pose.orientation, entity.q_ib),
            (state.twist.linear, entity.velocity),
            (state.twist.angular, entity.rate),
        ):
            for name, number in zip('xyzw', numbers.tolist(), strict=False):
                setattr(vector, name, number)
        return response

    def _set_entity_state(self, request, reply):
        latest, result = self._found(request.entity)
        if latest is None:
            return reply(SetEntityState.Response(result=result))
        samples, row = latest
        entity = EntityState.of(samples.states, row)
        self._services.request(
            lambda: self._requested(request, entity),
            _answering(
                SetEntityState,
                reply,
                {'initial.attitude': SetEntityState.Response.INVALID_POSE},
            ),
        )

    def _requested(self, request, entity) -> Mapping[str, Any]:
        """Return what a request asks for; what it leaves out is that of the last sample."""
        state = request.state
        frame_id = state.header.frame_id
        if frame_id not in ('', self._frames.inertial):
            raise ValueError(
                f'the frame is {frame_id}; the state of {self._name} is set in '
                f'{self._frames.inertial}'
            )
        # Versions before 2.1 have no flags: all is set.
        if getattr(request, 'set_pose', True):
            q = state.pose.orientation
            entity = replace(entity, q_ib=np.array([q.x, q.y, q.z, q.w]))
        if getattr(request, 'set_twist', True):
            rate = state.twist.angular
            entity = replace(entity, rate=np.array([rate.x, rate.y, rate.z]))
        return entity.request()

    def _found(self, name):
        """Return what was published last if there is such an entity, and the result."""
        if name != self._name:
            return None, _result(Result.RESULT_NOT_FOUND, f'the only entity is {self._name}')
        latest = self._latest()
        if latest is None:
            return None, _result(Result.RESULT_OPERATION_FAILED, 'no tick has come yet')
        return latest, _result(Result.RESULT_OK, '')


def _result(code, sentence):
    return Result(result=code, error_message=sentence)


def _answering(kind, reply, codes=MappingProxyType({})):
    """
    Return what answers a request with OK, or with the sentence that refuses it.

    codes: of sentences by the key with which they begin.
    """

    def answer(refusal):
        failed = codes.get(refusal.split(' ')[0], Result.RESULT_OPERATION_FAILED)
        code = failed if refusal else Result.RESULT_OK
        reply(kind.Response(result=_result(code, refusal)))

    return answer

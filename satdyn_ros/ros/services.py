"""The services: requests of new initial conditions, reset, pause, step and record."""

from collections.abc import Callable
from typing import Any

from rcl_interfaces.srv import SetParametersAtomically
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from ..run.events import Event, Request, Reset
from ..run.simulation import requested
from ..run.ticks import Ticks
from .pacing import Pacing
from .parameter_service import parameter_of
from .parameters import Parameters, plain_value
from .refusal import one_sentence


class Services:
    """
    The services of a node.

    record(enabled): opens a bag or closes the open one and returns (success, sentence).
    """

    def __init__(
        self,
        node: Node,
        parameters: Parameters,
        pacing: Pacing,
        record: Callable[[bool], tuple[bool, str]],
    ):
        self._parameters, self._pacing, self._record = parameters, pacing, record
        self._conditions = parameters.scenario
        self._ticks = Ticks(parameters.scenario.rate, parameters.scenario.epoch_ns)
        self._after_reply: Callable[[int], Event] | None = None
        acting = [
            node.create_service(
                SetParametersAtomically, '~/set_initial_conditions', self._set_initial_conditions
            ),
            node.create_service(Trigger, '~/reset', self._reset),
        ]
        for service in acting:
            self._act_after_reply(service)
        node.create_service(SetBool, '~/pause', self._pause)
        node.create_service(Trigger, '~/step', self._step)
        node.create_service(SetBool, '~/record', self._set_record)

    def _act_after_reply(self, service):
        """
        Let what a service left act once its reply is sent, with no tick in between.

        So the first tick after the reply carries exactly the requested state.
        """
        send = service.send_response

        def send_response(response, header):
            with self._pacing.between_ticks:
                send(response, header)
                event_at, self._after_reply = self._after_reply, None
                if event_at is not None:
                    self._pacing.put(event_at)

        service.send_response = send_response

    def _set_initial_conditions(self, request, response):
        try:
            values = _values(request.parameters)
            conditions = requested(self._conditions, values)
            self._check_closed_form(conditions)
        except ValueError as error:
            response.result.reason = one_sentence(error)
            return response
        self._conditions = conditions
        in_force = {name: self._conditions[name] for name in values}
        self._parameters.put_in_force(in_force)
        self._after_reply = lambda tick: Request(tick, in_force)
        response.result.successful = True
        return response

    def _reset(self, request, response):
        try:
            self._check_closed_form(self._conditions)
        except ValueError as error:
            response.message = one_sentence(error)
            return response
        self._after_reply = Reset
        response.success = True
        response.message = 'the motion restarts from the initial conditions in force'
        return response

    def _check_closed_form(self, conditions):
        """Raise ValueError if motion.method is exact and the next tick begins no closed form."""
        if conditions['motion.method'] == 'exact':
            t_s = self._ticks.seconds(self._pacing.tick + 1)
            conditions.motion_from(conditions.system, conditions.state_at(t_s), t_s)

    def _pause(self, request, response):
        response.success = True
        if request.data:
            self._pacing.pause()
            response.message = f'paused after tick {self._pacing.tick}'
        else:
            self._pacing.resume()
            response.message = 'running'
        return response

    def _step(self, request, response):
        count = self._parameters.scenario['step.ticks']
        response.success = self._pacing.step(count)
        if response.success:
            response.message = f'now after tick {self._pacing.tick}'
        else:
            response.message = 'the node is not paused; ~/step takes a paused node (~/pause)'
        return response

    def _set_record(self, request, response):
        response.success, response.message = self._record(request.data)
        return response


def _values(parameters) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for message in parameters:
        parameter = parameter_of(message)
        if parameter.name in values:
            raise ValueError(f'{parameter.name} is given twice; a request takes it once')
        values[parameter.name] = plain_value(parameter)
    return values

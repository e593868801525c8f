"""The services: requests of new initial conditions, reset, pause, step and record."""

from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue
from threading import Thread
from typing import Any

from rcl_interfaces.srv import SetParametersAtomically
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from ..base.sentences import one_sentence
from ..run.events import Event, Request, Reset
from ..run.requests import requested, try_out
from ..run.scenario import Scenario
from .pacing import Pacing
from .parameter_service import parameter_of
from .parameters import NodeParameters, plain_value

Reply = Callable[[Any], None]


class Services:
    """
    The services of a node.

    What begins a new motion is first tried in a thread of its own, one request after the other, so
    that neither ticks nor other services wait.  So is a bag opened, for which code may have to be
    compiled.  record(enabled): opens a bag or closes the open one and returns (success, sentence).
    """

    def __init__(
        self,
        node: Node,
        parameters: NodeParameters,
        pacing: Pacing,
        record: Callable[[bool], tuple[bool, str]],
    ):
        self._parameters, self._pacing, self._record = parameters, pacing, record
        self._conditions = parameters.scenario
        self._log = node.get_logger()
        self._asked: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        Thread(target=self._try_one_by_one, name='requests', daemon=True).start()
        _create_deferred(
            node, SetParametersAtomically, '~/set_initial_conditions', self._set_initial_conditions
        )
        _create_deferred(node, Trigger, '~/reset', self._reset)
        _create_deferred(node, Trigger, '~/step', self._step)
        _create_deferred(node, SetBool, '~/record', self._set_record)
        node.create_service(SetBool, '~/pause', self._pause)

    def close(self) -> None:
        """Try no more requests."""
        self._asked.put(None)

    # -- what begins a new motion ----------------------------------------------------------------

    def _try_one_by_one(self):
        while (ask := self._asked.get()) is not None:
            try:
                ask()
            except Exception as error:
                # The next request is to be answered all the same.
                self._log.error(f'a request failed: {one_sentence(repr(error))}')

    def _set_initial_conditions(self, request, reply):
        self._asked.put(lambda: self._try_request(request, reply))

    def _try_request(self, request, reply):
        response = SetParametersAtomically.Response()
        try:
            values = _values(request.parameters)
            conditions = requested(self._conditions, values)
            self._try_out(conditions)
        except (ValueError, ArithmeticError) as error:
            response.result.reason = one_sentence(error)
            return reply(response)
        for doubt in conditions.doubts_of(values):
            self._log.warning(doubt)
        self._conditions = conditions
        in_force = {name: conditions[name] for name in values}
        self._parameters.put_in_force(in_force)
        response.result.successful = True
        self._act(reply, response, lambda tick: Request(tick, in_force))

    def _reset(self, request, reply):
        self._asked.put(lambda: self._try_reset(reply))

    def _try_reset(self, reply):
        try:
            self._try_out(self._conditions)
        except (ValueError, ArithmeticError) as error:
            return reply(Trigger.Response(message=one_sentence(error)))
        sentence = 'the motion restarts from the initial conditions in force'
        self._act(reply, Trigger.Response(success=True, message=sentence), Reset)

    def _try_out(self, conditions: Scenario):
        try_out(conditions, self._pacing.tick + 1)

    def _act(self, reply: Reply, response: Any, event_at: Callable[[int], Event]):
        """
        Send the reply and let the event act, with no tick in between.

        So the first tick after the reply carries exactly the requested state.
        """
        with self._pacing.between_ticks:
            reply(response)
            self._pacing.put(event_at, restarts=True)

    # -- the passing of ticks --------------------------------------------------------------------

    def _pause(self, request, response):
        if request.data:
            self._pacing.pause()
            response.success = True
            response.message = f'paused after tick {self._pacing.tick}'
        elif self._pacing.halted:
            response.message = self._halted
        else:
            self._pacing.resume()
            response.success, response.message = True, 'running'
        return response

    def _step(self, request, reply):
        count = self._parameters.scenario['step.ticks']

        def ended(passed):
            now = f'now after tick {self._pacing.tick}'
            if passed == count:
                return reply(Trigger.Response(success=True, message=now))
            reply(Trigger.Response(message=f'{passed} of {count} ticks passed, {now}'))

        if self._pacing.step(count, ended):
            return
        if self._pacing.halted:
            reason = self._halted
        elif self._pacing.is_stepping:
            reason = 'a step is already in progress; ~/pause ends it'
        else:
            reason = 'the node is not paused; ~/step needs a paused node (call ~/pause)'
        reply(Trigger.Response(message=reason))

    @property
    def _halted(self):
        return one_sentence(
            f'no tick can follow until a request or a reset: {self._pacing.halted}'
        )

    def _set_record(self, request, reply):
        def record():
            success, sentence = self._record(request.data)
            reply(SetBool.Response(success=success, message=sentence))

        self._asked.put(record)


def _create_deferred(node: Node, kind: type, name: str, ask: Callable[[Any, Reply], None]) -> None:
    """Create a service that calls ask(request, reply); reply(response), by any thread, answers."""
    service = node.create_service(kind, name, lambda request, response: request)
    send = service.send_response

    # What the callback returns, here the request, the executor hands on with its header.
    def ask_with_header(request, header):
        def reply(response):
            # Who asked, or this node, may have gone.
            with suppress(rclpy_implementation.RCLError, rclpy_implementation.InvalidHandle):
                send(response, header)

        ask(request, reply)

    setattr(service, 'send_response', ask_with_header)  # noqa: B010


def _values(parameters) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for message in parameters:
        parameter = parameter_of(message)
        if parameter.name in values:
            raise ValueError(f'{parameter.name} is given twice; it may be given once')
        values[parameter.name] = plain_value(parameter)
    return values

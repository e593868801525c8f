"""The services: requests of new initial conditions, reset, pause, step and record."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from queue import SimpleQueue
from threading import Thread
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from ..base.sentences import one_sentence
from ..run.events import Event, Request, Reset
from ..run.in_place import OF_ATTITUDE
from ..run.requests import requested, try_out
from ..run.scenario import Scenario
from ..run.ticks import Ticks
from .pacing import Pacing
from .parameter_service import parameter_of
from .parameters import NodeParameters, plain_value

_ATTITUDE = 'initial.attitude'
Reply = Callable[[Any], None]
# Called once with what became of a request: why it is refused, '': it is not.
Answered = Callable[[str], None]


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
        # The last tick when the motion was last restarted, and the conditions that it had then.
        self.restarted: tuple[int, Scenario] | None = None
        # Why no tick may pass, '': ticks may.
        self.held = ''
        self._ticks = Ticks(self._conditions.rate, self._conditions.epoch_ns)
        self._log = node.get_logger()
        self._asked: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        Thread(target=self._try_one_by_one, name='requests', daemon=True).start()
        create_deferred(
            node, SetParametersAtomically, '~/set_initial_conditions', self._set_initial_conditions
        )
        create_deferred(node, Trigger, '~/reset', self._reset)
        create_deferred(node, Trigger, '~/step', self._step)
        create_deferred(node, SetBool, '~/record', self._set_record)
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

    def request(self, values_of: Callable[[], Mapping[str, Any]], answer: Answered) -> None:
        """Ask for initial conditions, values_of(); ValueError there: what is given is wrong."""
        self._asked.put(lambda: self._try_request(values_of, answer))

    def reset(self, answer: Answered) -> None:
        """Ask for a restart from the initial conditions in force."""
        self._asked.put(lambda: self._try_reset(answer))

    def _set_initial_conditions(self, request, reply):
        def answer(refusal):
            result = SetParametersResult(successful=not refusal, reason=refusal)
            reply(SetParametersAtomically.Response(result=result))

        self.request(lambda: _values(request.parameters), answer)

    def _try_request(self, values_of, answer):
        try:
            values = values_of()
            conditions = requested(self._conditions, values, self._next_s)
            self._try_out(conditions)
        except (ValueError, ArithmeticError) as error:
            return answer(one_sentence(error))
        for warning in conditions.warnings_about(values):
            self._log.warning(warning)
        self._conditions = conditions
        in_force = {name: conditions[name] for name in values if name not in OF_ATTITUDE}
        if of_attitude := {*values} & {*OF_ATTITUDE}:
            in_force[_ATTITUDE] = conditions[_ATTITUDE]
        self._parameters.put_in_force(in_force)
        # Where the target is at the tick that comes the run will see.
        asked = values if 'initial.pointing' in of_attitude else in_force
        self._act(answer, lambda tick: Request(tick, dict(asked)))

    def _reset(self, request, reply):
        done = 'the motion restarts from the initial conditions in force'
        self.reset(
            lambda refusal: reply(Trigger.Response(success=not refusal, message=refusal or done))
        )

    def _try_reset(self, answer):
        try:
            self._try_out(self._conditions)
        except (ValueError, ArithmeticError) as error:
            return answer(one_sentence(error))
        self._act(answer, Reset)

    @property
    def _next_s(self):
        """The time of the next tick from tick 0."""
        return self._ticks.seconds(self._pacing.tick + 1)

    def _try_out(self, conditions: Scenario):
        try_out(conditions, self._pacing.tick + 1)

    def _act(self, answer: Answered, event_at: Callable[[int], Event]):
        """
        Answer and let the event act, with no tick in between.

        So the first tick after the reply carries exactly the requested state.
        """
        with self._pacing.between_ticks:
            self.restarted = self._pacing.tick, self._conditions
            answer('')
            self._pacing.put(event_at, restarts=True)

    # -- the passing of ticks --------------------------------------------------------------------

    def _pause(self, request, response):
        refusal = self.pause(request.data)
        done = f'paused after tick {self._pacing.tick}' if request.data else 'running'
        response.success, response.message = not refusal, refusal or done
        return response

    def pause(self, paused: bool) -> str:
        """Let no tick pass, or let them pass again; return why not, '': it is so."""
        if paused:
            self._pacing.pause()
        elif self.held:
            return self.held
        elif self._pacing.halted:
            return self._halted
        else:
            self._pacing.resume()
        return ''

    def _step(self, request, reply):
        def answer(refusal):
            done = f'now after tick {self._pacing.tick}'
            reply(Trigger.Response(success=not refusal, message=refusal or done))

        self.step(self._parameters.scenario['step.ticks'], answer)

    def step(
        self, count: int, answer: Answered, passed: Callable[[int], None] | None = None
    ) -> None:
        """Ask for `count` ticks while paused; passed(number): called after each."""

        def ended(number):
            now = f'now after tick {self._pacing.tick}'
            answer('' if number == count else f'{number} of {count} ticks passed, {now}')

        if self.held:
            return answer(self.held)
        if self._pacing.step(count, ended, passed):
            return
        if self._pacing.halted:
            reason = self._halted
        elif self._pacing.is_stepping:
            reason = 'a step is already in progress; ~/pause ends it'
        else:
            reason = 'the node is not paused; ~/step needs a paused node (call ~/pause)'
        answer(reason)

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


def create_deferred(node: Node, kind: type, name: str, ask: Callable[[Any, Reply], None]) -> None:
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

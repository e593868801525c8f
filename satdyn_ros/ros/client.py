"""The client of a running node: its services, called from another process."""

import math
import os
import threading
import time
from array import array
from collections.abc import Mapping
from typing import Any, NamedTuple

import rclpy
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.context import Context
from rclpy.exceptions import NameValidationException
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.validate_full_topic_name import validate_full_topic_name
from std_srvs.srv import SetBool, Trigger

from ..base import ros_yaml
from ..base.units import is_quantity
from ..run.keys import KEYS
from .context import init
from .other_users import unreached

_LONGEST_S = 1e6
# The largest integer that a parameter holds.
_LARGEST = 2**63 - 1
# Between two checks for an answer, so that Ctrl-C is handled; and until it is asked for again.
_LOOK_S, _AGAIN_S = 0.1, 0.5


class Answer(NamedTuple):
    """What a node answered: whether it did what was asked, and its sentence."""

    success: bool
    text: str


class Client:
    """
    The services of a node, called one at a time; a ROS node of its own.

    node_name: 'satdyn', or '/sat1/satdyn' in a namespace.  TimeoutError, of every call: no answer
    came within timeout_s, or given_up was set meanwhile, by another thread.  ValueError: timeout_s
    or the name cannot be one.

    >>> with Client('satdyn') as client:  # doctest: +SKIP
    ...     client.set_initial_conditions({'initial.angular_velocity': [0.0, 0.0, 0.01]})
    Answer(success=True, text='...')
    """

    def __init__(
        self,
        node_name: str = 'satdyn',
        timeout_s: float = 5.0,
        given_up: threading.Event | None = None,
    ):
        if not (math.isfinite(timeout_s) and 0.0 < timeout_s <= _LONGEST_S):
            raise ValueError(
                f'--timeout is {timeout_s:g}; it must be a number above 0 and at most '
                f'{_LONGEST_S:g} s'
            )
        try:
            validate_full_topic_name('/' + node_name.removeprefix('/'), is_service=True)
        except NameValidationException as error:
            raise ValueError(
                f'--node is {node_name!r}; it must be the name of a node, satdyn or /sat1/satdyn'
            ) from error
        self._name, self._timeout_s = node_name, timeout_s
        self._given_up = given_up or threading.Event()
        self._context = Context()
        init(context=self._context)
        self._node = rclpy.create_node(
            f'satdyn_request_{os.getpid()}', context=self._context, start_parameter_services=False
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)

    def __enter__(self) -> 'Client':
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def set_initial_conditions(self, values: Mapping[str, Any]) -> Answer:
        """Restart the motion from initial conditions, by the keys of the scenario."""
        messages = [
            Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
        ]
        request = SetParametersAtomically.Request(parameters=messages)
        result = self._call(SetParametersAtomically, 'set_initial_conditions', request).result
        done = ', '.join(f'{name} = {value}' for name, value in values.items())
        text = f'restarted with {done}' if result.successful else result.reason
        return Answer(result.successful, text)

    def reset(self) -> Answer:
        """Restart the motion from the initial conditions in force."""
        return self._answer(Trigger, 'reset', Trigger.Request())

    def step(self, ticks: int | None = None) -> Answer:
        """
        Let step.ticks ticks pass, while paused; ticks: what step.ticks is set to before.

        ValueError: it cannot be set to that.
        """
        if ticks is not None:
            answer = self.set_parameter('step.ticks', KEYS['step.ticks'].checked(ticks))
            if not answer.success:
                return answer
        return self._answer(Trigger, 'step', Trigger.Request())

    def set_parameter(self, name: str, value: Any) -> Answer:
        """Set a parameter of the node."""
        messages = [Parameter(name, value=value).to_parameter_msg()]
        request = SetParameters.Request(parameters=messages)
        (result,) = self._call(SetParameters, 'set_parameters', request).results
        return Answer(result.successful, result.reason or f'{name} = {value}')

    def get_parameter(self, name: str) -> Answer:
        """Return the value of a parameter of the node, as text."""
        request = GetParameters.Request(names=[name])
        values = self._call(GetParameters, 'get_parameters', request).values
        value = parameter_value_to_python(values[0]) if values else None
        if value is None:
            return Answer(False, f'{self._name} has no parameter {name}')
        return Answer(True, str(value.tolist() if isinstance(value, array) else value))

    def pause(self) -> Answer:
        """Let no tick pass."""
        return self._answer(SetBool, 'pause', SetBool.Request(data=True))

    def resume(self) -> Answer:
        """Let ticks pass again."""
        return self._answer(SetBool, 'pause', SetBool.Request(data=False))

    def record(self, enabled: bool) -> Answer:
        """Begin a new bag, or close the open one."""
        return self._answer(SetBool, 'record', SetBool.Request(data=enabled))

    def _answer(self, service_type, service, request):
        response = self._call(service_type, service, request)
        return Answer(response.success, response.message)

    def _call(self, service_type, service, request):
        deadline_s = time.monotonic() + self._timeout_s
        client = self._client_of(service_type, service, deadline_s)
        # The node loses its answer to a client that it has not discovered.  It discovers clients
        # in their order: once it answers a later one, it knows this one.
        later = self._client_of(GetParameters, 'get_parameters', deadline_s)
        while not self._is_done(later.call_async(GetParameters.Request()), _AGAIN_S):
            self._check(deadline_s)
        future = client.call_async(request)
        while not self._is_done(future, _LOOK_S):
            self._check(deadline_s)
        self._node.destroy_client(later)
        self._node.destroy_client(client)
        return future.result()

    def _client_of(self, service_type, service, deadline_s):
        client = self._node.create_client(service_type, f'{self._name}/{service}')
        while not client.wait_for_service(_LOOK_S):
            if self._is_over(deadline_s):
                raise TimeoutError(
                    f'no node {self._name} found within {self._timeout_s:g} s; start one with '
                    'satdyn node --params-file default'
                )
        return client

    def _is_done(self, future, patience_s):
        """Wait for an answer; return whether it came."""
        self._executor.spin_until_future_complete(future, patience_s)
        return future.done()

    def _check(self, deadline_s):
        if self._is_over(deadline_s):
            raise TimeoutError(
                f'{self._name} did not answer within {self._timeout_s:g} s{unreached()}'
            )

    def _is_over(self, deadline_s):
        return self._given_up.is_set() or time.monotonic() > deadline_s


def assignment(text: str) -> tuple[str, Any]:
    """
    Return key and value of 'initial.angular_velocity=[0,0,0.01]', the value as in a YAML file.

    A text with a unit, such as [0, 0, 6] deg/s, needs no quotes.

    ValueError: it is not KEY=VALUE, or no parameter can hold the value.
    """
    name, equals, given = text.partition('=')
    if not (name and equals and given.strip()):
        raise ValueError(f'{text!r} must have the form KEY=VALUE')
    # Unquoted, '[5, 3, 2] mA m^2' is no YAML.
    value = given.strip() if is_quantity(given) else ros_yaml.load(given, name)
    if isinstance(value, list):
        value = [as_float(x) for x in value]
    elif not isinstance(value, int) or abs(value) > _LARGEST:
        # An integer stays one, as of some parameters; the node takes it for a number too.
        value = as_float(value)
    if isinstance(value, list) and any(isinstance(x, str) and is_quantity(x) for x in value):
        # ROS has no list of both: a 0 beside texts with a unit is a text too.
        value = [x if isinstance(x, str) else f'{x:g}' for x in value]
    try:
        Parameter(name, value=value)
    except TypeError:
        raise ValueError(f'{name} is {value}; it must be a number, a list or a text') from None
    return name, value


def as_float(value: Any) -> Any:
    """Return a number as a float: no initial condition is an integer."""
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value

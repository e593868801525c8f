"""The parameter services of rclpy, which survive any message."""

from collections.abc import Sequence
from contextlib import AbstractContextManager

import rclpy.parameter_service
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..base.sentences import one_sentence


class ParameterService(rclpy.parameter_service.ParameterService):
    """
    The services that list, describe, get and set a node's parameters.

    A set that rclpy would answer with an exception, which ends the executor, is refused.  lock:
    held while parameters are set.
    """

    def __init__(self, node: Node, lock: AbstractContextManager):
        self._lock = lock
        super().__init__(node)

    def _set_parameters_callback(
        self, request: SetParameters.Request, response: SetParameters.Response
    ) -> SetParameters.Response:
        response.results = [self._set([message]) for message in request.parameters]
        return response

    def _set_parameters_atomically_callback(
        self, request: SetParametersAtomically.Request, response: SetParametersAtomically.Response
    ) -> SetParametersAtomically.Response:
        response.result = self._set(request.parameters)
        return response

    def _set(self, messages: Sequence[ParameterMessage]) -> SetParametersResult:
        node = self._get_node()
        try:
            parameters = [parameter_of(message) for message in messages]
            # rclpy would make a parameter of an empty name.
            unknown = [p.name for p in parameters if not node.has_parameter(p.name)]
            if unknown:
                raise ValueError(f'{unknown[0]!r} is not a parameter of this node')
            with self._lock:
                result = node.set_parameters_atomically(parameters)
        except (ParameterException, ValueError, TypeError) as error:
            result = SetParametersResult(successful=False, reason=str(error))
        result.reason = one_sentence(result.reason)
        return result


def parameter_of(message: ParameterMessage) -> Parameter:
    """Return the parameter in a message; ValueError: its type does not exist."""
    types = [kind.value for kind in Parameter.Type]
    if message.value.type not in types:
        raise ValueError(
            f'{message.name} is of type {message.value.type}; it must be a type of '
            f'{min(types)} to {max(types)}'
        )
    return Parameter.from_parameter_msg(message)

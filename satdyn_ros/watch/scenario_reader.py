"""The scenario of a running node, from its parameters."""

from collections.abc import Callable, Iterable
from typing import Any

from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future

from ..run.parameter_file import RCLPY_PARAMETERS
from ..run.scenario import Scenario
from ..torques.body_torque import BodyTorque


class ScenarioReader:
    """
    Asks nodes for their parameters; take(name, scenario) gets the answer of the node `name`.

    A text in place of the scenario says why the parameters are not understood.
    """

    def __init__(
        self,
        asker: Node,
        torques: Iterable[type[BodyTorque]],
        take: Callable[[str, Scenario | str], None],
    ):
        self._asker, self._torques, self._take = asker, tuple(torques), take
        # Of each node the two that are needed: an executor looks at all at each turn, and rclpy's
        # AsyncParameterClient has six.
        self._clients: dict[str, tuple[Client, Client]] = {}

    def read(self, name: str) -> None:
        """Ask a node; one whose services are not there yet is not asked."""
        if name not in self._clients:
            self._clients[name] = (
                self._asker.create_client(ListParameters, f'{name}/list_parameters'),
                self._asker.create_client(GetParameters, f'{name}/get_parameters'),
            )
        lister, getter = self._clients[name]

        def listed(future: Future) -> None:
            names = [
                parameter
                for parameter in future.result().result.names
                if parameter.split('.')[0] not in RCLPY_PARAMETERS
            ]
            answer = getter.call_async(GetParameters.Request(names=names))
            answer.add_done_callback(
                lambda got: self._understand(name, names, got.result().values)
            )

        if lister.service_is_ready() and getter.service_is_ready():
            lister.call_async(ListParameters.Request()).add_done_callback(listed)

    def _understand(self, name: str, names: list[str], values: list[ParameterValue]) -> None:
        given = {
            parameter: value
            for parameter, message in zip(names, values, strict=False)
            if (value := parameter_value_to_python(message)) is not None
        }
        try:
            plain = {parameter: _plain(value) for parameter, value in given.items()}
            scenario = Scenario(plain, self._torques)
        except ValueError as error:
            self._take(name, f'the parameters of {name} are not understood: {error}')
        else:
            self._take(name, scenario)


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, 'tolist') else value

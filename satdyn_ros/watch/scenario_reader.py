"""The scenario of a running node, from its parameters."""

from collections.abc import Callable, Iterable
from typing import Any

from rcl_interfaces.msg import ParameterValue
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
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
        self._clients: dict[str, AsyncParameterClient] = {}

    def read(self, name: str) -> None:
        """Ask a node; one whose services are not there yet is not asked."""
        if name not in self._clients:
            self._clients[name] = AsyncParameterClient(self._asker, name)
        client = self._clients[name]

        def listed(future: Future) -> None:
            names = [
                parameter
                for parameter in future.result().result.names
                if parameter.split('.')[0] not in RCLPY_PARAMETERS
            ]
            client.get_parameters(
                names, callback=lambda got: self._understand(name, names, got.result().values)
            )

        if client.services_are_ready():
            client.list_parameters([], 0, callback=listed)

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

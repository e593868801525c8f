"""The node's parameters: declared from the table of keys, checked by it, changed by its rules."""

import sys
from array import array
from collections.abc import Callable, Mapping
from threading import RLock
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..base.key import Key, listed
from ..run.parameter_file import without_rclpys
from ..run.scenario import Scenario

_TYPES = {
    'double': Parameter.Type.DOUBLE,
    'double_array': Parameter.Type.DOUBLE_ARRAY,
    'integer': Parameter.Type.INTEGER,
    'string': Parameter.Type.STRING,
    'epoch': Parameter.Type.STRING,
    'string_array': Parameter.Type.STRING_ARRAY,
    'text': Parameter.Type.STRING,
    'texts': Parameter.Type.STRING_ARRAY,
    'bool': Parameter.Type.BOOL,
}


def given_parameters(node: Node) -> dict[str, Any]:
    """Return what the command line, parameter files and the constructor give, name to value."""
    # What rclpy read of them is public only by declaring it, types included.
    overrides = node._parameter_overrides
    return without_rclpys({name: plain_value(given) for name, given in overrides.items()})


def give_rclpy_its_own(node: Node, values: Mapping[str, Any]) -> None:
    """
    Let rclpy have those of values that are its own parameters, where nothing overrides them.

    ValueError: one of them is not allowed.
    """
    own = set(values) - set(without_rclpys(values)) - set(node._parameter_overrides)
    for name in sorted(own):
        parameter = Parameter(name, value=values[name])
        node._parameter_overrides[name] = parameter
        if node.has_parameter(name):
            if parameter.type_ != node.get_parameter(name).type_:
                raise ValueError(f'{name} is {values[name]!r}; it must be true or false')
            node.set_parameters([parameter])


def plain_value(parameter: Parameter) -> Any:
    """Return a parameter's value, an array as a list."""
    value = parameter.value
    return value.tolist() if isinstance(value, array) else value


def descriptor(key: Key) -> ParameterDescriptor:
    """Return what `ros2 param describe` says of a key."""
    described = ParameterDescriptor(
        description=f'[{key.unit}] {key.meaning}' if key.unit else key.meaning,
        additional_constraints=_constraints(key),
        read_only=key.changes == 'never',
        # Lists of integers are taken as floats, whole numbers as doubles.
        dynamic_typing=key.kind in ('double', 'double_array', 'string_array', 'texts'),
    )
    low, high = max(key.low, key.above), min(key.high, key.below)
    if (low, high) != (-float('inf'), float('inf')):
        if key.kind == 'double':
            largest = sys.float_info.max
            bounds = {'from_value': max(low, -largest), 'to_value': min(high, largest)}
            described.floating_point_range = [FloatingPointRange(**bounds)]
        elif key.kind == 'integer':
            described.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
    return described


def _constraints(key):
    if key.changes == 'service':
        return f'allowed: {key.allowed}; changed only through ~/set_initial_conditions'
    return f'allowed: {key.allowed}'


class NodeParameters:
    """
    The parameters of a node, whose values are those of a scenario.

    Parameters
    ----------
    node : Node
        which declares them
    scenario : Scenario
        its values at the start
    prepare : function of a Scenario and names
        called before an ordinary set of these is accepted; ValueError refuses it
    changed : function of a Scenario and names
        called after it was accepted

    Attributes
    ----------
    lock : lock
        held while parameters are set
    """

    def __init__(
        self,
        node: Node,
        scenario: Scenario,
        prepare: Callable[[Scenario, list[str]], None],
        changed: Callable[[Scenario, list[str]], None],
    ):
        self.scenario = scenario
        self.lock = RLock()
        self._node = node
        self._prepare, self._changed = prepare, changed
        self._puts_in_force = False
        for key in scenario.keys.values():
            _declare(node, key, listed(scenario[key.name]))
        node.add_pre_set_parameters_callback(self._converted)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._act)

    def withdraw(self) -> None:
        """Let the node have these parameters no more."""
        self._node.remove_pre_set_parameters_callback(self._converted)
        self._node.remove_on_set_parameters_callback(self._check)
        self._node.remove_post_set_parameters_callback(self._act)
        for name in self.scenario.keys:
            # One that is read-only cannot be undeclared.
            self._node.describe_parameter(name).read_only = False
            self._node.undeclare_parameter(name)

    def put_in_force(self, values: Mapping[str, Any]) -> None:
        """Show initial conditions that were accepted as the parameters' values."""
        with self.lock:
            self._puts_in_force = True
            try:
                self._node.set_parameters_atomically(
                    [_parameter(self.scenario.keys[n], v) for n, v in values.items()]
                )
            finally:
                self._puts_in_force = False

    def _converted(self, parameters):
        """Return the parameters in their keys' types where their values allow it."""
        return [_converted(self.scenario.keys.get(p.name), p) for p in parameters]

    def _check(self, parameters):
        try:
            scenario = self._with(parameters)
            self._unless_put_in_force(self._prepare, scenario, parameters)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _act(self, parameters):
        self.scenario = self._with(parameters)
        self._unless_put_in_force(self._changed, self.scenario, parameters)

    def _unless_put_in_force(self, call, scenario, parameters):
        names = [p.name for p in parameters if p.name in scenario.keys]
        if names and not self._puts_in_force:
            call(scenario, names)

    def _with(self, parameters):
        """Return the scenario with parameters changed; ValueError: they may not be."""
        keys = self.scenario.keys
        values = {p.name: plain_value(p) for p in parameters if p.name in keys}
        refused = [name for name in values if name in self.scenario.initial_conditions]
        if refused and not self._puts_in_force:
            raise ValueError(
                f'{refused[0]} changes only through the service ~/set_initial_conditions, which '
                'restarts the motion'
            )
        return self.scenario.with_values(values)


def _declare(node, key, value):
    if value != []:
        node.declare_parameter(key.name, value, descriptor(key), ignore_override=True)
        return
    # rclpy would declare an empty list as one of bytes.
    any_type = ParameterDescriptor(dynamic_typing=True)
    node.declare_parameter(key.name, value, any_type, ignore_override=True)
    node.set_parameters([_parameter(key, value)])
    node.set_descriptor(key.name, descriptor(key))


def _parameter(key, value):
    return Parameter(key.name, _TYPES[key.kind], listed(value))


def _converted(key, parameter):
    if key is None:
        return parameter
    try:
        return _parameter(key, key.checked(plain_value(parameter)))
    except ValueError:
        return parameter

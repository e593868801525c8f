"""What a torque is that comes with the environment: one class, from which all else follows."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..base.key import Key
from ..base.sentences import Checks
from ..orbits.along_orbit import AlongOrbit
from .body_torque import BodyTorque


class PartQuantity(NamedTuple):
    """
    A quantity of each part of a torque.

    Attributes
    ----------
    field : str
        of sensor_msgs/JointState, which has it
    column : str
        the end of its columns in tables
    of : function
        of(torque, states) returns its values (N, parts)
    """

    field: str
    column: str
    of: Callable[[Any, Any], np.ndarray]


class PartsTopic(NamedTuple):
    """
    The topic of the parts of a torque that have names.

    Attributes
    ----------
    name : str
        as in publish.topics
    says : str
        its content in words, with units
    title, unit : str
        of its panel, which has the first of the quantities
    quantities : tuple of PartQuantity
        what it shows
    """

    name: str
    says: str
    title: str
    unit: str
    quantities: tuple[PartQuantity, ...]


class EnvironmentTorque(BodyTorque):
    """
    A torque that comes with the environment; each kind is a subclass in a file beside this one.

    values: every key of a scenario by its dotted name, each allowed by itself; of many scenarios
    as arrays where they differ.

    Attributes
    ----------
    needs : str
        the key of the model without which there is none, such as environment.sun
    of_each : tuple of Key
        where the first of its keys gives names: the keys that describe each of them, by their last
        words
    parts : PartsTopic or None
        the topic of what has these names
    """

    needs: ClassVar[str]
    of_each: ClassVar[tuple[Key, ...]] = ()
    parts: ClassVar[PartsTopic | None] = None

    @classmethod
    def along(cls, values: Mapping[str, Any], environment: AlongOrbit) -> BodyTorque:
        """Return the torque of a scenario's values in the environment along its orbit."""
        raise NotImplementedError

    @classmethod
    def given(cls, values: Mapping[str, Any]) -> list[str]:
        """Return the keys by which a scenario describes what the torque acts on; none: nothing."""
        return [key.name for key in cls.keys if values[key.name] != key.default]

    @classmethod
    def checks(cls, values: Mapping[str, Any]) -> Checks:
        """Check what values may not be together."""
        yield from ()

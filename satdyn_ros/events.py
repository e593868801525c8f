"""
What can happen to a run, as data.

An event acts on a tick, never between ticks.  Requests and resets replace the state of their
tick; torques leave it and act from it on.
"""

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Request:
    """New initial conditions, by the keys of the scenario; keys not given stay in force."""

    tick: int
    values: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Reset:
    """A restart from the initial conditions in force."""

    tick: int


@dataclass(frozen=True)
class Torque:
    """A body torque [N m] in body axes, held until the next one or, if given, until a tick."""

    tick: int
    torque_b: tuple[float, float, float]
    until_tick: int | None = None


@dataclass(frozen=True)
class RotorTorque:
    """A motor torque on the rotor [N m], held until the next one or until a tick."""

    tick: int
    torque: float
    until_tick: int | None = None


@dataclass(frozen=True)
class Timeout:
    """The end of the held torques: 'torque' or 'rotor_torque' drops to zero."""

    tick: int
    topic: str


@dataclass(frozen=True)
class Topics:
    """A change of the published topics."""

    tick: int
    names: tuple[str, ...]


Event = Request | Reset | Torque | RotorTorque | Timeout | Topics

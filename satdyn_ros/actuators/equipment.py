"""The actuators of a scenario, and what acts of all that they are commanded."""

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any

from ..dynamics.rotor import Rotor
from ..dynamics.system import System
from ..torques.body_torque import BodyTorque
from .actuator import ACTUATORS, Actuator


class Equipment:
    """
    The actuators of a scenario.

    none: by all names under which something is held, what acts while nothing is commanded.
    """

    def __init__(self, values: Mapping[str, Any], rotors: tuple[Rotor, ...]):
        self.actuators: tuple[Actuator, ...] = tuple(k(values, rotors) for k in ACTUATORS.values())
        self.none = {name: x for each in self.actuators for name, x in each.none.items()}

    @property
    def topics(self) -> tuple[str, ...]:
        """The topics of all that can be commanded."""
        return tuple(self.of_topic)

    @cached_property
    def of_topic(self) -> dict[str, Actuator]:
        """The actuators by the topics of their commands."""
        return {topic: each for each in self.actuators for topic in each.topics}

    @cached_property
    def of_earlier(self) -> dict[str, Actuator]:
        """The actuators by the topics of earlier versions."""
        return {topic: each for each in self.actuators for topic in each.earlier}

    @cached_property
    def of_name(self) -> dict[str, Actuator]:
        """The actuators by the names under which something is held."""
        return {name: each for each in self.actuators for name in each.none}

    @cached_property
    def of_word(self) -> dict[str, Actuator]:
        """The actuators by their keys in an events file."""
        return {word: each for each in self.actuators for word in each.words}

    @cached_property
    def of_keyword(self) -> dict[str, tuple[Actuator, str]]:
        """The actuators by the keywords of Simulation.step, and their words for these."""
        return {
            keyword: (each, word)
            for each in self.actuators
            for word, keyword in each.words.items()
        }

    def held_as(self, name: str) -> str:
        """Return the name under which something is held, which version 0.1 called by its topic."""
        earlier = self.of_earlier.get(name)
        return next(iter(earlier.none)) if earlier else name

    def driven(
        self,
        system: System,
        acting: Mapping[str, Any],
        actuators: Iterable[Actuator] | None = None,
    ) -> System:
        """Return a system under what acts, of some actuators or of all."""
        for each in self.actuators if actuators is None else actuators:
            if changes := each.driven(system, acting):
                system = system.driven(**changes)
        return system

    def commanded_alone(self, system: System, topic: str, value: Any) -> System:
        """Return a system under a command of tick 0 and nothing else."""
        actuator = self.of_topic[topic]
        acting = {
            name: actuator.from_instant(name, x, self.none[name], 0.0)
            for name, x in actuator.held(topic, value).items()
        }
        return self.driven(system, self.none | acting, [actuator])

    def torques(self) -> tuple[BodyTorque, ...]:
        """Return the torques on the body that are there for actuators alone."""
        return tuple(torque for each in self.actuators if (torque := each.torque()) is not None)

    def ended(self, acting: Mapping[str, Any], at_s: float) -> dict[str, Any]:
        """Return what acts from an instant on, from tick 0, where all commands end."""
        return {name: x for each in self.actuators for name, x in each.ended(acting, at_s).items()}

    def restarted(self, acting: Mapping[str, Any], at_s: float) -> dict[str, Any]:
        """Return what acts from the restart of the motion on: what is held continues."""
        ended = self.ended(acting, at_s)
        return {
            name: x if self.of_name[name].is_held else ended[name] for name, x in acting.items()
        }

    def is_driving(self, acting: Mapping[str, Any]) -> bool:
        """Return whether a command is held that acts."""
        return any(x != self.none[name] for name, x in acting.items() if self.is_held(name))

    @property
    def has_pulses(self) -> bool:
        """Whether there is anything whose commands end by themselves."""
        return any(each.is_fitted and not each.is_held for each in self.actuators)

    def is_held(self, name: str) -> bool:
        """Return whether what is commanded under a name holds until the next command."""
        return self.of_name[name].is_held

    def kept(self, acting: Mapping[str, Any], others: 'Equipment', at_s: float) -> dict[str, Any]:
        """Return what continues on this body of what acts on another one, as of Actuator.kept."""
        pairs = zip(self.actuators, others.actuators, strict=True)
        return {n: x for each, other in pairs for n, x in each.kept(acting, other, at_s).items()}

    def to_plain(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts as plain data, for a snapshot."""
        return {name: x for each in self.actuators for name, x in each.to_plain(acting).items()}

    def from_plain(self, snapshot: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acted when to_plain was asked; ValueError, LookupError: it is not that."""
        return {
            name: x for each in self.actuators for name, x in each.from_plain(snapshot).items()
        }

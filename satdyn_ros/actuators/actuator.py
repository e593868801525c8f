"""What an actuator is: one class, from which all else that is commanded follows."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from ..base.key import Key
from ..base.sentences import one_sentence
from ..dynamics.rotor import Rotor
from ..dynamics.system import System
from ..torques.body_torque import BodyTorque

_NONE: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class Command:
    """
    What an actuator is commanded by one message, as its topic has it.

    Attributes
    ----------
    tick : int
        at which it is commanded
    topic : str
        of the actuator
    value : object
        the actuator's, as it is given: what acts of it is cut to its limits
    until_tick : int or None
        up to which it holds; None: up to the next one for the same
    """

    tick: int
    topic: str
    value: Any
    until_tick: int | None = None


class Actuator(ABC):
    """
    A kind of actuators, made for the values and the rotors of a scenario.

    Attributes
    ----------
    topic, message, says : str
        the topic of its commands, their type and their content in words
    in_body_axes : bool
        whether the header of a message must name the body's frame, or none
    words : dict
        by its key in an events file the keyword of Simulation.step for the same
    keys : tuple of Key
        of scenarios, its own
    of_each : tuple of Key
        those that follow a name in GROUP.names, of its own group
    limit, limiting : str
        the last word of the key that cuts commands, empty: none, and what it does, before that
        word
    acts_on : class or None
        the kind of torque on the body that it commands, None: what it drives is no such torque
    is_held : bool
        whether a command holds until the next one or its timeout; if not, it ends by itself, and
        each one acts anew
    earlier : dict
        topics of earlier versions, which bags have, and their types
    topics : tuple of str
        those of the scenario, which bags have
    is_fitted : bool
        whether there is anything to command
    none : dict
        by the names under which something is held, each timed out by itself, what acts while
        nothing is commanded
    rotors : dict
        by these names the rotor whose cuts become events
    """

    topic: ClassVar[str]
    message: ClassVar[str]
    says: ClassVar[str]
    in_body_axes: ClassVar[bool] = False
    words: ClassVar[Mapping[str, str]]
    keys: ClassVar[tuple[Key, ...]] = ()
    of_each: ClassVar[tuple[Key, ...]] = ()
    limit: ClassVar[str] = ''
    limiting: ClassVar[str] = 'cut to'
    acts_on: ClassVar[type[BodyTorque] | None] = None
    is_held: ClassVar[bool] = True
    earlier: ClassVar[Mapping[str, str]] = _NONE

    topics: tuple[str, ...]
    is_fitted: bool = True
    none: Mapping[str, Any]
    rotors: Mapping[str, str] = _NONE

    def __init_subclass__(cls) -> None:
        """Let scenarios have the kind."""
        if 'topic' in vars(cls):
            ACTUATORS[cls.topic] = cls

    @abstractmethod
    def __init__(self, values: Mapping[str, Any], rotors: tuple[Rotor, ...]):
        """Take what a scenario says of it."""

    @abstractmethod
    def given(self, word: str, given: Any) -> dict[str, Any]:
        """
        Return by topic the values of what an events file, or a program, gives as one of the words.

        ValueError, in one sentence: it is not allowed.
        """

    def columns(self, word: str, given: Any, count: int) -> dict[str, Any]:
        """
        Return what is held, by name, of the commands of many runs: each number a column (M,).

        Parameters
        ----------
        word : str
            of the events file, or of the program
        given : object
            as of given(), with an array in place of each number or vector, a row for each run
        count : int
            M

        Raises
        ------
        ValueError
            it is not allowed, in one sentence
        """
        raise ValueError(f'{word} is commanded run by run, not in columns')

    @classmethod
    @abstractmethod
    def plain(cls, topic: str, value: Any) -> dict[str, Any]:
        """Return a value as given() takes it, by its word."""

    @abstractmethod
    def read(self, topic: str, message: Any) -> Any:
        """Return the value in a message, field by field; ValueError: it is built otherwise."""

    @abstractmethod
    def check(self, topic: str, value: Any) -> None:
        """Raise ValueError, in one sentence, for a value that is not allowed."""

    @classmethod
    @abstractmethod
    def fields(cls, topic: str, value: Any) -> dict[str, Any]:
        """Return the fields of the message of a value: vectors as tuples, sequences as lists."""

    @abstractmethod
    def held(self, topic: str, value: Any) -> dict[str, Any]:
        """Return what a command holds, by name."""

    @abstractmethod
    def commanding(self, held: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
        """Yield topics and values of the commands that hold this and nothing else."""

    def within(self, name: str, held: Any) -> Any:
        """Return what acts of what is held under a name: cut to the limit."""
        return held

    def from_instant(self, name: str, held: Any, before: Any, at_s: float) -> Any:
        """
        Return what acts under a name from an instant on.

        Parameters
        ----------
        name : str
            under which it is held
        held : object
            what is held from then on
        before : object
            what acted before
        at_s : s
            the instant, from tick 0
        """
        return self.within(name, held)

    def ended(self, acting: Mapping[str, Any], at_s: float) -> dict[str, Any]:
        """Return what acts from an instant on where nothing is commanded any more."""
        return dict(self.none)

    def effect(self, acting: Mapping[str, Any]) -> Any:
        """Return what the motion depends on of all that acts, by name; equal: it is the same."""
        return {name: acting[name] for name in self.none}

    @classmethod
    def without_effect(cls, values: Mapping[str, Any]) -> Iterator[str]:
        """Yield a sentence on each thing that a scenario describes and that does nothing."""
        yield from ()

    def torque(self) -> BodyTorque | None:
        """Return the torque that is there for it alone, while nothing is commanded."""
        return None

    def commanded(self, torque: Any, acting: Mapping[str, Any]) -> BodyTorque:
        """Return the torque that it acts on, under what acts."""
        raise NotImplementedError

    def driven(self, system: System, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields of a system that change under what acts."""
        if self.acts_on is None or not self.is_fitted:
            return {}
        return {
            'torques': tuple(
                self.commanded(torque, acting) if isinstance(torque, self.acts_on) else torque
                for torque in system.torques
            )
        }

    def kept(self, acting: Mapping[str, Any], others: Any, at_s: float) -> dict[str, Any]:
        """
        Return what continues here of what acts on another body; the rest is as in none.

        Parameters
        ----------
        acting : dict
            what acts, as of none
        others : Actuator of this kind
            those of the other body
        at_s : s
            the instant from tick 0, from which on it acts here
        """
        found = {name: self.within(name, acting[name]) for name in self.none if name in acting}
        return {**self.none, **found}

    @abstractmethod
    def to_plain(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts as plain data, for a snapshot."""

    @abstractmethod
    def from_plain(self, snapshot: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acted when to_plain was asked; ValueError, LookupError: it is not that."""

    def report(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts in words, for the diagnostics."""
        return {}


def column(name: str, given: Any, count: int, size: int = 0) -> np.ndarray:
    """
    Return what is given for a command of many runs, (M,), or of vectors (M, size).

    Parameters
    ----------
    name : str
        what a sentence calls it
    given : (M,) or (M, size)
        the numbers
    count : int
        M
    size : int
        of the vectors, 0: they are numbers

    Raises
    ------
    ValueError
        it has another shape, or not finite numbers alone; in one sentence
    """
    shape = (size,) if size else ()
    try:
        numbers = np.asarray(given, float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(
            f'{name} is {one_sentence(given)}; it must be numbers of the shape {(count, *shape)}, '
            f'a row of each run, or {shape}, the same for all'
        ) from None
    if numbers.shape not in (shape, (count, *shape)):
        raise ValueError(
            f'{name} has the shape {numbers.shape}; it must be {(count, *shape)}, a row of each '
            f'run, or {shape}, the same for all'
        )
    numbers = np.broadcast_to(numbers, (count, *shape))
    if not np.isfinite(numbers).all():
        run = int(np.argwhere(~np.isfinite(numbers))[0, 0])
        raise ValueError(f'{name} of run {run} is {numbers[run]}; it must be finite')
    return numbers


# By their topics.
ACTUATORS: dict[str, type[Actuator]] = {}


def kind_of(topic: str) -> type[Actuator]:
    """Return the kind of actuators that has a topic, which may have names behind it."""
    return ACTUATORS[topic.partition('/')[0]]


def is_commanding(topic: str) -> bool:
    """Return whether a topic is, or was in an earlier version, that of an actuator."""
    return topic.partition('/')[0] in ACTUATORS or topic in earlier_types()


def earlier_types() -> dict[str, str]:
    """Return the types of messages by the topics of earlier versions."""
    return {topic: each for kind in ACTUATORS.values() for topic, each in kind.earlier.items()}

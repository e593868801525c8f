"""What is commanded as one vector in body axes."""

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any, ClassVar

from ..base.key import Key
from .actuator import Actuator, column

ZERO = (0.0, 0.0, 0.0)


class BodyVector(Actuator):
    """
    An actuator with one command, a vector (3,) in body axes.

    Attributes
    ----------
    quantity : Key
        its key in an events file
    field : str
        of the message, that has x, y and z
    record : str
        its name in snapshots
    """

    in_body_axes = True
    quantity: ClassVar[Key]
    field: ClassVar[str]
    record: ClassVar[str]

    def given(self, word: str, given: Any) -> dict[str, Any]:
        """Return by topic the checked values of a word; ValueError: as of Actuator.given."""
        return {self.topic: self.quantity.checked(given)}

    def columns(self, word: str, given: Any, count: int) -> dict[str, Any]:
        """Return what is held of vectors (M, 3); ValueError: as of Actuator.columns."""
        return {self.topic: tuple(column(self.quantity.name, given, count, 3).T)}

    @classmethod
    def plain(cls, topic: str, value: Any) -> dict[str, Any]:
        """Return a value as given() takes it, by its word."""
        return {cls.quantity.name: list(value)}

    def read(self, topic: str, message: Any) -> tuple[float, float, float]:
        """Return the value in a message; ValueError: it is built otherwise."""
        for part in self.field.split('.'):
            message = getattr(message, part)
        return message.x, message.y, message.z

    def check(self, topic: str, value: Any) -> None:
        """Raise ValueError, in one sentence, for a value that is not allowed."""
        if not all(map(isfinite, value)):
            given = ', '.join(f'{number:g}' for number in value)
            raise ValueError(f'{topic} is {given}; it must be finite [{self.quantity.unit}]')

    @classmethod
    def fields(cls, topic: str, value: Any) -> dict[str, Any]:
        """Return the fields of the message with a value."""
        return {cls.field: tuple(value)}

    def held(self, topic: str, value: Any) -> dict[str, Any]:
        """Return what a command holds, by name."""
        return {topic: tuple(value)}

    def commanding(self, held: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
        """Yield topics and values of the commands that hold this and nothing else."""
        yield from held.items()

    def to_plain(self, acting: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acts as plain data."""
        # Bags of scenarios without it have none.
        return {self.record: list(acting[self.topic])} if self.is_fitted else {}

    def from_plain(self, snapshot: Mapping[str, Any]) -> dict[str, Any]:
        """Return what acted when to_plain was asked."""
        if not self.is_fitted:
            return {}
        return {self.topic: self.quantity.checked(snapshot[self.record])}

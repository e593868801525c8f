"""What a value of orbit.type is: the keys that it takes, and the orbit that it makes of them."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NamedTuple

from ..base.key import Key
from ..base.sentences import Checks
from .orbit import Orbit

# By the value of orbit.type.
ORBIT_TYPES: dict[str, type['OrbitType']] = {}


class Ellipse(NamedTuple):
    """
    The ellipse at tick 0.

    Attributes
    ----------
    mu : m^3/s^2
        gravitational parameter
    semi_major_axis : m
        a
    eccentricity : float
        e
    name_of_axis : str
        what a sentence calls the semi-major axis
    """

    mu: Any
    semi_major_axis: Any
    eccentricity: Any
    name_of_axis: str


class OrbitType(ABC):
    """
    A value of orbit.type.

    Its methods take every key of a scenario by its dotted name, each value allowed by itself; of
    many scenarios arrays where they differ.  is_earlier is whether tables end as by rules below 4
    of runs.

    Attributes
    ----------
    name : str
        the value
    keys : tuple of Key
        of orbit.*, which belong to it and to others that name them; an orbit of one's own adds
        some
    has_lvlh : bool
        as of its orbits
    text : str
        the key of the text that says all of an orbit about the Earth from an instant on, or empty
    """

    name: ClassVar[str]
    keys: ClassVar[tuple[Key, ...]]
    has_lvlh: ClassVar[bool] = True
    text: ClassVar[str] = ''

    def __init_subclass__(cls) -> None:
        """Enter it into the list."""
        if 'name' in vars(cls):
            ORBIT_TYPES[cls.name] = cls

    @classmethod
    @abstractmethod
    def orbit(cls, values: Mapping[str, Any], is_earlier: bool) -> Orbit:
        """Return the orbit, the same one for the same values; ValueError: there is none."""

    @classmethod
    def checks(cls, values: Mapping[str, Any]) -> Checks:
        """Check what values may not be together."""
        yield from ()

    @classmethod
    def warnings(cls, values: Mapping[str, Any], is_earlier: bool) -> Iterator[str]:
        """Yield a sentence on what is doubtful, once tick 0 has an instant."""
        yield from ()

    @classmethod
    def is_shared(cls, values: Mapping[str, Any]) -> bool:
        """Return whether many runs can fly together on the same orbit alone."""
        return True

    @classmethod
    def ellipse(cls, values: Mapping[str, Any]) -> Ellipse | None:
        """Return the ellipse that the values describe, None: they describe none."""
        return None

"""The orbit of a scenario, by its orbit.type and by the rules of its run."""

from collections.abc import Iterator, Mapping
from typing import Any

from ..base.sentences import Checks
from ..orbits import ORBIT_TYPES, Orbit, OrbitType
from .rules import RULES, TABLES_END_WHERE_THEY_MUST

# The keys of the texts that say all of an orbit.
TEXTS = tuple(kind.text for kind in ORBIT_TYPES.values() if kind.text)
# Without one of these orbits a body has no LVLH, and with one no weight.
_FIXED = tuple(name for name, kind in ORBIT_TYPES.items() if not kind.has_lvlh)


def type_of(values: Mapping[str, Any]) -> type[OrbitType]:
    """Return what orbit.type says."""
    return ORBIT_TYPES[values['orbit.type']]


def belongs() -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Yield of each key that belongs to some types only: key, the choosing key, the types."""
    yield 'body.weight_moment', 'orbit.type', _FIXED
    keys = dict.fromkeys(key.name for kind in ORBIT_TYPES.values() for key in kind.keys)
    for name in keys:
        kinds = (each for each in ORBIT_TYPES.values() if name in (key.name for key in each.keys))
        yield name, 'orbit.type', tuple(kind.name for kind in kinds)


def checks(values: Mapping[str, Any]) -> Checks:
    """Check what the values of an orbit may not be together."""
    yield from type_of(values).checks(values)


def warnings(values: Mapping[str, Any], rules: int) -> Iterator[str]:
    """Yield a sentence on what is doubtful about it, by the rules of a run."""
    yield from type_of(values).warnings(values, rules < TABLES_END_WHERE_THEY_MUST)


def orbit_of(values: Mapping[str, Any], rules: int = RULES) -> Orbit:
    """
    Return the orbit, by the rules of a run.

    ValueError: its values allow none.
    """
    return type_of(values).orbit(values, rules < TABLES_END_WHERE_THEY_MUST)

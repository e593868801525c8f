"""The keys of sensors, in the order of the table of a scenario's keys."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from ..base.key import Key, part_key
from .sensor import COMMON, KINDS

# The sensors that version 0.2 had: their keys are in every text.
_ALWAYS_WRITTEN = 'gyro', 'star_tracker'
_SEED = Key(
    'sensors.seed',
    'integer',
    0,
    '',
    'seed of the noise, the same noise for the same seed; 0: drawn at start and recorded',
    low=0,
    high=2**63 - 1,
)


def keys_of_sensors() -> tuple[Key, ...]:
    """Return the keys of sensors that every scenario has, those of one of each type named so."""
    names = Key(
        'sensors.names',
        'string_array',
        (),
        '',
        'the sensors that measure, each described by sensors.NAME.type and so on; one with '
        f'the name of a type, {", ".join(KINDS)}, is of that type; each publishes on the '
        'topic of its name',
    )
    return (
        *(names, _SEED),
        *(key for name in KINDS for key in _of_any_type(name)),
        *(key for name, kind in KINDS.items() for key in _named(name, kind.keys)),
    )


def keys_of_sensor(name: str, kind: str) -> tuple[Key, ...]:
    """Return the keys of a sensor of a name and a type that not every scenario has."""
    key = type_of_sensor(name, kind)
    return (key,) if name in KINDS else (key, *_of_any_type(name), *_named(name, KINDS[kind].keys))


def type_of_sensor(name: str, default: str = '') -> Key:
    """Return the key of the type of a sensor; one that has the name of a type is of this type."""
    choices = (name,) if name in KINDS else tuple(KINDS)
    return Key(
        f'sensors.{name}.type', 'string', default, '', 'type of the sensor', choices=choices
    )


def _of_any_type(name: str) -> Iterator[Key]:
    """Yield the keys that a sensor of a name has whatever its type."""
    yield part_key(f'sensors.{name}')
    yield from _named(name, COMMON)


def _named(name: str, keys: Iterable[Key]) -> Iterator[Key]:
    """Yield the keys of a sensor of a name; its frame has the same unless it is given."""
    for key in keys:
        default = name if key.name == 'frame_id' else key.default
        is_optional = key.is_optional or name not in _ALWAYS_WRITTEN
        full_name = f'sensors.{name}.{key.name}'
        yield replace(key, name=full_name, default=default, is_optional=is_optional)

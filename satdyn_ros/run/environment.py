"""The environment of a scenario: what acts by it, and what its values may not be together."""

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Any

from ..actuators import ACTUATORS
from ..base.sentences import Checks, written
from ..environment import Exponential, Msis
from ..orbits import Orbit
from ..orbits.along_orbit import AlongOrbit
from ..orbits.kepler import EARTH_MU, EARTH_TO
from ..torques import ENVIRONMENT_TORQUES, BodyTorque
from ..torques.plates import COEFFICIENTS
from .orbits import type_of
from .rules import RULES, STEPS_SEE_PAIRS, TABLES_END_WHERE_THEY_MUST

# The models of what there is, none by default.
MODELS = ('environment.magnetic_field', 'environment.atmosphere', 'environment.sun')
_AIR: dict[str, Any] = {'exponential': Exponential, 'msis': Msis}
# Keys that belong to one model of the air: key, the choosing key, the choice.
OF_THE_AIR = tuple(
    (f'environment.{leaf}', 'environment.atmosphere', (model,))
    for model, kind in _AIR.items()
    for leaf in kind._fields
)


def asked(values: Mapping[str, Any]) -> list[str]:
    """Return the keys of the models that are asked for."""
    return [name for name in MODELS if values[name] != 'none']


def needs_epoch(values: Mapping[str, Any]) -> str:
    """Return the key by which the scenario needs the instant of tick 0, '' if it needs none."""
    if type_of(values).text:
        return 'orbit.type'
    return next(iter(asked(values)), '')


def checks(values: Mapping[str, Any]) -> Checks:
    """Check that the centre is the Earth where its environment is asked for, and the plates."""
    orbit_type = type_of(values)
    for key in asked(values):
        model, mu = values[key], values['orbit.mu']
        if (yield not orbit_type.has_lvlh):
            raise ValueError(
                f'{key} is {model}; with orbit.type {orbit_type.name} the body has no position in '
                'it, so it must be none'
            )
        if (yield abs(mu / EARTH_MU - 1.0) > EARTH_TO):
            raise ValueError(
                f'{key} is {model}, of the Earth, and orbit.mu {written(mu)}; it must be within '
                f'{EARTH_TO:g} of {EARTH_MU:.10g}'
            )
    if values['environment.atmosphere'] == 'exponential':
        for leaf in ('density', 'scale_height'):
            name = f'environment.{leaf}'
            if (yield values[name] == 0.0):
                raise ValueError(
                    f'{name} is 0; with environment.atmosphere exponential it must be above 0'
                )
    for prefix in ('surface', *(f'surface.{name}' for name in values['surface.names'])):
        mirrored, scattered = values[f'{prefix}.specular'], values[f'{prefix}.diffuse']
        if (yield mirrored + scattered > 1.0):
            default = (
                '' if prefix == 'surface' else '; values that are not given are those of surface'
            )
            raise ValueError(
                f'{prefix}.specular is {written(mirrored)} and {prefix}.diffuse '
                f'{written(scattered)}; together they must be at most 1{default}'
            )


def of_the_surface(names: Iterable[str]) -> dict[str, str]:
    """Return, by the keys of plates of these names that default to it, each key of the surface."""
    return {
        f'surface.{name}.{key.name}': f'surface.{key.name}'
        for name in names
        for key in COEFFICIENTS
    }


def checks_of_torques(values: Mapping[str, Any]) -> Checks:
    """Check what the values of the torques of the environment may not be together."""
    for kind in ENVIRONMENT_TORQUES:
        yield from kind.checks(values)


def _given(kind, values):
    """Return the keys that describe what a kind of torques acts on, those of actuators too."""
    acting = (each for each in ACTUATORS.values() if each.acts_on is kind)
    keys = (key for each in acting for key in each.keys)
    return [*kind.given(values), *(key.name for key in keys if values[key.name] != key.default)]


def without_effect(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence on each thing that is described and that nothing acts on."""
    needed: dict[str, list[str]] = {}
    for kind in ENVIRONMENT_TORQUES:
        for name in _given(kind, values):
            needed.setdefault(name, []).append(kind.needs)
    for name, models in needed.items():
        if all(values[model] == 'none' for model in models):
            yield f'{name} is given, but without {" or ".join(models)} it has no effect'


def along(
    values: Mapping[str, Any],
    orbit: Orbit,
    by_rules: int = RULES,
) -> AlongOrbit | None:
    """
    Return the environment along an orbit, the same for scenarios that share orbit and models.

    None: the centre is not the Earth, or tick 0 has no instant.  ValueError: a model does not know
    the time of tick 0.
    """
    if not orbit.has_lvlh or not (
        values['time.epoch_ns'] and abs(values['orbit.mu'] / EARTH_MU - 1.0) <= EARTH_TO
    ):
        return None
    model = values['environment.atmosphere']
    air = None
    if model != 'none':
        air = _AIR[model](*(values[f'environment.{leaf}'] for leaf in _AIR[model]._fields))
    return _along(
        orbit,
        values['time.epoch_ns'],
        values['environment.magnetic_field'],
        air,
        values['environment.sun'] != 'none',
        by_rules < TABLES_END_WHERE_THEY_MUST,
        by_rules >= STEPS_SEE_PAIRS,
    )


# Runs that share them share the tables.
_along = lru_cache(maxsize=4)(AlongOrbit)


def torques_of(
    values: Mapping[str, Any], along_orbit: AlongOrbit | None
) -> tuple[BodyTorque, ...]:
    """Return the torques of the environment, those whose ingredients are given."""
    if along_orbit is None:
        return ()
    return tuple(
        kind.along(values, along_orbit)
        for kind in ENVIRONMENT_TORQUES
        if values[kind.needs] != 'none' and _given(kind, values)
    )

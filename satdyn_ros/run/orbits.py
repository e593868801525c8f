"""The orbit of a scenario, and what its values may not be together."""

import math
from collections.abc import Mapping
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

import numpy as np

from ..base.sentences import Rules, written
from ..orbits import FixedDirection, KeplerOrbit, TabledOrbit
from ..orbits.kepler import EARTH_MU, state_rules
from ..orbits.tabled import OrbitSource
from .rules import RULES, TABLES_END_WHERE_THEY_MUST

OF_AN_ELLIPSE = ('circular', 'kepler', 'state')
# Those of the Earth, with an instant of their own, and the key of each.
OF_A_TEXT = {'tle': 'orbit.tle', 'oem': 'orbit.file'}
_ELEMENTS = (
    'mu',
    'semi_major_axis',
    'eccentricity',
    'inclination',
    'raan',
    'argument_of_periapsis',
    'true_anomaly',
)
# Values of mu in use differ by less.
EARTH_TO = 1e-4


def rules(values: Mapping[str, Any]) -> Rules:
    """Check that a state is on an ellipse, and that the centre of a text is the Earth."""
    kind, mu = values['orbit.type'], values['orbit.mu']
    if kind == 'state':
        yield from state_rules(*_state(values))
    if kind in OF_A_TEXT and (yield abs(mu / EARTH_MU - 1.0) > EARTH_TO):
        raise ValueError(
            f'orbit.mu is {written(mu)}; with orbit.type {kind} the centre is the Earth, so it '
            f'must be within {EARTH_TO:g} of {EARTH_MU:.10g}'
        )


def orbit_of(
    values: Mapping[str, Any], rules: int = RULES
) -> FixedDirection | KeplerOrbit | TabledOrbit:
    """
    Return the orbit, by the rules of a run.

    ValueError: it needs the instant of tick 0, which has none yet.
    """
    kind, mu = values['orbit.type'], values['orbit.mu']
    if kind == 'fixed':
        return FixedDirection(values['orbit.gradient'])
    if kind in OF_A_TEXT:
        return _tabled(text_source(values, rules), mu)
    if kind == 'state':
        ellipse = KeplerOrbit.from_state(*_state(values))
    else:
        ellipse = KeplerOrbit(**{name: values[f'orbit.{name}'] for name in _ELEMENTS})
    if not values['orbit.j2']:
        return ellipse
    return _tabled(_oblate(ellipse, values['orbit.j2'], values['orbit.reference_radius']), mu)


@lru_cache(maxsize=4)
def _oblate(ellipse, j2, reference_radius):
    from ..orbits.j2 import OblateOrbit

    return OblateOrbit(ellipse, j2, reference_radius)


# Runs that share the orbit share its table.
_tabled = lru_cache(maxsize=4)(TabledOrbit)


def is_tabled(values: Mapping[str, Any]) -> bool:
    """Return whether the orbit is a table, which many runs can only share."""
    return values['orbit.type'] in OF_A_TEXT or values['orbit.j2'] != 0.0


def known_until(orbit: FixedDirection | KeplerOrbit | TabledOrbit, t_s: float) -> float:
    """Return up to when [s] an orbit is known from a time on; ValueError: it is not there."""
    return orbit.pieces.covered_until(t_s) if isinstance(orbit, TabledOrbit) else math.inf


def ellipse(values: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    """Return mu [m^3/s^2], semi-major axis [m] and eccentricity of the ellipse at tick 0."""
    mu = values['orbit.mu']
    if values['orbit.type'] == 'state':
        orbit = KeplerOrbit.from_state(*_state(values))
        return mu, orbit.semi_major_axis, orbit.eccentricity
    return mu, values['orbit.semi_major_axis'], values['orbit.eccentricity']


def name_of_axis(values: Mapping[str, Any]) -> str:
    """Return by what the semi-major axis is given."""
    if values['orbit.type'] == 'state':
        return 'the semi-major axis of orbit.position and orbit.velocity'
    return 'orbit.semi_major_axis'


def text_source(values: Mapping[str, Any], rules: int = RULES) -> OrbitSource:
    """
    Return what the text of orbit.tle or orbit.file says, by the rules of a run.

    ValueError: what is wrong with it.
    """
    kind = values['orbit.type']
    given = values[OF_A_TEXT[kind]]
    if not given:
        raise ValueError(f'orbit.type is {kind}, and {OF_A_TEXT[kind]} is not given')
    is_earlier = rules < TABLES_END_WHERE_THEY_MUST
    return _source(kind, given, values['time.epoch_ns'], is_earlier)


# A long ephemeris takes longer to read than all the rest of a scenario.
@lru_cache(maxsize=4)
def _source(kind, given, epoch_ns, is_earlier):
    with _needed_by(kind):
        if kind == 'tle':
            from ..orbits import tle

            text = '\n'.join(given)
            if not is_earlier:
                tle.check(text)
            return tle.TwoLineOrbit(text, epoch_ns)
        if is_earlier:
            from ..orbits.earlier_ephemeris import EarlierEphemerisOrbit

            return EarlierEphemerisOrbit(given, epoch_ns)
        from ..orbits.ephemeris import EphemerisOrbit

        return EphemerisOrbit(given, epoch_ns)


@contextmanager
def _needed_by(kind):
    """Say of a library that is not installed which orbit.type needs it."""
    try:
        yield
    except ValueError as error:
        if isinstance(error.__cause__, ImportError):
            raise ValueError(f'orbit.type is {kind}: {error}') from error.__cause__
        raise


def _state(values):
    """Return r_i, v_i and mu."""
    r_i, v_i = np.asarray(values['orbit.position']), np.asarray(values['orbit.velocity'])
    return r_i, v_i, values['orbit.mu']

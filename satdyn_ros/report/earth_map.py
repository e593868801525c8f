"""What a map of the Earth needs: coast lines, and the topic of the position over it."""

import json
from collections.abc import Iterator
from importlib.resources import files
from typing import Any

import numpy as np

from ..base.nanoseconds import SECOND_NS
from ..orbits import Orbit
from ..orbits.kepler import EARTH_MU, EARTH_RADIUS_M
from ..run.scenario import Scenario
from ..run.topics import Topic

# The topic of the position: latitude and longitude [deg] and height [m] on WGS 84.
GEODETIC = 'geodetic'


def geodetic_topics(scenario: Scenario) -> list[Topic]:
    """Return the topic of the position, if the scenario publishes it."""
    return [scenario.topic_table[GEODETIC]] if GEODETIC in scenario.topics else []


def is_about_earth(orbit: Orbit) -> bool:
    """Return whether there is an orbit, and its centre is the Earth, by its mu."""
    return orbit.has_lvlh and bool(abs(orbit.mu / EARTH_MU - 1.0) < 1e-3)


def description(scenario: Scenario) -> dict[str, Any] | None:
    """
    Return what a page needs to draw the Earth, plain data; None: no position is published.

    Returns
    -------
    epoch_s : s
        Unix time of tick 0
    period_s : s
        of the orbit, so long is the track
    coast : dict
        as in coast.json
    """
    orbit = scenario.system.orbit
    if GEODETIC not in scenario.topics or not orbit.has_lvlh:
        return None
    return {
        'epoch_s': scenario.epoch_ns / SECOND_NS,
        'period_s': orbit.period_s,
        'coast': _coast(),
    }


def coast_lines() -> Iterator[np.ndarray]:
    """Yield the coast lines, (N, 2) each: longitude and latitude [deg]."""
    coast = _coast()
    for line in coast['lines']:
        yield np.multiply(coast['unit_deg'], line).reshape(-1, 2)


def earth() -> dict[str, Any]:
    """
    Return what a page needs to draw the Earth and orbits about it, plain data.

    Returns
    -------
    radius_m : m
        of the equator
    mu : m^3/s^2
        gravitational parameter
    coast : dict
        as in coast.json
    """
    return {'radius_m': EARTH_RADIUS_M, 'mu': EARTH_MU, 'coast': _coast()}


def _coast():
    return json.loads(files(__package__).joinpath('bundled/coast.json').read_text())

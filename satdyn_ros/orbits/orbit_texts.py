"""Orbits of a text, about the Earth and of an instant: element sets and ephemerides."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from ..base.key import Key
from ..base.sentences import Checks, written
from .ellipses import MU
from .kepler import EARTH_MU, EARTH_TO
from .orbit import Orbit
from .orbit_type import OrbitType
from .tabled import OrbitSource, tabled_orbit

TLE = Key(
    'orbit.tle',
    'texts',
    (),
    '',
    'the two lines of an element set, or the name of a file of one, also as a CCSDS OMM '
    '(keyword = value, XML, JSON, CSV), as seen from the parameter file; or the name of a '
    'file of many, and the number in the catalogue or the name, both as texts, of the one '
    'to take; its text is then the value; orbit.type tle only',
    is_optional=True,
)
FILE = Key(
    'orbit.file',
    'text',
    '',
    '',
    'the name of a file with a CCSDS OEM (keyword = value or XML) or an STK ephemeris, as '
    'seen from the parameter file, whose text is then the value; or of an SPK kernel of '
    'SPICE, of which it is an OEM; what has a line break is the text; orbit.type oem only',
    is_optional=True,
)


class _OfAText(OrbitType):
    """An orbit of a text, which is a table."""

    @classmethod
    def orbit(cls, values: Mapping[str, Any], is_earlier: bool) -> Orbit:
        """Return the orbit."""
        return tabled_orbit(cls._source_of(values, is_earlier), values['orbit.mu'])

    @classmethod
    def checks(cls, values: Mapping[str, Any]) -> Checks:
        """Check that the centre is the Earth."""
        mu = values['orbit.mu']
        if (yield abs(mu / EARTH_MU - 1.0) > EARTH_TO):
            raise ValueError(
                f'orbit.mu is {written(mu)}; with orbit.type {cls.name} the centre is the Earth, '
                f'so it must be within {EARTH_TO:g} of {EARTH_MU:.10g}'
            )

    @classmethod
    def warnings(cls, values: Mapping[str, Any], is_earlier: bool) -> Iterator[str]:
        """Yield what is doubtful about the text."""
        if sentence := cls._source_of(values, is_earlier).warning:
            yield sentence

    @classmethod
    def _source_of(cls, values, is_earlier):
        given = values[cls.text]
        if not given:
            raise ValueError(f'orbit.type is {cls.name}, and {cls.text} is not given')
        return _source(cls, given, values['time.epoch_ns'], is_earlier)


class OfElementSet(_OfAText):
    """An element set by SGP4."""

    name = 'tle'
    keys, text = (MU, TLE), TLE.name

    @staticmethod
    def source(given: tuple[str, ...], epoch_ns: int, is_earlier: bool) -> OrbitSource:
        """Return what the lines say."""
        from . import tle

        text = '\n'.join(given)
        if not is_earlier:
            tle.check(text)
        return tle.TwoLineOrbit(text, epoch_ns)


class OfEphemeris(_OfAText):
    """An ephemeris message."""

    name = 'oem'
    keys, text = (MU, FILE), FILE.name

    @staticmethod
    def source(given: str, epoch_ns: int, is_earlier: bool) -> OrbitSource:
        """Return what the text says."""
        if is_earlier:
            from .earlier_ephemeris import EarlierEphemerisOrbit

            return EarlierEphemerisOrbit(given, epoch_ns)
        from .ephemeris import EphemerisOrbit

        return EphemerisOrbit(given, epoch_ns)


# A long ephemeris takes longer to read than all the rest of a scenario.
@lru_cache(maxsize=4)
def _source(kind, given, epoch_ns, is_earlier):
    with _needed_by(kind):
        return kind.source(given, epoch_ns, is_earlier)


@contextmanager
def _needed_by(kind):
    """Say of a library that is not installed which orbit.type needs it."""
    try:
        yield
    except ValueError as error:
        if isinstance(error.__cause__, ImportError):
            raise ValueError(f'orbit.type is {kind.name}: {error}') from error.__cause__
        raise

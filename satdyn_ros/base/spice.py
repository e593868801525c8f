"""NAIF's SPICE toolkit, which the extra `spice` brings, and one sentence for what it refuses."""

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

from .extras import brought_by


@contextmanager
def spice() -> Iterator[ModuleType]:
    """Yield the module spiceypy; ValueError: it is not installed, or what SPICE says."""
    with brought_by('spice', 'spiceypy'):
        import spiceypy
    try:
        yield spiceypy
    except spiceypy.exceptions.SpiceyError as error:
        raise ValueError(f'SPICE says: {" ".join(error.long.split())}') from None

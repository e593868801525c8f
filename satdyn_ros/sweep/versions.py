"""The versions that all runs of a table have in common."""

from functools import cache
from hashlib import sha256
from pathlib import Path

from ..bag.run_metadata import machine


@cache
def versions() -> dict[str, str]:
    """Return what the bits of a table depend on; sources: a digest of this package's."""
    package = Path(__file__).parents[1]
    sources = b''.join(path.read_bytes() for path in sorted(package.rglob('*.py')))
    return machine() | {'sources': sha256(sources).hexdigest()[:12]}

"""The versions that all runs of a table have in common."""

from functools import cache
from hashlib import sha256
from pathlib import Path

from ..bag.run_metadata import machine
from ..kernel.code_folder import sources


@cache
def versions() -> dict[str, str]:
    """Return what the bits of a table depend on; sources: a digest of this package's."""
    package = Path(__file__).parents[1]
    content = b''.join(path.read_bytes() for path in sources(package))
    return machine() | {'sources': sha256(content).hexdigest()[:12]}

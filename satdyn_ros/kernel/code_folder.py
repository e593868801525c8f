"""The folder for the code of exactly these sources, by these libraries, for this processor."""

import functools
import os
import sys
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from llvmlite.binding import get_host_cpu_features, get_host_cpu_name

from . import cache

# What compiles, and whose numbers are compiled into the code, as SciPy's tableau is.
_LIBRARIES = 'numba', 'llvmlite', 'numpy', 'scipy'


def sources(package: Path) -> list[Path]:
    """Return the files of a package's code, in order."""
    found = []
    for folder, folders, names in os.walk(package):
        # In there other processes remove the code of older sources while this one looks.
        folders[:] = [name for name in folders if name != '__pycache__']
        found += [Path(folder, name) for name in names if name.endswith('.py')]
    return sorted(found)


@functools.cache
def code_folder() -> Path | None:
    """Return the folder, after removing those of older sources; None: there is no folder."""
    root = cache.find(os.environ.get('NUMBA_CACHE_DIR', ''))
    if root is None:
        return None
    # numba itself looks for changes in a function's own file alone, not in what it calls.
    package = Path(__file__).parents[1]
    content = sha256()
    for path in sources(package):
        content.update(f'{path.relative_to(package)}\n'.encode() + path.read_bytes())
    for library in _LIBRARIES:
        content.update(f'{library} {version(library)}\n'.encode())
    made_by = [str(package), sys.version, get_host_cpu_name(), get_host_cpu_features().flatten()]
    begin = sha256('\n'.join(made_by).encode()).hexdigest()[:8]
    folder = root / f'{begin}-{content.hexdigest()[:16]}'
    cache.remove_others(folder, f'{begin}-*')
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder


def other_processor() -> str | None:
    """Return the processor that NUMBA_CPU_NAME asks code for, None: for the one here."""
    return os.environ.get('NUMBA_CPU_NAME') or None


def compiler() -> dict[str, str]:
    """Return the processor that code is compiled for, and the versions of what compiles it."""
    libraries = {library: version(library) for library in ('numba', 'llvmlite')}
    return {'processor': get_host_cpu_name(), **libraries}

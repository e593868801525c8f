"""The decorators of compiled functions, and where their code is kept for the next start."""

import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba import config, njit

# What is said before the first use, which takes its time.
NOTICE = 'compiling the equations of motion: once, for some seconds'


def compiled(function: Callable) -> Any:
    """Compile a function at its first call, and keep the code."""
    return _compile(function, cache=True)


def inlined(function: Callable) -> Any:
    """Compile a function into the body of those that call it."""
    return _compile(function, forceinline=True)


def is_kept(function: Any) -> bool:
    """Return whether the code of a compiled function is there from an earlier start."""
    return any(Path(function.stats.cache_path).glob(f'*.{function.__name__}-*.nbi'))


def _compile(function, **options):
    before, config.CACHE_DIR = config.CACHE_DIR, _DIRECTORY
    try:
        # Contraction to fused multiply-add is all the compiler may do: same inputs, same bits.
        return njit(function, fastmath={'contract'}, error_model='numpy', **options)
    finally:
        config.CACHE_DIR = before


def _directory():
    """Return where code made of these very sources is kept; what others left there goes."""
    # numba itself looks for changes in a function's own file alone, not in what it calls.
    package = Path(__file__).parent
    sources = [Path(__file__), *package.glob('dynamics/*.py'), *package.glob('exact/*.py')]
    digest = sha256(b''.join(path.read_bytes() for path in sorted(sources))).hexdigest()[:16]
    if not config.CACHE_DIR and os.access(package, os.W_OK):
        kept = package / '__pycache__' / 'compiled'
    else:
        kept = Path(config.CACHE_DIR or Path.home() / '.cache', 'satdyn_ros')
    with suppress(OSError):
        for old in kept.iterdir():
            if old.name != digest:
                shutil.rmtree(old, ignore_errors=True)
    return str(kept / digest)


_DIRECTORY = _directory()

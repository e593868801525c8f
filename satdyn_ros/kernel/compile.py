"""
The decorators of compiled functions.

A function is compiled at its first call and its code kept for the next start.  The compiler works
in a child process: this one could not handle a signal until the compiler is done.
"""

import fcntl
import functools
import logging
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from importlib import import_module
from typing import Any

from numba import config, njit

from . import cache
from .code_folder import code_folder

_log = logging.getLogger('satdyn_ros')
_is_child = False


def compiled(
    function: Callable[..., Any],
    signature: str | None = None,
    nogil: bool = False,
    is_short: bool = False,
) -> Any:
    """
    Compile a function at its first call, or now for a signature, and keep the code.

    Parameters
    ----------
    function : function
        in the Python that numba compiles
    signature : str or None
        for which it is compiled now; None: at its first call
    nogil : bool
        whether other threads of Python go on while it runs
    is_short : bool
        whether it is compiled here, in less than a second: to start another process would take
        twice as long
    """
    dispatcher = _compile(function, cache=_FOLDER is not None, nogil=nogil)
    if _FOLDER is not None and not is_short:
        compile_here = dispatcher.compile

        def compile_aside_first(signature):
            if not _is_child and not _is_kept(dispatcher, signature):
                _compile_aside(dispatcher, signature)
            return compile_here(signature)

        dispatcher.compile = compile_aside_first
    if signature is not None:
        dispatcher.compile(signature)
        # Arrays of other layouts are converted; left to itself numba would compile for each.
        dispatcher.disable_compile()
    return dispatcher


def inlined(function: Callable[..., Any], makes_arrays: bool = False) -> Any:
    """
    Compile a function into the body of those that call it.

    It has no code of its own: called by Python, it runs as it is written.

    makes_arrays: it makes arrays of its own.  If not, it borrows those it is given: counting who
    holds them at every call took an eighth of a propagation.
    """
    # What Python would call it by takes half of the compiler's time.
    wrappers = {'no_cpython_wrapper': True, 'no_cfunc_wrapper': True}
    dispatcher = _compile(function, forceinline=True, _nrt=makes_arrays, **wrappers)
    overloads = dispatcher.overloads
    dispatcher.add_overload = lambda code: overloads.update({tuple(code.signature.args): code})
    dispatcher._compile_for_args = lambda *args, **named: function
    return dispatcher


def load_numba_without_blas() -> None:
    """
    Load what numba loads with its first compiled code, but for scipy.linalg, a fifth of a start.

    For the compiler's process: no function here has matrix products.
    """
    if 'scipy.linalg' in sys.modules:
        return
    sys.modules['scipy.linalg'] = None  # type: ignore[assignment]
    try:
        import_module('numba.np.arraymath')
    finally:
        del sys.modules['scipy.linalg']


def _compile(function, **options):
    with _keeping():
        # Nothing may be contracted or reordered: same inputs, same bits.
        return njit(function, error_model='numpy', **options)


@contextmanager
def _keeping() -> Iterator[None]:
    before, config.CACHE_DIR = config.CACHE_DIR, str(_FOLDER or '')
    try:
        yield
    finally:
        config.CACHE_DIR = before


def _is_kept(dispatcher, signature):
    """Return whether there is code for a signature from an earlier start."""
    # numba has no public way to ask without loading the code.
    kept = dispatcher._cache
    key = kept._index_key(signature, dispatcher.targetctx.codegen())
    return key in kept._cache_file._load_index()


# -- the child process ----------------------------------------------------------------------------

_PROGRAM = (
    'import sys; sys.path[:] = sys.argv[1:]; '
    'from satdyn_ros.kernel.compile import compile_for_parent; compile_for_parent()'
)


def _compile_aside(dispatcher, signature):
    """
    Let a child process compile a function for a signature, unless another process just did.

    A failure there, as of a file system without locks, is left to the compilation in this process.
    """
    try:
        work = pickle.dumps((dispatcher.__module__, dispatcher.__name__, signature))
    except (AttributeError, pickle.PicklingError):
        # A class, such as one in a function, that no other process could import.
        return
    with suppress(OSError), _lock(dispatcher, repr(signature)):
        if _is_kept(dispatcher, signature):
            return
        _log_compilation()
        with subprocess.Popen(
            [sys.executable, '-c', _PROGRAM, *sys.path],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        ) as child:
            assert child.stdin is not None  # it is a pipe
            try:
                # Left open: the child ends when it is closed, as it is when this process ends.
                child.stdin.write(work)
                child.stdin.flush()
                child.wait()
            except BaseException:
                child.kill()
                raise
        if child.returncode == -signal.SIGINT:
            raise KeyboardInterrupt


def compile_for_parent() -> None:
    """Compile what the parent process asks for on the standard input, and end when it ends."""
    global _is_child
    _is_child = True
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    load_numba_without_blas()
    module, name, signature = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    dispatcher = getattr(import_module(module), name)
    save = dispatcher._cache.save_overload

    def save_alone(*code):
        # numba reads the list of what is kept of a function, adds to it, and writes it.
        with _lock(dispatcher, 'list'):
            save(*code)

    dispatcher._cache.save_overload = save_alone
    dispatcher.compile(signature)


def _end_with_parent():
    sys.stdin.buffer.read()
    os._exit(1)


@contextmanager
def _lock(function, what: str) -> Iterator[None]:
    """Let one process at a time do something with a function, as compile it for a signature."""
    name = f'{function.__module__}.{function.__name__}-{sha256(what.encode()).hexdigest()[:16]}'
    with open(_FOLDER / f'{name}.lock', 'wb') as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@functools.cache
def _log_compilation():
    """Say once why the first use takes its time."""
    if cache.is_temporary(_FOLDER.parent):
        _log.info(
            'compiling, for some ten seconds at every start: no folder for '
            'compiled code can be written, and %s is removed at the end',
            _FOLDER.parent,
        )
    else:
        _log.info('compiling, for some ten seconds: the code is kept for the next start')


_FOLDER: Any = code_folder()

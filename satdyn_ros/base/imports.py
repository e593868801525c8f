"""Modules that are imported when they are named: of a package (PEP 562), a user, or an extra."""

import pkgutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType


def modules_of(package: str) -> tuple[Callable[[str], ModuleType], Callable[[], list[str]]]:
    """
    Return a package's __getattr__, which imports its modules, and its __dir__, which lists them.

    >>> __getattr__, __dir__ = modules_of('satdyn_ros.theory')
    >>> __getattr__('stability').__name__, 'verdicts' in __dir__()
    ('satdyn_ros.theory.stability', True)
    """

    def module(name: str) -> ModuleType:
        try:
            if not name.startswith('_'):
                return import_module(f'{package}.{name}')
        except ModuleNotFoundError:
            pass
        raise AttributeError(f'module {package!r} has no attribute {name!r}')

    def names() -> list[str]:
        here = sys.modules[package]
        own = (name for name in vars(here) if name.startswith('__'))
        return [*own, *(found.name for found in pkgutil.iter_modules(here.__path__))]

    return module, names


def own_module(name: str) -> ModuleType:
    """Import a module that a command line names, from the working directory too."""
    # As for `python -m`.
    if '' not in sys.path:
        sys.path.append('')
    return import_module(name)


@contextmanager
def brought_by(extra: str, library: str) -> Iterator[None]:
    """
    Say of a library that is imported here which extra brings it, if it is not installed.

    ValueError: it is not.

    >>> with brought_by('plot', 'a-library'):
    ...     import a_library
    Traceback (most recent call last):
    ValueError: this needs a-library, which the extra `plot` brings: pip install a-library
    """
    try:
        yield
    except ImportError as error:
        raise ValueError(
            f'this needs {library}, which the extra `{extra}` brings: pip install {library}'
        ) from error


@contextmanager
def spice() -> Iterator[ModuleType]:
    """Yield the module spiceypy; ValueError: it is not installed, or what SPICE says."""
    with brought_by('spice', 'spiceypy'):
        import spiceypy
    try:
        yield spiceypy
    except spiceypy.exceptions.SpiceyError as error:
        raise ValueError(f'SPICE says: {" ".join(error.long.split())}') from None

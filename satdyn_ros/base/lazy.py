"""Modules that are imported when they are named: of a package (PEP 562), or by whoever types."""

import pkgutil
import sys
from collections.abc import Callable
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

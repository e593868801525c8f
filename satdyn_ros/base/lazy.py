"""Modules of a package that are imported when they are first named (PEP 562)."""

from collections.abc import Callable
from importlib import import_module
from types import ModuleType


def modules_of(package: str) -> Callable[[str], ModuleType]:
    """
    Return a package's __getattr__, which imports its modules.

    >>> __getattr__ = modules_of('satdyn_ros.theory')
    >>> __getattr__('stability').__name__
    'satdyn_ros.theory.stability'
    """

    def module(name: str) -> ModuleType:
        try:
            if not name.startswith('_'):
                return import_module(f'{package}.{name}')
        except ModuleNotFoundError:
            pass
        raise AttributeError(f'module {package!r} has no attribute {name!r}')

    return module

"""What moves: bodies, orbits, the equations of motion and what theory says of them."""

from importlib import import_module
from types import ModuleType


def __getattr__(name: str) -> ModuleType:
    """Return a module of this package, imported when it is first named."""
    if name.startswith('_'):
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    try:
        return import_module(f'{__name__}.{name}')
    except ModuleNotFoundError as error:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}') from error

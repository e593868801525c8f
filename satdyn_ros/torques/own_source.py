"""What the function of a torque of one's own depends on: the texts of modules."""

import inspect
from collections.abc import Iterable, Iterator
from contextlib import suppress
from types import CodeType, FunctionType, ModuleType
from typing import Any

_PACKAGE = __name__.partition('.')[0]


def source_of(things: Iterable[Any]) -> str:
    """
    Return the texts of the modules of some classes and functions, and of the functions they call.

    Each once; those of this package are left out.
    """
    functions = [thing for thing in things if not isinstance(thing, type)]
    classes = [thing for thing in things if isinstance(thing, type)]
    own = [
        thing for thing in (*classes, *_called(functions)) if not is_of_package(thing.__module__)
    ]
    return '\n'.join(dict.fromkeys(map(_text, own)))


def _called(functions: Iterable[Any]) -> list[FunctionType]:
    """Return plain functions, and what they call of those, each once."""
    found: dict[FunctionType, None] = {}
    waiting = list(functions)
    while waiting:
        function = waiting.pop(0)
        # Of a compiled function the one that was compiled.
        function = getattr(function, 'py_func', function)
        if isinstance(function, FunctionType) and function not in found:
            found[function] = None
            if not is_of_package(function.__module__):
                waiting += [value for _, value in _referred(function)]
    return list(found)


def _referred(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield what a function refers to outside of itself, by its name there."""
    known = dict(function.__globals__)
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        # A cell may be empty until the function is called.
        with suppress(ValueError):
            known[name] = cell.cell_contents
    names = [name for code in codes(function.__code__) for name in _names(code)]
    for name in dict.fromkeys(names):
        if name in known:
            yield name, known[name]
            if isinstance(known[name], ModuleType):
                inner = vars(known[name])
                yield from ((f'{name}.{each}', inner[each]) for each in names if each in inner)


def _names(code):
    return (*code.co_names, *code.co_freevars)


def codes(code: CodeType) -> Iterator[CodeType]:
    """Yield a code and those of the functions in it."""
    yield code
    for const in code.co_consts:
        if isinstance(const, CodeType):
            yield from codes(const)


def is_of_package(module: str | None) -> bool:
    """Return whether the module of a thing, by its name, is one of this package."""
    return (module or '').partition('.')[0] == _PACKAGE


def _text(thing):
    """Return the text of the module that a class or a function is in, or of itself without one."""
    try:
        module = inspect.getmodule(thing)
        return inspect.getsource(thing if module is None else module)
    except (OSError, TypeError):
        # Typed into an interpreter or a notebook.
        functions = [thing] if isinstance(thing, FunctionType) else []
        return ' '.join(_written(code) for f in functions for code in codes(f.__code__))


def _written(code):
    # The text of a code in another has an address.
    consts = [const for const in code.co_consts if not isinstance(const, CodeType)]
    return f'{code.co_code.hex()} {consts} {code.co_names}'

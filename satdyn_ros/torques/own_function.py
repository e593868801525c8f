"""
The functions of a torque of one's own, made for what the equations call them with.

They are written with math, min and max, which take no symbols and no columns: what they refer to
is replaced by what does.
"""

import builtins
import functools
import math
import traceback
from collections.abc import Callable
from pathlib import Path
from types import CellType, FunctionType, ModuleType
from typing import Any

import numpy as np

from ..kernel import functions
from ..trace.graph import Symbol
from .own_source import codes, is_of_package

_NUMBERS = (Symbol, float, int, np.floating, np.integer)
# How many numbers the functions of a torque return; 0: one that is no tuple, None: any.
_LENGTHS = {
    'torque': 3,
    'force': 3,
    'field': 3,
    'potential': 0,
    'orbit_power': 0,
    'signs': None,
    'rates': None,
}


def function_of(kind: Any, name: str) -> Callable[..., Any]:
    """
    Return a function of a torque, which takes floats, symbols and columns.

    That of one's own raises ValueError, in one sentence with its file and line, where it cannot be
    called with them or returns something else.
    """
    function = getattr(kind, name)
    if kind.is_shipped():
        return function
    return functools.partial(_checked, function, f'the torque {kind.full_name()}: its {name}')


def _checked(function, subject, *arguments):
    try:
        found = _rebound(function, {})(*arguments)
    except Exception as error:
        where = _where(function, traceback.extract_tb(error.__traceback__))
        why = str(error) if type(error) is TypeError else f'{type(error).__name__}: {error}'
        raise ValueError(f'{subject} cannot be computed: {why}{where}') from None
    length = _LENGTHS[subject.rpartition(' ')[2]]
    parts = found if isinstance(found, tuple) else (found,)
    fits = isinstance(found, tuple) == (length != 0) and (not length or len(parts) == length)
    if fits and all(isinstance(x, (*_NUMBERS, np.ndarray)) for x in parts):
        return found
    if isinstance(found, tuple):
        wrong = [type(x).__name__ for x in parts if not isinstance(x, (*_NUMBERS, np.ndarray))]
        returned = f'a tuple of {len(found)}' + (f' with a {wrong[0]}' if wrong else '')
    else:
        returned = 'nothing' if found is None else f'a value of type {type(found).__name__}'
    due = 'a number' if length == 0 else f'a tuple of {length or "some"} numbers'
    raise ValueError(f'{subject} returns {returned}; it must return {due}{_where(function, [])}')


def _where(function, frames):
    """Return the file and the line of the last of some frames that is not in this package."""
    package = str(Path(__file__).parents[1])
    for frame in reversed(frames):
        if not frame.filename.startswith(package):
            return f' ({Path(frame.filename).name}, line {frame.lineno})'
    code = getattr(function, '__code__', None)
    return f' ({Path(code.co_filename).name}, line {code.co_firstlineno})' if code else ''


# -- what a function refers to --------------------------------------------------------------------


def _least(*values: Any, **how: Any) -> Any:
    """Return min(...), of symbols and columns too."""
    return builtins.min(*values, **how) if how else _folded(functions.minimum, values)


def _greatest(*values: Any, **how: Any) -> Any:
    """Return max(...), of symbols and columns too."""
    return builtins.max(*values, **how) if how else _folded(functions.maximum, values)


def _folded(of_two, values):
    return functools.reduce(of_two, values[0] if len(values) == 1 else values)


def _length(*parts: Any) -> Any:
    """Return math.hypot(...) as the root of the sum of the squares."""
    return functions.sqrt(functools.reduce(lambda total, x: total + x * x, parts, 0.0))


_BUILTINS = {**vars(builtins), 'min': _least, 'max': _greatest}
_REPLACED: dict[Any, Any] = {
    min: _least,
    max: _greatest,
    **{getattr(math, name): function for name, function in functions.BY_NAME.items()},
    **{
        getattr(np, name): function
        for name, function in functions.BY_NAME.items()
        if hasattr(np, name)
    },
    math.pow: pow,
    np.arcsin: functions.asin,
    np.arccos: functions.acos,
    np.arctan: functions.atan,
    np.arctan2: functions.atan2,
    math.fabs: abs,
    np.abs: abs,
    np.absolute: abs,
    math.hypot: _length,
    np.hypot: _length,
    np.minimum: functions.minimum,
    np.maximum: functions.maximum,
    np.where: functions.select,
}


class _Rebound:
    """A module whose functions take symbols and columns."""

    def __init__(self, module: ModuleType, known: dict[Any, Any]):
        self._module, self._known = module, known

    def __getattr__(self, name: str) -> Any:
        return _rebound(getattr(self._module, name), self._known)


def _rebound(thing: Any, known: dict[Any, Any]) -> Any:
    """Return what takes symbols and columns in place of something that a function refers to."""
    # Of a compiled function the one that was compiled.
    thing = getattr(thing, 'py_func', thing)
    if isinstance(thing, ModuleType):
        return thing if is_of_package(thing.__name__) else _Rebound(thing, known)
    if not isinstance(thing, FunctionType):
        try:
            return _REPLACED.get(thing, thing)
        except TypeError:
            return thing
    if is_of_package(thing.__module__):
        return thing
    if thing not in known:
        namespace: dict[str, Any] = {'__builtins__': _BUILTINS, '__name__': thing.__module__}
        cells = tuple(CellType() for _ in thing.__closure__ or ())
        made = FunctionType(thing.__code__, namespace, thing.__name__, thing.__defaults__, cells)
        made.__kwdefaults__ = thing.__kwdefaults__
        known[thing] = made
        for cell, given in zip(cells, thing.__closure__ or (), strict=True):
            # A cell may be empty until the function is called.
            if _is_filled(given):
                cell.cell_contents = _rebound(given.cell_contents, known)
        for name in {name for code in codes(thing.__code__) for name in code.co_names}:
            if name in thing.__globals__:
                namespace[name] = _rebound(thing.__globals__[name], known)
    return known[thing]


def _is_filled(cell):
    try:
        return cell.cell_contents is not cell
    except ValueError:
        return False

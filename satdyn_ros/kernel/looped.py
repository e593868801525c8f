"""Functions with loops in plain Python, whose code is made at the first call, and kept."""

import ctypes
import functools
import inspect
from collections.abc import Callable
from typing import Any


def looped(function: Callable[..., int]) -> Callable[..., int]:
    """Make code of a function of integers that returns one, or a truth (trace/loops.py)."""

    @functools.cache
    def code() -> tuple[Any, Callable[..., int]]:
        # Formulas can be read, and run by Python, where there is no LLVM.
        from ..trace.load import Code
        from ..trace.loops import text_of
        from .code_folder import code_folder, other_processor

        name, whole_name = function.__name__, f'{function.__module__}.{function.__name__}'
        text = functools.partial(text_of, name, function)
        made = Code(text, code_folder(), other_processor(), whole_name)
        words: list[Any] = [ctypes.c_int64] * (1 + len(inspect.signature(function).parameters))
        # Other threads of Python wait while it runs.
        return made, ctypes.PYFUNCTYPE(*words)(made.address(name))

    @functools.wraps(function)
    def run(*numbers: int) -> int:
        return code()[1](*numbers)

    return run

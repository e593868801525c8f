"""Outcomes of one's own: columns that a function of the states adds to the table."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from ..base.imports import own_module
from ..dynamics.motion import States


class Wrong(RuntimeError):  # noqa: N818 - it says what a function is
    """A function that does not give what it must; its text is one sentence."""


@dataclass(frozen=True)
class OwnOutcome:
    """
    A function of the states (M, N) of M runs to numbers (M,).

    It is named by whoever starts a sweep, never by a file: code that is named is run.

    Attributes
    ----------
    path : str
        module:function
    sources : str
        a digest of its module's file
    """

    path: str
    sources: str

    @classmethod
    def at(cls, path: str) -> 'OwnOutcome':
        """Return the outcome of a path; ValueError, one sentence: there is no such function."""
        module, _, name = path.partition(':')
        if not (module and name.isidentifier()):
            raise ValueError(f'--outcome is {path}; it must be MODULE:FUNCTION')
        try:
            found = own_module(module)
        except ImportError as error:
            raise ValueError(f'--outcome is {path}, which cannot be imported: {error}') from None
        if not callable(getattr(found, name, None)):
            raise ValueError(f'--outcome is {path}; {module} has no function {name}')
        file = getattr(found, '__file__', None)
        return cls(path, sha256(Path(file).read_bytes()).hexdigest()[:12] if file else '')

    @property
    def name(self) -> str:
        """The name of the column."""
        return self.path.partition(':')[2]

    @property
    def meaning(self) -> str:
        """The first line of the function's docstring."""
        lines = (self._function.__doc__ or '').strip().splitlines()
        return lines[0] if lines else self.path

    def values(self, states: States) -> np.ndarray:
        """Return the numbers (M,) of M runs; Wrong: the function does not give them."""
        try:
            values = np.asarray(self._function(states), float)
        except Exception as error:
            raise Wrong(f'{self.path}: {type(error).__name__}: {error}') from error
        if values.shape != states.q_ib.shape[:1]:
            raise Wrong(
                f'{self.path} gives an array {values.shape} for states of '
                f'{states.q_ib.shape[:2]}; it must be {states.q_ib.shape[:1]}, one number per run'
            )
        return values

    @cached_property
    def _function(self) -> Callable[[States], Any]:
        module, _, name = self.path.partition(':')
        return getattr(import_module(module), name)

"""A controller in the runs of a sweep, by its path, as code is named on a command line."""

import sys
from collections.abc import Iterable
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path

from ..run.controllers import Controller, named


@dataclass(frozen=True)
class OwnController:
    """
    A class of controllers of one's own.

    Attributes
    ----------
    path : str
        MODULE:CLASS or FILE.py:CLASS
    parameters : tuple of str
        what it is called with, each NAME=VALUE
    sources : str
        a digest of its file
    """

    path: str
    parameters: tuple[str, ...]
    sources: str = ''

    @classmethod
    def at(cls, path: str, parameters: Iterable[str]) -> 'OwnController':
        """Return the controllers of a path; ValueError, one sentence: they cannot be made."""
        module, _, name = path.rpartition(':')
        if module.endswith('.py'):
            # Wherever the runs are done.
            path = f'{Path(module).resolve()}:{name}'
        controllers = cls(path, tuple(parameters))
        kind = type(controllers.new())
        file = Path(
            module if module.endswith('.py') else str(sys.modules[kind.__module__].__file__)
        )
        return replace(controllers, sources=sha256(file.read_bytes()).hexdigest()[:12])

    def new(self) -> Controller:
        """Return a controller that has seen nothing."""
        return named(self.path, self.parameters)

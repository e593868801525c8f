"""The kinds of modes; each is a file beside this one, which nothing else needs to name."""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from .inner_mode import InnerMode

for _found in iter_modules([str(Path(__file__).parent)]):
    import_module(f'{__package__}.{_found.name}')

# In the order in which the equations add them.
MODE_KINDS: tuple[type[InnerMode], ...] = tuple(
    sorted(InnerMode.__subclasses__(), key=lambda kind: kind.names.name)
)

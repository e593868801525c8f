"""Torques on the body, one in a file, and what one of your own is made of."""

from importlib import import_module
from pkgutil import iter_modules

from ..base.key import Key
from ..kernel.functions import select
from ..kernel.time_table import Table, interpolate, table_of
from .body_torque import KNOWN, BodyTorque
from .environment_torque import EnvironmentTorque

# Those of the environment that are shipped, in the order in which the equations add them; any
# other is a file here, which nothing else needs to name.
_IN_ORDER = 'magnetic', 'aerodynamic', 'solar', 'hysteresis'
for _found in (*_IN_ORDER, *(each.name for each in iter_modules(__path__))):
    import_module(f'{__name__}.{_found}')
ENVIRONMENT_TORQUES: tuple[type[EnvironmentTorque], ...] = tuple(
    kind for kind in KNOWN.values() if issubclass(kind, EnvironmentTorque)
)

__all__ = [
    'ENVIRONMENT_TORQUES',
    'BodyTorque',
    'EnvironmentTorque',
    'Key',
    'Table',
    'interpolate',
    'select',
    'table_of',
]

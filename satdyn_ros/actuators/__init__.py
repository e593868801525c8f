"""What is commanded: torques on the body, the motors of rotors, magnetorquers; a file each."""

from importlib import import_module
from pkgutil import iter_modules

from .actuator import ACTUATORS, Actuator, Command, earlier_types, is_commanding, kind_of
from .equipment import Equipment

# An actuator is a file here, which nothing else needs to name.
for _found in iter_modules(__path__):
    import_module(f'{__name__}.{_found.name}')

__all__ = [
    'ACTUATORS',
    'Actuator',
    'Command',
    'Equipment',
    'earlier_types',
    'is_commanding',
    'kind_of',
]

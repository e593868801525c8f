"""Units in which a key may be typed other than its own."""

import math
from typing import Any

from satdyn_ros.base.key import Key

# For each unit of a key another of its dimension, and how many of the first that is: NIST SP 811
# (2008), appendix B.8, and powers of ten.
OTHER: dict[str, tuple[str, float]] = {
    'kg m^2': ('g cm^2', 1e-7),
    'N m': ('mN m', 1e-3),
    'A m^2': ('mA m^2', 1e-3),
    'm': ('km', 1e3),
    'm^2': ('cm^2', 1e-4),
    'N m s': ('mN m s', 1e-3),
    'rad/s': ('rpm', math.pi / 30.0),
    '1/s': ('1/min', 1.0 / 60.0),
    'kg m': ('g cm', 1e-5),
    'm^3/s^2': ('km^3/s^2', 1e9),
    'rad': ('deg', math.pi / 180.0),
    'm/s': ('km/s', 1e3),
    'kg/m^3': ('g/cm^3', 1e3),
    '1e-22 W/m^2/Hz': ('sfu', 1.0),
    '1/s^2': ('1/min^2', 1.0 / 3600.0),
    'Hz': ('kHz', 1e3),
    'ns': ('s', 1e9),
    's/s': ('min/s', 60.0),
    's': ('min', 60.0),
    'lx': ('klx', 1e3),
    'rad/s/sqrt(Hz)': ('deg/sqrt(h)', math.pi / 180.0 / 60.0),
    'rad/s^2/sqrt(Hz)': ('deg/h/sqrt(h)', math.pi / 180.0 / 216000.0),
    'N': ('mN', 1e-3),
    'T': ('uT', 1e-6),
    'T/sqrt(s)': ('nT/sqrt(s)', 1e-9),
    'T/(A m^2)': ('uT/(A m^2)', 1e-6),
    'byte': ('MB', 1e6),
    'm^3': ('cm^3', 1e-6),
    'A/m': ('Oe', 250.0 / math.pi),
    'sqrt(kg) m': ('sqrt(g) mm', 1e-3 * math.sqrt(1e-3)),
    'sqrt(kg) m/s': ('sqrt(g) mm/s', 1e-3 * math.sqrt(1e-3)),
}


def in_another(key: Key, value: Any) -> Any:
    """Return a value of a key as a text in another unit, or in its own where that is not exact."""
    unit, factor = OTHER[key.unit]
    numbers = value if isinstance(value, tuple) else (value,)
    text = _text(key, [x / factor for x in numbers], unit)
    return text if key.checked(text) == value else _text(key, numbers, key.unit)


def _text(key, numbers, unit):
    listed = ', '.join(map(repr, numbers))
    return f'[{listed}] {unit}' if key.lengths else f'{listed} {unit}'

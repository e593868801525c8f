"""Hysteresis rods as a scenario describes them, under hysteresis.NAME.*."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ..base.key import Key
from ..base.sentences import Checks, written

ROD_NAMES = Key(
    'hysteresis.names',
    'string_array',
    (),
    '',
    'names of hysteresis rods, each described by hysteresis.NAME.axis and so on; with '
    'environment.magnetic_field they damp the motion',
    is_optional=True,
)
# Of a rod; they follow its name.
KEYS_OF_A_ROD = (
    Key(
        'axis',
        'double_array',
        (1.0, 0.0, 0.0),
        '',
        'along the rod, body axes; only its direction counts',
        lengths=(3,),
        is_direction=True,
    ),
    Key('volume', 'double', 0.0, 'm^3', 'volume of the rod, or of all along this axis', low=0.0),
    Key(
        'coercive_force',
        'double',
        0.0,
        'A/m',
        'field at which its flux is zero, for the rod as it is cut; above 0',
        low=0.0,
    ),
    Key(
        'remanence',
        'double',
        0.0,
        'T',
        'flux density without a field, of the rod as it is cut; above 0, below saturation',
        low=0.0,
    ),
    Key(
        'saturation',
        'double',
        0.0,
        'T',
        'flux density in a very large field, of the rod as it is cut',
        low=0.0,
    ),
    Key(
        'minor_slope',
        'double',
        0.0,
        '',
        'slope at a reversal of the field inside the loop, relative to that of the loop there',
        low=0.0,
        high=1.0,
    ),
    Key(
        'exponent',
        'double',
        2.0,
        '',
        'how the slope grows towards the loop',
        above=0.0,
        high=100.0,
    ),
)


class Rod(NamedTuple):
    """
    A rod; its field and flux densities are apparent values, for the rod as it is cut.

    Attributes
    ----------
    name : str
        of the rod
    axis : (3,), body axes
        unit vector
    volume : m^3
        V
    coercive_force : A/m
        Hc
    remanence : T
        Br
    saturation : T
        Bs
    minor_slope : float
        q0
    exponent : float
        p
    """

    name: str
    axis: Sequence[float]
    volume: float
    coercive_force: float
    remanence: float
    saturation: float
    minor_slope: float = 0.0
    exponent: float = 2.0


def rods_of(values: Mapping[str, Any]) -> list[Rod]:
    """Return the rods of a scenario's values."""
    return [
        Rod(name, *(values[f'hysteresis.{name}.{key.name}'] for key in KEYS_OF_A_ROD))
        for name in values['hysteresis.names']
    ]


def checks_of_rods(values: Mapping[str, Any]) -> Checks:
    """Check that the loops of rods are loops."""
    for name in values['hysteresis.names']:
        prefix = f'hysteresis.{name}'
        coercive, remanence, saturation = (
            values[f'{prefix}.{leaf}'] for leaf in ('coercive_force', 'remanence', 'saturation')
        )
        if (yield coercive == 0.0):
            raise ValueError(f'{prefix}.coercive_force is 0; it must be above 0 A/m')
        if (yield (remanence == 0.0) | (remanence >= saturation)):
            raise ValueError(
                f'{prefix}.remanence is {written(remanence)} and {prefix}.saturation '
                f'{written(saturation)}; the remanence must be above 0 and below the saturation'
            )

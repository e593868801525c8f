"""The hysteresis rods that a scenario describes, under hysteresis.NAME.*."""

from collections.abc import Mapping
from typing import Any

from ..base.sentences import Checks, written
from ..torques.hysteresis import KEYS_OF_A_ROD, Rod


def rods_of(values: Mapping[str, Any]) -> list[Rod]:
    """Return the rods of a scenario's values."""
    return [
        Rod(name, *(values[f'hysteresis.{name}.{key.name}'] for key in KEYS_OF_A_ROD))
        for name in values['hysteresis.names']
    ]


def checks(values: Mapping[str, Any]) -> Checks:
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

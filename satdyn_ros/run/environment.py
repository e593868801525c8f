"""The environment of a scenario: what acts by it, and what its values may not be together."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.sentences import Rules, written
from ..orbits import FixedDirection, KeplerOrbit, TabledOrbit
from ..orbits.kepler import EARTH_MU
from ..torques.body_torque import BodyTorque
from ..torques.magnetic import Magnetic
from .orbits import EARTH_TO

# What is left out of a text where it is not given.
OPTIONAL = ('body.dipole', 'environment.magnetic_field')


def needs_epoch(values: Mapping[str, Any]) -> str:
    """Return the key by which the scenario needs the instant of tick 0, '' if it needs none."""
    if values['orbit.type'] in ('tle', 'oem'):
        return 'orbit.type'
    return '' if values['environment.magnetic_field'] == 'none' else 'environment.magnetic_field'


def rules(values: Mapping[str, Any]) -> Rules:
    """Check that the centre is the Earth where its field is asked for."""
    model, kind, mu = (
        values[name] for name in ('environment.magnetic_field', 'orbit.type', 'orbit.mu')
    )
    if model == 'none':
        return
    if (yield kind == 'fixed'):
        raise ValueError(
            f'environment.magnetic_field is {model}; with orbit.type fixed there is no place in '
            'it, so it must be none'
        )
    if (yield abs(mu / EARTH_MU - 1.0) > EARTH_TO):
        raise ValueError(
            f'environment.magnetic_field is {model}, of the Earth, and orbit.mu {written(mu)}; it '
            f'must be within {EARTH_TO:g} of {EARTH_MU:.10g}'
        )


def acts(values: Mapping[str, Any]) -> bool:
    """Return whether any torque of the environment acts."""
    return values['environment.magnetic_field'] != 'none' and bool(np.any(values['body.dipole']))


def torques_of(
    values: Mapping[str, Any], orbit: FixedDirection | KeplerOrbit | TabledOrbit
) -> tuple[BodyTorque, ...]:
    """Return the torques of the environment on an orbit; ValueError: tick 0 has no instant."""
    if isinstance(orbit, FixedDirection) or not acts(values):
        return ()
    # It loads what is used here alone.
    from ..orbits.along_orbit import magnetic_field

    model, epoch_ns = values['environment.magnetic_field'], values['time.epoch_ns']
    field = magnetic_field(orbit, model, epoch_ns)
    return (Magnetic(values['body.dipole'], field),)

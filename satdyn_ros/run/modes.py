"""The modes of parts inside the body that a scenario describes, such as flexible.NAME.*."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.sentences import Checks, distinct_texts
from ..dynamics import inertia
from ..dynamics.inner_mode import InnerMode
from ..dynamics.mode_kinds import MODE_KINDS
from ..dynamics.system import System
from . import rotors


def modes_of(values: Mapping[str, Any]) -> tuple[InnerMode, ...]:
    """Return the modes of a scenario's values."""
    return tuple(mode for kind in MODE_KINDS for mode in kind.of(values))


def checks_of_kinds(values: Mapping[str, Any]) -> Checks:
    """Check what the values of modes may not be together, by their kinds, and their names."""
    seen: dict[str, str] = {}
    for kind in MODE_KINDS:
        key = kind.names.name
        for name in values[key]:
            # The columns of tables have only the name.
            if (yield name in seen):
                raise ValueError(
                    f'{key} has {name!r}, which is in {seen[name]} too; each mode needs a name of '
                    'its own'
                )
            seen[name] = key
        yield from kind.checks(values)


def inner(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return displacement and rate of each mode at the start, by their names."""
    # An inner coordinate has the name of its key.
    return {
        name: values[name]
        for mode in modes_of(values)
        for name in (mode.displacement_name, mode.rate_name)
    }


def checks(values: Mapping[str, Any]) -> Checks:
    """Check that modes leave the body an inertia."""
    body = System(inertia.entries(values['body.inertia']), rotors.rotors_of(values))
    left = body.carrier_inertia
    others = of_rotors = ['the rotors'] if body.has_turning_rotor else []
    for mode in modes_of(values):
        d = mode.coupling
        share = np.sum(d * np.linalg.solve(left, d[..., None])[..., 0], axis=-1)
        is_too_much = ~(share < 1.0 - inertia.ROUNDING)
        if (yield is_too_much):
            size = math.hypot(*d)
            u = d / size
            given, most = distinct_texts(size, float(1.0 / np.sqrt(u @ np.linalg.solve(left, u))))
            raise ValueError(
                f'{mode.group()}.{mode.name}.coupling is {d.tolist()}, of length {given}; in this '
                f'direction it must be below {most} sqrt(kg) m, the most that '
                f'{" and ".join(["body.inertia", *others])} allow{"" if others else "s"}'
            )
        rest = left - d[..., :, None] * d[..., None, :]
        # Among many, those that are refused keep what can be solved for.
        left = np.where(np.asarray(is_too_much)[..., None, None], left, rest)
        others = [*of_rotors, 'the modes before it']

"""Many scenarios at once, which differ in the values of some keys, and which of them are valid."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..base.key import Key
from ..dynamics import inertia
from ..dynamics.motion import States
from . import rotors
from .checks import BELONGS, MOST_RAD_PER_TICK
from .keys import keys_of
from .scenario import Scenario

# Far inside what a Scenario allows.
_SURELY_RAD_PER_TICK = MOST_RAD_PER_TICK / 10.0


def many(values: Mapping[str, Any], count: int) -> tuple[Scenario, np.ndarray]:
    """
    Return count scenarios as one of arrays, and which of them are valid beyond doubt, (count,).

    values: of every key, those that differ as arrays (count,) or (count, k).  Where there is
    doubt, Scenario itself decides, and finds the sentence.
    """
    differ = {name: x for name, x in values.items() if isinstance(x, np.ndarray)}
    # Every run has a row of its own in the state.
    differ.setdefault('initial.attitude', np.tile(values['initial.attitude'], (count, 1)))
    keys = keys_of(values['rotor.names'])
    valid = np.full(count, not any(_is_out_of_place(name, values) for name in differ))
    for name, x in differ.items():
        valid &= _is_in_range(keys[name], x)
    axes = [f'{prefix}.axis' for prefix in rotors.prefixes(values['rotor.names'])]
    with np.errstate(all='ignore'):
        for name in ('initial.attitude', *axes):
            if name in differ:
                allowed_error = 1e-6 if name == 'initial.attitude' else np.inf
                differ[name], norm = _unit(differ[name])
                valid &= (norm > 0.0) & np.isfinite(norm) & (abs(norm - 1.0) <= allowed_error)
        scenario = Scenario.of_many({**values, **{k: x[:, None] for k, x in differ.items()}})
        if valid.any():
            valid &= _turns_slowly(scenario) & _has_a_body(scenario, differ)
    return scenario, valid


def _is_out_of_place(name, values):
    if values['rotor.names'] and name in rotors.OF_THE_ONE:
        return True
    belongs = (*BELONGS, *rotors.belongs(values['rotor.names']))
    return any(name == key and values[chooser] not in choices for key, chooser, choices in belongs)


def _is_in_range(key: Key, x):
    within = np.isfinite(x) & (x >= key.low) & (x <= key.high) & (x > key.above) & (x < key.below)
    return within if x.ndim == 1 else within.all(axis=-1) & (x.shape[-1] in key.lengths)


def _unit(vectors):
    """Return vectors (M, k) as units, those that are units to rounding as they are, and norms."""
    norm = np.linalg.norm(vectors, axis=-1)
    is_unit = np.abs(norm - 1.0) < 4.0 * np.finfo(float).eps
    return np.where(is_unit[:, None], vectors, vectors / norm[:, None]), norm


def _turns_slowly(scenario):
    tick_s = float(1 / scenario.rate)
    fastest = np.linalg.norm(scenario['initial.angular_velocity'], axis=-1)
    if not scenario.is_fixed:
        e = scenario['orbit.eccentricity']
        mean_motion = np.sqrt(scenario['orbit.mu'] / scenario['orbit.semi_major_axis'] ** 3)
        fastest = fastest + mean_motion * np.sqrt((1.0 + e) / (1.0 - e)) / (1.0 - e)
    return np.ravel(fastest * tick_s <= _SURELY_RAD_PER_TICK)


def _has_a_body(scenario, differ):
    """Return whether the inertias are those of bodies whose rotors leave some, none too fast."""
    moments, system = scenario['body.inertia'], scenario.system
    valid = np.array(True)
    if 'body.inertia' in differ:
        valid = inertia.is_that_of_a_body(system.inertia)
        if moments.shape[-1] == 9:
            rows = np.reshape(moments, system.inertia.shape)
            valid = valid & np.all(rows == system.inertia, axis=(-1, -2))
    left = system.inertia
    for prefix, rotor in zip(rotors.prefixes(scenario['rotor.names']), system.rotors, strict=True):
        if not rotor.turns_freely:
            continue
        axis, J = rotor.axis, np.asarray(rotor.inertia)
        compliance = np.sum(axis * np.linalg.solve(left, axis[..., None])[..., 0], -1)
        speed, limit = np.abs(scenario[f'{prefix}.speed']), rotor.max_speed
        valid = valid & (J > 0.0) & (J * compliance < 1.0 - 1e-9)
        valid = valid & ((speed <= limit) | np.equal(limit, 0.0))
        rest = left - J[..., None, None] * axis[..., :, None] * axis[..., None, :]
        # What is not valid any more must not be singular for those that are.
        left = np.where(valid[..., None, None], rest, left)
    return np.ravel(valid)


def part_of(many_things: Any, rows: slice | None) -> Any:
    """
    Return some rows of a system, orbit or table of states of many; None: one becomes many of one.

    What all of them share stays as it is.
    """
    if isinstance(many_things, States):
        tables = {
            name: getattr(many_things, name)[rows]
            for name in ('q_ib', 'omega_bi_b', 'rotor_speed', 'rotor_angle', 'work')
        }
        return replace(many_things, **tables, orbit=part_of(many_things.orbit, rows))
    if is_dataclass(many_things) and not isinstance(many_things, type) and rows is not None:
        parts = {f.name: getattr(many_things, f.name) for f in fields(many_things)}
        chosen = {name: part_of(part, rows) for name, part in parts.items()}
        differ = any(chosen[name] is not part for name, part in parts.items())
        return replace(many_things, **chosen) if differ else many_things
    if isinstance(many_things, tuple) and rows is not None:
        some = tuple(part_of(part, rows) for part in many_things)
        same = all(a is b for a, b in zip(some, many_things, strict=True))
        return many_things if same else some
    if isinstance(many_things, np.ndarray) and rows is not None:
        return many_things[rows] if many_things.shape[1:2] == (1,) else many_things
    return many_things

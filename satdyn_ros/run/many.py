"""Many scenarios at once, which differ in the values of some keys, and which of them are valid."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..dynamics.motion import States
from . import checks
from .keys import NAMES_OF_EACH, keys_of
from .scenario import Scenario


def many(values: Mapping[str, Any], count: int) -> tuple[Scenario, np.ndarray]:
    """
    Return the valid ones of count scenarios as one of arrays, and which those are, (count,).

    values: of every key, those that differ as arrays (count,) or (count, k); what they have in
    common is allowed key by key.
    """
    # Every run has a row of its own in the state.
    attitude = np.array(np.broadcast_to(values['initial.attitude'], (count, 4)))
    together = {
        name: x[:, None] if isinstance(x, np.ndarray) else x
        for name, x in {**values, 'initial.attitude': attitude}.items()
    }
    rows = np.arange(count)
    with np.errstate(all='ignore'):
        together, rows = _allowed([_within, checks.units], together, rows)
        together, rows = _allowed(checks.ALL_CHECKS, together | checks.as_units(together), rows)
    return Scenario.of_many(together), np.isin(np.arange(count), rows)


def _allowed(all_checks, values, rows):
    """Return of values, and of the rows that they are, those that pass all checks."""
    for check in all_checks:
        sound = np.ones((len(rows), 1), bool)
        for fails in check(values):
            sound &= np.logical_not(fails)
        # As with one, a check is asked only of what those before it allow.
        if not sound.all():
            kept, rows = sound[:, 0], rows[sound[:, 0]]
            values = {k: x[kept] if isinstance(x, np.ndarray) else x for k, x in values.items()}
    return values, rows


def _within(values):
    """Check arrays as their keys check one value."""
    keys = keys_of({name: values[name] for name in NAMES_OF_EACH})
    for name, x in values.items():
        if isinstance(x, np.ndarray):
            lengths, within = keys[name].lengths, keys[name].is_within(x)
            yield ~(within.all(axis=-1) & (x.shape[-1] in lengths) if lengths else within)


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
        tables['inner'] = {name: values[rows] for name, values in many_things.inner.items()}
        return replace(many_things, **tables, orbit=part_of(many_things.orbit, rows))
    if isinstance(many_things, dict):
        return {name: part_of(part, rows) for name, part in many_things.items()}
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

"""A request before it acts: what it may change, and whether a motion can start from it."""

from collections.abc import Mapping
from typing import Any

from ..base.key import listed
from ..base.sentences import nearest
from ..dynamics.motion import Halted, TableEnded
from ..integrate.propagation import Propagation
from . import in_place
from .scenario import Scenario
from .segment import MOST_STEPS_A_TICK, NO_STAMP
from .ticks import Ticks

# A request is tried for this many ticks, or steps in all.
_TRIED_TICKS, _TRIED_STEPS = 100, 10**6


def requested(conditions: Scenario, values: Mapping[str, Any], at_s: float = 0.0) -> Scenario:
    """
    Return the conditions with what a request gives; ValueError: it is not allowed.

    at_s: when it acts, from tick 0.
    """
    allowed = conditions.initial_conditions
    foreign = [name for name in values if name not in allowed]
    if foreign:
        name, hint = foreign[0], ''
        if name not in conditions.keys:
            hint = f'; the nearest that can is {nearest(name, allowed)}'
        raise ValueError(f'{name} cannot be requested{hint}; allowed: {", ".join(allowed)}')
    return conditions.with_values(values, at_s)


def resolved(values: Mapping[str, Any], changed: Scenario) -> dict[str, Any]:
    """
    Return what a request gives as numbers in the units of the keys.

    changed: the conditions with it, whose attitude takes the place of what stands for it.
    """
    keys = changed.keys
    found = {
        name: keys[name].plain(x) for name, x in values.items() if name not in in_place.OF_ATTITUDE
    }
    if len(found) < len(values):
        found['initial.attitude'] = listed(changed['initial.attitude'])
    return found


def try_out(conditions: Scenario, tick: int, last_tick: int | None = None) -> None:
    """
    Raise ValueError unless a motion can start from the initial conditions at a tick.

    Tried are the ticks that follow, up to the last of the run if it is known, or fewer where these
    take many steps or a table of what depends on time ends; no torque acts.
    """
    ticks = Ticks(conditions.rate, conditions.epoch_ns)
    if tick > ticks.last:
        raise ValueError(NO_STAMP)
    start_s = ticks.seconds(tick)
    motion = conditions.motion_from(
        conditions.system, conditions.state_at(start_s), start_s, MOST_STEPS_A_TICK
    )
    last_tick = ticks.last if last_tick is None else min(last_tick, ticks.last)
    tried = min(_TRIED_TICKS, last_tick - tick)
    try:
        for t_s in ticks.seconds_between(0, 0, tried + 1):
            motion.at(t_s)
            if isinstance(motion, Propagation) and motion.steps > _TRIED_STEPS:
                break
    except TableEnded:
        return
    except Halted as halted:
        raise ValueError(f'no motion can start from these values: {halted}') from None

"""The table of a sweep file's keys: the values allowed, the default and the meaning of each."""

from typing import Any

from ..base.key import Key
from .capture import AXES, LEAST

# Checked by plan.py, not by their kind; the values allowed, in words.
SPECIAL = {
    'vary': 'names of quantities, each with how it varies',
    'bags': 'a list of runs, integers from 0',
    'controller_parameters': 'names of parameters, each with its value',
}

SWEEP_KEYS = {
    key.name: key
    for key in (
        Key('scenario', 'string', None, '', 'path of the scenario, relative to the sweep file'),
        Key('vary', 'mapping', None, '', 'what varies, and how; see below'),
        Key('duration_s', 'double', None, 's', 'duration of each run', above=0.0),
        Key(
            'interval_s',
            'double',
            60.0,
            's',
            'time between the samples from which the extremes are found, at most duration_s',
            above=0.0,
        ),
        Key(
            'runs',
            'integer',
            1,
            '',
            'how often each combination of the grids is run, with its own draws',
            low=1,
            high=10**9,
        ),
        Key('seed', 'integer', 0, '', 'seed of the draws', low=0, high=2**63 - 1),
        Key('samples', 'bool', False, '', 'keep the attitudes and rates at the samples'),
        Key(
            'captured_axis',
            'string',
            LEAST,
            '',
            'the body axis whose crossing of the horizontal ends a capture; least: that of least '
            'inertia',
            choices=(LEAST, *AXES),
        ),
        Key(
            'controller',
            'string',
            '',
            '',
            'a controller in each run: MODULE:CLASS, or FILE.py:CLASS relative to the sweep file',
        ),
        Key('controller_parameters', 'mapping', {}, '', 'keyword arguments of that class'),
        Key('bags', 'list', (), '', 'the runs that also record a bag'),
    )
}
REQUIRED = tuple(name for name, key in SWEEP_KEYS.items() if key.default is None)


def checked(given: dict[str, Any], name: str) -> Any:
    """Return what a sweep file has under a name, or its default; ValueError: not allowed."""
    return SWEEP_KEYS[name].checked(given.get(name, SWEEP_KEYS[name].default))

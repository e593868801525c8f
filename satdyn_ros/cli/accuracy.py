"""`satdyn check FILE --duration S`: how the error of a run grows."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..dynamics.motion import Motion
from ..exact import recognise
from ..integrate.propagation import Propagation
from ..kernel import rotation
from ..run.scenario import Scenario

FINER = 0.01
# Below this a step's error is rounding, whatever the tolerance.
_LEAST = 1e-15
_ROWS = 2001
_SHOWN = 10


@dataclass(frozen=True)
class Growth:
    """
    How far the attitude of a propagation is from the same motion computed more accurately.

    Attributes
    ----------
    tolerance : float
        the scenario's
    t_s : (N,), s
        from the start
    angle_rad : dict of (N,), rad
        for each comparison, the largest angle so far
    steps : int
        the number of steps
    """

    tolerance: float
    t_s: np.ndarray
    angle_rad: Mapping[str, np.ndarray]
    steps: int


def growth(scenario: Scenario, duration_s: float) -> Growth:
    """
    Run a scenario with its own tolerance, a hundredth of it, and in closed form if there is one.

    RuntimeError: a propagation comes to a halt.
    """
    system, state, tolerance = (
        scenario.system,
        scenario.initial_state,
        scenario['motion.tolerance'],
    )
    t_s = np.linspace(0.0, duration_s, _ROWS)
    own = Propagation(system, state, tolerance=tolerance)
    states = own.at(t_s)
    finer = max(FINER * tolerance, _LEAST)
    better: dict[str, Motion] = {
        f'tolerance {finer:.0e}': Propagation(system, state, tolerance=finer)
    }
    closed = recognise(system, state)
    if closed is not None:
        better[f'closed form: {closed.name}'] = closed
    angles = {
        name: np.maximum.accumulate(rotation.angle_between(states.q_ib, motion.at(t_s).q_ib))
        for name, motion in better.items()
    }
    return Growth(tolerance, t_s, angles, own.steps)


def check_run(scenario: Scenario, name: str, duration: str, output: str | None = None) -> None:
    """Print how the error of a scenario's run grows, and draw it where an output is given."""
    duration_s = seconds(duration)
    found = growth(scenario, duration_s)
    print(f'{name}: the attitude at motion.tolerance {found.tolerance:g}, {found.steps} steps,')
    print('its largest angle [rad] so far to the same motion in')
    names = list(found.angle_rad)
    print(f'{"time [s]":>14}  ' + '  '.join(f'{name:>28}' for name in names))
    for row in np.linspace(0, _ROWS - 1, _SHOWN + 1).astype(int)[1:]:
        angles = '  '.join(f'{found.angle_rad[name][row]:28.1e}' for name in names)
        print(f'{found.t_s[row]:14.6g}  {angles}')
    for name in names:
        print(f'after {duration_s:g} s: {found.angle_rad[name][-1]:.1e} rad to {name}')
    if output is not None:
        draw(found, output)
        print(output)


def seconds(duration: str) -> float:
    """Return the seconds of an argument; ValueError: not a number above 0."""
    try:
        given = float(duration)
    except ValueError:
        given = 0.0
    if not 0.0 < given < np.inf:
        raise ValueError(f'--duration is {duration}; it must be a number above 0 s')
    return given


def draw(found: Growth, output: str | Path) -> None:
    """Draw how the error grows, both axes logarithmic; ValueError: unknown image format."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.2), layout='constrained')
    axes = figure.add_subplot()
    for name, angle in found.angle_rad.items():
        axes.loglog(found.t_s[1:], angle[1:], label=f'to {name}')
    axes.set(xlabel='time [s]', ylabel='largest angle so far [rad]')
    axes.set_title(f'Error at motion.tolerance {found.tolerance:g}')
    axes.grid(alpha=0.3)
    axes.legend()
    try:
        figure.savefig(output, dpi=150)
    except ValueError as error:
        raise ValueError(f'{output} cannot be drawn: {error}') from None

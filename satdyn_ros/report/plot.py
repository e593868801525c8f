"""One figure of a bag that a user would put in a report."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..bag.read_run import RecordedRun
from . import panels
from .curves import topics_with_panels
from .ground_track import ground_track, utc_axis
from .history import History, history
from .place import GEODETIC, place_topics

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SQUARE = ('polhode', 'phase')
PANELS = (*panels.TIME_PANELS, *_SQUARE)


def plot(
    bag: str | Path,
    output: str | Path,
    what: Sequence[str] = (),
    begin_s: float | None = None,
    end_s: float | None = None,
    unwrap: bool = False,
) -> None:
    """
    Draw the chosen panels of a bag into an image; the suffix of its name selects the format.

    what: without any: attitude, rates, torques, drift, those of the run's sensors, and the map
    where geodetic is published.  begin_s, end_s: only the ticks between these times [s from tick
    0].  unwrap: roll, pitch and yaw go on past half a turn.

    ValueError: a panel is unknown or the run has none, the bag was not written by satdyn_ros
    or has no such ticks, or matplotlib does not write such images.  ImportError: there is none.
    """
    allowed = PANELS
    if unknown := [name for name in what if name not in allowed]:
        scenario = RecordedRun(bag).scenario
        topics = [*topics_with_panels(scenario), *place_topics(scenario)]
        allowed += (*(topic.name for topic in topics), *scenario.sensors)
        unknown = [name for name in unknown if name not in allowed]
    if unknown:
        raise ValueError(f'the panel is {unknown[0]}; allowed: {", ".join(allowed)}')
    figure = draw(history(bag, begin_s=begin_s, end_s=end_s), what, unwrap)
    try:
        figure.savefig(output, dpi=150)
    except ValueError as error:
        raise ValueError(f'{output} cannot be drawn: {error}') from None


def draw(run: History, what: Sequence[str] = (), unwrap: bool = False) -> 'Figure':
    """Return the matplotlib figure of a history's panels, those over time on one time axis."""
    from matplotlib.figure import Figure

    places = [name for name in run.shown if name == GEODETIC]
    what = what or ('attitude', 'rates', *run.panels, 'drift', *run.sensors, *places)
    over_time = [name for name in what if name not in (*_SQUARE, GEODETIC)]
    square = [name for name in what if name in _SQUARE]
    maps = [name for name in what if name == GEODETIC]
    height = 1.9 * len(over_time) + 5.5 * len(square) + 4.6 * len(maps) + 0.4
    figure = Figure(figsize=(8.0, height))
    figure.set_layout_engine('constrained')
    ratios = [1.0] * len(over_time) + [2.8] * len(square) + [2.4] * len(maps)
    grid = figure.add_gridspec(len(ratios), 1, height_ratios=ratios)
    first = None
    for row, name in enumerate(over_time):
        first = axes = figure.add_subplot(grid[row], sharex=first)
        if unwrap and name == 'attitude':
            panels.unwrapped_attitude(axes, run)
        elif name in run.panels:
            panels.shown(axes, run, name)
        elif name in run.sensors:
            panels.sensor(axes, run, name)
        else:
            panels.TIME_PANELS[name](axes, run)
        panels.events(axes, run)
        axes.grid(alpha=0.3)
        axes.margins(x=0.0)
        if name != over_time[-1]:
            axes.tick_params(labelbottom=False)
        else:
            unit_s, unit = panels.time_unit(run)
            axes.set_xlabel(f'time from tick 0 [{unit}]')
            if places:
                utc_axis(axes, run, unit_s)
    for row, name in enumerate([*square, *maps], start=len(over_time)):
        if name == 'polhode':
            panels.polhode(figure.add_subplot(grid[row], projection='3d'), run)
        else:
            axes = figure.add_subplot(grid[row])
            draws = ground_track if name == GEODETIC else panels.phase
            draws(axes, run)
            axes.grid(alpha=0.3)
    return figure

"""One figure of a bag, or of several side by side, that a user would put in a report."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from ..bag.read_run import RecordedRun
from . import panels
from .curves import topics_with_panels
from .earth_map import GEODETIC, geodetic_topics
from .ground_track import ground_track, utc_axis
from .history import History, history
from .hysteresis_loops import loops

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DRAWN = {'phase': panels.phase, 'loops': loops, GEODETIC: ground_track}
_SQUARE = ('polhode', 'phase', 'loops')
PANELS = (*panels.TIME_PANELS, *_SQUARE)
# The panel of the angle to another tool's attitude, which no --what names.
_AGAINST = '--against'
_WIDTH = 8.0


def plot(
    bag: str | Path | Sequence[str | Path],
    output: str | Path,
    what: Sequence[str] = (),
    begin_s: float | None = None,
    end_s: float | None = None,
    unwrap: bool = False,
    against: str | Path | None = None,
) -> None:
    """
    Draw the chosen panels of a bag into an image.

    Parameters
    ----------
    bag : str, Path or a sequence of these
        of several, each has a column, scaled as the others
    output : str or Path
        the image; the suffix of its name selects the format
    what : sequence of str
        the panels; none: attitude, rates, torques, drift, those of the run's sensors, and the map
        where geodetic is published
    begin_s, end_s : s or None
        only the ticks between these times from tick 0
    unwrap : bool
        whether roll, pitch and yaw go on past half a turn
    against : str, Path or None
        an AEM, to whose attitudes the angle is drawn too

    Raises
    ------
    ValueError
        a panel is unknown or the run has none, the bag was not written by satdyn_ros or has no
        such ticks, or none at which `against` has an attitude, or matplotlib does not write such
        images
    ImportError
        there is no matplotlib
    """
    bags = [bag] if isinstance(bag, str | Path) else list(bag)
    for each in bags:
        _check(each, what)
    runs = [history(each, begin_s=begin_s, end_s=end_s) for each in bags]
    if len(bags) == 1:
        figure = draw(runs[0], what, unwrap, against)
    else:
        figure = draw_beside(list(map(str, bags)), runs, what, unwrap, against)
    try:
        figure.savefig(output, dpi=150)
    except ValueError as error:
        raise ValueError(f'{output} cannot be drawn: {error}') from None


def _check(bag, what):
    """ValueError: a panel is unknown."""
    allowed = PANELS
    if unknown := [name for name in what if name not in allowed]:
        scenario = RecordedRun(bag).scenario
        topics = [*topics_with_panels(scenario), *geodetic_topics(scenario)]
        allowed += (*(topic.name for topic in topics), *scenario.sensors)
        unknown = [name for name in unknown if name not in allowed]
    if unknown:
        raise ValueError(f'the panel is {unknown[0]}; allowed: {", ".join(allowed)}')


class _Layout:
    """The panels of a history by their kind, and how high they are together."""

    def __init__(self, run: History, what: Sequence[str], against: str | Path | None):
        self.maps = [name for name in run.shown if name == GEODETIC]
        what = what or ('attitude', 'rates', *run.panels, 'drift', *run.sensors, *self.maps)
        self.has_utc = bool(self.maps)
        self.over_time = [name for name in what if name not in (*_SQUARE, GEODETIC)]
        self.over_time += [_AGAINST] if against else []
        self.square = [name for name in what if name in _SQUARE]
        self.maps = [name for name in what if name == GEODETIC]
        over_time, square, maps = len(self.over_time), len(self.square), len(self.maps)
        self.height = 1.9 * over_time + 5.5 * square + 4.6 * maps + 0.4
        self.ratios = [1.0] * over_time + [2.8] * square + [2.4] * maps


def draw(
    run: History,
    what: Sequence[str] = (),
    unwrap: bool = False,
    against: str | Path | None = None,
) -> 'Figure':
    """Return the matplotlib figure of a history's panels, those over time on one time axis."""
    from matplotlib.figure import Figure

    layout = _Layout(run, what, against)
    figure = Figure(figsize=(_WIDTH, layout.height))
    figure.set_layout_engine('constrained')
    _fill(figure, run, layout, unwrap, against)
    return figure


def draw_beside(
    names: Sequence[str],
    runs: Sequence[History],
    what: Sequence[str] = (),
    unwrap: bool = False,
    against: str | Path | None = None,
) -> 'Figure':
    """Return the figure of several histories, each a column below its name."""
    from matplotlib.figure import Figure

    layouts = [_Layout(run, what, against) for run in runs]
    height = max(layout.height for layout in layouts) + 0.4
    figure = Figure(figsize=(_WIDTH * len(runs), height))
    figure.set_layout_engine('constrained')
    columns = figure.subfigures(1, len(runs), squeeze=False)[0]
    drawn = []
    for part, name, run, layout in zip(columns, names, runs, layouts, strict=True):
        part.suptitle(name, fontsize=10)
        drawn.append(_fill(part, run, layout, unwrap, against))
    _scale_alike(drawn)
    return figure


def _scale_alike(drawn):
    """Give one ordinate to the panels of several bags that show the same in the same unit."""
    alike = defaultdict(list)
    for axes in chain(*drawn):
        alike[axes.get_ylabel(), axes.get_yscale()].append(axes)
    for group in alike.values():
        lowest, highest = zip(*(axes.get_ylim() for axes in group), strict=True)
        for axes in group:
            axes.set_ylim(min(lowest), max(highest))


def _fill(figure, run, layout, unwrap, against):
    """Draw the panels of a layout into a figure, or a part of one; return those over time."""
    grid = figure.add_gridspec(len(layout.ratios), 1, height_ratios=layout.ratios)
    first = None
    drawn = []
    for row, name in enumerate(layout.over_time):
        first = axes = figure.add_subplot(grid[row], sharex=first)
        drawn.append(axes)
        if name == _AGAINST:
            panels.against(axes, run, against)
        elif unwrap and name == 'attitude':
            panels.unwrapped_attitude(axes, run)
        elif name in run.panels and name in panels.TIME_PANELS:
            panels.TIME_PANELS[name](axes, run)
        elif name in run.panels:
            panels.shown(axes, run, name)
        elif name in run.sensors:
            panels.sensor(axes, run, name)
        else:
            panels.TIME_PANELS[name](axes, run)
        panels.events(axes, run)
        axes.grid(alpha=0.3)
        axes.margins(x=0.0)
        if row < len(layout.over_time) - 1:
            axes.tick_params(labelbottom=False)
        else:
            unit_s, unit = panels.time_unit(run)
            axes.set_xlabel(f'time from tick 0 [{unit}]')
            if layout.has_utc:
                utc_axis(axes, run, unit_s)
    for row, name in enumerate([*layout.square, *layout.maps], start=len(layout.over_time)):
        if name == 'polhode':
            panels.polhode(figure.add_subplot(grid[row], projection='3d'), run)
        else:
            axes = figure.add_subplot(grid[row])
            _DRAWN[name](axes, run)
            axes.grid(alpha=0.3)
    return drawn

"""The ground track on a map, and UTC along an axis of time (matplotlib)."""

from typing import TYPE_CHECKING

import numpy as np

from ..base.nanoseconds import DAY_NS, SECOND_NS
from .earth_map import GEODETIC, coast_lines
from .history import History

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def ground_track(axes: 'Axes', history: History) -> None:
    """
    Draw the track of the body on a map, dashed where it is in the umbra.

    What is in the umbra is known where the topic sunlight is among what is shown.
    """
    from matplotlib.collections import LineCollection

    position, sunlight = history.shown[GEODETIC], history.shown.get('sunlight')
    points = position[:, 1::-1]
    is_dark = np.zeros(len(points), bool) if sunlight is None else sunlight[:, 0] == 0.0
    axes.add_collection(LineCollection([*coast_lines()], colors='0.55', linewidths=0.6))
    track, rows = _track(points)
    # Where the umbra begins or ends the lines meet.
    dark = is_dark[rows] | np.append(is_dark[rows[1:]], False)
    in_light = 'track' if sunlight is None else 'in sunlight'
    for hidden, style, label in ((dark, '-', in_light), (~is_dark[rows], '--', 'in the umbra')):
        if not np.all(hidden):
            line = np.where(hidden[:, None], np.nan, track)
            axes.plot(*line.T, style, color='#D55E00', lw=1.4, label=label)
    for row, mark, name in ((0, 'o', 'from'), (-1, 's', 'to')):
        when = np.datetime64(_utc_ns(history, history.t_s[row]), 'ns').astype('datetime64[ms]')
        label = f'{name} {str(when).replace("T", " ").removesuffix(".000")} UTC'
        axes.plot(*points[row], mark, color='0.15', mfc='w', ms=6, ls='none', label=label)
    axes.set(
        xlim=(-180.0, 180.0),
        ylim=(-90.0, 90.0),
        xticks=range(-180, 181, 60),
        yticks=range(-90, 91, 30),
        xlabel='longitude [deg]',
        ylabel='latitude [deg]',
        aspect='equal',
    )
    axes.legend(loc='lower center', bbox_to_anchor=(0.5, 1.0), ncols=4, fontsize=8, frameon=False)


def _track(points):
    """
    Return the track (M, 2) through points (N, 2) [deg], and the row (M,) of each of its points.

    Where it leaves the map on one side it comes in on the other, after a point of nan.
    """
    longitude = np.unwrap(points[:, 0], period=360.0)
    worlds = np.rint(longitude / 360.0)
    parts, rows = [], []
    for world in np.unique(worlds):
        inside = worlds == world
        # With the points before and after, which are off the map.
        drawn = inside | np.append(inside[1:], False) | np.append(False, inside[:-1])
        chosen = np.flatnonzero(drawn)
        line = np.column_stack([longitude[chosen] - 360.0 * world, points[chosen, 1]])
        gaps = np.flatnonzero(np.diff(chosen, prepend=-2) > 1)
        parts.append(np.insert(line, gaps, np.nan, axis=0))
        rows.append(np.insert(chosen, gaps, chosen[gaps]))
    return np.concatenate(parts), np.concatenate(rows)


def utc_axis(axes: 'Axes', history: History, unit_s: float) -> None:
    """Write UTC below axes over time, whose unit has unit_s seconds."""
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

    begin_d, unit_d = _utc_ns(history, 0.0) / DAY_NS, unit_s / 86400.0
    functions = (
        lambda t: begin_d + unit_d * np.asarray(t),
        lambda days: (np.asarray(days) - begin_d) / unit_d,
    )
    below = axes.secondary_xaxis(-0.38, functions=functions)
    locator = AutoDateLocator()
    below.xaxis.set_major_locator(locator)
    below.xaxis.set_major_formatter(ConciseDateFormatter(locator))
    below.set_xlabel('UTC')


def _utc_ns(history, t_s):
    return history.scenario.epoch_ns + round(t_s * SECOND_NS)

"""Plots the results of a sweep: a map of a grid of two numbers, else histograms."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..base.regular_file import regular_file
from .maps import edges, grid

TABLE = 'table.parquet'
# In the metadata of a column that a function of one's own gave.
_OWN = b'outcome'
_CAPTURE = 'captured'
_MAPPED = (_CAPTURE, 'nadir_angle_max_rad', 'lvlh_angle_max_rad')
_COUNTED = ('rate_max_rad_s', 'nadir_angle_max_rad', 'capture_s')
# Numbers that are the same but for this would be one bar of a histogram.
_ROUNDING = 1e-9
_CAPTURED, _TUMBLING, _GREY, _ALL = '#0072B2', '#E69F00', '#999999', '#56B4E9'


def plot_sweep(directory: str | Path, output: str | Path, what: Sequence[str] = ()) -> None:
    """
    Draw columns of a sweep's table into an image.

    Parameters
    ----------
    directory : str or Path
        of the sweep
    output : str or Path
        the image; the suffix of its name selects the format
    what : sequence of str
        columns with numbers; none: those of angles, rates and capture that have values, and
        outcomes of one's own

    Raises
    ------
    ValueError
        the sweep is not finished, or has no such column, or no such images are written
    """
    table = Path(directory) / TABLE
    if not table.exists():
        raise ValueError(f'{directory} has no {TABLE}: its sweep has not finished')
    figure = draw_sweep(table, what)
    try:
        figure.savefig(output, dpi=150)
    except ValueError as error:
        raise ValueError(f'{output} cannot be drawn: {error}') from None


def draw_sweep(table: str | Path, what: Sequence[str] = ()) -> Figure:
    """Return the figure of a sweep's table; ValueError: a column that cannot be drawn."""
    columns = _columns(table)
    numbers = [name for name in columns.column_names if _is_number(columns, name)]
    unknown = [name for name in what if name not in numbers]
    if unknown:
        raise ValueError(f'the column is {unknown[0]}; allowed: {", ".join(numbers)}')
    axes_names = _grid_axes(columns, numbers)
    usual = _MAPPED if axes_names else _COUNTED
    own = [field.name for field in columns.schema if _OWN in (field.metadata or {})]
    chosen = what or [name for name in (*usual, *own) if name in numbers]
    if not chosen:
        raise ValueError(f'{table} has none of the columns {", ".join(usual)}; name others')
    figure = Figure(figsize=(4.6 * len(chosen), 4.0), layout='constrained')
    for k, name in enumerate(chosen):
        axes = figure.add_subplot(1, len(chosen), k + 1)
        if axes_names:
            x, y = axes_names
            xs, ys, values = grid(table, x, y, name)
            mesh = axes.pcolormesh(edges(xs), edges(ys), values, cmap='viridis')
            figure.colorbar(mesh, ax=axes, label=name)
            axes.set(xlabel=x, ylabel=y)
        else:
            _histogram(axes, columns, name)
    return figure


def _columns(table: str | Path) -> pa.Table:
    """Return a table, perhaps written again by another program; ValueError: it is not one."""
    try:
        return pq.read_table(regular_file(table))
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f'{table} cannot be read: {error}') from None


def _is_number(columns, name):
    kind = columns[name].type
    is_number = (
        pa.types.is_floating(kind) or pa.types.is_boolean(kind) or pa.types.is_integer(kind)
    )
    return name != 'run' and is_number and bool(np.isfinite(_numbers(columns, name)).any())


def _numbers(columns, name):
    return columns[name].cast(pa.float64(), safe=False).to_numpy()


def _grid_axes(columns, numbers):
    """Return the names of the two numbers whose every combination is a row, or None."""
    # What varies has the dotted name of a key; no result has.
    varied = [name for name in columns.column_names if '.' in name]
    if len(varied) != 2 or not set(varied) <= set(numbers):
        return None
    values = [_numbers(columns, name) for name in varied]
    if not np.isfinite(values).all():
        return None
    counts = [len(np.unique(each)) for each in values]
    return varied if min(counts) > 1 and np.prod(counts) == len(columns) else None


def _histogram(axes: Axes, columns: pa.Table, name: str) -> None:
    """Draw how a column is distributed, the captured runs apart where any run was judged."""
    values = _numbers(columns, name)
    judged = np.full(len(values), np.nan)
    if _CAPTURE in columns.column_names and _is_number(columns, _CAPTURE):
        judged = _numbers(columns, _CAPTURE)
    parts = {
        'captured': (_CAPTURED, judged == 1.0),
        'not captured': (_TUMBLING, judged == 0.0),
        'not judged': (_GREY, ~np.isin(judged, (0.0, 1.0))),
    }
    is_judged = bool(np.isfinite(judged).any())
    if not is_judged:
        parts = {'runs': (_ALL, np.full(len(values), True))}
    found = {
        label: (values[rows][np.isfinite(values[rows])], colour)
        for label, (colour, rows) in parts.items()
    }
    drawn = {label: part for label, part in found.items() if len(part[0])}
    axes.set(xlabel=name, ylabel='runs')
    every = np.concatenate([part for part, _ in drawn.values()])
    if np.ptp(every) <= _ROUNDING * np.abs(every).max():
        counts = ', '.join(f'{len(part)} {label}' for label, (part, _) in drawn.items())
        says = f'{every[0]:.9g}\nin all {len(every)} runs' + f'\n({counts})' * is_judged
        axes.text(0.5, 0.5, says, ha='center', va='center', transform=axes.transAxes)
        axes.set(xticks=[], yticks=[])
        return
    axes.hist(
        [part for part, _ in drawn.values()],
        bins=40,
        stacked=True,
        color=[colour for _, colour in drawn.values()],
        label=list(drawn),
    )
    axes.locator_params(axis='x', nbins=5)
    if is_judged:
        axes.legend(fontsize=8)

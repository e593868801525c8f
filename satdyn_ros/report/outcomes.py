"""Plots the results of a sweep: a map of a grid of two numbers, else histograms."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .maps import edges, grid

TABLE = 'table.parquet'
_MAPPED = ('captured', 'nadir_angle_max_rad', 'lvlh_angle_max_rad')
_COUNTED = ('rate_max_rad_s', 'nadir_angle_max_rad', 'capture_s')
_CAPTURED, _TUMBLING, _GREY = '#0072B2', '#E69F00', '#999999'


def plot_sweep(directory: str | Path, output: str | Path, what: Sequence[str] = ()) -> None:
    """
    Draw columns of a sweep's table into an image; the suffix of its name selects the format.

    what: columns with numbers; none: those of angles, rates and capture that have values.
    ValueError: the sweep is not finished, or has no such column, or no such images are written.
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
    columns = pq.read_table(table)
    numbers = [name for name in columns.column_names if _is_number(columns, name)]
    unknown = [name for name in what if name not in numbers]
    if unknown:
        raise ValueError(f'the column is {unknown[0]}; allowed: {", ".join(numbers)}')
    axes_names = _grid_axes(columns, numbers)
    usual = _MAPPED if axes_names else _COUNTED
    chosen = what or [name for name in usual if name in numbers]
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


def _is_number(columns, name):
    column = columns[name]
    is_number = pa.types.is_floating(column.type) or pa.types.is_boolean(column.type)
    return is_number and column.null_count < len(column)


def _grid_axes(columns, numbers):
    """Return the names of the two numbers whose every combination is a row, or None."""
    varied = [f.name for f in columns.schema if f.metadata[b'description'].startswith(b'varied')]
    if len(varied) != 2 or not set(varied) <= set(numbers):
        return None
    counts = [len(columns[name].unique()) for name in varied]
    return varied if min(counts) > 1 and np.prod(counts) == len(columns) else None


def _histogram(axes: Axes, columns: pa.Table, name: str) -> None:
    """Draw how a column is distributed, the captured runs apart from the others."""
    values = np.array(columns[name].to_pylist(), float)
    judged = columns['captured'].to_pylist()
    parts = {
        'captured': (_CAPTURED, [c is True for c in judged]),
        'not captured': (_TUMBLING, [c is False for c in judged]),
        'not judged': (_GREY, [c is None for c in judged]),
    }
    found = {
        label: (values[rows][np.isfinite(values[rows])], colour)
        for label, (colour, rows) in parts.items()
    }
    drawn = {label: part for label, part in found.items() if len(part[0])}
    axes.hist(
        [part for part, _ in drawn.values()],
        bins=40,
        stacked=True,
        color=[colour for _, colour in drawn.values()],
        label=list(drawn),
    )
    axes.set(xlabel=name, ylabel='runs')
    axes.locator_params(axis='x', nbins=5)
    axes.legend(fontsize=8)

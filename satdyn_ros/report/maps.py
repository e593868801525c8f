"""
Maps of many runs as pictures: stability, capture, and the chaotic sea.

Each takes the table of its sweep (config/sweeps) and returns a matplotlib figure.  The colours are
those of Okabe and Ito and of viridis, which colour-blind eyes distinguish.
"""

from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pyarrow.parquet as pq
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ..theory.stability import smelt_moments, stability_region

_BLUE, _ORANGE, _GREEN, _GREY = '#0072B2', '#E69F00', '#009E73', '#DDDDDD'


def smelt_map(table: str | Path) -> Figure:
    """
    Draw which bodies stay upright, in the plane of the Smelt parameters.

    Left by propagation, the largest angle to LVLH; right by the linear theory of stability.py.
    """
    k_Y, k_R, angle = grid(table, 'smelt.k_Y', 'smelt.k_R', 'lvlh_angle_max_rad')
    fine = np.linspace(-0.998, 0.998, 500)
    regions = theory(fine, fine)
    figure, (left, right) = plt.subplots(
        1, 2, figsize=(11.0, 5.2), sharey=True, layout='constrained'
    )
    mesh = left.pcolormesh(
        edges(k_Y), edges(k_R), np.rad2deg(angle), cmap='viridis', norm=LogNorm(0.03, 180.0)
    )
    left.contour(fine, fine, regions > 0, levels=[0.5], colors='white', linewidths=0.8)
    figure.colorbar(mesh, ax=left, label='largest angle to LVLH [deg]', shrink=0.8)
    right.pcolormesh(
        fine, fine, regions, cmap=ListedColormap([_GREY, _BLUE, _ORANGE]), vmin=0, vmax=2
    )
    left.set_title('Propagated; white: where linear theory is stable')
    right.set_title('Linear theory')
    names = {'Lagrange': _BLUE, 'DeBra-Delp': _ORANGE, 'unstable': _GREY}
    right.legend(
        handles=[Patch(color=c, label=name) for name, c in names.items()], loc='upper left'
    )
    left.set_ylabel('$k_R = (I_n - I_r) / I_t$ (roll)')
    for axes in (left, right):
        axes.set_xlabel('$k_Y = (I_n - I_t) / I_r$ (yaw)')
        axes.set_aspect('equal')
    return figure


def theory(k_Y: np.ndarray, k_R: np.ndarray) -> np.ndarray:
    """Return 1 in Lagrange's region, 2 in that of DeBra and Delp, else 0, shape (k_R, k_Y)."""
    number = {None: 0, 'Lagrange': 1, 'DeBra-Delp': 2}
    return np.array([[number[stability_region(*smelt_moments(r, y))] for y in k_Y] for r in k_R])


def capture_map(table: str | Path) -> Figure:
    """Draw the rotors and rates with which a gyrostat is captured, and how far it swings."""
    names = 'rotor.momentum', 'initial.angular_velocity.x'
    h, rate, captured = grid(table, *names, 'captured')
    angle = grid(table, *names, 'lvlh_angle_max_rad')[2]
    figure, axes = plt.subplots(figsize=(7.0, 5.2), layout='constrained')
    swing = np.where(captured > 0.0, np.rad2deg(angle), np.nan)
    axes.set_facecolor(_GREY)
    mesh = axes.pcolormesh(edges(h), 1e3 * edges(rate), swing, cmap='viridis', vmin=0.0, vmax=90.0)
    figure.colorbar(mesh, label='largest angle to LVLH [deg]', extend='max')
    axes.legend(handles=[Patch(color=_GREY, label='tumbles')], loc='upper right')
    axes.set_xlabel('rotor momentum along body y [N m s]')
    axes.set_ylabel('initial roll rate relative to LVLH [mrad/s]')
    axes.set_title('Capture of a gyrostat')
    return figure


def stroboscopic_map(table: str | Path, orbital_rate: float) -> Figure:
    """
    Draw pitch and pitch rate at every passage of the pericentre, one colour per run.

    orbital_rate: that at the pericentre [rad/s], the unit of the pitch rate.
    """
    figure, axes = plt.subplots(figsize=(7.5, 6.0), layout='constrained')
    runs = list(strobes(table))
    colours = plt.colormaps['viridis'](np.linspace(0.0, 0.95, len(runs)))
    for (pitch, rate), colour in zip(runs, colours, strict=True):
        axes.plot(np.rad2deg(pitch), rate / orbital_rate, '.', ms=2.0, mec='none', color=colour)
    ends = [Line2D([], [], marker='.', ls='', color=colours[k]) for k in (0, -1)]
    axes.legend(ends, ['first run', 'last run'], loc='upper right')
    axes.set_xlim(-90.0, 90.0)
    axes.set_xticks(range(-90, 91, 30))
    axes.set_xlabel('pitch at the pericentre, upside down or not [deg]')
    axes.set_ylabel('pitch rate at the pericentre [rad per rad of true anomaly]')
    axes.set_title("Libration on an ellipse (Beletsky's equation), once per orbit")
    return figure


def strobes(table: str | Path) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """
    Yield pitch [rad] and pitch rate [rad/s] of each run's samples, (N,).

    The pitch from -pi/2 to pi/2: the field does not distinguish a body from one upside down.
    """
    for row in pq.read_table(table).to_pylist():
        q_lb, omega_bl_b = np.array(row['samples_q_lb']), np.array(row['samples_omega_bl_b'])
        pitch = 2.0 * np.arctan2(q_lb[:, 1], q_lb[:, 3])
        yield (pitch + np.pi / 2.0) % np.pi - np.pi / 2.0, omega_bl_b[:, 1]


def grid(
    table: str | Path, x_name: str, y_name: str, name: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the columns x (n,), y (m,) of a grid and what a column holds there, (m, n)."""
    columns = pq.read_table(table, columns=[x_name, y_name, name])
    x, y, values = (np.array(columns[key].to_pylist(), float) for key in (x_name, y_name, name))
    (xs, i), (ys, j) = np.unique(x, return_inverse=True), np.unique(y, return_inverse=True)
    grid = np.full((len(ys), len(xs)), np.nan)
    grid[j, i] = values
    return xs, ys, grid


def edges(middles: np.ndarray) -> np.ndarray:
    """Return the edges (n + 1,) of the cells around evenly spaced middles (n,)."""
    half = (middles[1] - middles[0]) / 2.0
    return np.append(middles - half, middles[-1] + half)

"""The flux density in hysteresis rods over the field along them: minor loops inside the large."""

from typing import TYPE_CHECKING

import numpy as np

from ..torques.hysteresis import Hysteresis
from .history import History
from .panels import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def loops(axes: 'Axes', history: History) -> None:
    """
    Draw b over H of each rod, and the curves of its large loop.

    ValueError: the run has no rods.
    """
    torque, states = Hysteresis.among(history.scenario.system.torques), history.states
    if torque is None:
        raise ValueError('the panel loops needs hysteresis rods, and the run has none')
    b, H = torque.flux_densities(states.inner), torque.fields(states.magnetic_field_b)
    for i, name in enumerate(torque.states):
        colour = COLOURS[i % len(COLOURS)]
        axes.plot(H[:, i], 1e3 * b[:, i], color=colour, lw=0.8, label=name)
        field = np.linspace(H.min(), H.max(), 400)
        for side in (-1.0, 1.0):
            curve = torque.curve(i, side, field)
            axes.plot(field, 1e3 * curve, '--', color=colour, lw=0.8, alpha=0.6)
    axes.set(xlabel='field along the rod [A/m]', ylabel='flux density in the rod [mT]')
    axes.legend(loc='upper left', fontsize=8)

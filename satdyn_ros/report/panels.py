"""The panels of a figure: each draws one part of a History into one pair of axes."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bag.message_angle import angle_to_message
from ..base.nanoseconds import SECOND_NS
from ..dynamics.inertia import principal_axes
from ..kernel import rotation
from ..run.events import Request, Reset
from .curves import least_axis, line_names, nadir_angles, rotor_columns
from .envelope import envelope
from .history import History
from .scene import rotor_names
from .sensor_errors import largest_of_kind, with_gaps

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito's colours, which colour-blind readers can distinguish; line styles serve in print.
COLOURS = ('#0072B2', '#D55E00', '#009E73', '#CC79A7', '#E69F00', '#56B4E9')
STYLES = ('-', '--', '-.', ':')
# Zero on a logarithmic axis: the rounding of a number near one.
_LEAST_SHOWN = 2e-16
# Of the largest value of a panel: more than what computing leaves of a zero.
_ROUNDING = 1e-9
# An axis for several sensors is longer than the largest error by so much.
_ROOM = 1.06
# Across a panel, from below: where limits are marked.
_EDGE = (0.95, 1.0, 1.0, 0.95)
# Along the time: a line that goes up and down within 8 of some 1050 pixels fills them.
_STEPS = 130
_ABOVE = {
    'loc': 'lower right',
    'bbox_to_anchor': (1.0, 0.97),
    'fontsize': 8,
    'frameon': False,
}


def time_unit(history: History) -> tuple[float, str]:
    """Return the seconds and the name of the unit that suits the history's length."""
    span_s = history.t_s[-1] - history.t_s[0]
    for seconds, name in ((86400.0, 'd'), (3600.0, 'h'), (60.0, 'min')):
        if span_s > 3.0 * seconds:
            return seconds, name
    return 1.0, 's'


def _lines(axes, history, columns, names, bounds=None, scale=1.0, turn=np.inf):
    """
    Draw one line per column, and a band with its mean where it is denser than the pixels.

    bounds: the name of these curves in history.least, most and mean, which, times scale, are the
    band where the body turns too far between rows.  turn: what leads back to the same angle.
    """
    seconds, _ = time_unit(history)
    t = history.t_s / seconds
    far = history.turns_too_far if bounds else np.zeros(len(t), bool)
    noise = _ROUNDING * np.nanmax(np.abs(columns), initial=0.0)
    for i, (column, name) in enumerate(zip(columns, names, strict=True)):
        style, colour = STYLES[i % len(STYLES)], COLOURS[i % len(COLOURS)]
        edges = (column, column, column)
        if bounds:
            parts = history.least, history.most, history.mean
            edges = tuple(scale * part[bounds][:, i] for part in parts)
        band = envelope(column, _STEPS, far, edges, noise, turns=turn == 360.0)
        line = np.where(band.is_band, np.nan, _open(column, turn))
        axes.plot(t, line, style, color=colour, label=name, lw=1.4)
        if np.any(band.is_band):
            axes.fill_between(
                t, band.least, band.most, where=band.is_band, color=colour, alpha=0.2, lw=0.0
            )
            mean = np.where(band.is_band, _open(band.mean, turn), np.nan)
            axes.plot(t, mean, style, color=colour, lw=1.4)
    if any(names):
        axes.legend(**_ABOVE, ncols=len(names))


def _open(angles, turn):
    """Return angles (N,) with a gap, nan, where they go on at the other end of a turn."""
    jumps = np.abs(np.diff(angles, prepend=angles[:1])) > turn / 2.0
    return np.where(jumps, np.nan, angles)


def attitude(axes: 'Axes', history: History) -> None:
    """
    Draw roll, pitch and yaw of the body to LVLH, or to inertial axes without an orbit.

    With them, where there is one, the angle of the axis of least inertia to nadir.  Roll and yaw
    go from -180 to 180 deg: a line has a gap where it goes through the end.
    """
    _attitude(axes, history, np.degrees(_angles(history)), 'attitude', 360.0)


def unwrapped_attitude(axes: 'Axes', history: History) -> None:
    """
    Draw roll, pitch and yaw as angles that count their turns.

    ValueError: the body turns too far between the rows to count them.
    """
    if np.any(history.turns_too_far):
        begin_s = history.t_s[0]
        raise ValueError(
            'unwrap cannot count the turns: the body turns more than a quarter turn between two '
            f'rows; a part of {history.window_s:.4g} s can be followed, such as --begin '
            f'{begin_s:.0f} --end {begin_s + history.window_s:.0f}'
        )
    _attitude(axes, history, np.degrees(np.unwrap(_angles(history), axis=0)))


def _angles(history):
    return rotation.roll_pitch_yaw(history.states.q_ib if history.q_lb is None else history.q_lb)


def _attitude(axes, history, angles, bounds=None, turn=np.inf):
    names, columns = ['roll', 'pitch', 'yaw'], [*angles.T]
    axis_b = least_axis(history.scenario.system.inertia)
    if axis_b is not None and history.q_lb is not None:
        names.append('axis to nadir')
        columns.append(np.degrees(nadir_angles(history.q_lb, axis_b)[:, 0]))
    _lines(axes, history, columns, names, bounds, np.degrees(1.0), turn)
    frame = 'inertial axes' if history.q_lb is None else 'LVLH'
    axes.set_ylabel(f'body to {frame} [deg]')


def nadir(axes: 'Axes', history: History) -> None:
    """
    Draw the angle of the axis of least inertia, its nearer end, to nadir and its parts.

    ValueError: there is no LVLH, or no such axis.
    """
    axis_b = least_axis(history.scenario.system.inertia)
    if axis_b is None or history.q_lb is None:
        raise ValueError('the panel nadir needs LVLH and an axis of least inertia')
    angles = np.degrees(nadir_angles(history.q_lb, axis_b))
    names = ('axis to nadir', 'along track', 'to the orbit normal')
    _lines(axes, history, angles.T, names, 'nadir', np.degrees(1.0), 180.0)
    axes.set_ylabel('axis of least\ninertia [deg]')


def rates(axes: 'Axes', history: History) -> None:
    """Draw the body rate relative to inertial axes, in body axes, and its length."""
    names = (r'$\omega_x$', r'$\omega_y$', r'$\omega_z$', r'$|\omega|$')
    omega = history.states.omega_bi_b
    rates = np.degrees([*omega.T, np.linalg.norm(omega, axis=-1)])
    _lines(axes, history, rates, names, 'rate', np.degrees(1.0))
    axes.set_ylabel('body rate [deg/s]')


def against(axes: 'Axes', history: History, message: str | Path) -> None:
    """Draw the angle by which the body is turned from the attitudes in an AEM of another tool."""
    stamps_ns = history.scenario.epoch_ns + np.rint(history.t_s * SECOND_NS).astype(np.int64)
    angle = angle_to_message(message, stamps_ns, history.states.q_ib)
    _lines(axes, history, np.degrees([angle]), [f'to {Path(message).name}'])
    axes.set_ylabel('angle [deg]')


def shown(axes: 'Axes', history: History, topic: str) -> None:
    """Draw what a topic shows, such as a torque in body axes."""
    values, panel = history.shown[topic], history.panels[topic]
    title, unit, _ = panel
    scale, prefix = _prefixed(values) if unit else (1.0, '')
    names = line_names(panel, values.shape[1])
    _lines(axes, history, values.T / scale, names, topic, 1.0 / scale)
    # Units of joints are long.
    between = '\n' if panel.lines else ' '
    axes.set_ylabel(f'{title}{between}[{prefix}{unit or 1}]')


def valves(axes: 'Axes', history: History) -> None:
    """Draw when the valve of each thruster is open, as bars, whatever the ticks."""
    seconds, _ = time_unit(history)
    names = [*history.valves_open]
    for k, name in enumerate(names):
        bars = [(a / seconds, (b - a) / seconds) for a, b in history.valves_open[name]]
        colour = COLOURS[k % len(COLOURS)]
        # A pulse of no pixel yet has an edge.
        axes.broken_barh(bars, (k - 0.35, 0.7), facecolor=colour, edgecolor=colour, linewidth=0.6)
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(max(len(names), 1) - 0.5, -0.5)
    axes.set_ylabel('open valves [name]')


def torque(axes: 'Axes', history: History) -> None:
    """Draw the gravity-gradient torque in body axes."""
    shown(axes, history, 'gravity_gradient')


def _prefixed(values):
    """Return the scale in which the largest value is easy to read, and the prefix of its unit."""
    largest = np.max(np.abs(values), initial=0.0)
    exponent = 3 * int(np.floor(np.log10(largest) / 3)) if largest > 0.0 else 0
    prefix = {0: '', -3: 'm', -6: 'µ', -9: 'n'}.get(exponent)
    return (1.0, '') if prefix is None else (10.0**exponent, prefix)


def drift(axes: 'Axes', history: History) -> None:
    """Draw how far the first integrals have drifted since the last event, on a log scale."""
    shown = {name: values for name, values in history.drift.items() if np.any(values >= 0.0)}
    largest = [np.maximum(values, _LEAST_SHOWN) for values in shown.values()]
    _lines(axes, history, largest, [name.replace('_', ' ') for name in shown])
    axes.set_yscale('log')
    axes.set_ylabel('relative drift of\nfirst integrals [1]')


def rotor(axes: 'Axes', history: History) -> None:
    """Draw the speed of each rotor relative to the body."""
    speeds = rotor_columns(history.states.rotor_speed)
    names = rotor_names(history.scenario)
    _lines(axes, history, speeds.T, names, 'rotor_speed')
    axes.set_ylabel('rotor speed [rad/s]')


def sensor(axes: 'Axes', history: History, name: str) -> None:
    """
    Draw measured minus true values in sensor axes, and three sigma of the noise.

    Several sensors of a kind are drawn to one scale.
    """
    errors = history.sensors[name]
    unit, per_si = errors.sensor.unit, errors.sensor.per_si
    largest = largest_of_kind(name, history.sensors)
    sizes = errors.error if largest is None else np.array([largest])
    scale, prefix = _prefixed(sizes) if per_si == 1.0 else (1.0 / per_si, '')
    _measured(axes, history, with_gaps(errors), scale)
    if largest:
        axes.set_ylim(-_ROOM * largest / scale, _ROOM * largest / scale)
    axes.set_ylabel(f'{name.replace("_", " ")} minus\ntruth [{prefix}{unit}]')


def _measured(axes, history, errors, scale):
    """Draw errors about the axes of a sensor, the noisiest behind the others."""
    seconds, _ = time_unit(history)
    t = errors.t_s / seconds
    for i, name in enumerate('xyz'[-len(errors.sigma) :]):
        colour, order = COLOURS[i], 2.0 - errors.sigma[i] / max(errors.sigma.max(), _LEAST_SHOWN)
        axes.plot(
            t, errors.error[:, i] / scale, color=colour, label=name, lw=0.6, zorder=2.0 + order
        )
        for sign in (-3.0, 3.0):
            edge = (errors.systematic[:, i] + sign * errors.sigma[i]) / scale
            axes.plot(t, edge, '--', color=colour, lw=1.0, zorder=5.0)
    axes.plot([], [], '--', color='0.4', lw=1.0, label='3 sigma')
    axes.legend(**_ABOVE, ncols=4)


TIME_PANELS = {
    'attitude': attitude,
    'rates': rates,
    'torque': torque,
    'drift': drift,
    'nadir': nadir,
    'rotor': rotor,
    'thruster': valves,
}


def events(axes: 'Axes', history: History) -> None:
    """
    Mark requests and resets by a line, and shade where an applied torque acts.

    Along the upper edge it is marked where a rotor meets a limit of torque or speed.
    """
    from matplotlib.collections import LineCollection, PolyCollection

    seconds, _ = time_unit(history)
    driven = [(begin_s / seconds, end_s / seconds) for begin_s, end_s in history.driven]
    restarts = {t_s for t_s, event in history.events if isinstance(event, Request | Reset)}
    spans = [[(begin, 0), (begin, 1), (end, 1), (end, 0)] for begin, end in driven]
    lines = [[(t_s / seconds, 0), (t_s / seconds, 1)] for t_s in sorted(restarts)]
    limits = [
        [(x, y) for x, y in zip(np.divide([a, a, b, b], seconds), _EDGE, strict=True)]
        for a, b in history.limited
    ]
    across = axes.get_xaxis_transform()
    # A collection draws thousands in the time of a few single lines.
    shades = PolyCollection(spans, transform=across, color=COLOURS[3], alpha=0.15, lw=0.0)
    marks = LineCollection(
        lines, transform=across, color='0.35', alpha=0.7, linewidths=1.2, zorder=0
    )
    edge = PolyCollection(limits, transform=across, color=COLOURS[1], linewidths=1.2)
    for parts, collection in ((spans, shades), (lines, marks), (limits, edge)):
        if parts:
            axes.add_collection(collection, autolim=False)


def polhode(axes: Any, history: History) -> None:
    """Draw omega on the ellipsoids of energy and momentum, in principal axes (3-D axes)."""
    moments, R_bp = principal_axes(history.scenario.system.inertia)
    omega = history.states.omega_bi_b @ R_bp
    energy = float(np.sum(moments * omega[0] ** 2)) / 2.0
    momentum = float(np.linalg.norm(moments * omega[0]))
    theta, phi = np.meshgrid(np.linspace(0.0, np.pi, 41), np.linspace(0.0, 2.0 * np.pi, 81))
    sphere = np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1
    )
    for axis_lengths, colour in (
        (np.sqrt(2.0 * energy / moments), COLOURS[5]),
        (momentum / moments, COLOURS[4]),
    ):
        surface = np.moveaxis(np.degrees(sphere * axis_lengths), -1, 0)
        axes.plot_surface(*surface, color=colour, alpha=0.25, linewidth=0)
    axes.plot(*np.degrees(omega).T, color=COLOURS[1], lw=1.6)
    axes.set(
        xlabel=r'$\omega_1$ [deg/s]', ylabel=r'$\omega_2$ [deg/s]', zlabel=r'$\omega_3$ [deg/s]'
    )
    axes.set_title(
        'body rate on the ellipsoids of energy (blue) and momentum (yellow)', fontsize=9
    )
    axes.set_box_aspect((1, 1, 1))


def phase(axes: 'Axes', history: History) -> None:
    """Draw pitch and pitch rate in LVLH, with the separatrix of the planar libration."""
    orbit = history.states.orbit
    if history.q_lb is None or not orbit.has_lvlh:
        raise ValueError('the panel phase needs LVLH, which orbit.type fixed does not have')
    pitch = np.unwrap(rotation.roll_pitch_yaw(history.q_lb)[:, 1])
    rate_l = rotation.rotate(history.q_lb, history.states.omega_bi_b)
    rate = (rate_l[:, 1] + orbit.rate(history.states.orbit_s)) / orbit.mean_motion
    axes.plot(np.degrees(pitch), rate, color=COLOURS[0], lw=1.4, label='this run')
    inertia = history.scenario.system.inertia
    # Beletsky 1957, sec. 2: I_n th'' + 3 n^2 (I_t - I_r) sin th cos th = 0 about the normal.
    strength = 3.0 * (inertia[0, 0] - inertia[2, 2]) / inertia[1, 1]
    angle = np.linspace(-np.pi, np.pi, 721)
    height = np.cos(angle) if strength >= 0.0 else np.sin(angle)
    limit = np.sqrt(abs(strength)) * np.abs(height)
    for sign, name in ((1.0, 'separatrix'), (-1.0, None)):
        axes.plot(np.degrees(angle), sign * limit, '--', color='0.3', lw=1.0, label=name)
    axes.set(xlabel='pitch to LVLH [deg]', ylabel='pitch rate in LVLH / mean motion [1]')
    axes.legend(loc='upper right', fontsize=8)

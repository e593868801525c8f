"""One self-contained page of a bag: a 3-D view that plays, the plots, the scenario, the proof."""

import json
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np

from .. import __version__
from ..dynamics import rotation
from ..dynamics.propagator import Propagation
from ..run.events import Event, to_yaml
from .history import History, history
from .scene import scene

_ROWS = 4000
_LISTED_EVENTS = 200


def report(bag: str | Path, output: str | Path) -> None:
    """
    Write the page of a bag.

    ValueError: the bag is none of ours, or plotly is not installed.  OSError: output cannot be
    written.
    """
    Path(output).write_text(page(history(bag, _ROWS), Path(bag).name), encoding='utf-8')


def page(run: History, title: str) -> str:
    """Return the page of a history as HTML that needs nothing else."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise ValueError(
            'reports take plotly, which is not installed; pip install satdyn_ros[plot]'
        ) from None
    room = files(__package__)
    data = {'t_s': run.t_s.tolist(), 'plots': _plots(run), 'scene': scene(run)}
    return Template((room / 'report.html').read_text(encoding='utf-8')).substitute(
        title=escape(title),
        version=__version__,
        summary=escape(_summary(run)),
        integrals=_table(['first integral', 'largest relative drift'], _integrals(run)),
        closed_forms=_table(['from', 'motion', 'source', 'difference [rad]'], _closed_forms(run)),
        events=_table(['time [s]', 'event'], _events(run.events)),
        scenario=escape(run.scenario.to_yaml()),
        data=json.dumps(data).replace('</', '<\\/'),
        plotly=get_plotlyjs(),
        script=(room / 'report.js').read_text(encoding='utf-8'),
    )


def _summary(run):
    span_s = run.t_s[-1] - run.t_s[0]
    return (
        f'{run.ticks} ticks at {float(run.scenario.rate):g} Hz, {span_s:g} s; '
        f'{len(run.t_s)} of them are drawn, all are checked'
    )


def _plots(run):
    """Return the plots over time: title, and name and values of each line."""
    q = run.states.q_ib if run.q_lb is None else run.q_lb
    frame = 'inertial axes' if run.q_lb is None else 'LVLH'
    angles = np.degrees(np.unwrap(rotation.roll_pitch_yaw(q), axis=0))
    plots = [
        _plot(f'body to {frame} [deg]', ('roll', 'pitch', 'yaw'), angles.T),
        _plot('body rate [deg/s]', ('x', 'y', 'z'), np.degrees(run.states.omega_bi_b).T),
        _plot('gravity gradient [N m]', ('x', 'y', 'z'), run.torque_b.T),
    ]
    names = [name.replace('_', ' ') for name in run.drift]
    largest = [np.maximum(values, 1e-17) for values in run.drift.values()]
    return [*plots, _plot('relative drift [1]', names, largest) | {'log': True}]


def _plot(title, names, columns):
    lines = [
        {'name': name, 'y': [None if np.isnan(y) else float(f'{y:.7g}') for y in column]}
        for name, column in zip(names, columns, strict=True)
    ]
    return {'title': title, 'lines': lines}


def _integrals(run):
    return [(name.replace('_', ' '), f'{drift:.2e}') for name, drift in run.largest_drift.items()]


def _closed_forms(run):
    """Yield, for each motion of the run, the closed form it has and how far both are apart."""
    from .. import exact

    for tick, motion in list(run.motions.items())[:_LISTED_EVENTS]:
        begin = f'tick {tick}'
        closed = exact.recognise(motion.system, motion.state, motion.start_s)
        if closed is None:
            yield begin, 'no closed form', exact.explain(motion.system, motion.state), ''
            continue
        later = [other for other in run.motions if other > tick]
        end_s = min(later, default=np.inf) / float(run.scenario.rate)
        inside = (run.t_s >= motion.start_s) & (run.t_s < end_s)
        t_s = run.t_s[inside] - motion.start_s
        numeric = Propagation(motion.system, motion.state, motion.start_s).at(t_s)
        apart = rotation.angle_between(closed.at(t_s).q_ib, numeric.q_ib)
        yield begin, closed.name, closed.source, f'{np.max(apart, initial=0.0):.2e}'


def _events(events: list[tuple[float, Event]]):
    rows = [(f'{t_s:.9g}', to_yaml([event]).strip()) for t_s, event in events[:_LISTED_EVENTS]]
    if len(events) > _LISTED_EVENTS:
        rows.append(('…', f'{len(events) - _LISTED_EVENTS} more'))
    return rows


def _table(heads, rows):
    """Return an HTML table, or a dash where there are no rows."""
    body = ''.join(
        '<tr>' + ''.join(f'<td>{escape(str(cell))}</td>' for cell in row) + '</tr>' for row in rows
    )
    if not body:
        return '<p>none</p>'
    head = ''.join(f'<th>{escape(name)}</th>' for name in heads)
    return f'<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'

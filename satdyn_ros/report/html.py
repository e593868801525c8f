"""One self-contained page of a bag: the scene that plays, the charts, the proof, the scenario."""

import json
from collections.abc import Iterable, Iterator
from html import escape
from importlib.resources import files
from operator import itemgetter
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from .. import __version__
from ..integrate.propagation import Propagation
from ..kernel import rotation
from ..run.events import Request, Reset, RotorLimited, Topics, to_yaml
from ..run.scenario import Scenario
from .history import History, history
from .scene import of_history, table
from .sensor_errors import largest_of_kind, with_gaps

# Enough for a body that turns a thousand times, and small enough for a page of a few megabytes.
TABLE_ROWS = 16000
_LISTED_EVENTS = 200

STYLE_SHEETS = ('bundled/uplot.min.css', 'page/style.css')
SCENE_SCRIPTS = (
    'bundled/three.min.js',
    'bundled/uplot.min.js',
    'page/units.js',
    'page/rows.js',
    'page/earth.js',
    'page/planet.js',
    'page/things.js',
    'page/labels.js',
    'page/scene.js',
    'page/ground.js',
    'page/stage.js',
    'page/envelope.js',
    'page/charts.js',
)
PLAYER_SCRIPTS = (*SCENE_SCRIPTS, 'page/timeline.js', 'page/player.js')


def report(
    bag: str | Path,
    output: str | Path,
    begin_s: float | None = None,
    end_s: float | None = None,
) -> None:
    """
    Write the page of a bag, or of the ticks from begin_s to end_s [s] in it.

    ValueError: the bag was not written by satdyn_ros, or has no such ticks.
    OSError: output cannot be written.
    """
    run = history(bag, TABLE_ROWS, begin_s, end_s)
    Path(output).write_text(page(run, Path(bag).name), encoding='utf-8')


def page(run: History, title: str) -> str:
    """Return the page of a history as self-contained HTML."""
    scripts = ''.join(
        f'<script>{asset(name)}</script>\n' for name in (*PLAYER_SCRIPTS, 'page/report.js')
    )
    style = '\n'.join(asset(name) for name in STYLE_SHEETS)
    body = Template(asset('page/report.html')).substitute(
        title=escape(title),
        version=__version__,
        summary=escape(summary(run)),
        note=f'<p class="quiet">{escape(band_note(run))}</p>' if band_note(run) else '',
        integrals=_table(['first integral', 'largest relative drift'], _integrals(run)),
        closed_forms=_table(['from', 'motion', 'source', 'difference [rad]'], _closed_forms(run)),
        events=_table(['time [s]', 'event'], _events(run)),
        scenario=_table(
            ['key', 'value', 'unit', 'default', 'as typed, or in common units'],
            _differences(run.scenario),
        ),
        yaml=escape(run.scenario.to_yaml()),
        run=json.dumps(playable(run)).replace('</', '<\\/'),
        scripts=scripts,
    )
    return document(title, f'<style>{style}</style>', body)


def document(title: str, head: str, body: str) -> str:
    """Return a page of HTML; head: its style sheets and scripts."""
    return Template(asset('page/page.html')).substitute(title=escape(title), head=head, body=body)


def asset(name: str) -> str:
    """Return the text of a file of the pages."""
    return files(__package__).joinpath(name).read_text(encoding='utf-8')


def playable(run: History) -> dict[str, Any]:
    """
    Return what the page plays, plain data.

    description and table: see scene.py.  bands: the rows in which the body turns too far for a
    line, and tables of least, most and mean; null where there are none.  marks: events
    (t_s, kind 'restart' or 'change') and intervals (from, to) [s]: driven, and limited, in which
    rotors meet a limit.  notice: what the 3-D view cannot show, or ''.  sensors: by their names a
    table of t_s, error and systematic, and sigma, see sensor_errors.py, with unit and per_si of
    the chart, see Sensor, and largest, of the sensors of its kind, or null where it is the only
    one.
    """
    description, rows = of_history(run)
    far = np.flatnonzero(run.turns_too_far)
    return {
        'description': description,
        'table': rows,
        'bands': {'rows': far.tolist()}
        | {name: table(getattr(run, name)) for name in ('least', 'most', 'mean')}
        if len(far)
        else None,
        'marks': {'events': _marks(run), 'driven': run.driven, 'limited': run.limited},
        'notice': _notice(run),
        'sensors': {name: _errors(name, run.sensors) for name in run.sensors},
    }


def _errors(name, sensors):
    errors = with_gaps(sensors[name])
    columns = {name: getattr(errors, name) for name in ('t_s', 'error', 'systematic')}
    return {
        'table': table(columns),
        'sigma': errors.sigma.tolist(),
        'unit': errors.sensor.unit,
        'per_si': errors.sensor.per_si,
        'largest': largest_of_kind(name, sensors),
    }


def summary(run: History) -> str:
    """Return in one sentence what is drawn."""
    drawn = 'each is drawn' if len(run.t_s) == run.ticks else f'{len(run.t_s)} of them are drawn'
    return (
        f'{run.ticks} ticks at {float(run.scenario.rate):g} Hz, {run.span_s:.9g} s; '
        f'{drawn}, all are checked'
    )


def band_note(run: History) -> str:
    """Return what the bands of the charts mean, or '' if there are no bands."""
    if not np.any(run.turns_too_far) or len(run.t_s) == run.ticks:
        return ''
    return (
        'Where the body turns more than a quarter turn from one row to the next, a band from '
        'minimum to maximum over all ticks replaces the lines; a shorter window (--begin S '
        '--end S) shows the lines.'
    )


def _notice(run):
    if not np.any(run.turns_too_far):
        return ''
    largest = np.degrees(run.turned.max())
    row_s = float(np.diff(run.t_s).max(initial=0.0))
    between = f'The body turns up to {largest:.0f} deg between rows {row_s:.3g} s apart'
    if len(run.t_s) == run.ticks:
        return f'{between}, which the ticks do not resolve: publish.rate is too low to play it.'
    begin_s = run.t_s[int(np.argmax(run.turned))]
    end_s = min(begin_s + run.window_s, run.t_s[-1])
    return (
        f'{between}, which this view cannot play. A shorter window plays as it was: '
        f'--begin {begin_s:.0f} --end {end_s:.0f}.'
    )


def _marks(run):
    """Return when restarts and changes were, each instant once."""
    marks = {
        (t_s, 'restart' if isinstance(event, Request | Reset) else 'change'): None
        for t_s, event in _discrete(run)
    }
    return [{'t_s': t_s, 'kind': kind} for t_s, kind in marks]


def _discrete(run):
    """Yield the events that are listed one by one."""
    for t_s, event in run.events:
        if isinstance(event, Request | Reset | Topics):
            yield t_s, event


def _limits(run):
    """Yield of each limit that a rotor meets the first time and a sentence."""
    times: dict[tuple[str, str], list[float]] = {}
    for t_s, event in run.events:
        if isinstance(event, RotorLimited):
            times.setdefault((event.rotor, event.limit), []).append(t_s)
    for (rotor, limit), found in times.items():
        count = f'{len(found)} times until {found[-1]:.9g} s' if found[1:] else 'once'
        yield found[0], f'{rotor} meets its {limit}, {count}'


def _integrals(run):
    return [(name.replace('_', ' '), f'{drift:.2e}') for name, drift in run.largest_drift.items()]


def _closed_forms(run):
    """Yield, for each motion of the run, its closed form and how far both are apart."""
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


def _events(run: History) -> Iterator[tuple[str, str]]:
    """
    Yield what happened: restarts and changes one by one, torques as intervals.

    Of the limits that rotors meet, the first time and how often.
    """
    happened = sorted([*_discrete(run), *run.driven, *_limits(run)], key=itemgetter(0))
    for t_s, what in happened[:_LISTED_EVENTS]:
        if isinstance(what, float):
            yield f'{t_s:.9g}', f'applied torque until {what:.9g} s'
        elif isinstance(what, str):
            yield f'{t_s:.9g}', what
        else:
            yield f'{t_s:.9g}', to_yaml([what]).strip().removeprefix('- ')
    if len(happened) > _LISTED_EVENTS:
        yield '…', f'{len(happened) - _LISTED_EVENTS} more'


def _differences(scenario: Scenario) -> Iterator[tuple[str, ...]]:
    """Yield what differs from its default: the cells of its row."""
    for name, value in scenario.values.items():
        key = scenario.keys[name]
        if value != key.default:
            typed = scenario.typed.get(name) or key.in_trade(value)
            yield name, _text(value), key.unit, _text(key.default), _text(typed)


def _text(value):
    if isinstance(value, tuple | list):
        return f'[{", ".join(_text(x) for x in value)}]'
    return f'{value:.9g}' if isinstance(value, float) else str(value)


def _table(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return an HTML table, or 'none' where there are no rows."""
    body = ''.join(
        '<tr>' + ''.join(f'<td>{escape(str(cell))}</td>' for cell in row) + '</tr>' for row in rows
    )
    if not body:
        return '<p>none</p>'
    head = ''.join(f'<th>{escape(name)}</th>' for name in heads)
    return (
        '<div class="scroll"><table>'
        f'<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'
    )

"""
Write the tables and entries of the reference pages from the declarations that the code reads.

    python scripts/write_tables.py

Each is between <!-- name --> and <!-- end of name -->.
"""

import argparse
import os
import re
from contextlib import contextmanager
from pathlib import Path

from satdyn_ros.cli.command_line import parser
from satdyn_ros.run import parts, shipped
from satdyn_ros.run.environment import of_the_surface
from satdyn_ros.run.keys import KEYS, keys_of
from satdyn_ros.run.scenario import Frames, Scenario
from satdyn_ros.run.topics import TOPICS
from satdyn_ros.sensors import KINDS
from satdyn_ros.sweep import quantities, sweep_keys, variation
from satdyn_ros.sweep.table import OUTCOMES

_ROOT = Path(__file__).parents[1]
DOCUMENTS = (
    *(
        _ROOT / 'docs' / 'reference' / f'{name}.md'
        for name in ('topics', 'parameters', 'commands')
    ),
    _ROOT / 'docs' / 'sweeps.md',
)
# Commands that a reader ends by Ctrl-C.
_ENDLESS = ('node', 'replay', 'watch')
_NAME = 'NAME'
_TYPE = f'sensors.{_NAME}.type'
_CHANGES = {'never': 'at the start', 'running': 'while it runs', 'service': 'by request'}


def tables() -> dict[str, str]:
    """Return the tables and entries, by name, as Markdown."""
    return {
        'topics': _topics(),
        'parameters': _parameters(),
        'parts': _parts(),
        'scenarios': _scenarios(),
        'commands': _commands(),
        'sweep keys': _sweep_keys(),
        'quantities': _table(('name', 'what varies'), quantities.QUANTITY_FORMS.items()),
        'variations': _table(
            ('form', 'meaning'),
            ((f'`{form}`', says) for form, says in variation.WAYS.items()),
        ),
        'outcomes': _table(
            ('column', 'meaning'), ((f'`{name}`', says) for name, (_, says) in OUTCOMES.items())
        ),
    }


def with_tables(text: str) -> str:
    """Return the text of a document with its tables as declared."""
    for name, table in tables().items():
        between = re.compile(f'(<!-- {name} -->\n).*?(<!-- end of {name} -->)', re.DOTALL)

        def filled(found, table=table):
            return found[1] + table + found[2]

        text = between.sub(filled, text)
    return text


def _topics():
    rows = [
        (
            f'`{topic.name}`'
            + (' (in)' if topic.role == 'input' else '')
            + '<br>'
            + topic.type.replace('/msg/', '/'),
            f'`{getattr(Frames(), topic.frame)}`' if topic.frame else '',
            topic.says,
        )
        for topic in TOPICS.values()
    ]
    return _table(('topic and type', 'frame', 'content'), rows)


def _parameters():
    """Return an entry for each key, under a heading of its own, in sections by what it is of."""
    named = _of_named()
    sections: dict[str, list[str]] = {}
    for name, key in {**KEYS, **named}.items():
        owner, _, rest = name.partition('.')
        kind, _, leaf = rest.partition('.')
        if kind == _NAME and f'{owner}.{leaf}' in KEYS:
            continue  # the entry of that one names it
        if kind in KINDS:
            if f'sensors.{_NAME}.{leaf}' in named:
                continue  # one entry for all types
            owner = f'sensors of type {kind}'
        twin = named.get(f'{owner}.{_NAME}.{rest}')
        sections.setdefault(owner, []).append(_entry(key, twin))
    return ''.join(f'### {owner}\n\n{"".join(of_it)}' for owner, of_it in sections.items())


def _entry(key, twin):
    default = 'no default' if key.name == _TYPE else f'default {_default(key)}'
    facts = [key.allowed, default, _CHANGES[key.changes]]
    if twin:
        falls_back = ', by default this value' if twin.name in of_the_surface([_NAME]) else ''
        facts.append(f'also `{twin.name}`{falls_back}')
    return f'#### `{key.name}`\n\n{key.meaning}\\\n*{" · ".join(facts)}*\n\n'


def _default(key):
    return 'empty' if key.default == '' else f'`{_plain(key.default)}`'.replace("'", '')


def _of_named():
    """Return what each plate, rotor and sensor with a name has: of a sensor, whatever its type."""
    keys = keys_of(
        (_NAME,),
        (_NAME,),
        sensors={_NAME: next(iter(KINDS))},
        mode_names=(_NAME,),
        rod_names=(_NAME,),
    )
    any_sensor = {_TYPE, *(f'sensors.{_NAME}.{leaf}' for leaf in _of_any_sensor())}
    return {
        name: key
        for name, key in keys.items()
        if name not in KEYS and (not name.startswith('sensors.') or name in any_sensor)
    }


def _of_any_sensor():
    leaves = [{name.rsplit('.')[2] for name in KEYS if f'.{kind}.' in name} for kind in KINDS]
    return set.intersection(*leaves)


def _parts():
    by_kind = sorted(parts.catalogue().items(), key=lambda item: item[1].kind)
    rows = [
        (
            f'`{name}`',
            part.kind.replace('_', ' '),
            '<br>'.join(f'`{leaf}: {_plain(x)}`' for leaf, x in part.values.items()),
            part.says,
        )
        for name, part in by_kind
    ]
    return _table(('part', 'of a', 'says', 'class and source'), rows)


def _scenarios():
    rows = []
    for name in shipped.names():
        text, scenario = shipped.scenario_path(name).read_text(), Scenario.from_yaml(name)
        comment = text[: text.index('/**:')].replace('# ', '').split()
        inertia, rate = (
            f'{_plain(scenario[key])}' for key in ('body.inertia', 'initial.angular_velocity')
        )
        rotors = ', '.join(rotor.mode.replace('_', ' ') for rotor in scenario.system.rotors)
        facts = f'inertia {inertia} kg m^2 · rate {rate} rad/s to {scenario["initial.frame"]}'
        rows.append((f'`{name}`', f'{" ".join(comment)}<br>*{facts} · rotors {rotors}*'))
    return _table(('scenario', 'shows'), rows)


def _commands():
    (commands,) = (
        action for action in parser()._actions if isinstance(action, argparse._SubParsersAction)
    )
    with _terminal():
        return ''.join(
            f'## satdyn {name}\n\n```sh{" background" if name in _ENDLESS else ""}\n'
            f'{command.examples}\n```\n\n```none\n{command.format_usage_and_options()}```\n\n'
            for name, command in commands.choices.items()
        )


@contextmanager
def _terminal():
    """Let help be as wide as a page, whatever the terminal."""
    before = os.environ.get('COLUMNS')
    os.environ['COLUMNS'] = '99'
    try:
        yield
    finally:
        os.environ.pop('COLUMNS')
        if before is not None:
            os.environ['COLUMNS'] = before


def _sweep_keys():
    rows = [
        (
            f'`{key.name}`',
            sweep_keys.SPECIAL.get(key.name) or key.allowed,
            'required' if key.default is None else f'`{_plain(key.default)}`',
            key.meaning,
        )
        for key in sweep_keys.SWEEP_KEYS.values()
    ]
    return _table(('key', 'allowed', 'default', 'meaning'), rows)


def _plain(value):
    if isinstance(value, tuple):
        return [x if isinstance(x, str) else round(x, 4) for x in value]
    return str(value).lower() if isinstance(value, bool) else value


def _table(head, rows):
    lines = [head, ['---'] * len(head), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


if __name__ == '__main__':
    for document in DOCUMENTS:
        document.write_text(with_tables(document.read_text(encoding='utf-8')), encoding='utf-8')

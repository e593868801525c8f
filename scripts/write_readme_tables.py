"""
Write the tables of topics and parameters into README.md from their declarations.

    python scripts/write_readme_tables.py

Each table stands between <!-- name --> and <!-- end of name -->.
"""

import re
from pathlib import Path

from satdyn_ros.messages.topics import TOPICS
from satdyn_ros.run.keys import KEYS
from satdyn_ros.run.scenario import Frames

README = Path(__file__).parents[1] / 'README.md'
_CHANGES = {'never': 'start', 'running': 'running', 'service': 'request'}


def tables() -> dict[str, str]:
    """Return the tables, by name, as Markdown."""
    return {'topics': _topics(), 'parameters': _parameters()}


def with_tables(text: str) -> str:
    """Return the text of the README with its tables as declared."""
    for name, table in tables().items():
        between = re.compile(f'(<!-- {name} -->\n).*?(<!-- end of {name} -->)', re.DOTALL)
        text = between.sub(lambda found, table=table: found[1] + table + found[2], text)
    return text


def _topics():
    rows = [
        (
            f'`{topic.name}`' + (' (in)' if topic.role == 'input' else ''),
            topic.type.replace('/msg/', '/'),
            f'`{getattr(Frames(), topic.frame)}`' if topic.frame else '',
            topic.says,
        )
        for topic in TOPICS.values()
    ]
    return _table(('topic', 'type', 'frame', 'says'), rows)


def _parameters():
    rows = [
        (
            f'`{key.name}`',
            key.allowed,
            f'`{_plain(key.default)}`'.replace("'", ''),
            key.meaning,
            _CHANGES[key.changes],
        )
        for key in KEYS.values()
    ]
    return _table(('parameter', 'takes', 'default', 'meaning', 'changes'), rows)


def _plain(value):
    if isinstance(value, tuple):
        return [x if isinstance(x, str) else round(x, 4) for x in value]
    return str(value).lower() if isinstance(value, bool) else value


def _table(head, rows):
    lines = [head, ['---'] * len(head), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


if __name__ == '__main__':
    README.write_text(with_tables(README.read_text(encoding='utf-8')), encoding='utf-8')

"""YAML files as ROS reads them, and one sentence for what is wrong with one."""

import re
from pathlib import Path
from typing import Any

import yaml


def read_text(path: str | Path, what: str) -> str:
    """Return the text of a file; what: its name in the ValueError, 'the scenario'."""
    try:
        return Path(path).read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'it is not a text file'
        raise ValueError(f'{what} {path} cannot be read: {reason}') from None


def load(text: str, origin: str) -> Any:
    """
    Return what a YAML text says; origin names it in the ValueError: it is no YAML.

    >>> load('[1e-3, 3.9e14]', 'example')
    [0.001, 390000000000000.0]
    """
    try:
        return yaml.load(text, _Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        where = f' at line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or 'it cannot be parsed'
        raise ValueError(f'{origin} is no YAML{where}: {problem}') from None


class _Loader(yaml.SafeLoader):
    """YAML whose numbers are those of ROS: 1e-3 and 3.9e14 are numbers too."""


_Loader.yaml_implicit_resolvers = {
    first: [(tag, regexp) for tag, regexp in resolvers if tag != 'tag:yaml.org,2002:timestamp']
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float',
    re.compile(r'[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+$'),
    list('-+.0123456789'),
)

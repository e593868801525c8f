"""
YAML files as ROS reads them, and one sentence for what is wrong with one.

A file may be hostile: size, depth, the length of a number and the number of values, aliases
counted with all that they stand for, have limits that are checked before anything is built.  What
they allow is read within a second.
"""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from .regular_file import regular_file

# The parser in C where PyYAML has it; that in Python is some twenty times slower.
SafeLoader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
LARGEST_BYTES, MOST_VALUES = (
    (2_000_000, 50_000) if SafeLoader is not yaml.SafeLoader else (200_000, 5_000)
)
DEEPEST = 64
_TOO_DEEP = f'is nested deeper than the {DEEPEST} levels allowed'
# The parser in C may look further ahead than we count, and then says this of a limit of its own.
_OWN_LIMIT = 'exceeded maximum nesting depth'
# Of an unquoted text, which may be a number: 1:1:1 is one to the base of sixty.
LONGEST_PLAIN = 1000
# A text in a bag may have one value for so many bytes of the bag: what rosbag2 says of a topic or
# a file has more for each.
_BYTES_A_VALUE = 20
# A list and its unit are one text, which YAML takes in quotes alone.
_LIST_WITH_UNIT = re.compile(r'\]\s*[^\W\d_]')
_QUOTED_UNIT = "; a list with its unit is quoted, as in '[5, 3, 2] mA m^2'"
# What YAML has in double quotes alone, escaped: what it does not take, or takes for a line break.
TO_ESCAPE = re.compile(
    '[^\t\n\x20-\x7e\xa0-\u2027\u202a-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]'
)


def read_text(path: str | Path, what: str, largest_bytes: int = LARGEST_BYTES) -> str:
    """Return the text of a file; what: its name in the ValueError, 'the scenario'."""
    try:
        with open(regular_file(path), 'rb') as file:
            content = file.read(largest_bytes + 1)
        # With or without the byte-order mark that some editors put first.
        text = content.decode('utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or 'it is not a text file'
        raise ValueError(f'{what} {path} cannot be read: {reason}') from None
    if len(content) > largest_bytes:
        raise ValueError(f'{what} {path} is larger than the {largest_bytes} bytes allowed')
    return text


def quoted(text: str) -> str:
    r"""
    Return a text in double quotes, on one line, as YAML 1.1 and 1.2 both read it back.

    >>> print(quoted('\t"é"\x85'))
    "\t\"é\"\u0085"
    """
    as_json = json.dumps(text, ensure_ascii=False)
    return TO_ESCAPE.sub(lambda match: f'\\u{ord(match[0]):04x}', as_json)


def load(text: str, origin: str, size: int = 0) -> Any:
    """
    Return what a YAML text says; origin names it in the ValueError: it is not YAML, or too much.

    size [bytes]: of the bag or the record that holds the text, which was read and so may allow
    more than a text alone.

    >>> load('[1e-3, 3.9e14, -.5]', 'example')
    [0.001, 390000000000000.0, -0.5]
    """
    node = compose(text, origin, _Loader, size)
    if node is None:
        return None
    if twice := _given_twice(node, set()):
        raise ValueError(f'{origin} {twice}')
    with _in_one_sentence(origin):
        return _Loader('').construct_document(node)


def compose(text: str, origin: str, loader: Any, size: int = 0) -> yaml.Node | None:
    """Return the nodes of a YAML text by a loader of PyYAML; size, ValueError: as of load."""
    with _in_one_sentence(origin, text):
        excess = _excess(text, size)
        node = None if excess else yaml.compose(text, loader)
    if excess:
        raise ValueError(f'{origin} {excess}')
    return node


@contextmanager
def _in_one_sentence(origin: str, text: str = '') -> Iterator[None]:
    """Raise what PyYAML raises as a ValueError of one sentence."""
    try:
        yield
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        where = f' at line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or 'it cannot be parsed'
        if problem == _OWN_LIMIT:
            raise ValueError(f'{origin} {_TOO_DEEP}') from None
        line = text.splitlines()[mark.line : mark.line + 1] if mark else []
        hint = _QUOTED_UNIT if line and _LIST_WITH_UNIT.search(line[0]) else ''
        raise ValueError(f'{origin} is not YAML{where}: {problem}{hint}') from None
    except (ValueError, LookupError, AttributeError, ArithmeticError, TypeError):
        # What PyYAML raises depends on the tag.
        raise ValueError(
            f'{origin} has a value that does not suit its tag, as in !!bool maybe'
        ) from None


def _excess(text: str, size: int) -> str | None:
    """Return which limit a text exceeds, if any, before anything is built of it."""
    most_bytes, most_values = max(LARGEST_BYTES, size), max(MOST_VALUES, size // _BYTES_A_VALUE)
    if len(text) > most_bytes:
        return f'is larger than the {most_bytes} bytes allowed'
    count = 0
    begins: list[tuple[str | None, int]] = []
    sizes: dict[str | None, int] = {}
    for event in yaml.parse(text, _Loader):
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in sizes:
                return f'has the alias *{event.anchor} for something not complete before it'
            count += sizes[event.anchor]
        elif isinstance(event, yaml.ScalarEvent):
            count += 1
            sizes[event.anchor] = 1
            if len(event.value) > LONGEST_PLAIN and (event.implicit[0] or event.tag):
                return f'has an unquoted text of more than the {LONGEST_PLAIN} characters allowed'
        elif isinstance(event, yaml.CollectionStartEvent):
            sizes.pop(event.anchor, None)
            begins.append((event.anchor, count))
            count += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, begin = begins.pop()
            sizes[anchor] = count - begin
        if len(begins) > DEEPEST:
            return _TOO_DEEP
        if count > most_values:
            return f'has more than the {most_values} values allowed, aliases written out'
    return None


def _given_twice(node: yaml.Node, seen: set[yaml.Node]) -> str | None:
    """Return which key is given twice in one mapping of a tree of nodes, if any."""
    if isinstance(node, yaml.ScalarNode) or node in seen:
        return None
    seen.add(node)
    keys: set[tuple[str, str]] = set()
    for item in node.value:
        key, value = item if isinstance(node, yaml.MappingNode) else (None, item)
        if isinstance(key, yaml.ScalarNode):
            if (key.tag, key.value) in keys:
                line = key.start_mark.line + 1
                return f'gives {key.value} twice, again at line {line}; it must be given once'
            keys.add((key.tag, key.value))
        if twice := _given_twice(value, seen):
            return twice
    return None


class _Loader(SafeLoader):  # type: ignore[misc, valid-type]
    """YAML whose numbers are those of ROS: 1e-3, 3.9e14 and -.5 are numbers too."""


_Loader.yaml_implicit_resolvers = {
    first: [(tag, regexp) for tag, regexp in resolvers if tag != 'tag:yaml.org,2002:timestamp']
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float',
    re.compile(r'[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?(?=[eE]))([eE][-+]?[0-9]+)?$'),
    list('-+.0123456789'),
)

"""The site: `make docs` builds it offline into build/docs."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]

from numpy.typing import ArrayLike  # noqa: E402
from sphinx.util.typing import stringify_annotation  # noqa: E402

from satdyn_ros import __version__  # noqa: E402

project = 'satdyn_ros'
author = copyright = 'the satdyn_ros developers'
release = version = __version__

extensions = [
    'myst_parser',
    'sphinx.ext.apidoc',
    'sphinx.ext.autodoc',
    'sphinx.ext.mathjax',
    'sphinx.ext.napoleon',
]
myst_enable_extensions = ['dollarmath']
myst_heading_anchors = 4
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
exclude_patterns = ['_static']
root_doc = 'index'

html_theme = 'furo'
html_title = 'satdyn_ros'
html_static_path = ['_static']
# No page leads to it, and its tables are wider than a page; the search finds as much.
html_use_index = False
html_domain_indices = False
mathjax_path = 'mathjax/tex-svg.js'

apidoc_modules = [
    {
        'path': str(ROOT / 'satdyn_ros'),
        'destination': 'reference/api',
        'max_depth': 2,
        'separate_modules': False,
        # Its functions are listed with the package, which has one of its name.
        'exclude_patterns': [str(ROOT / 'satdyn_ros/exact/recognise.py')],
        'automodule_options': {'members', 'show-inheritance'},
    }
]
autodoc_member_order = 'bysource'
autodoc_typehints = 'signature'
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
# Without references to words of their units.
napoleon_custom_sections = [('Attributes', 'params_style')]
# In no wheel of ROS 2.
autodoc_mock_imports = ['simulation_interfaces']

nitpicky = True
# Types of other libraries, type variables and private bases, which have no page.
nitpick_ignore_regex = [
    ('py:.*', r'(?!satdyn_ros).*'),
    ('py:.*', r'.*\._(Messages|Name|Same|OfAnEllipse|OfAText)'),
]
# A word of a signature, such as type in type[Sensor], may be the name of several fields.
suppress_warnings = ['ref.python']


def _with_array_like(app, what, name, obj, options, *signature):
    """Call ArrayLike so, and not by all that it is."""
    long = stringify_annotation(ArrayLike, 'smart')
    return tuple(part and part.replace(long, '~numpy.typing.ArrayLike') for part in signature)


def _as_written(app, what, name, obj, options, lines):
    """
    Keep a docstring as it is written, but for its sections, which napoleon reads.

    It is plain text with formulas in it: what reStructuredText would take for markup is escaped,
    and what is indented is kept line by line.  Examples are kept as Python.
    """
    first = next((i for i in range(len(lines)) if _is_header(lines, i)), len(lines))
    examples = next((i for i in range(first, len(lines)) if lines[i] == 'Examples'), len(lines))
    prose, sections = lines[:first], lines[first:examples]
    lines[:] = [*_blocks(prose), *map(_escaped, sections), *lines[examples:]]
    if what in ('attribute', 'data', 'property'):
        # In the first line napoleon takes what is before a colon for a type: an empty comment.
        lines[:0] = ['..', '']


def _is_header(lines, i):
    """Whether line i names a section, which the line below it underlines."""
    return bool(lines[i]) and lines[i + 1 : i + 2] == ['-' * len(lines[i])]


def _escaped(line):
    """Return a line without markup."""
    return re.sub(r'([*`|_\\])', r'\\\1', line)


def _blocks(written):
    """Return lines of text, what is indented in them as blocks."""
    lines, in_block = [], False
    for i, line in enumerate(written):
        starts = line.startswith((' ', '>>>'))
        if starts and not in_block:
            lines.extend(['', '::', ''])
        if line and not starts and in_block and not _goes_on(written, i):
            lines.append('')
            in_block = False
        in_block = in_block or starts
        lines.append(f'    {line}' if in_block else _escaped(line))
    return lines


def _goes_on(lines, i):
    """Whether line i is the output of an example above it."""
    before = lines[:i]
    while before and before[-1] and not before[-1].startswith(' '):
        if before[-1].startswith('>>>'):
            return True
        before.pop()
    return False


def setup(app):
    """Connect what changes docstrings."""
    # Before napoleon, which has the priority 500.
    app.connect('autodoc-process-docstring', _as_written, priority=400)
    app.connect('autodoc-process-signature', _with_array_like)

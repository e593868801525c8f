"""The parameter file of a fleet: a satellite for each element set of a catalogue."""

import errno
import os
import re
from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from ..base import ros_yaml
from ..base.nanoseconds import SECOND_NS, epoch
from ..orbits.element_sets import Catalogue, ElementSet
from ..orbits.tle import checked
from .parameter_file import LARGEST_CATALOGUE, ParameterFile


def write_constellation(path: str | Path, output: str | Path, pattern: str = '*') -> int:
    """
    Write a parameter file with a satellite for each element set in a file; return their number.

    pattern: of the names of those that are taken, with * and ?, in capitals or not.  Tick 0 is at
    the latest epoch of their elements, up to a second later.  The sets stay in their file, which
    the new one names.  ValueError: a set is none that SGP4 flies, or is not distinguished from
    another by number or name, or none has such a name; with the line.  OSError: it cannot be
    written.
    """
    folder = Path(output).parent
    if not folder.is_dir():
        raise FileNotFoundError(errno.ENOENT, 'there is no such folder', str(folder))
    text = ros_yaml.read_text(path, 'the element sets in', LARGEST_CATALOGUE)
    try:
        catalogue = Catalogue(text)
        taken = [
            each for each in catalogue.sets if fnmatchcase(each.name.upper(), pattern.upper())
        ]
        if not taken:
            raise ValueError(f'it holds no set with a name like {pattern!r}, of {catalogue}')
        words = [_word_of(each, catalogue) for each in taken]
        epoch_ns = max(checked(each).elements_ns for each in taken)
    except ValueError as error:
        raise ValueError(f'{path}: {error}') from error.__cause__
    # From where the new file is, whatever links lead there.
    name = ros_yaml.quoted(os.path.relpath(os.path.realpath(path), folder.resolve()))
    begin = epoch(-(-epoch_ns // SECOND_NS) * SECOND_NS)[:19]
    sections = [
        f'/{namespace}/satdyn:\n'
        '  ros__parameters:\n'
        f'    orbit: {{tle: [{name}, {ros_yaml.quoted(word)}]}}\n'
        for namespace, word in zip(_namespaces(taken), words, strict=True)
    ]
    written = (
        f'# Satellites on the element sets in {os.path.basename(path)}; each may have more keys\n'
        '# of its own, and /** those of all.  Tick 0 is just after the latest epoch of the sets.\n'
        '/**:\n'
        '  ros__parameters:\n'
        '    orbit: {type: tle}\n'
        f"    time: {{epoch: '{begin}Z'}}\n"
        f'{"".join(sections)}'
    )
    # What is too large to be read is not written.
    try:
        ParameterFile.of_texts([(written, str(output))], {str(output): folder})
    except ValueError as error:
        raise ValueError(
            f'a parameter file of {len(taken)} satellites cannot be read: {error}; --name '
            'chooses some of them'
        ) from None
    Path(output).write_text(written, encoding='utf-8')
    return len(taken)


def _word_of(wanted: ElementSet, catalogue: Catalogue) -> str:
    """Return by what a set is chosen; ValueError: nothing distinguishes it."""
    word = wanted.number or wanted.name
    if not word:
        raise ValueError(f'the set of line {wanted.line} has neither a number nor a name')
    catalogue.chosen(word)
    return word


def _namespaces(sets: Sequence[ElementSet]) -> list[str]:
    """Return the namespace of each: its name in small letters, with its number if it needs one."""
    names = [re.sub('[^a-z0-9]+', '_', each.name.lower()).strip('_') for each in sets]
    found: dict[str, None] = {}
    for name, each in zip(names, sets, strict=True):
        parts = [name, each.number if names.count(name) > 1 or not name else '']
        whole = '_'.join(part for part in parts if part) or f'line_{each.line}'
        whole = whole if whole[0].isalpha() else f'sat_{whole}'
        # Two names may differ in what a namespace cannot have.
        while whole in found:
            whole = f'{whole}_{each.line}'
        found[whole] = None
    return list(found)

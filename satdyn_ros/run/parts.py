"""
Parts of a catalogue: small parameter files, whose keys are laid under those that are given.

rotor.part, rotor.NAME.part, sensors.NAME.part, magnetorquer.part and thruster.NAME.part each name
one.  What a part says of `rotor`, of a sensor by its type, of `magnetorquer` or of `thruster` is
then said of the one that names it, where nothing else is.  A scenario has the values; the part is
as if it had not been given.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from ..base.sentences import nearest
from ..sensors import KINDS
from . import shipped
from .keys import KEYS
from .parameter_file import ParameterFile

# Of those that have names; of others the key is in the table.
_NAMES_ONE = re.compile(r'(rotor|sensors|thruster)\.\w+\.part', re.ASCII)


@dataclass(frozen=True)
class Part:
    """
    A part of the catalogue.

    Attributes
    ----------
    kind : str
        rotor, magnetorquer, thruster, or a type of sensors
    values : dict
        as in its file, by the last words of their keys
    says : str
        what it is and whose figures it has, in one line
    """

    kind: str
    values: Mapping[str, Any]
    says: str


@cache
def catalogue() -> dict[str, Part]:
    """Return the parts that are shipped, by name."""
    return {path.stem: _part(path) for path in shipped.paths('part')}


def _part(path):
    text = path.read_text(encoding='utf-8')
    values = ParameterFile.of_texts([(text, str(path))]).parameters('/satdyn')
    kind = next(iter(values)).removeprefix('sensors.').split('.')[0]
    says = text.partition('/**')[0].replace('# ', '').split()
    return Part(kind, {name.rpartition('.')[2]: x for name, x in values.items()}, ' '.join(says))


def names_one(key: str) -> bool:
    """Return whether a key is one that names a part."""
    return bool(_NAMES_ONE.fullmatch(key)) or (key in KEYS and key.endswith('.part'))


def named(given: Mapping[str, Any]) -> dict[str, str]:
    """Return the names of the parts that are given, by the keys that name them."""
    return {key: x for key, x in given.items() if isinstance(x, str) and x and names_one(key)}


def laid_under(given: Mapping[str, Any]) -> dict[str, Any]:
    """
    Return what is given, and what the parts that it names say of what is not.

    ValueError, in one sentence: there is no such part.
    """
    laid: dict[str, Any] = {}
    for key, name in named(given).items():
        owner = key.removesuffix('.part')
        part = _part_of(owner, name, given)
        laid |= {f'{owner}.{leaf}': value for leaf, value in part.values.items()}
        if part.kind in KINDS and owner != f'sensors.{part.kind}':
            laid[f'{owner}.type'] = part.kind
    return {**given, **{key: value for key, value in laid.items() if key not in given}}


def _part_of(owner, name, given):
    """Return the part of a name that fits what has it; a sensor may not have a type yet."""
    group, _, own_name = owner.partition('.')
    kind = group
    if group == 'sensors':
        kind = own_name if own_name in KINDS else given.get(f'{owner}.type', 'sensor')
    kinds = KINDS if kind == 'sensor' else (kind,)
    fitting = {each: part for each, part in catalogue().items() if part.kind in kinds}
    if name in fitting:
        return fitting[name]
    where = f' in {path.parent}' if (path := next(iter(shipped.paths('part')), None)) else ''
    hint = f'the nearest is {nearest(name, fitting)}' if fitting else 'there is none'
    raise ValueError(f'{owner}.part is {name!r}; it must be a part of a {kind}{where}; {hint}')

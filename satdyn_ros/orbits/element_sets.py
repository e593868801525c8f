"""
Mean elements as catalogues hand them around: two or three lines, or a CCSDS OMM, of one or many.

An Orbit Mean-Elements Message, 502.0-B, stands in keyword = value notation, in XML, or, as
CelesTrak and Space-Track serve it, in JSON or CSV with the keywords as names.
"""

import csv
import json
import re
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Iterator
from io import StringIO
from typing import Any, NamedTuple

from ..base.ndm_xml import is_xml, xml_elements

# What an OMM must say, where it says it, for its elements to be those of SGP4.
SGP4_MEANS = {
    'CENTER_NAME': ('EARTH',),
    'REF_FRAME': ('TEME',),
    'TIME_SYSTEM': ('UTC',),
    'MEAN_ELEMENT_THEORY': ('SGP4', 'SGP', 'SGP/SGP4'),
}
ELEMENTS = (
    'EPOCH',
    'MEAN_MOTION',
    'ECCENTRICITY',
    'INCLINATION',
    'RA_OF_ASC_NODE',
    'ARG_OF_PERICENTER',
    'MEAN_ANOMALY',
    'BSTAR',
)
_VERSION = 'CCSDS_OMM_VERS'
# What of a message is kept where one is chosen of many.
_KEPT = (
    *('OBJECT_NAME', 'OBJECT_ID', *SGP4_MEANS, *ELEMENTS),
    *('MEAN_MOTION_DOT', 'MEAN_MOTION_DDOT', 'EPHEMERIS_TYPE', 'CLASSIFICATION_TYPE'),
    *('NORAD_CAT_ID', 'ELEMENT_SET_NO', 'REV_AT_EPOCH'),
)
# The first of five digits may be a letter, without I and O, for numbers from 100000 on.
_LETTERS = 'ABCDEFGHJKLMNPQRSTUVWXYZ'
_MOST_SHOWN = 5
Pairs = list[tuple[str, str]]


class MeanElements(NamedTuple):
    """
    The mean elements of an OMM.

    Attributes
    ----------
    pairs : list of pairs of str
        keywords and values, units in brackets behind them
    line : int
        where it begins
    """

    pairs: Pairs
    line: int


class ElementSet(NamedTuple):
    """
    One of the sets of a file.

    Attributes
    ----------
    name : str
        of the satellite, empty: not given
    number : str
        in the catalogue, in decimals, empty: not given
    text : str
        the set alone, two lines or an OMM in keyword = value notation
    line : int
        where it begins
    """

    name: str
    number: str
    text: str
    line: int


class Catalogue:
    """The element sets of a text; ValueError: it has none, or is damaged, with the line."""

    def __init__(self, text: str):
        self.sets = list(_of_messages(messages(text)) if is_message(text) else _of_lines(text))
        if not self.sets:
            raise ValueError('it holds no element set')
        self._of_word: defaultdict[str, list[ElementSet]] = defaultdict(list)
        for each in self.sets:
            for word in {_as_number(each.number), each.name.upper()} - {''}:
                self._of_word[word].append(each)

    def __str__(self) -> str:
        return _shown(self.sets)

    def chosen(self, word: str) -> ElementSet:
        """
        Return the set of a satellite by its number in the catalogue, or by its name.

        ValueError: there is none, or more than one.
        """
        given = word.strip().upper()
        found = self._of_word.get(_as_number(given), []) or self._of_word.get(given, [])
        if len(found) == 1:
            return found[0]
        if found:
            numbers = {each.number for each in found}
            by = 'number' if len(numbers) == len(found) else 'file of one set each'
            raise ValueError(
                f'it holds {len(found)} sets of {word!r}, {_shown(found)}; use a {by}'
            )
        raise ValueError(f'it holds no set of {word!r}, but of {self}')


def is_message(text: str) -> bool:
    """Whether a text holds an OMM, in one of its notations, and not lines."""
    return is_xml(text) or _VERSION in text or _is_json(text) or _is_csv(text)


def messages(text: str) -> list[MeanElements]:
    """Return the messages in a text; ValueError: it is damaged, with the line."""
    if is_xml(text):
        return _of_xml(text)
    if _is_json(text):
        return _of_json(text)
    if _is_csv(text):
        return _of_csv(text)
    return _of_keywords(text)


def _is_json(text):
    return text.removeprefix('\ufeff').lstrip().startswith(('[', '{'))


def _is_csv(text):
    first = text.strip().partition('\n')[0]
    return ',' in first and 'MEAN_MOTION' in first


def _of_keywords(text):
    found: list[MeanElements] = []
    for number, line in enumerate(text.splitlines(), 1):
        keyword, is_assignment, value = (part.strip() for part in line.partition('='))
        if not is_assignment:
            continue
        if keyword == _VERSION or not found:
            found.append(MeanElements([], number))
        found[-1].pairs.append((keyword, value))
    return found


def _of_xml(text):
    elements = xml_elements(text)
    # Where there is no element of this name, all is one message.
    begin = 'omm' if any(each.tag == 'omm' for each in elements) else elements[0].tag
    found: list[MeanElements] = []
    for each in elements:
        if each.tag == begin:
            found.append(MeanElements([], each.line))
        if found:
            unit = f' [{each.attributes["units"]}]' if 'units' in each.attributes else ''
            found[-1].pairs.append((each.tag, f'{each.text}{unit}'))
    return found


class _Object(list[tuple[str, object]]):
    """What is between braces, its names in order and as often as they stand."""


# With the digits as they stand.
_DECODER = json.JSONDecoder(
    object_pairs_hook=_Object, parse_float=str, parse_int=str, parse_constant=str
)
_BLANKS: Any = re.compile('[ \t\r\n]*')


def _of_json(text):
    """Return those of an object, or of a list of objects."""
    text = text.removeprefix('\ufeff')
    breaks = [match.start() for match in re.finditer('\n', text)]
    found: list[MeanElements] = []
    is_list = text.lstrip().startswith('[')
    at = _BLANKS.match(text, _BLANKS.match(text).end() + is_list).end()
    is_over = is_list and text.startswith(']', at)
    while not is_over:
        line = bisect_left(breaks, at) + 1
        try:
            value, at = _DECODER.raw_decode(text, at)
        except json.JSONDecodeError as error:
            raise ValueError(f'line {error.lineno}: its JSON is damaged, {error.msg}') from None
        except RecursionError:
            raise ValueError(f'line {line}: its JSON is nested too deep') from None
        found.append(MeanElements(_pairs_of(value, line), line))
        at = _BLANKS.match(text, at).end()
        is_over = not is_list or text.startswith(']', at)
        if not is_over and not text.startswith(',', at):
            line = bisect_left(breaks, at) + 1
            raise ValueError(f'line {line}: its JSON is damaged, a comma or ] must follow')
        at = _BLANKS.match(text, at + (not is_over)).end()
    at = _BLANKS.match(text, at + is_list).end()
    if at < len(text):
        line = bisect_left(breaks, at) + 1
        raise ValueError(f'line {line}: its JSON is damaged, text follows its end')
    return found


def _pairs_of(value, line):
    """Return what an object of JSON says."""
    if not isinstance(value, _Object):
        raise ValueError(
            f'line {line}: its JSON must be an object with keywords, or a list of them'
        )
    pairs = []
    for keyword, each in value:
        if not isinstance(each, str | bool | None):
            raise ValueError(f'line {line}: {keyword} is a list or an object of JSON')
        pairs.append((keyword.strip(), '' if each is None else str(each).strip()))
    return pairs


def _of_csv(text):
    rows = csv.reader(StringIO(text.removeprefix('\ufeff').lstrip(), newline=''), strict=True)
    # Blank lines above the names of the columns count too.
    above = text[: len(text) - len(text.lstrip())].count('\n')
    found: list[MeanElements] = []
    try:
        names = [name.strip() for name in next(rows)]
        for row in rows:
            line = rows.line_num + above
            if not row:
                continue
            if len(row) != len(names):
                raise ValueError(f'line {line}: it has {len(row)} values for {len(names)} columns')
            pairs = zip(names, (value.strip() for value in row), strict=True)
            found.append(MeanElements(list(pairs), line))
    except csv.Error as error:
        raise ValueError(f'line {rows.line_num + above}: its CSV is damaged, {error}') from None
    return found


def _of_messages(found) -> Iterator[ElementSet]:
    for message in found:
        said = dict(message.pairs)
        # A value may go over several lines in XML.
        kept = [
            ' '.join(f'{keyword} = {value}'.split())
            for keyword, value in message.pairs
            if keyword in _KEPT and value
        ]
        text = '\n'.join([f'{_VERSION} = 3.0', *kept, ''])
        number = said.get('NORAD_CAT_ID', '')
        yield ElementSet(said.get('OBJECT_NAME', ''), _as_number(number), text, message.line)


def _of_lines(text) -> Iterator[ElementSet]:
    """Yield the pairs of lines of a text, a line of the name above or not."""
    name, first, begin = '', '', 0
    for number, line in enumerate(text.removeprefix('\ufeff').splitlines(), 1):
        line = line.rstrip()
        if not line or line.startswith('#'):
            continue
        if first:
            if not line.startswith('2 '):
                raise ValueError(f'line {number} must be the second of an element set')
            yield ElementSet(name, _as_number(first[2:7]), f'{first}\n{line}\n', begin)
            name, first = '', ''
        elif line.startswith('1 '):
            first, begin = line, number
        elif name or line.startswith('2 '):
            raise ValueError(f'line {number} must be the first of an element set')
        else:
            name = line.removeprefix('0 ').strip()
    if name or first:
        raise ValueError(f'line {number}: it ends within an element set')


def _as_number(text):
    """Return a number of the catalogue in decimals without zeros in front, empty: it is none."""
    text = text.strip()
    if len(text) == 5 and text[0] in _LETTERS:
        text = f'{_LETTERS.index(text[0]) + 10}{text[1:]}'
    return str(int(text)) if re.fullmatch('[0-9]{1,9}', text) else ''


def _shown(sets):
    names = [f'{each.number} {each.name}'.strip() or f'line {each.line}' for each in sets]
    more = f' and {len(names) - _MOST_SHOWN} more' if len(names) > _MOST_SHOWN else ''
    return f'{", ".join(names[:_MOST_SHOWN])}{more}'

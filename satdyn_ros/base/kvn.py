"""The keyword = value notation of the ephemeris messages of CCSDS, 502.0-B and 504.0-B."""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

# Names of the SANA registry for axes that do not turn; J2000 is what older files call EME2000.
INERTIAL_FRAMES = ('EME2000', 'GCRF', 'ICRF', 'J2000')

_HEADER = ('CLASSIFICATION', 'CREATION_DATE', 'ORIGINATOR', 'MESSAGE_ID')
# What a line is in, as a sentence calls it.
_IN_HEADER, _IN_METADATA, _BEFORE_ROWS, _IN_ROWS, _AFTER_ROWS, _IN_COVARIANCE = (
    'the header',
    'the metadata',
    'data without a row',
    'the data',
    'what follows the data',
    'a covariance',
)
# What each mark may stand in, and what begins with it.
_MARKS = {
    'META_START': ((_IN_HEADER, _IN_ROWS, _AFTER_ROWS), _IN_METADATA),
    'META_STOP': ((_IN_METADATA,), _BEFORE_ROWS),
    'DATA_START': ((_BEFORE_ROWS,), _BEFORE_ROWS),
    'DATA_STOP': ((_IN_ROWS,), _AFTER_ROWS),
    'COVARIANCE_START': ((_IN_ROWS, _AFTER_ROWS), _IN_COVARIANCE),
    'COVARIANCE_STOP': ((_IN_COVARIANCE,), _AFTER_ROWS),
}


class KvnMetadata(dict[str, str]):
    """The keywords of a segment; lines: where each stands, and META_START."""

    def __init__(self, line: int = 0):
        super().__init__()
        self.lines = {'META_START': line}

    def give(self, keyword: str, value: str, line: int) -> None:
        """Take the value of a keyword in a line; ValueError: it has one."""
        if keyword in self:
            raise ValueError(
                f'line {line}: {keyword} is given twice, before in line {self.lines[keyword]}'
            )
        self[keyword], self.lines[keyword] = value, line


class KvnRow(NamedTuple):
    """
    A row of data.

    Attributes
    ----------
    version : str
        of its message
    metadata : KvnMetadata
        the keywords of its segment, one and the same object for all its rows
    words : list of str
        of the row
    line : int
        where it stands
    """

    version: str
    metadata: KvnMetadata
    words: list[str]
    line: int


def kvn_rows(
    lines: Iterable[str], message: str, keyword: str, versions: Sequence[str]
) -> Iterator[KvnRow]:
    """
    Yield the rows of data of a message, whose first line gives its version by a keyword.

    Covariances are left out.

    Parameters
    ----------
    lines : iterable of str
        of the message
    message : str
        what a sentence calls it
    keyword : str
        of the first line
    versions : sequence of str
        those that are read

    Raises
    ------
    ValueError
        it is another message, or has a line where none of its kind may stand
    """
    version: str | None = None
    header, metadata, section = KvnMetadata(), KvnMetadata(), _IN_HEADER
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words or words[0] == 'COMMENT':
            continue
        word, is_assignment, value = (part.strip() for part in line.partition('='))
        if version is None:
            version = value
            if word != keyword or version not in versions:
                raise ValueError(
                    f'this is not an {message} in keyword = value notation, '
                    f'whose first line is {keyword} = {" or ".join(versions)}'
                )
        elif word in _MARKS and not is_assignment:
            within, begins = _MARKS[word]
            if section not in within:
                raise ValueError(f'line {number}: {word} stands in {section}')
            section = begins
            if section == _IN_METADATA:
                metadata = KvnMetadata(number)
        elif is_assignment and section in (_IN_HEADER, _IN_METADATA):
            if section == _IN_HEADER and word not in _HEADER:
                raise ValueError(f'line {number}: {word} is no keyword of the header')
            keywords = header if section == _IN_HEADER else metadata
            keywords.give(word, value, number)
        elif is_assignment and section != _IN_COVARIANCE:
            raise ValueError(f'line {number}: the keyword {word} stands in {section}')
        elif section in (_BEFORE_ROWS, _IN_ROWS):
            section = _IN_ROWS
            yield KvnRow(version, metadata, words, number)
        elif section != _IN_COVARIANCE:
            raise ValueError(f'line {number}: a row that begins with {words[0]} is in {section}')
    if section in (_IN_METADATA, _BEFORE_ROWS, _IN_COVARIANCE):
        raise ValueError(f'it ends within {section}')


def by_segment(rows: Iterable[KvnRow]) -> Iterator[list[KvnRow]]:
    """Yield the rows of each segment."""
    for _, group in groupby(rows, key=lambda row: id(row.metadata)):
        yield list(group)


def kvn_text(keyword: str, rows: Iterable[KvnRow]) -> str:
    """
    Return rows as a message in keyword = value notation, whose first line is of a keyword.

    What stands in a line, stands there in the text too, unless another does.
    """
    lines: list[str] = []

    def put(text, line):
        lines.extend([''] * (line - 1 - len(lines)))
        lines.append(' '.join(text.split()))

    metadata = None
    for row in rows:
        if not lines:
            put(f'{keyword} = {row.version}', 1)
        if row.metadata is not metadata:
            metadata = row.metadata
            put('META_START', metadata.lines['META_START'])
            for name, value in metadata.items():
                put(f'{name} = {value}', metadata.lines[name])
            put('META_STOP', 0)
        put(' '.join(row.words), row.line)
    return '\n'.join([*lines, ''])


def is_inertial(frame: str) -> bool:
    """
    Whether a name is one of INERTIAL_FRAMES, or a numbered realisation of one.

    >>> is_inertial('ICRF3'), is_inertial('ITRF2000')
    (True, False)
    """
    return frame in INERTIAL_FRAMES or re.sub('[0-9]+$', '', frame) in INERTIAL_FRAMES

"""The keyword = value notation of the ephemeris messages of CCSDS, 502.0-B and 504.0-B."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple


class KvnRow(NamedTuple):
    """
    A row of data, split into its words, with the version of its message.

    metadata: the keywords of its segment, one and the same object for all its rows.
    """

    version: str
    metadata: dict[str, str]
    words: list[str]


def kvn_rows(
    lines: Iterable[str], message: str, keyword: str, versions: Sequence[str]
) -> Iterator[KvnRow]:
    """
    Yield the rows of data of a message, whose first line gives its version by a keyword.

    message: what it is called in the sentence of a ValueError, which says that it is another.
    Covariances are left out.
    """
    version: str | None = None
    metadata: dict[str, str] = {}
    is_data = False
    for line in lines:
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
        elif word == 'META_START':
            metadata, is_data = {}, False
        elif is_assignment:
            metadata[word] = value
        elif word in ('META_STOP', 'DATA_START'):
            is_data = True
        elif word in ('DATA_STOP', 'COVARIANCE_START'):
            is_data = False
        elif is_data:
            yield KvnRow(version, metadata, words)

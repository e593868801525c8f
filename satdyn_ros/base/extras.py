"""Libraries that not every installation has."""

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def brought_by(extra: str, library: str) -> Iterator[None]:
    """
    Say of a library that is imported here which extra brings it, if it is not installed.

    ValueError: it is not.

    >>> with brought_by('plot', 'a-library'):
    ...     import a_library
    Traceback (most recent call last):
    ValueError: this needs a-library, which the extra `plot` brings: pip install a-library
    """
    try:
        yield
    except ImportError as error:
        raise ValueError(
            f'this needs {library}, which the extra `{extra}` brings: pip install {library}'
        ) from error

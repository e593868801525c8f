"""The sentence of a refusal: one line of bounded length, whose numbers do not hide its reason."""

from collections.abc import Generator, Iterable
from contextlib import suppress
from difflib import get_close_matches
from typing import Any

LONGEST_SENTENCE = 500
_LONGEST_NAME = 100
# Yields, check by check, whether it fails, of many things whether each fails it; raises
# ValueError, in one sentence, when the answer is that one does.
Checks = Generator[Any, Any, None]


def refuse(checks: Checks) -> None:
    """Raise the ValueError of the first check that one thing fails."""
    fails = None
    with suppress(StopIteration):
        while True:
            fails = checks.send(fails)


def one_sentence(reason: object) -> str:
    r"""
    Return the text of an error without line breaks and of at most LONGEST_SENTENCE characters.

    >>> one_sentence(ValueError('a\nb'))
    'a b'
    """
    text = ' '.join(str(reason).split())
    return text if len(text) <= LONGEST_SENTENCE else f'{text[: LONGEST_SENTENCE - 3]}...'


def written(number: float) -> str:
    """
    Return a number in six digits, or in all that it has.

    >>> written(0.1), written(3.000000003)
    ('0.1', '3.000000003')
    """
    return short if float(short := f'{number:g}') == number else repr(float(number))


def nearest(given: object, allowed: Iterable[str]) -> str:
    """
    Return the one of some names that is most like what was given.

    >>> nearest('body.dipol', ['body.box', 'body.dipole', 'rotor.mode'])
    'body.dipole'
    """
    # Longer than any name, what follows adds nothing and costs its square.
    (found,) = get_close_matches(str(given)[:_LONGEST_NAME], list(allowed), 1, cutoff=0.0)
    return found


def distinct_texts(*numbers: float) -> list[str]:
    """
    Return numbers in six digits, or in as many as show which of them differ.

    >>> distinct_texts(1.0000044, 1.0)
    ['1.000004', '1']
    """
    for digits in range(6, 18):
        texts = [f'{number:.{digits}g}' for number in numbers]
        if len(set(texts)) == len(set(numbers)):
            break
    return texts

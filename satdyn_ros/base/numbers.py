"""Numbers as files of other programs have them."""

import re

# Not what Python reads besides: underscores, the digits of other scripts, nan and inf.
_NUMBER = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?', re.ASCII)


def number(text: str) -> float | None:
    """
    Return the number that a text in ASCII is, or None if it is not a number.

    >>> number('-.5e-3'), number('1_000.0')
    (-0.0005, None)
    """
    return float(text) if _NUMBER.fullmatch(text) else None

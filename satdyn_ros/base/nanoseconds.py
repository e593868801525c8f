"""Stamps as UTC epochs: Unix time in integer nanoseconds to calendar text and back."""

import re
from collections.abc import Sequence
from datetime import datetime, timedelta, timezone
from decimal import ROUND_HALF_EVEN, Decimal

import numpy as np

_UNIX_EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)
SECOND_NS = 10**9
DAY_NS = 86_400 * SECOND_NS
# How far from 1970 stamps are: what 64 bits hold, less what other time systems are ahead of UTC.
FURTHEST_NS = 2**63 - 1 - DAY_NS

# The two forms of CCSDS 301.0-B-4, section 3.5: calendar date, and day of the year.
_EPOCH = re.compile(
    r'(?P<year>\d{4})-(?:(?P<month>\d\d)-(?P<day>\d\d)|(?P<day_of_year>\d{3}))'
    r'T(?P<hour>\d\d):(?P<minute>\d\d):(?P<second>\d\d)(?P<fraction>\.\d+)?Z?',
    re.ASCII,
)


def epoch(stamp_ns: int) -> str:
    """
    Return a stamp as an epoch with nine decimals.

    >>> epoch(1_500_000_000)
    '1970-01-01T00:00:01.500000000'
    """
    return epochs([stamp_ns])[0]


def epochs(stamps_ns: Sequence[int] | np.ndarray) -> list[str]:
    """Return stamps (N,) as epochs."""
    instants = np.asarray(stamps_ns, np.int64).view('datetime64[ns]')
    return np.datetime_as_string(instants, unit='ns').tolist()


def stamp_ns(text: str) -> int:
    """
    Return the stamp of an epoch in UTC, rounded to a nanosecond.

    text: '2026-01-31T12:00:00.25' or, by the day of the year, '2026-031T12:00:00.25'; a Z may
    follow.  ValueError: it is neither, or a leap second, which Unix time does not have, or of a
    year that stamps do not reach.

    >>> stamp_ns('1970-002T00:00:00')
    86400000000000
    """
    found = _EPOCH.fullmatch(text.strip())
    if found is None:
        raise ValueError(
            f'{text!r} is not an epoch; give UTC as 2026-01-31T12:00:00 or 2026-031T12:00:00, '
            'with decimals if needed'
        )
    if found['second'] == '60':
        raise ValueError(f'{text} is a leap second, which Unix time cannot express')
    try:
        if found['day_of_year']:
            day = timedelta(days=int(found['day_of_year']) - 1)
            date = datetime(int(found['year']), 1, 1) + day
            if date.year != int(found['year']):
                raise ValueError(f'the year has no day {found["day_of_year"]}')
        else:
            date = datetime(int(found['year']), int(found['month']), int(found['day']))
        whole = date.replace(
            hour=int(found['hour']),
            minute=int(found['minute']),
            second=int(found['second']),
            tzinfo=timezone.utc,
        )
    except ValueError as error:
        raise ValueError(f'{text} is not an epoch: {error}') from None
    nanoseconds = Decimal(found['fraction'] or 0) * SECOND_NS
    rounded = int(nanoseconds.to_integral_value(ROUND_HALF_EVEN))
    found_ns = (whole - _UNIX_EPOCH) // timedelta(seconds=1) * SECOND_NS + rounded
    if abs(found_ns) > FURTHEST_NS:
        raise ValueError(
            f'the epoch {text} is out of range; it must be between {epoch(-FURTHEST_NS)[:4]} and '
            f'{epoch(FURTHEST_NS)[:4]}'
        )
    return found_ns

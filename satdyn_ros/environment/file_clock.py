"""Epochs in files of other programs, in UTC, TAI or TT, and the uniform time that they are in."""

import re
from collections.abc import Sequence

import numpy as np

from ..base.nanoseconds import DAY_NS, SECOND_NS, stamp_ns
from .earth import TO_UTC, leap_seconds_between

_LEAP_SECOND = re.compile(r'(.*T\d\d:\d\d:)60((?:\.\d+)?Z?)', re.ASCII)
# What 64 bits can hold.
_LAST_NS = 2**63 - 1


class Time:
    """
    An epoch in a file.

    Attributes
    ----------
    text : str
        as it stands
    line : int
        where
    is_leap_second : bool
        whether its second is 60
    stamp_ns : ns
        the stamp that it would have, were it in UTC and no leap second

    Raises
    ------
    ValueError
        it is no epoch, or none that a stamp could have; with the line
    """

    def __init__(self, text: str, line: int):
        self.text, self.line = text, line
        found = _LEAP_SECOND.fullmatch(text) if ':60' in text else None
        self.is_leap_second = found is not None
        try:
            self.stamp_ns = stamp_ns(f'{found[1]}59{found[2]}' if found else text)
        except ValueError as error:
            raise ValueError(f'line {line}: {error}') from None


class Clock:
    """
    Gives times of a file in TAI, less what it is ahead of UTC at the begin of the file [ns].

    A leap second has a time of its own there, and no stamp.

    Parameters
    ----------
    system : str
        in which the file counts, a name of TO_UTC
    times : sequence of Time
        those of its rows
    """

    def __init__(self, system: str, times: Sequence[Time]):
        self._is_utc = system == 'UTC'
        first_ns = min(time.stamp_ns for time in times)
        last_ns = max(time.stamp_ns + time.is_leap_second * SECOND_NS for time in times)
        self._ahead_ns = 0
        if not self._is_utc:
            # A noon, which is in no leap second.
            first_ns = first_ns // DAY_NS * DAY_NS - DAY_NS // 2
            utc_ns = TO_UTC[system](np.array([first_ns, last_ns]))
            self._ahead_ns = first_ns - int(utc_ns[0])
            first_ns, last_ns = int(utc_ns[0]), int(utc_ns[1]) + SECOND_NS
        self._leaps = leap_seconds_between(first_ns, last_ns)

    def tai_ns(self, time: Time) -> int:
        """Return the instant of an epoch; ValueError: it is a leap second that was none."""
        if not self._is_utc:
            if time.is_leap_second:
                raise ValueError(f'line {time.line}: {time.text} is a leap second, and not in UTC')
            return time.stamp_ns - self._ahead_ns
        found = self.at_stamp(time.stamp_ns)
        if time.is_leap_second:
            following_ns = (time.stamp_ns // SECOND_NS + 1) * SECOND_NS
            if self._leaps.get(following_ns) != SECOND_NS:
                raise ValueError(f'line {time.line}: {time.text} is no leap second that there was')
            found += SECOND_NS
        return found

    def at_stamp(self, at_ns: int) -> int:
        """Return the instant of a stamp."""
        return at_ns + sum(step for after, step in self._leaps.items() if after <= at_ns)

    def stamp_ns(self, tai_ns: int) -> int:
        """Return the stamp of an instant, of one in a leap second the stamp that follows."""
        for after, step in self._leaps.items():
            if tai_ns >= after:
                tai_ns = max(after, tai_ns - step)
        return tai_ns

    def parts(self, first_ns: int, last_ns: int) -> list[tuple[int, int, int]]:
        """Return between two instants begin and end, by stamps, and by what TAI is ahead [ns]."""
        found, ahead_ns = [], 0
        begins = [(-_LAST_NS, 0), *self._leaps.items()]
        ends_ns = [*self._leaps, _LAST_NS]
        for (from_ns, step_ns), until_ns in zip(begins, ends_ns, strict=True):
            ahead_ns += step_ns
            begin_ns, end_ns = max(from_ns, first_ns - ahead_ns), min(until_ns, last_ns - ahead_ns)
            if begin_ns < end_ns:
                found.append((begin_ns, end_ns, ahead_ns))
        return found

"""
The orbit of an Orbit Ephemeris Message as runs of rules before 4 flew it, for their bags alone.

It was read without the checks of today and interpolated in UTC, in pieces of one length; of
segments that overlap the later one began where it did.
"""

from dataclasses import replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from ..base.kvn import KvnMetadata
from ..base.nanoseconds import SECOND_NS, stamp_ns
from ..environment.earth import TO_UTC
from .ephemeris import EphemerisOrbit, interpolation_of
from .interpolation import Span
from .pieces import PIECE_TURN, Piece, Stretch, fitted

_ENOUGH_M, _HALVED = 1e-4, 5


class EarlierEphemerisOrbit(EphemerisOrbit):
    """The orbit of the text of an OEM that a bag of rules before 4 has."""

    warning = None

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """The useable times."""
        made = [_span(metadata, rows, self.epoch_ns) for metadata, rows in _segments(self.text)]
        made.sort(key=lambda span: span.begin_s)
        # Where two have the same time, the later one counts.
        for i, (span, following) in enumerate(pairwise(made)):
            made[i] = replace(span, end_s=min(span.end_s, following.begin_s))
        return tuple(span for span in made if span.begin_s < span.end_s)


class _EarlierSpan(Span):
    """Rows in pieces of one length."""

    def stretches(self) -> tuple[Stretch, ...]:
        """Return the one stretch."""
        span_s, times_s = self.end_s - self.begin_s, self.interpolation.times_s
        fewest = max(1, int(np.ceil(span_s * self.fastest_rad_s / PIECE_TURN)))
        counts = {fewest * 2**n for n in range(_HALVED)}
        # Pieces that end at rows, the shortest of which are exact.
        inside = (times_s >= self.begin_s) & (times_s < self.end_s)
        steps = max(1, int(np.sum(inside)))
        rows_s = self.begin_s + span_s / steps * np.arange(steps)
        if np.allclose(times_s[times_s >= self.begin_s][:steps], rows_s, rtol=0.0, atol=1e-6):
            counts |= {count for count in range(fewest, steps + 1) if steps % count == 0}
        for count in sorted(counts):
            stretch = Stretch(self.begin_s, float(span_s / count), self.begin_s, self.end_s)
            if self._error_m(stretch) <= _ENOUGH_M:
                break
        return (stretch,)

    def _error_m(self, stretch):
        """Return how far the polynomials of some pieces are from the interpolation."""
        x, worst_m = np.linspace(-1.0, 1.0, 50), 0.0
        for number in np.unique(np.linspace(0, stretch.last, 9).astype(int)):
            piece = Piece(stretch, int(number))
            t_s = piece.begin_s + stretch.length_s * (x[1:-1] + 1.0) / 2.0
            true = self.interpolated(t_s)[:, :3]
            found = chebyshev.chebval(x[1:-1], fitted(self.interpolated)(piece)[:3].T).T
            worst_m = max(worst_m, float(np.max(np.abs(found - true))))
        return worst_m


def _segments(text):
    """Return metadata and rows, split into words, of each segment."""
    found: list[tuple[KvnMetadata, list[list[str]]]] = []
    metadata, is_data = KvnMetadata(), False
    for line in text.splitlines():
        words = line.split()
        if not words or words[0] == 'COMMENT':
            continue
        word, is_assignment, value = (part.strip() for part in line.partition('='))
        if word == 'META_START':
            metadata, is_data = KvnMetadata(), False
        elif is_assignment:
            metadata[word] = value
        elif word in ('META_STOP', 'DATA_START'):
            is_data = True
        elif word in ('DATA_STOP', 'COVARIANCE_START'):
            is_data = False
        elif is_data:
            if not found or found[-1][0] is not metadata:
                found.append((metadata, []))
            found[-1][1].append(words)
    return found


def _span(metadata, rows, epoch_ns):
    def seconds(epochs):
        to_utc = TO_UTC[metadata['TIME_SYSTEM'].upper()]
        return (to_utc(np.array([stamp_ns(text) for text in epochs])) - epoch_ns) / SECOND_NS

    times_s = seconds([row[0] for row in rows])
    table = 1e3 * np.array([[float(word) for word in row[1:7]] for row in rows])
    begin_s, end_s = (
        float(seconds([text])[0])
        for text in (
            metadata.get('USEABLE_START_TIME', rows[0][0]),
            metadata.get('USEABLE_STOP_TIME', rows[-1][0]),
        )
    )
    r, v = table[:, :3], table[:, 3:]
    rates = np.linalg.norm(np.cross(r, v), axis=1) / np.sum(r * r, axis=1)
    return _EarlierSpan(
        interpolation_of(metadata, times_s, table),
        max(begin_s, float(times_s[0])),
        min(end_s, float(times_s[-1])),
        0.0,
        float(np.max(rates)),
    )

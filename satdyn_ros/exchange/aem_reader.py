"""
Attitudes from a CCSDS Attitude Ephemeris Message, 504.0-B, at its rows and between them.

Versions 1.0 and 2.0, in keyword = value notation and in XML.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..base.kvn import KvnRow, by_segment, kvn_rows
from ..base.nanoseconds import SECOND_NS, epoch, stamp_ns
from ..base.ndm_xml import is_xml, xml_rows
from ..base.regular_file import regular_file
from ..environment.file_clock import Clock, Time
from ..kernel import rotation
from .aem_types import NUMBER_NAMES, Meaning

_VERSIONS = ('1.0', '2.0')
_HIGHEST_DEGREE = 99


@dataclass(frozen=True)
class Attitude:
    """
    An attitude in an AEM.

    Attributes
    ----------
    stamp_ns : ns
        Unix time
    q_ib : (4,), x, y, z, w
        body to inertial
    omega_bi_b : (3,), rad/s, body axes, or None
        where the file has rates
    """

    stamp_ns: int
    q_ib: np.ndarray
    omega_bi_b: np.ndarray | None


class AttitudeFile:
    """
    The attitudes in an AEM.

    Between an inertial frame and SC_BODY, in either direction.  Between rows, in TAI, it is as
    INTERPOLATION_METHOD says, without it a steady turn (slerp), the rates along a line; where the
    file has rates, of the turns that lead to the next row the one that they mean.  ValueError: the
    file is none, or has what is not read; with file and line.
    """

    def __init__(self, path: str | Path):
        self.path = path
        with open(regular_file(path), encoding='utf-8-sig', errors='replace') as file:
            text = file.read()
        try:
            self._segments = [_Segment(rows) for rows in by_segment(_rows(text))]
        except ValueError as error:
            raise ValueError(f'{path}: {error}') from None
        if not self._segments:
            raise ValueError(f'{path} has no attitudes')

    def at(self, at_ns: int) -> Attitude:
        """
        Return the attitude at a stamp; where two segments meet, the later's.

        ValueError: it is in no segment, or outside its useable time; then the nearest row is
        named.
        """
        q_ib, omega_bi_b, has_rates = self._at(at_ns)
        return Attitude(at_ns, q_ib, omega_bi_b if has_rates else None)

    def motion_at(self, at_ns: int) -> tuple[np.ndarray, np.ndarray]:
        """
        Return q_ib (4,) and omega_bi_b (3,) [rad/s] at a stamp; ValueError: as of at.

        Where the file has no rates, that of the interpolation.
        """
        q_ib, omega_bi_b, _ = self._at(at_ns)
        return q_ib, omega_bi_b

    def attitudes(self, stamps_ns: np.ndarray) -> np.ndarray:
        """Return q_ib (N, 4) at stamps (N,), nan where the file has none; ValueError: as of at."""
        found = np.full((len(stamps_ns), 4), np.nan)
        for row, at_ns in enumerate(stamps_ns.tolist()):
            if any(each.holds(at_ns) for each in self._segments):
                found[row] = self._at(at_ns)[0]
        return found

    def _at(self, at_ns):
        inside = [each for each in self._segments if each.begin_ns <= at_ns <= each.end_ns]
        useable = [each for each in inside if each.holds(at_ns)]
        if useable:
            segment = useable[-1]
            try:
                return *segment.at(at_ns), segment.has_rates
            except ValueError as error:
                raise ValueError(f'{self.path}: {error}') from None
        if inside:
            raise ValueError(
                f'{self.path}: the attitude at {epoch(at_ns)} is outside the useable time of its '
                f'segment, {inside[-1].useable}'
            )
        ends_ns = [ns for each in self._segments for ns in (each.begin_ns, each.end_ns)]
        nearest_ns = min(ends_ns, key=lambda ns: abs(ns - at_ns))
        raise ValueError(
            f'{self.path} has no attitude at {epoch(at_ns)}; the nearest is {epoch(nearest_ns)}'
        )


def attitude_at(path: str | Path, epoch_text: str) -> Attitude:
    """Return the attitude of an AEM at an epoch in UTC; ValueError: see AttitudeFile."""
    return AttitudeFile(path).at(stamp_ns(epoch_text))


class _Segment:
    """
    The rows of a segment, as attitudes.

    begin_ns, end_ns: stamps of the first and the last.  has_rates: whether they have rates.
    """

    def __init__(self, rows: Sequence[KvnRow]):
        self._metadata = rows[0].metadata
        how = Meaning(self._metadata, rows[0].version)
        times = [Time(row.words[0], row.line) for row in rows]
        self._clock = Clock(how.time_system, times)
        tai_ns = [self._clock.tai_ns(time) for time in times]
        for row, (before_ns, after_ns) in zip(rows[1:], pairwise(tai_ns), strict=True):
            if after_ns <= before_ns:
                raise ValueError(
                    f'line {row.line}: the row at {row.words[0]} is not later than the one before'
                )
        self._tai_ns = np.array(tai_ns, np.int64)
        self.begin_ns, self.end_ns = map(self._clock.stamp_ns, (tai_ns[0], tai_ns[-1]))
        # A last row in a leap second is before the stamp that follows on it.
        self.end_ns -= self._clock.at_stamp(self.end_ns) > tai_ns[-1]
        self._first_ns, self._last_ns = map(
            self._said, ('USEABLE_START_TIME', 'USEABLE_STOP_TIME')
        )
        q_ib, omega_bi_b = how.attitudes(np.array([how.numbers(row) for row in rows]), rows)
        # The nearer one of the two that are the same attitude.
        is_opposite = np.sum(q_ib[1:] * q_ib[:-1], axis=-1) < 0.0
        q_ib[1:] *= np.where(np.cumsum(is_opposite) % 2, -1.0, 1.0)[:, None]
        self.has_rates = omega_bi_b is not None
        self._q_ib = q_ib
        self._omega_bi_b = np.zeros((len(q_ib), 3)) if omega_bi_b is None else omega_bi_b

    def _said(self, keyword):
        """Return the stamp that a keyword gives, None: there is none."""
        if keyword not in self._metadata:
            return None
        time = Time(self._metadata[keyword], self._metadata.lines[keyword])
        return self._clock.stamp_ns(self._clock.tai_ns(time))

    def holds(self, at_ns: int) -> bool:
        """Whether a stamp is between its rows, and in USEABLE_START_TIME to USEABLE_STOP_TIME."""
        first_ns = self.begin_ns if self._first_ns is None else self._first_ns
        last_ns = self.end_ns if self._last_ns is None else self._last_ns
        return max(self.begin_ns, first_ns) <= at_ns <= min(self.end_ns, last_ns)

    @property
    def useable(self) -> str:
        """The useable time in words."""
        begin = '' if self._first_ns is None else f'from {epoch(self._first_ns)}'
        end = '' if self._last_ns is None else f'to {epoch(self._last_ns)}'
        return f'{begin} {end}'.strip()

    def at(self, at_ns: int) -> tuple[np.ndarray, np.ndarray]:
        """Return attitude and rate at a stamp between the first row and the last."""
        at_ns = self._clock.at_stamp(at_ns)
        i = int(np.searchsorted(self._tai_ns, at_ns, side='right')) - 1
        if self.has_rates and self._tai_ns[i] == at_ns:
            return self._q_ib[i], self._omega_bi_b[i]
        if len(self._tai_ns) == 1:
            return self._q_ib[0], np.zeros(3)
        method, window = self._method()
        i = min(i, len(self._tai_ns) - 2)
        if method == 'LINEAR':
            return self._turned(i, at_ns)
        first = min(max(0, i + 1 - window // 2), len(self._tai_ns) - window)
        return self._on_polynomial(slice(first, first + window), at_ns, method == 'HERMITE')

    def _method(self):
        """Return INTERPOLATION_METHOD and of how many rows it is; ValueError: we have it not."""
        lines = self._metadata.lines
        method = self._metadata.get('INTERPOLATION_METHOD', 'LINEAR').upper()
        if method in ('LINEAR', 'SLERP'):
            return 'LINEAR', 2
        if method not in ('LAGRANGE', 'HERMITE'):
            raise ValueError(
                f'line {lines["INTERPOLATION_METHOD"]}: INTERPOLATION_METHOD is {method}; '
                'supported: LINEAR, LAGRANGE and HERMITE'
            )
        text = self._metadata.get('INTERPOLATION_DEGREE', '')
        if not re.fullmatch('0*[1-9][0-9]?', text):
            line = lines.get('INTERPOLATION_DEGREE', lines['INTERPOLATION_METHOD'])
            raise ValueError(
                f'line {line}: INTERPOLATION_DEGREE is {text or "not given"}; with {method} it '
                f'must be a whole number from 1 to {_HIGHEST_DEGREE}'
            )
        # Without slopes Hermite's polynomial is Lagrange's.
        method = method if self.has_rates else 'LAGRANGE'
        degree = int(text)
        # Hermite's polynomial through n rows has the degree 2 n - 1.
        window = max(2, degree // 2 + 1 if method == 'HERMITE' else degree + 1)
        if window > len(self._tai_ns):
            raise ValueError(
                f'line {lines["META_START"]}: a segment has {len(self._tai_ns)} rows; '
                f'interpolation of degree {degree} needs {window}'
            )
        return method, window

    def _turned(self, i, at_ns):
        """Return attitude and rate on the way from a row to the next by a steady turn."""
        step_s = (self._tai_ns[i + 1] - self._tai_ns[i]) / SECOND_NS
        part = (at_ns - self._tai_ns[i]) / (self._tai_ns[i + 1] - self._tai_ns[i])
        before, after = self._q_ib[i], self._q_ib[i + 1]
        turn = rotation.to_vector(rotation.multiply(rotation.conjugate(before), after))
        rate = turn / step_s
        if self.has_rates:
            rates = self._omega_bi_b[i : i + 2]
            angle = np.linalg.norm(turn)
            # Whole turns more, which rows do not show.
            along = turn / angle if angle else rates[0] / (np.linalg.norm(rates[0]) or 1.0)
            more = np.sum(rates, axis=0) / 2.0 * step_s @ along - angle
            turn = turn + 2.0 * np.pi * np.rint(more / (2.0 * np.pi)) * along
            rate = rates[0] + part * (rates[1] - rates[0])
        q_ib = rotation.multiply(before, rotation.from_vector(part * turn))
        return rotation.normalise(q_ib), rate

    def _on_polynomial(self, rows, at_ns, is_hermite):
        """Return attitude and rate on the polynomial of the components through some rows."""
        from scipy.interpolate import KroghInterpolator

        times_s = (self._tai_ns[rows] - at_ns) / SECOND_NS
        q_ib = self._q_ib[rows]
        if is_hermite:
            spin = np.hstack([self._omega_bi_b[rows], np.zeros((len(q_ib), 1))])
            slopes = rotation.multiply(q_ib, spin) / 2.0
            through = KroghInterpolator(
                np.repeat(times_s, 2), np.stack([q_ib, slopes], axis=1).reshape(-1, 4)
            )
        else:
            through = KroghInterpolator(times_s, q_ib)
        q, slope = through(0.0), through.derivative(0.0)
        rate = 2.0 * rotation.multiply(rotation.conjugate(q), slope)[:3] / (q @ q)
        if self.has_rates and not is_hermite:
            rate = KroghInterpolator(times_s, self._omega_bi_b[rows])(0.0)
        return rotation.normalise(q), rate


def _rows(text):
    """Yield the rows of a message in either notation."""
    if not is_xml(text):
        lines = StringIO(text)
        yield from kvn_rows(lines, 'Attitude Ephemeris Message', 'CCSDS_AEM_VERS', _VERSIONS)
        return
    for row in xml_rows(text, 'aem', _VERSIONS, 'attitudeState', NUMBER_NAMES):
        # There the names say which is the scalar.
        row.metadata['QUATERNION_TYPE'] = 'LAST'
        yield row

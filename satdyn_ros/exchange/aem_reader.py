"""
Attitudes from a CCSDS Attitude Ephemeris Message, 504.0-B, at its rows and between them.

Versions 1.0 and 2.0, in keyword = value notation and in XML.  A row gives the rotation that takes
the axes of one frame to those of another, of which one is inertial and one the body.  Its rates,
whatever they are in the file, become the body rate; those of Euler's angles, which version 1.0 has
as QUATERNION/RATE and EULER_ANGLE/RATE, by the rotations of EULER_ROT_SEQ, whatever RATE_FRAME.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import StringIO
from itertools import pairwise
from pathlib import Path

import numpy as np

from ..base.kvn import INERTIAL_FRAMES, KvnMetadata, KvnRow, is_inertial, kvn_rows
from ..base.nanoseconds import SECOND_NS, epoch, stamp_ns
from ..base.ndm_xml import is_xml, xml_rows
from ..base.numbers import number
from ..base.regular_file import regular_file
from ..kernel import rotation
from .euler_turns import angles_of, spin_of, turns

_VERSIONS = ('1.0', '2.0')
# How many numbers follow the epoch in the rows of each type.
_LENGTHS = {
    'QUATERNION': 4,
    'QUATERNION/DERIVATIVE': 8,
    'QUATERNION/RATE': 7,
    'QUATERNION/ANGVEL': 7,
    'EULER_ANGLE': 3,
    'EULER_ANGLE/RATE': 6,
    'EULER_ANGLE/DERIVATIVE': 6,
    'EULER_ANGLE/ANGVEL': 6,
    'SPIN': 4,
}
# The same numbers in the order of a row, by their names in XML.
_NAMES = tuple(
    name.format(i)
    for name, places in (
        ('Q{}', '123C'),
        ('Q{}_DOT', '123C'),
        ('ANGLE_{}', '123'),
        ('ANGLE_{}_DOT', '123'),
        ('ANGVEL_{}', 'XYZ'),
        ('SPIN_{}', ('ALPHA', 'DELTA', 'ANGLE', 'ANGLE_VEL')),
    )
    for i in places
)
# What 2.0 means by itself, and keywords of 1.0 say.
_MEANT = {'ATTITUDE_DIR': 'A2B', 'QUATERNION_TYPE': 'LAST'}
_OTHERWISE = {'ATTITUDE_DIR': 'B2A', 'QUATERNION_TYPE': 'FIRST'}
# Printed with a few digits a quaternion is not quite of length 1; further off it is a mistake.
_NORM_ERROR = 1e-3
_SEQUENCE = re.compile('(?!.*(.)\\1)[XYZ]{3}')
_HIGHEST_DEGREE = 99


@dataclass(frozen=True)
class Attitude:
    """An attitude q_ib (4,), and omega_bi_b (3,) [rad/s] where the file has rates."""

    stamp_ns: int
    q_ib: np.ndarray
    omega_bi_b: np.ndarray | None


class AttitudeFile:
    """
    The attitudes in an AEM.

    UTC, between an inertial frame and SC_BODY in either direction.  Between rows it is as
    INTERPOLATION_METHOD says, without it a steady turn (slerp), the rates along a line; where the
    file has rates, of the turns that lead to the next row the one that they mean.  ValueError: the
    file is none, or has what is not read; with file and line.
    """

    def __init__(self, path: str | Path):
        self.path = path
        with open(regular_file(path), encoding='utf-8-sig', errors='replace') as file:
            text = file.read()
        try:
            self._segments = [_Segment(rows) for rows in _rows_by_segment(text)]
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
        how = _Meaning(self._metadata, rows[0].version)
        self._first_ns, self._last_ns = (
            _stamp(self._metadata[keyword], self._metadata.lines[keyword])
            if keyword in self._metadata
            else None
            for keyword in ('USEABLE_START_TIME', 'USEABLE_STOP_TIME')
        )
        stamps = [_stamp(row.words[0], row.line) for row in rows]
        for row, (before_ns, after_ns) in zip(rows[1:], pairwise(stamps), strict=True):
            if after_ns <= before_ns:
                raise ValueError(
                    f'line {row.line}: the row at {row.words[0]} is not later than the one before'
                )
        self._stamps_ns = np.array(stamps, np.int64)
        self.begin_ns, self.end_ns = stamps[0], stamps[-1]
        q_ib, omega_bi_b = how.attitudes(np.array([how.numbers(row) for row in rows]), rows)
        # The nearer one of the two that are the same attitude.
        is_opposite = np.sum(q_ib[1:] * q_ib[:-1], axis=-1) < 0.0
        q_ib[1:] *= np.where(np.cumsum(is_opposite) % 2, -1.0, 1.0)[:, None]
        self.has_rates = omega_bi_b is not None
        self._q_ib = q_ib
        self._omega_bi_b = np.zeros((len(q_ib), 3)) if omega_bi_b is None else omega_bi_b

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
        i = int(np.searchsorted(self._stamps_ns, at_ns, side='right')) - 1
        if self.has_rates and self._stamps_ns[i] == at_ns:
            return self._q_ib[i], self._omega_bi_b[i]
        if len(self._stamps_ns) == 1:
            return self._q_ib[0], np.zeros(3)
        method, window = self._method()
        i = min(i, len(self._stamps_ns) - 2)
        if method == 'LINEAR':
            return self._turned(i, at_ns)
        first = min(max(0, i + 1 - window // 2), len(self._stamps_ns) - window)
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
        if method == 'HERMITE' and not self.has_rates:
            raise ValueError(
                f'line {lines["INTERPOLATION_METHOD"]}: INTERPOLATION_METHOD is HERMITE, which '
                'needs rates, and ATTITUDE_TYPE has none'
            )
        degree = int(text)
        # Hermite's polynomial through n rows has the degree 2 n - 1.
        window = max(2, degree // 2 + 1 if method == 'HERMITE' else degree + 1)
        if window > len(self._stamps_ns):
            raise ValueError(
                f'line {lines["META_START"]}: a segment has {len(self._stamps_ns)} rows; '
                f'interpolation of degree {degree} needs {window}'
            )
        return method, window

    def _turned(self, i, at_ns):
        """Return attitude and rate on the way from a row to the next by a steady turn."""
        step_s = (self._stamps_ns[i + 1] - self._stamps_ns[i]) / SECOND_NS
        part = (at_ns - self._stamps_ns[i]) / (self._stamps_ns[i + 1] - self._stamps_ns[i])
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

        times_s = (self._stamps_ns[rows] - at_ns) / SECOND_NS
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


class _Meaning:
    """What the metadata of a segment say of its rows."""

    def __init__(self, metadata: KvnMetadata, version: str):
        self._metadata = metadata
        value = self._value
        self._type = value('ATTITUDE_TYPE').replace(' ', '_')
        if self._type not in _LENGTHS:
            self._refuse('ATTITUDE_TYPE', self._type, f'supported: {", ".join(_LENGTHS)}')
        if value('TIME_SYSTEM') != 'UTC':
            self._refuse('TIME_SYSTEM', value('TIME_SYSTEM'), 'only UTC is supported')
        frames = value('REF_FRAME_A'), value('REF_FRAME_B')
        are_body = [frame.startswith('SC_BODY') for frame in frames]
        if sum(are_body) != 1 or not is_inertial(frames[are_body.index(False)]):
            self._refuse(
                'REF_FRAME_A',
                f'{frames[0]} and REF_FRAME_B {frames[1]}',
                f'supported: SC_BODY and one of {", ".join(INERTIAL_FRAMES)}',
            )
        is_otherwise = dict.fromkeys(_MEANT, False)
        has_quaternion = self._type.startswith('QUATERNION')
        for keyword in (
            ('ATTITUDE_DIR', 'QUATERNION_TYPE') if has_quaternion else ('ATTITUDE_DIR',)
        ):
            meant = _MEANT[keyword]
            # 2.0 does not have it; left over from a file of 1.0 it may say the same.
            given = value(keyword, meant if version == '2.0' else None)
            allowed = (meant, _OTHERWISE[keyword]) if version == '1.0' else (meant,)
            if given not in allowed:
                self._refuse(
                    keyword,
                    given,
                    f'in version {version} it must be {" or ".join(allowed)}'
                    f'{"" if version == "1.0" else ", or better left out"}',
                )
            is_otherwise[keyword] = given != meant
        self._scalar_first = is_otherwise['QUATERNION_TYPE']
        self._is_to_body = are_body[1] != is_otherwise['ATTITUDE_DIR']
        self._body_is_b = are_body[1]
        if self._type == 'SPIN' and not self._is_to_body:
            self._refuse(
                'ATTITUDE_TYPE', 'SPIN', 'it is defined from an inertial frame to SC_BODY alone'
            )
        self._sequence = ''
        if self._type.startswith('EULER') or self._type == 'QUATERNION/RATE':
            given = value('EULER_ROT_SEQ')
            self._sequence = given.translate(str.maketrans('123', 'XYZ'))
            if not _SEQUENCE.fullmatch(self._sequence) or len(set(self._sequence)) == 1:
                self._refuse('EULER_ROT_SEQ', given, 'it must be three axes, such as ZYX or 321')
        if self._type.endswith('/ANGVEL'):
            self._rate_in_body = self._frame_of_rates(frames) == frames[are_body.index(True)]

    def _value(self, keyword, default=None):
        if keyword not in self._metadata and default is None:
            line = self._metadata.lines['META_START']
            raise ValueError(f'line {line}: a segment has no {keyword}')
        return self._metadata.get(keyword, default).upper()

    def _refuse(self, keyword, given, allowed):
        line = self._metadata.lines.get(keyword, self._metadata.lines['META_START'])
        raise ValueError(f'line {line}: {keyword} is {given}; {allowed}')

    def _frame_of_rates(self, frames):
        names = {'REF_FRAME_A': frames[0], 'REF_FRAME_B': frames[1]}
        given = self._value('ANGVEL_FRAME')
        frame = names.get(given, given)
        if frame not in frames:
            self._refuse('ANGVEL_FRAME', frame, 'which is not a frame of its segment')
        of_old = names.get(self._value('RATE_FRAME', frame), self._value('RATE_FRAME', frame))
        if of_old != frame:
            self._refuse(
                'ANGVEL_FRAME',
                f'{frame} and RATE_FRAME, of version 1.0, {of_old}',
                'they must be the same',
            )
        return frame

    def numbers(self, row: KvnRow) -> list[float]:
        """Return the numbers of a row; ValueError: it does not have them."""
        found = [number(word) for word in row.words[1:]]
        count = _LENGTHS[self._type]
        if len(found) != count or not all(x is not None and np.isfinite(x) for x in found):
            raise ValueError(
                f'line {row.line}: the row at {row.words[0]} does not hold {count} numbers'
            )
        return [float(x) for x in found if x is not None]

    def attitudes(
        self, numbers: np.ndarray, rows: Sequence[KvnRow]
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """
        Return q_ib (N, 4) and omega_bi_b (N, 3) [rad/s] of numbers (N, M); None: without rates.

        ValueError: a quaternion is not of length 1.
        """
        # q takes the axes of one frame to those of another, and spin is the rate of the latter
        # relative to the former, in the axes of the latter.
        spin = None
        if self._type == 'SPIN':
            # Right ascension and declination of the body's z axis, and the angle about it.
            alpha, delta, angle, rate = np.radians(numbers).T
            angles = np.stack([alpha + np.pi / 2, np.pi / 2 - delta, angle], axis=-1)
            q, _ = turns('ZXZ', angles)
            spin = np.stack([0.0 * rate, 0.0 * rate, rate], axis=-1)
        elif self._type.startswith('EULER'):
            angles = np.radians(numbers[:, :3])
            q, _ = turns(self._sequence, angles)
            if self._type in ('EULER_ANGLE/RATE', 'EULER_ANGLE/DERIVATIVE'):
                spin = spin_of(self._sequence, angles, np.radians(numbers[:, 3:]))
        else:
            q = self._scalar_last(numbers[:, :4])
            length = np.linalg.norm(q, axis=-1)
            is_wrong = np.abs(length - 1.0) > _NORM_ERROR
            if np.any(is_wrong):
                row = rows[int(np.argmax(is_wrong))]
                raise ValueError(
                    f'line {row.line}: the quaternion at {row.words[0]} is not of length 1'
                )
            if self._type == 'QUATERNION/DERIVATIVE':
                slope = self._scalar_last(numbers[:, 4:]) / length[:, None]
                spin = 2.0 * rotation.multiply(rotation.conjugate(q), slope)[:, :3]
                spin /= length[:, None]
            q = rotation.normalise(q)
            if self._type == 'QUATERNION/RATE':
                angles = angles_of(self._sequence, q)
                spin = spin_of(self._sequence, angles, np.radians(numbers[:, 4:]))
        q_ib = q if self._is_to_body else rotation.conjugate(q)
        if spin is not None:
            return q_ib, spin if self._is_to_body else -rotation.rotate(q, spin)
        if not self._type.endswith('/ANGVEL'):
            return q_ib, None
        # The rate of frame B relative to frame A.
        omega = np.radians(numbers[:, -3:]) * (1.0 if self._body_is_b else -1.0)
        if not self._rate_in_body:
            omega = rotation.rotate(rotation.conjugate(q_ib), omega)
        return q_ib, omega

    def _scalar_last(self, numbers):
        return np.roll(numbers, -1, axis=-1) if self._scalar_first else numbers


def _stamp(text, line):
    try:
        return stamp_ns(text)
    except ValueError as error:
        raise ValueError(f'line {line}: {error}') from None


def _rows_by_segment(text: str) -> Iterator[list[KvnRow]]:
    """Yield the rows of each segment of a message."""
    if is_xml(text):
        rows = xml_rows(text, 'aem', _VERSIONS, 'attitudeState', _NAMES)
    else:
        rows = kvn_rows(StringIO(text), 'Attitude Ephemeris Message', 'CCSDS_AEM_VERS', _VERSIONS)
    found: list[KvnRow] = []
    for row in rows:
        if is_xml(text):
            # There the names tell which is the scalar.
            row.metadata['QUATERNION_TYPE'] = 'LAST'
        if found and row.metadata is not found[0].metadata:
            yield found
            found = []
        found.append(row)
    if found:
        yield found

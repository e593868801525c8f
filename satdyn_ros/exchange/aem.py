"""
The CCSDS Attitude Ephemeris Message, 504.0-B, in keyword = value notation.

Attitudes alone are written in version 1.0, which every reader knows; with body rates it is 2.0,
since 1.0 has rates of Euler's angles alone.

Its quaternion gives the rotation that takes the axes of REF_FRAME_A to those of REF_FRAME_B,
vector part first.  With the inertial frame as A and the body as B these are the numbers of q_ib.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import numpy as np

from ..base.kvn import INERTIAL_FRAMES, is_inertial, kvn_rows
from ..base.nanoseconds import epoch, stamp_ns
from ..base.numbers import number
from ..base.regular_file import regular_file
from ..kernel import rotation
from .ccsds import SegmentWriter, Subject

BODY = 'SC_BODY_1'
# How many numbers follow the epoch in the rows of each type that we read.
_LENGTHS = {'QUATERNION': 4, 'QUATERNION/ANGVEL': 7}
_VERSIONS = ('1.0', '2.0')
# What 2.0 means by itself, and keywords of 1.0 say.
_MEANT = {'ATTITUDE_DIR': 'A2B', 'QUATERNION_TYPE': 'LAST'}
_OTHERWISE = {'ATTITUDE_DIR': 'B2A', 'QUATERNION_TYPE': 'FIRST'}
# Printed with a few digits a quaternion is not quite of length 1; further off it is a mistake.
_NORM_ERROR = 1e-3


class AemWriter:
    """Attitudes, with with_rates also body rates, as an AEM; see SegmentWriter."""

    def __init__(self, file: TextIO, subject: Subject, with_rates: bool = False):
        version = '2.0' if with_rates else '1.0'
        metadata = {
            'OBJECT_NAME': subject.object_name,
            'OBJECT_ID': 'UNKNOWN',
            'CENTER_NAME': subject.center,
            'REF_FRAME_A': subject.frame,
            'REF_FRAME_B': BODY,
            **({} if with_rates else {'ATTITUDE_DIR': _MEANT['ATTITUDE_DIR']}),
            'TIME_SYSTEM': 'UTC',
            'START_TIME': '',
            'STOP_TIME': '',
        }
        comments = [
            f'Rotation of the axes of {subject.frame} (A) to those of {BODY} (B): '
            'v_A = q v_B q*, scalar last.'
        ]
        if with_rates:
            metadata |= {'ATTITUDE_TYPE': 'QUATERNION/ANGVEL', 'ANGVEL_FRAME': BODY}
            comments.append('Angular velocity of B relative to A, in axes of B [deg/s].')
        else:
            metadata['ATTITUDE_TYPE'] = 'QUATERNION'
            metadata['QUATERNION_TYPE'] = _MEANT['QUATERNION_TYPE']
        self._with_rates = with_rates
        self._segments = SegmentWriter(
            file, f'CCSDS_AEM_VERS = {version}', comments, metadata, data_marks=True
        )

    def write(self, stamps_ns: np.ndarray, q_ib: np.ndarray, omega_bi_b: np.ndarray) -> None:
        """Append rows: stamps (N,), attitudes (N, 4) and body rates (N, 3) [rad/s]."""
        values = np.hstack([q_ib, np.degrees(omega_bi_b)]) if self._with_rates else q_ib
        self._segments.write(stamps_ns, values)

    def end_segment(self) -> None:
        """End the segment, where the motion restarts and at the end."""
        self._segments.end_segment()


@dataclass(frozen=True)
class Attitude:
    """An attitude q_ib (4,), and omega_bi_b (3,) [rad/s] where the file has rates."""

    stamp_ns: int
    q_ib: np.ndarray
    omega_bi_b: np.ndarray | None


def attitude_at(path: str | Path, epoch_text: str) -> Attitude:
    """
    Return the attitude in the row of an AEM at an epoch; where two segments meet, the later's.

    Versions 1.0 (504.0-B-1) and 2.0 (504.0-B-2) in keyword = value notation, in UTC, between an
    inertial frame and SC_BODY in either direction.  ValueError: the file is not one, or has no
    useable row at that epoch; then the nearest one is named.
    """
    wanted_ns = stamp_ns(epoch_text)
    found, nearest_ns, unuseable = None, None, None
    with open(regular_file(path), encoding='utf-8-sig', errors='replace') as file:
        try:
            for segment, row in _rows(file):
                row_ns = stamp_ns(row[0])
                if not segment.is_useable(row_ns):
                    unuseable = segment if row_ns == wanted_ns else unuseable
                    continue
                if row_ns == wanted_ns:
                    found = segment.attitude(row)
                if nearest_ns is None or abs(row_ns - wanted_ns) < abs(nearest_ns - wanted_ns):
                    nearest_ns = row_ns
        except ValueError as error:
            raise ValueError(f'{path}: {error}') from None
    if found is None and unuseable is not None:
        raise ValueError(
            f'{path}: the row at {epoch_text} is outside the useable time of its segment, '
            f'{unuseable.useable}'
        )
    if nearest_ns is None:
        raise ValueError(f'{path} has no attitudes')
    if found is None:
        raise ValueError(f'{path} has no row at {epoch_text}; the nearest is {epoch(nearest_ns)}')
    return found


class _Segment:
    """What the metadata of a segment say of its rows."""

    def __init__(self, metadata: Mapping[str, str], version: str):
        def value(keyword, default=None):
            if keyword not in metadata and default is None:
                raise ValueError(f'a segment has no {keyword}')
            return metadata.get(keyword, default).upper()

        self.type = value('ATTITUDE_TYPE')
        if self.type not in _LENGTHS:
            raise ValueError(f'ATTITUDE_TYPE is {self.type}; supported: {" and ".join(_LENGTHS)}')
        if value('TIME_SYSTEM') != 'UTC':
            raise ValueError(f'TIME_SYSTEM is {value("TIME_SYSTEM")}; only UTC is supported')
        frames = value('REF_FRAME_A'), value('REF_FRAME_B')
        are_body = [frame.startswith('SC_BODY') for frame in frames]
        if sum(are_body) != 1 or not is_inertial(frames[are_body.index(False)]):
            raise ValueError(
                f'REF_FRAME_A is {frames[0]} and REF_FRAME_B {frames[1]}; supported: SC_BODY and '
                f'one of {", ".join(INERTIAL_FRAMES)}'
            )
        is_otherwise = {}
        for keyword, meant in _MEANT.items():
            # 2.0 does not have it; left over from a file of 1.0 it may say the same.
            given = value(keyword, meant if version == '2.0' else None)
            allowed = (meant, _OTHERWISE[keyword]) if version == '1.0' else (meant,)
            if given not in allowed:
                raise ValueError(
                    f'{keyword} is {given}; in version {version} it must be {" or ".join(allowed)}'
                    f'{"" if version == "1.0" else ", or better left out"}'
                )
            is_otherwise[keyword] = given != meant
        self._scalar_first = is_otherwise['QUATERNION_TYPE']
        self._rotates_to_body = are_body[1] != is_otherwise['ATTITUDE_DIR']
        self._body_is_b = are_body[1]
        if self.type == 'QUATERNION/ANGVEL':
            names = {'REF_FRAME_A': frames[0], 'REF_FRAME_B': frames[1]}
            frame = names.get(value('ANGVEL_FRAME'), value('ANGVEL_FRAME'))
            if frame not in frames:
                raise ValueError(f'ANGVEL_FRAME is {frame}, which is not a frame of its segment')
            of_old = names.get(value('RATE_FRAME', frame), value('RATE_FRAME', frame))
            if of_old != frame:
                raise ValueError(
                    f'ANGVEL_FRAME is {frame} and RATE_FRAME, of version 1.0, {of_old}; they must '
                    'be the same'
                )
            self._rate_in_body = frame == frames[are_body.index(True)]
        self._first_ns, self._last_ns = (
            stamp_ns(metadata[keyword]) if keyword in metadata else None
            for keyword in ('USEABLE_START_TIME', 'USEABLE_STOP_TIME')
        )

    def is_useable(self, row_ns: int) -> bool:
        """Whether a row at a stamp is within USEABLE_START_TIME and USEABLE_STOP_TIME."""
        is_early = self._first_ns is not None and row_ns < self._first_ns
        return not is_early and (self._last_ns is None or row_ns <= self._last_ns)

    @property
    def useable(self) -> str:
        """The useable time in words."""
        begin = '' if self._first_ns is None else f'from {epoch(self._first_ns)}'
        end = '' if self._last_ns is None else f'to {epoch(self._last_ns)}'
        return f'{begin} {end}'.strip()

    def attitude(self, row: list[str]) -> Attitude:
        """Return a row's attitude; ValueError: its numbers are not an attitude."""
        # What is no number is nan.
        numbers = np.array([number(word) for word in row[1:]], float)
        if len(numbers) != _LENGTHS[self.type] or not np.all(np.isfinite(numbers)):
            raise ValueError(f'the row at {row[0]} does not hold {_LENGTHS[self.type]} numbers')
        q = np.roll(numbers[:4], -1) if self._scalar_first else numbers[:4]
        if abs(np.linalg.norm(q) - 1.0) > _NORM_ERROR:
            raise ValueError(f'the quaternion at {row[0]} is not of length 1')
        q_ib = rotation.normalise(q if self._rotates_to_body else rotation.conjugate(q))
        omega_bi_b = None
        if self.type == 'QUATERNION/ANGVEL':
            # The rate of frame B relative to frame A.
            omega = np.radians(numbers[4:]) * (1.0 if self._body_is_b else -1.0)
            to_body = rotation.IDENTITY if self._rate_in_body else rotation.conjugate(q_ib)
            omega_bi_b = rotation.rotate(to_body, omega)
        return Attitude(stamp_ns(row[0]), q_ib, omega_bi_b)


def _rows(lines: Iterable[str]) -> Iterator[tuple[_Segment, list[str]]]:
    """Yield each row of a message, split into its words, with its segment."""
    metadata: dict[str, str] | None = None
    for row in kvn_rows(lines, 'Attitude Ephemeris Message', 'CCSDS_AEM_VERS', _VERSIONS):
        if row.metadata is not metadata:
            metadata = row.metadata
            segment = _Segment(metadata, row.version)
        yield segment, row.words

"""
What the rows of a CCSDS Attitude Ephemeris Message mean, by what the metadata of a segment say.

A row gives the rotation that takes the axes of one frame to those of another, of which one is
inertial and one the body.  Its rates, whatever they are in the file, become the body rate; those
of Euler's angles, which version 1.0 has as QUATERNION/RATE and EULER_ANGLE/RATE, by the rotations
of EULER_ROT_SEQ, whatever RATE_FRAME.
"""

import re
from collections.abc import Sequence

import numpy as np

from ..base.kvn import INERTIAL_FRAMES, KvnMetadata, KvnRow, is_inertial
from ..base.numbers import number
from ..environment.earth import TO_UTC
from ..kernel import rotation
from .euler_turns import angles_of, spin_of, turns

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
    'SPIN/NUTATION': 7,
    'SPIN/NUTATION_MOM': 7,
}
# The same numbers in the order of a row, by their names in XML.
NUMBER_NAMES = tuple(
    name.format(i)
    for name, suffixes in (
        ('Q{}', '123C'),
        ('Q{}_DOT', '123C'),
        ('ANGLE_{}', '123'),
        ('ANGLE_{}_DOT', '123'),
        ('ANGVEL_{}', 'XYZ'),
        ('SPIN_{}', ('ALPHA', 'DELTA', 'ANGLE', 'ANGLE_VEL')),
        ('NUTATION{}', ('', '_PER', '_PHASE')),
        ('MOMENTUM_{}', ('ALPHA', 'DELTA')),
        ('NUTATION_{}', ('VEL',)),
    )
    for i in suffixes
)
# What 2.0 means by itself, and keywords of 1.0 say.
_MEANT = {'ATTITUDE_DIR': 'A2B', 'QUATERNION_TYPE': 'LAST'}
_OTHERWISE = {'ATTITUDE_DIR': 'B2A', 'QUATERNION_TYPE': 'FIRST'}
# Printed with a few digits a quaternion is not quite of length 1; further off it is a mistake.
_NORM_ERROR = 1e-3
_SEQUENCE = re.compile('(?!.*(.)\\1)[XYZ]{3}')


class Meaning:
    """
    What the metadata of a segment say of its rows.

    ValueError: of what is not read; with the line.
    """

    def __init__(self, metadata: KvnMetadata, version: str):
        self._metadata = metadata
        value = self._value
        self._type = value('ATTITUDE_TYPE').replace(' ', '_')
        if self._type not in _LENGTHS:
            self._refuse('ATTITUDE_TYPE', self._type, f'supported: {", ".join(_LENGTHS)}')
        system = value('TIME_SYSTEM')
        if system not in TO_UTC:
            self._refuse('TIME_SYSTEM', system, f'supported: {", ".join(TO_UTC)}')
        self.time_system = system
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
        if self._type.startswith('SPIN') and not self._is_to_body:
            self._refuse(
                'ATTITUDE_TYPE',
                self._type,
                'it is defined from an inertial frame to SC_BODY alone',
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

        ValueError: a quaternion is not of length 1, or a nutation takes no time.
        """
        # q takes the axes of one frame to those of another, and spin is the rate of the latter
        # relative to the former, in the axes of the latter.
        spin = None
        if self._type.startswith('SPIN'):
            # Right ascension and declination of the body's z axis, and the angle about it.
            alpha, delta, angle, rate = np.radians(numbers[:, :4]).T
            angles = np.stack([alpha + np.pi / 2, np.pi / 2 - delta, angle], axis=-1)
            q, _ = turns('ZXZ', angles)
            spin = rate[:, None] * np.array([0.0, 0.0, 1.0])
            if self._type != 'SPIN':
                spin = spin + self._nutation(q, numbers[:, 4:], rows)
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

    def _nutation(self, q, numbers, rows):
        """Return the rate (N, 3) at which the z axis goes about the angular momentum."""
        if self._type == 'SPIN/NUTATION':
            # Where the momentum is in the body: its angle to z, and the phase about z.
            angle, phase = np.radians(numbers[:, [0, 2]]).T
            across = np.sin(angle)
            momentum = [across * np.cos(phase), -across * np.sin(phase), np.cos(angle)]
            period_s = numbers[:, 1]
            if np.any(period_s == 0.0):
                row = rows[int(np.argmax(period_s == 0.0))]
                raise ValueError(f'line {row.line}: the nutation at {row.words[0]} takes 0 s')
            return (2.0 * np.pi / period_s)[:, None] * np.stack(momentum, axis=-1)
        alpha, delta, rate = np.radians(numbers).T
        across = np.cos(delta)
        momentum = [across * np.cos(alpha), across * np.sin(alpha), np.sin(delta)]
        return rate[:, None] * rotation.rotate(rotation.conjugate(q), np.stack(momentum, axis=-1))

    def _scalar_last(self, numbers):
        return np.roll(numbers, -1, axis=-1) if self._scalar_first else numbers

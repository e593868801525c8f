"""
The CCSDS Attitude Ephemeris Message, 504.0-B, in keyword = value notation.

Its quaternion gives the rotation that takes the axes of REF_FRAME_A to those of REF_FRAME_B,
vector part first.  With the inertial frame as A and the body as B these are the numbers of q_ib.
Version 2.0 has body rates; 1.0, which every reader knows, has the rates of Euler's angles alone.
"""

from typing import TextIO

import numpy as np

from ..base.nanoseconds import epoch
from .ccsds import SegmentWriter, Subject
from .euler_turns import angles_of, rates_of

BODY = 'SC_BODY_1'
# The turns of version 1.0, about z, y and x; this near to 90 deg of the second [rad] their rates
# have no digits.
_SEQUENCE, _WRITTEN_SEQUENCE, _NEAREST = 'ZYX', '321', 1e-4


class AemWriter:
    """
    Attitudes as an AEM; see SegmentWriter.

    Parameters
    ----------
    file : TextIO
        open for text and seekable
    subject : Subject
        what it is about
    with_rates : bool
        whether it has body rates too
    version : str or None
        1.0 or 2.0; None: 2.0 with rates, 1.0 without
    """

    def __init__(
        self,
        file: TextIO,
        subject: Subject,
        with_rates: bool = False,
        version: str | None = None,
    ):
        version = version or ('2.0' if with_rates else '1.0')
        self._with_rates, self._is_first = with_rates, version == '1.0'
        metadata = {
            'OBJECT_NAME': subject.object_name,
            'OBJECT_ID': 'UNKNOWN',
            'CENTER_NAME': subject.center,
            'REF_FRAME_A': subject.frame,
            'REF_FRAME_B': BODY,
            **({'ATTITUDE_DIR': 'A2B'} if self._is_first else {}),
            'TIME_SYSTEM': 'UTC',
            'START_TIME': '',
            'STOP_TIME': '',
            'ATTITUDE_TYPE': 'QUATERNION',
        }
        comments = [
            f'Rotation of the axes of {subject.frame} (A) to those of {BODY} (B): '
            'v_A = q v_B q*, scalar last.'
        ]
        if self._is_first:
            metadata['QUATERNION_TYPE'] = 'LAST'
        if with_rates and self._is_first:
            metadata |= {
                'ATTITUDE_TYPE': 'QUATERNION/RATE',
                'EULER_ROT_SEQ': _WRITTEN_SEQUENCE,
                'RATE_FRAME': 'REF_FRAME_B',
            }
            comments.append("Rates of Euler's angles, in the order of EULER_ROT_SEQ [deg/s].")
        elif with_rates:
            metadata |= {'ATTITUDE_TYPE': 'QUATERNION/ANGVEL', 'ANGVEL_FRAME': BODY}
            comments.append('Angular velocity of B relative to A, in axes of B [deg/s].')
        self._segments = SegmentWriter(
            file, f'CCSDS_AEM_VERS = {version}', comments, metadata, data_marks=True
        )

    def write(self, stamps_ns: np.ndarray, q_ib: np.ndarray, omega_bi_b: np.ndarray) -> None:
        """
        Append rows.

        Parameters
        ----------
        stamps_ns : (N,), ns
            Unix times, which increase
        q_ib : (N, 4), x, y, z, w
            attitudes, body to inertial
        omega_bi_b : (N, 3), rad/s, body axes
            body rates

        Raises
        ------
        ValueError
            version 1.0 cannot give the rates of one
        """
        rates = omega_bi_b
        if self._with_rates and self._is_first:
            x, y, z, w = q_ib.T
            if np.any(is_locked := 2.0 * np.abs(w * y - x * z) > np.cos(_NEAREST)):
                raise ValueError(
                    f'at {epoch(stamps_ns[np.argmax(is_locked)])} the second Euler angle is 90 '
                    'deg, where version 1.0 has no rates; version 2.0 has'
                )
            rates = rates_of(_SEQUENCE, angles_of(_SEQUENCE, q_ib), omega_bi_b)
        values = np.hstack([q_ib, np.degrees(rates)]) if self._with_rates else q_ib
        self._segments.write(stamps_ns, values)

    def end_segment(self) -> None:
        """End the segment, where the motion restarts and at the end."""
        self._segments.end_segment()

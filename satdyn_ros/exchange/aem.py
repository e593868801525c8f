"""
The CCSDS Attitude Ephemeris Message, 504.0-B, in keyword = value notation.

Attitudes alone are written in version 1.0, which every reader knows; with body rates it is 2.0,
since 1.0 has rates of Euler's angles alone.

Its quaternion gives the rotation that takes the axes of REF_FRAME_A to those of REF_FRAME_B,
vector part first.  With the inertial frame as A and the body as B these are the numbers of q_ib.
"""

from typing import TextIO

import numpy as np

from .ccsds import SegmentWriter, Subject

BODY = 'SC_BODY_1'


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
            **({} if with_rates else {'ATTITUDE_DIR': 'A2B'}),
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
            metadata['QUATERNION_TYPE'] = 'LAST'
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

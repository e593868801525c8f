"""The CCSDS Orbit Ephemeris Message, 502.0-B-3 (version 3.0), in keyword = value notation."""

from typing import TextIO

import numpy as np

from .ccsds import SegmentWriter, Subject


class OemWriter:
    """Positions and velocities as an OEM in km and km/s; see SegmentWriter."""

    def __init__(self, file: TextIO, subject: Subject):
        metadata = {
            'OBJECT_NAME': subject.object_name,
            'OBJECT_ID': 'UNKNOWN',
            'CENTER_NAME': subject.center,
            'REF_FRAME': subject.frame,
            'TIME_SYSTEM': 'UTC',
            'START_TIME': '',
            'STOP_TIME': '',
        }
        comments = [f'Position [km] and velocity [km/s] relative to {subject.center}.']
        self._segments = SegmentWriter(
            file, 'CCSDS_OEM_VERS = 3.0', comments, metadata, data_marks=False
        )

    def write(self, stamps_ns: np.ndarray, r_i: np.ndarray, v_i: np.ndarray) -> None:
        """
        Append rows.

        Parameters
        ----------
        stamps_ns : (N,), ns
            Unix times, which increase
        r_i : (N, 3), m, inertial axes
            positions
        v_i : (N, 3), m/s, inertial axes
            velocities
        """
        self._segments.write(stamps_ns, np.hstack([r_i, v_i]) / 1000.0)

    def end_segment(self) -> None:
        """End the segment, at the end: an orbit goes on where the attitude restarts."""
        self._segments.end_segment()

"""What the ephemeris messages of CCSDS share: names, and segments written as the rows come."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import TextIO

import numpy as np

from ..base.kvn import INERTIAL_FRAMES
from ..base.nanoseconds import epoch, epochs

_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_ ()/-]*')


@dataclass(frozen=True)
class Subject:
    """
    What a file is about.

    Attributes
    ----------
    object_name : str
        the satellite
    frame : str
        name of the inertial axes in the file
    center : str
        the attracting body

    Raises
    ------
    ValueError
        the frame is not inertial, or a name has characters that other programs would not read
    """

    object_name: str
    frame: str = 'EME2000'
    center: str = 'EARTH'

    def __post_init__(self) -> None:
        if self.frame not in INERTIAL_FRAMES:
            raise ValueError(
                f'the frame is {self.frame}; it must be an inertial one: '
                f'{", ".join(INERTIAL_FRAMES)}'
            )
        for what, name in (('center', self.center), ('object', self.object_name)):
            if not _NAME.fullmatch(name):
                raise ValueError(f'the {what} is {name!r}; allowed: letters, digits, _ and -')


class SegmentWriter:
    """
    A message in keyword = value notation, written segment by segment.

    Memory does not grow with the rows: STOP_TIME is filled in when its segment ends.

    Parameters
    ----------
    file : TextIO
        open for text and seekable
    version : str
        the first line
    comments : iterable of str
        what the header says to a human reader
    metadata : dict
        the keywords of each segment in the order of the standard; START_TIME and STOP_TIME stand
        in it and get their values here
    data_marks : bool
        whether DATA_START and DATA_STOP enclose the rows
    """

    def __init__(
        self,
        file: TextIO,
        version: str,
        comments: Iterable[str],
        metadata: Mapping[str, str],
        data_marks: bool,
    ):
        self._file, self._metadata, self._data_marks = file, metadata, data_marks
        self._stop_at: int | None = None
        self._last_ns = 0
        created = datetime.now(timezone.utc).strftime('%Y-%m-%dT%H:%M:%S')
        file.write(f'{version}\n')
        file.writelines(f'COMMENT {comment}\n' for comment in comments)
        file.write(f'CREATION_DATE = {created}\nORIGINATOR = SATDYN_ROS\n')

    def write(self, stamps_ns: np.ndarray, values: np.ndarray) -> None:
        """Append rows: stamps (N,) that increase, and their values (N, M)."""
        if len(stamps_ns) == 0:
            return
        if self._stop_at is None:
            self._begin_segment(int(stamps_ns[0]))
        # 16 significant digits are the most that the standards allow.
        row = '%s' + ' %.15e' * values.shape[1] + '\n'
        table = zip(epochs(stamps_ns), *values.T.tolist(), strict=True)
        self._file.write(''.join([row % cells for cells in table]))
        self._last_ns = int(stamps_ns[-1])

    def end_segment(self) -> None:
        """End the segment: readers do not interpolate between it and the next."""
        if self._stop_at is None:
            return
        if self._data_marks:
            self._file.write('DATA_STOP\n')
        end = self._file.tell()
        self._file.seek(self._stop_at)
        self._file.write(epoch(self._last_ns))
        self._file.seek(end)
        self._stop_at = None

    def _begin_segment(self, start_ns):
        self._file.write('\nMETA_START\n')
        for keyword, value in self._metadata.items():
            self._file.write(f'{keyword} = ')
            if keyword == 'STOP_TIME':
                self._stop_at = self._file.tell()
            times = {'START_TIME': epoch(start_ns), 'STOP_TIME': epoch(start_ns)}
            self._file.write(f'{times.get(keyword, value)}\n')
        self._file.write('META_STOP\n\n')
        if self._data_marks:
            self._file.write('DATA_START\n')

"""
The attitude file of STK (.a), AttitudeTimeQuaternions or AttitudeTimeQuatAngVels.

Its quaternion, vector part first, gives the rotation that takes the coordinate axes to the body's
axes: the numbers of q_ib.  Rates are those of the body relative to the coordinate axes, in body
axes and deg/s; times are seconds past ScenarioEpoch, leap seconds among them.
"""

from datetime import datetime, timezone
from typing import TextIO

import numpy as np

from ..base.nanoseconds import SECOND_NS
from ..environment.earth import elapsed_ns
from .ccsds import Subject

_AXES = {'EME2000': 'J2000', 'J2000': 'J2000', 'GCRF': 'ICRF', 'ICRF': 'ICRF'}
_COUNT_WIDTH = 19


class StkAttitudeWriter:
    """
    Attitudes as an STK attitude file.

    Memory does not grow with the rows: the header's number of rows is filled in at the end.

    Parameters
    ----------
    file : TextIO
        open for text and seekable
    subject : Subject
        what it is about
    with_rates : bool
        whether it has body rates too
    """

    def __init__(self, file: TextIO, subject: Subject, with_rates: bool = False):
        self._file, self._subject, self._with_rates = file, subject, with_rates
        self._epoch_ns: int | None = None
        self._count_at = 0
        self._count = 0

    def write(self, stamps_ns: np.ndarray, q_ib: np.ndarray, omega_bi_b: np.ndarray) -> None:
        """
        Append rows.

        Parameters
        ----------
        stamps_ns : (N,), ns
            Unix times
        q_ib : (N, 4), x, y, z, w
            attitudes, body to inertial
        omega_bi_b : (N, 3), rad/s, body axes
            body rates
        """
        if len(stamps_ns) == 0:
            return
        if self._epoch_ns is None:
            self._begin(int(stamps_ns[0]))
        assert self._epoch_ns is not None
        seconds, nanoseconds = np.divmod(elapsed_ns(self._epoch_ns, stamps_ns), SECOND_NS)
        values = np.hstack([q_ib, np.degrees(omega_bi_b)]) if self._with_rates else q_ib
        row = '%d.%09d' + ' %.16e' * values.shape[1] + '\n'
        table = zip(seconds.tolist(), nanoseconds.tolist(), *values.T.tolist(), strict=True)
        self._file.write(''.join([row % cells for cells in table]))
        self._count += len(stamps_ns)

    def close(self) -> None:
        """Write what follows the last row, and the number of rows into the header."""
        if self._epoch_ns is None:
            self._begin(0)
        self._file.write('END Attitude\n')
        self._file.seek(self._count_at)
        self._file.write(f'{self._count:<{_COUNT_WIDTH}}')

    def _begin(self, epoch_ns):
        self._epoch_ns = epoch_ns
        kind = 'AttitudeTimeQuatAngVels' if self._with_rates else 'AttitudeTimeQuaternions'
        # The date and time of STK's UTCG, in English whatever the locale.
        instant = datetime.fromtimestamp(epoch_ns // SECOND_NS, timezone.utc)
        month = 'JanFebMarAprMayJunJulAugSepOctNovDec'[3 * instant.month - 3 :][:3]
        utcg = f'{instant.day} {month} {instant:%Y %H:%M:%S}.{epoch_ns % SECOND_NS:09d}'
        self._file.write(
            'stk.v.8.0\n'
            f'# {self._subject.object_name}: rotation of the coordinate axes to the body axes, '
            'v_coordinate = q v_body q*, scalar last.\n'
        )
        if self._with_rates:
            self._file.write('# Rate of the body relative to the axes, in body axes [deg/s].\n')
        self._file.write('BEGIN Attitude\nNumberOfAttitudePoints ')
        self._count_at = self._file.tell()
        self._file.write(
            f'{0:<{_COUNT_WIDTH}}\n'
            f'ScenarioEpoch {utcg}\n'
            f'CentralBody {self._subject.center.capitalize()}\n'
            f'CoordinateAxes {_AXES[self._subject.frame]}\n'
            f'{kind}\n'
        )

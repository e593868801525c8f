"""
The scene of CesiumJS (.czml): where a satellite is above the Earth, its ground track and attitude.

Positions are Earth-fixed [m]; the quaternion, vector part first, takes the body's axes to the
Earth-fixed ones.  Both are given as samples, which CesiumJS interpolates: positions by Lagrange's
polynomials of degree 5, the attitude by a steady turn from one to the next.
"""

import json
from collections.abc import Sequence
from typing import TextIO

import numpy as np

from ..base.nanoseconds import SECOND_NS, epoch
from ..environment.earth import elapsed_ns

_DEGREE = 5
# How long a part of the path is shown behind the satellite [s].
_TRAIL_S = 6000


class CzmlWriter:
    """
    A satellite's way as CZML.

    Memory does not grow with the rows: each write makes packets of their own, which CesiumJS
    joins, and the end of the clock is filled in.

    Parameters
    ----------
    file : TextIO
        open for text and seekable
    name : str
        of the satellite
    box : (3,), m
        edges along the body axes, all 0: none is drawn
    """

    def __init__(self, file: TextIO, name: str, box: Sequence[float] = (0.0, 0.0, 0.0)):
        self._file, self._name, self._box = file, name, box
        self._epoch_ns: int | None = None
        self._ends_at: list[int] = []
        self._last_ns = 0

    def write(
        self,
        stamps_ns: np.ndarray,
        r_t: np.ndarray,
        q_tb: np.ndarray,
        latitude: np.ndarray,
        longitude: np.ndarray,
    ) -> None:
        """
        Append rows.

        Parameters
        ----------
        stamps_ns : (N,), ns
            Unix times
        r_t : (N, 3), m, Earth-fixed axes
            positions
        q_tb : (N, 4), x, y, z, w
            attitudes, body to Earth-fixed
        latitude, longitude : (N,), rad
            of the ground track
        """
        if len(stamps_ns) == 0:
            return
        if self._epoch_ns is None:
            self._begin(int(stamps_ns[0]))
        assert self._epoch_ns is not None
        # CesiumJS counts seconds past an epoch in TAI.
        t_s = elapsed_ns(self._epoch_ns, stamps_ns) / SECOND_NS
        position = self._samples('cartesian', t_s, r_t)
        attitude = self._samples('unitQuaternion', t_s, q_tb, 1)
        track = self._samples(
            'cartographicDegrees',
            t_s,
            np.stack([np.degrees(longitude), np.degrees(latitude), np.zeros(len(t_s))], axis=-1),
        )
        self._packet({'id': self._name, 'position': position, 'orientation': attitude})
        self._packet({'id': f'{self._name}/ground_track', 'position': track})
        self._last_ns = int(stamps_ns[-1])

    def close(self) -> None:
        """Write what follows the last row, and the end of the clock."""
        self._file.write('\n]\n')
        for at in self._ends_at:
            self._file.seek(at)
            self._file.write(f'{epoch(self._last_ns)}Z')

    def _samples(self, kind, t_s, values, degree=_DEGREE):
        assert self._epoch_ns is not None
        return {
            'epoch': f'{epoch(self._epoch_ns)}Z',
            'interpolationAlgorithm': 'LAGRANGE' if degree > 1 else 'LINEAR',
            'interpolationDegree': degree,
            kind: np.column_stack([t_s, values]).ravel().tolist(),
        }

    def _begin(self, epoch_ns):
        self._epoch_ns = epoch_ns
        begin = f'{epoch(epoch_ns)}Z'
        path = {'width': 1, 'trailTime': _TRAIL_S, 'leadTime': 0, 'resolution': 60}
        clock = {'interval': f'{begin}/{begin}', 'currentTime': begin, 'multiplier': 10}
        self._file.write('[\n')
        self._packet(
            {'id': 'document', 'name': self._name, 'version': '1.0', 'clock': clock}, is_first=True
        )
        satellite = {
            'id': self._name,
            'name': self._name,
            'availability': f'{begin}/{begin}',
            'point': {'pixelSize': 6},
            'path': path,
        }
        if any(self._box):
            satellite['box'] = {'dimensions': {'cartesian': list(self._box)}}
        self._packet(satellite)
        self._packet(
            {
                'id': f'{self._name}/ground_track',
                'availability': f'{begin}/{begin}',
                'path': path,
            }
        )

    def _packet(self, packet, is_first=False):
        text = json.dumps(packet)
        start = self._file.tell() + (0 if is_first else 2)
        self._file.write(text if is_first else f',\n{text}')
        if (found := text.find('Z/')) >= 0:
            self._ends_at.append(start + found + 2)

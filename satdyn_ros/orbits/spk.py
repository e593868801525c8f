"""
The ephemeris of a satellite in an SPK kernel of SPICE (.bsp), as the text of an OEM.

CSPICE evaluates it, whatever the type of its segments.  The rows of the OEM are as close as
Lagrange's polynomials of degree 13 need to go within half a centimetre of that, so that a run and
its bag need no kernel; not Hermite's, since the velocities of some types are no slopes.  Times are
in TT, into which SPICE's are turned as SPICE does.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..base.imports import spice
from ..base.nanoseconds import SECOND_NS, epoch, epochs, stamp_ns
from ..base.regular_file import regular_file
from ..kernel.rows import length
from .interpolation import Interpolation

_MARK = b'DAF/SPK'
_EARTH, _MOON = 399, 301
_INERTIAL = 1
_DOUBLES, _INTEGERS = 2, 6
_J2000_NS = stamp_ns('2000-01-01T12:00:00')
_DEGREE = 13
# SPICE gives instants as doubles, to 1e-7 s, in which a satellite goes a millimetre.
_MISSED_M, _MISSED_M_S = 5e-3, 1e-3
# Rows are this far apart, or halves of it down to where only a jump asks for more [ns].
_STEP_NS, _LEAST_NS = 600 * SECOND_NS, SECOND_NS
_MOST_ROWS = 12_000


class _Part(NamedTuple):
    """A time in which one segment is in force, in SPICE's seconds."""

    begin_s: float
    end_s: float
    descriptor: np.ndarray


def is_spk(path: str | Path) -> bool:
    """Whether a file is an SPK kernel, by its first bytes; what cannot be read is none."""
    try:
        with open(regular_file(path), 'rb') as file:
            return file.read(len(_MARK)) == _MARK
    except OSError:
        return False


def oem_of_spk(path: str | Path) -> str:
    """
    Return the ephemeris of the one satellite of the Earth in an SPK kernel as an OEM.

    ValueError: spiceypy is not installed, SPICE cannot read the file, or it has no such satellite,
    several, or axes that turn.
    """
    with spice() as toolkit:
        handle = toolkit.dafopr(str(path))
        try:
            body, segments = _segments(toolkit, handle)
            text = f'CCSDS_OEM_VERS = 2.0\nCOMMENT SPK body {body}\nORIGINATOR = SATDYN_ROS\n'
            rows_left = _MOST_ROWS
            for part in _parts(segments):
                tt_ns, states = _rows(part, _evaluation(toolkit, handle, part), rows_left)
                rows_left -= len(tt_ns)
                text += _segment_text(body, tt_ns, states)
            return text
        finally:
            toolkit.dafcls(handle)


def _segments(toolkit: Any, handle: int) -> tuple[int, list[_Part]]:
    """Return the number of the satellite and its segments, in the order of the file."""
    found: dict[int, list[_Part]] = {}
    centers = set()
    toolkit.dafbfs(handle)
    while toolkit.daffna():
        descriptor = toolkit.dafgs(_DOUBLES + _INTEGERS // 2)
        (begin_s, end_s), (body, center, *_) = toolkit.dafus(descriptor, _DOUBLES, _INTEGERS)
        centers.add(int(center))
        if center == _EARTH and body != _MOON:
            found.setdefault(int(body), []).append(_Part(begin_s, end_s, descriptor))
    if not found:
        named = ', '.join(map(str, sorted(centers))) or 'none'
        raise ValueError(
            f'it has no satellite about the Earth, {_EARTH}; the centres of its segments: {named}'
        )
    if len(found) > 1:
        raise ValueError(
            f'it has {len(found)} satellites, {", ".join(map(str, sorted(found)))}; it must have '
            'one'
        )
    return next(iter(found.items()))


def _parts(segments: list[_Part]) -> Iterator[_Part]:
    """Yield the times from edge to edge: of segments that overlap the last is in force."""
    edges = sorted({edge for each in segments for edge in (each.begin_s, each.end_s)})
    for begin_s, end_s in pairwise(edges):
        covering = [each for each in segments if each.begin_s <= begin_s and end_s <= each.end_s]
        # What is shorter than some nanoseconds holds no rows.
        if covering and _tt_ns(end_s) - _tt_ns(begin_s) > _DEGREE:
            yield _Part(begin_s, end_s, covering[-1].descriptor)


def _evaluation(toolkit: Any, handle: int, part: _Part) -> Callable[[np.ndarray], np.ndarray]:
    """Return the function that gives states (N, 6) [km, km/s] in J2000 at TT (N,) [ns]."""
    frame, _, _ = toolkit.spkpvn(handle, part.descriptor, part.begin_s)
    name = toolkit.frmnam(frame)
    if toolkit.frinfo(frame)[1] != _INERTIAL:
        raise ValueError(f'its axes are {name}, which turn; they must be inertial, such as J2000')
    to_j2000 = toolkit.pxform(name, 'J2000', 0.0)

    def states(tt_ns):
        et_s = np.clip(_et_s(tt_ns), part.begin_s, part.end_s)
        found = [toolkit.spkpvn(handle, part.descriptor, at_s)[1] for at_s in et_s.tolist()]
        return (np.reshape(found, (-1, 2, 3)) @ to_j2000.T).reshape(-1, 6)

    return states


def _rows(
    part: _Part, states: Callable[[np.ndarray], np.ndarray], most: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return TT (N,) [ns] and states (N, 6) [km, km/s] of the rows that a part needs."""
    begin_ns, end_ns = _tt_ns(part.begin_s), _tt_ns(part.end_s)
    count = min(most, max(_DEGREE, -(-(end_ns - begin_ns) // _STEP_NS)))
    tt_ns = np.unique([begin_ns + (end_ns - begin_ns) * k // count for k in range(count + 1)])
    found = states(tt_ns)
    while True:
        if len(tt_ns) > most:
            raise ValueError(
                f'it needs more than {_MOST_ROWS} rows to be interpolated within '
                f'{1e3 * _MISSED_M:g} mm; give a file of fewer days'
            )
        middle_ns = (tt_ns[1:] + tt_ns[:-1]) // 2
        between = states(middle_ns)
        through = Interpolation((tt_ns - begin_ns) / SECOND_NS, found, False, _DEGREE + 1)
        off = 1e3 * (between - through.at((middle_ns - begin_ns) / SECOND_NS))
        missing = (length(off[:, :3]) > _MISSED_M) | (length(off[:, 3:]) > _MISSED_M_S)
        if not np.any(missing):
            return tt_ns, found
        if np.any(too_near := missing & (np.diff(tt_ns) < _LEAST_NS)):
            raise ValueError(
                f'its positions or velocities jump at {epoch(middle_ns[np.argmax(too_near)])} TT'
            )
        order = np.argsort(all_ns := np.concatenate([tt_ns, middle_ns[missing]]))
        tt_ns, found = all_ns[order], np.concatenate([found, between[missing]])[order]


def _segment_text(body, tt_ns, states):
    times = epochs(tt_ns)
    row = '%s' + ' %.12g' * 6 + '\n'
    rows = ''.join([row % cells for cells in zip(times, *states.T.tolist(), strict=True)])
    return (
        f'META_START\nOBJECT_NAME = {body}\nOBJECT_ID = {body}\nCENTER_NAME = EARTH\n'
        f'REF_FRAME = EME2000\nTIME_SYSTEM = TT\n'
        f'START_TIME = {times[0]}\nSTOP_TIME = {times[-1]}\n'
        f'INTERPOLATION = LAGRANGE\nINTERPOLATION_DEGREE = {_DEGREE}\nMETA_STOP\n{rows}'
    )


def _tdb_from_tt_s(at_s):
    """Return TDB - TT [s] at seconds from 2000 on, as naif0012.tls has it (SPICE Time reading)."""
    anomaly = 6.239996 + 1.99096871e-7 * at_s
    return 1.657e-3 * np.sin(anomaly + 1.671e-2 * np.sin(anomaly))


def _tt_ns(et_s: float) -> int:
    whole_s = int(et_s // 1)
    rest_s = et_s - whole_s - float(_tdb_from_tt_s(et_s))
    return _J2000_NS + whole_s * SECOND_NS + round(rest_s * SECOND_NS)


def _et_s(tt_ns):
    at_s = (tt_ns - _J2000_NS) / SECOND_NS
    return at_s + _tdb_from_tt_s(at_s)

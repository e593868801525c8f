"""
Attitudes as a C-kernel of SPICE (.bc), with the clock and the frame by which it is read.

Segments are of type 3, which SPICE interpolates by steady turns.  The clock (.tsc) counts the
nanoseconds of stamps from the first row on, so that a row is at a whole number of ticks; parallel
to it runs TT.  The frame kernel (.tf) names the satellite and its body axes.
"""

import zlib
from pathlib import Path
from types import ModuleType

import numpy as np

from ..base.imports import spice
from ..base.nanoseconds import SECOND_NS, epoch, stamp_ns
from ..environment.earth import leap_seconds_between, terrestrial_time_ns
from ..kernel import rotation
from .ccsds import Subject

# SPICE's name of the inertial axes, and the lengths that it allows to others.
_REFERENCE = 'J2000'
_LONGEST_SEGMENT, _LONGEST_NAME, _LONGEST_FRAME = 40, 36, 26
# Of a longer path SPICE takes the first characters, and writes another file.
_LONGEST_PATH = 255
_J2000_NS = stamp_ns('2000-01-01T12:00:00')
# The two fields of the clock: seconds, which fit in 32 bits, and nanoseconds.
_MOST_SECONDS = 2**32


class CkWriter:
    """
    Attitudes as a C-kernel.

    Its numbers in SPICE follow from the satellite's name, so that kernels of several can be loaded
    together: the satellite is -1XXXXXX, as is its clock, and its axes are that times 1000.  Memory
    does not grow with the rows: each write makes a segment, which begins with the last row of the
    one before.

    Parameters
    ----------
    path : Path
        of the kernel
    subject : Subject
        what it is about
    with_rates : bool
        whether it has body rates too

    Raises
    ------
    ValueError
        spiceypy is not installed, or SPICE cannot write the file
    """

    def __init__(self, path: Path, subject: Subject, with_rates: bool = False):
        if len(bytes(path)) > _LONGEST_PATH:
            raise ValueError(
                f'the path {path} has {len(bytes(path))} characters; SPICE writes no file beyond '
                f'{_LONGEST_PATH}'
            )
        self._path, self._subject, self._with_rates = path, subject, with_rates
        name = subject.object_name
        self._satellite = -(1_000_000 + zlib.crc32(name.encode()) % 1_000_000)
        self._axes = 1000 * self._satellite
        self._handle: int | None = None
        self._first_ns = self._last_ns = 0
        self._before: tuple[np.ndarray, ...] | None = None

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
        rows: tuple[np.ndarray, ...] = (stamps_ns, q_ib, omega_bi_b)
        if self._before is not None:
            rows = tuple(map(np.concatenate, zip(self._before, rows, strict=True)))
        self._before = tuple(values[-1:] for values in rows)
        self._last_ns = int(stamps_ns[-1])
        with spice() as toolkit:
            if self._handle is None:
                # Where no file can be made, that is said as of other formats.  SPICE writes none
                # that there is.
                self._path.touch()
                self._path.unlink()
                self._handle = toolkit.ckopn(str(self._path), 'SATDYN_ROS', 0)
                self._first_ns = int(stamps_ns[0])
            self._write_segment(toolkit, *rows)

    def _write_segment(self, toolkit: ModuleType, stamps_ns, q_ib, omega_bi_b):
        ticks = (stamps_ns - self._first_ns).astype(float)
        # SPICE turns components the other way, inertial to body, and has the scalar first.
        quaternions = np.roll(rotation.conjugate(q_ib), 1, axis=-1)
        toolkit.ckw03(
            self._handle,
            ticks[0],
            ticks[-1],
            self._axes,
            _REFERENCE,
            self._with_rates,
            self._subject.object_name[:_LONGEST_SEGMENT],
            len(ticks),
            ticks,
            np.ascontiguousarray(quaternions),
            np.ascontiguousarray(rotation.rotate(q_ib, omega_bi_b)),
            1,
            ticks[:1],
        )

    def end_segment(self) -> None:
        """End the segment, where the motion restarts: nothing is interpolated across it."""
        self._before = None

    def close(self) -> None:
        """Complete the file, also where it stays without all rows."""
        if self._handle is not None:
            with spice() as toolkit:
                toolkit.ckcls(self._handle)
            self._handle = None

    @property
    def clock_kernel(self) -> str:
        """The text of the clock, from the first row to the last."""
        clock = -self._satellite
        begins_ns = [self._first_ns, *leap_seconds_between(self._first_ns, self._last_ns)]
        tt_ns = (terrestrial_time_ns(np.array(begins_ns)) - _J2000_NS).tolist()
        records = '\n'.join(
            f'  {begin_ns - self._first_ns} {_seconds(at_ns)} 1'
            for begin_ns, at_ns in zip(begins_ns, tt_ns, strict=True)
        )
        return f"""\
KPL/SCLK

Clock of {self._subject.object_name}: nanoseconds of Unix time from {epoch(self._first_ns)} UTC on,
which count no leap second; SSSSSSSSSS.NNNNNNNNN.  Parallel to it: TT.

\\begindata

SCLK_KERNEL_ID = ( @{epoch(self._first_ns)[:19]} )
SCLK_DATA_TYPE_{clock} = ( 1 )
SCLK01_TIME_SYSTEM_{clock} = ( 2 )
SCLK01_N_FIELDS_{clock} = ( 2 )
SCLK01_MODULI_{clock} = ( {_MOST_SECONDS} {SECOND_NS} )
SCLK01_OFFSETS_{clock} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{clock} = ( 1 )
SCLK_PARTITION_START_{clock} = ( 0 )
SCLK_PARTITION_END_{clock} = ( {_MOST_SECONDS * SECOND_NS} )
SCLK01_COEFFICIENTS_{clock} = (
{records}
)

\\begintext
"""

    @property
    def frame_kernel(self) -> str:
        """The text of the names of the satellite and its body axes."""
        axes = self._axes
        name = self._subject.object_name[:_LONGEST_NAME]
        frame = f'{name[: _LONGEST_FRAME - len("_BODY")]}_BODY'
        return f"""\
KPL/FK

Body axes of {name} relative to {_REFERENCE}, by its C-kernel.

\\begindata

NAIF_BODY_NAME += ( '{name}' )
NAIF_BODY_CODE += ( {self._satellite} )
FRAME_{frame} = {axes}
FRAME_{axes}_NAME = '{frame}'
FRAME_{axes}_CLASS = 3
FRAME_{axes}_CLASS_ID = {axes}
FRAME_{axes}_CENTER = {self._satellite}
CK_{axes}_SCLK = {self._satellite}
CK_{axes}_SPK = {self._satellite}

\\begintext
"""


def _seconds(at_ns: int) -> str:
    sign, (whole, part) = '-' if at_ns < 0 else '', divmod(abs(at_ns), SECOND_NS)
    return f'{sign}{whole}.{part:09d}'

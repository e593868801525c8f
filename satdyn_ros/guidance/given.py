"""References that are given: one attitude for all times, or those of a file."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..base.nanoseconds import SECOND_NS
from ..exchange.aem_reader import AttitudeFile
from ..kernel import rotation
from .reference import OrbitState, Reference

# Over so long the rates of a file are differenced.
_STEP_NS = SECOND_NS // 20


def inertial(q: ArrayLike) -> Callable[[OrbitState], Reference]:
    """
    Return the reference that rests in inertial axes.

    Parameters
    ----------
    q : (4,), x, y, z, w
        q_ir, of any length: takes components in the axes of the reference to inertial ones

    Raises
    ------
    ValueError
        q is not four numbers, or zero
    """
    given = np.array(q, float)
    if given.shape != (4,) or not 0.0 < np.linalg.norm(given) < np.inf:
        raise ValueError(f'q is {given.tolist()}; it must be 4 numbers, x, y, z, w, not all zero')
    return partial(_inertial, rotation.normalise(given))


def _inertial(q_ir, sample):
    return Reference(q_ir, np.zeros(3), np.zeros(3))


def from_aem(path: str | Path) -> Callable[[OrbitState], Reference]:
    """
    Return the reference of a CCSDS AEM, interpolated between its rows as the file says.

    The body of the file is the reference.  The acceleration is a difference of the rates over 0.1
    s, large at the rows of a file without rates, where they jump.

    Parameters
    ----------
    path : str or Path
        the file

    Raises
    ------
    ValueError
        as for AttitudeFile; or, for a sample, the file has no attitude at its stamp
    """
    return partial(_of_file, AttitudeFile(path))


def _of_file(file, sample):
    at_ns = int(sample.stamp_ns)
    q_ir, omega = file.motion_at(at_ns)
    (begin_ns, first), (end_ns, last) = (
        _rate_near(file, at_ns + step_ns, at_ns, omega) for step_ns in (-_STEP_NS, _STEP_NS)
    )
    between_s = (end_ns - begin_ns) / SECOND_NS
    return Reference(q_ir, omega, (last - first) / between_s if between_s else np.zeros(3))


def _rate_near(file, at_ns, now_ns, omega):
    """Return a stamp and the rate there, or, beyond the ends of the file, those of now."""
    try:
        return at_ns, file.motion_at(at_ns)[1]
    except ValueError:
        return now_ns, omega

"""A curve that goes up and down more often than a picture has pixels, as a band with a mean."""

from typing import NamedTuple

import numpy as np

from .curves import direction

# Neighbours that have a say in whether a line or a band is drawn: a curve does not change at each.
_NEIGHBOURS = 9
_FEWEST_ROWS = 4


class Envelope(NamedTuple):
    """
    A curve as a band where it goes to and fro.

    Attributes
    ----------
    is_band : (N,) bool
        where it is drawn as a band
    least, most : (N,)
        of each step along the time
    mean : (N,)
        which goes from one step to the next
    """

    is_band: np.ndarray
    least: np.ndarray
    most: np.ndarray
    mean: np.ndarray


def envelope(
    values: np.ndarray,
    steps: int,
    is_far: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray, np.ndarray],
    noise: float = 0.0,
    turns: bool = False,
) -> Envelope:
    """
    Return the envelope of a curve in steps along the time.

    A step is a band where the curve goes to and fro at least once within it, or one of its rows is
    far.

    Parameters
    ----------
    values : (N,)
        the curve, of evenly spread rows
    steps : int
        how many at most
    is_far : (N,) bool
        where least, most and mean are the bounds
    bounds : three of (N,)
        least, most and mean of values that no row has
    noise : float
        what goes to and fro by less goes nowhere
    turns : bool
        whether the values are angles [deg] whose mean is that of directions
    """
    steps = max(1, min(steps, len(values) // _FEWEST_ROWS))
    begins = np.arange(steps) * len(values) // steps
    rows = np.diff(begins, append=len(values))
    least, most, mean = (np.where(is_far, bound, values) for bound in bounds)
    least, most = np.fmin.reduceat(least, begins), np.fmax.reduceat(most, begins)
    way = np.add.reduceat(np.nan_to_num(np.abs(np.diff(values, prepend=values[:1]))), begins)
    span = most - least
    to_and_fro = (span > noise) & (way >= 2.0 * span)
    votes, voters = (
        np.convolve(them, np.ones(_NEIGHBOURS))[_NEIGHBOURS // 2 : -(_NEIGHBOURS // 2)]
        for them in (to_and_fro, np.ones(len(begins)))
    )
    is_band = (votes > voters / 2.0) | np.logical_or.reduceat(is_far, begins)
    added = np.exp(1j * np.radians(mean)) if turns else mean
    with np.errstate(invalid='ignore'):
        count = np.add.reduceat(np.isfinite(mean), begins)
        average = np.add.reduceat(np.nan_to_num(added), begins) / count
    average = np.interp(np.arange(len(values)), begins + (rows - 1) / 2.0, average)
    average = np.degrees(direction(average)) if turns else average
    is_band, least, most = (np.repeat(part, rows) for part in (is_band, least, most))
    return Envelope(is_band, least, most, average)

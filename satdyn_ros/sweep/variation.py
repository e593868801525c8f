"""How one quantity varies: over a grid, or drawn in every run."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.key import Key
from ..kernel import rotation

_COUNT = Key('the count of linspace', 'integer', 1, '', '', low=1, high=10**7)


@dataclass(frozen=True)
class Variation:
    """
    The values of one quantity: those of a grid or, if it is empty, drawn.

    Attributes
    ----------
    given : object
        as the sweep file has it
    grid : tuple
        the values
    draw : function of a Generator
        returns the random numbers of one run
    values_of_draws : function of the numbers of M runs
        returns the values (M,) or (M, k)
    """

    given: Any
    grid: tuple[Any, ...] = ()
    draw: Callable[[np.random.Generator], Any] = lambda rng: None
    values_of_draws: Callable[[np.ndarray], np.ndarray] = lambda draws: draws

    def drawn(self, rng: np.random.Generator) -> Any:
        """Return one value: of a grid any, all alike."""
        if self.grid:
            return self.grid[rng.integers(len(self.grid))]
        return self.values_of_draws(np.array([self.draw(rng)]))[0]


def variation(key: Key, given: Any) -> Variation:
    """
    Return how a quantity varies, as the sweep file gives it.

    {values: [...]}; {linspace: [first, last, count]}; {uniform: [low, high]};
    {normal: [mean, standard deviation]}, vectors by component; sphere: attitudes uniform on the
    sphere of unit quaternions.  ValueError, in one sentence: it is not one of these, or not
    allowed.

    >>> variation(Key('x', 'double', 0.0, '', ''), {'linspace': [0, 1, 3]}).grid
    (0.0, 0.5, 1.0)
    """
    if given == 'sphere' and key.lengths == (4,):
        # Four independent normal numbers have no preferred direction.
        return Variation(
            given,
            draw=lambda rng: rng.standard_normal(4),
            values_of_draws=rotation.normalise,
        )
    if not isinstance(given, Mapping) or len(given) != 1 or next(iter(given)) not in _WAYS:
        sphere = ', or sphere' if key.lengths == (4,) else ''
        raise ValueError(
            f'{key.name} in vary is {given}; it must be one of {", ".join(_WAYS)}{sphere}'
        )
    ((way, arguments),) = given.items()
    length, make = _WAYS[way]
    if not isinstance(arguments, list) or len(arguments) != (length or len(arguments) or 1):
        what = f'a list of {length}' if length else 'a list that is not empty'
        raise ValueError(f'{way} of {key.name} is {arguments}; it must be {what}')
    if way != 'values' and key.kind not in ('double', 'double_array'):
        raise ValueError(
            f'{key.name} varies by {way}; a quantity that is not a number allows only values'
        )
    return make(key, given, arguments)


def _values(key, given, values):
    return Variation(given, grid=tuple(key.checked(value) for value in values))


def _linspace(key, given, arguments):
    first, last = (np.array(key.checked(value)) for value in arguments[:2])
    _refuse_other_length(key, first, last)
    points = np.linspace(first, last, _COUNT.checked(arguments[2]))
    return Variation(given, grid=tuple(_as_floats(point) for point in points))


def _uniform(key, given, arguments):
    low, high = (np.array(key.checked(value)) for value in arguments)
    _refuse_other_length(key, low, high)
    if not np.all(low <= high):
        raise ValueError(f'uniform of {key.name} is {arguments}; the lower bound comes first')
    return Variation(
        given,
        draw=lambda rng: rng.random(low.shape),
        values_of_draws=lambda draws: low + (high - low) * draws,
    )


def _normal(key, given, arguments):
    mean = np.array(key.checked(arguments[0]))
    deviation_key = Key(
        f'the standard deviation of {key.name}',
        key.kind,
        0.0,
        key.unit,
        '',
        low=0.0,
        lengths=key.lengths,
    )
    deviation = np.array(deviation_key.checked(arguments[1]))
    _refuse_other_length(key, mean, deviation)
    return Variation(
        given,
        draw=lambda rng: rng.standard_normal(mean.shape),
        values_of_draws=lambda draws: mean + deviation * draws,
    )


# The ways to vary, and how many entries their lists have; None: any.
_WAYS = {
    'values': (None, _values),
    'linspace': (3, _linspace),
    'uniform': (2, _uniform),
    'normal': (2, _normal),
}

# Every way as a sweep file writes it, and what it means.
WAYS = {
    '{values: [A, B, ...]}': 'a grid: each of the values',
    '{linspace: [FIRST, LAST, COUNT]}': 'a grid: evenly spaced, both ends included',
    '{uniform: [LOW, HIGH]}': 'drawn anew in each run, evenly between the two',
    '{normal: [MEAN, DEVIATION]}': 'drawn anew in each run, with a standard deviation',
    'sphere': 'attitudes only: drawn anew, uniform on the sphere of unit quaternions',
}


def _refuse_other_length(key, first, second):
    if first.shape != second.shape:
        raise ValueError(f'{key.name} in vary must have two lists of the same length')


def _as_floats(value):
    return tuple(float(x) for x in value) if np.ndim(value) else float(value)

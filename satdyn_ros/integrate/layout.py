"""
What is where in the arrays of a step; in lanes each of their numbers is one of each lane.

    frame        t, h, and the times from tick 0 between which the torques are smooth; the times of
                 the 16 stages; the error and the part before a corner
    y            the variables at the end of the step
    dense        8 rows, the terms of the dense output, the first the variables at its start
    k            16 rows, the stages
    errors       2 rows, the errors by the orders 3 and 5
    constants    the numbers of the Constants
    arrays       the addresses of their arrays
"""

from typing import NamedTuple

from ..dynamics.constants import ROTOR_SIZE, Constants
from ..dynamics.variables import Variables
from ..trace.graph import flatten

ARRAYS = 'frame', 'y', 'dense', 'k', 'errors', 'constants', 'arrays'
# What is in the frame.
T, H, FROM_S, UNTIL_S, STAGE_S = range(5)
STAGES, EVALUATED, TERMS = 16, 12, 8
ERROR = STAGE_S + STAGES
PART = ERROR + 1
FRAME = PART + 1
# As many variables of one motion are combined at once.
PACK = 4


def row_length(size: int, lanes: int) -> int:
    """Return how many variables a row has room for, of motions of `size` variables."""
    return size if lanes > 1 else -(-size // PACK) * PACK


class Layout(NamedTuple):
    """
    What is where in a kind of motions.

    size: the number of variables, anomaly: where the true anomaly is among them, 0: it is not;
    numbers and arrays: how many the Constants have; rotors: of those that turn; rotors_at: where
    they begin among the numbers, events_at: their event functions, 0: there are none;
    momenta: where the rotors' are among the variables; cuts_first: whether a step that
    misses the tolerance is cut at a corner before its error shortens it.
    """

    size: int
    anomaly: int
    rotors: int
    rotors_at: int
    events_at: int
    momenta: int
    cuts_first: bool
    numbers: int
    arrays: int

    @classmethod
    def of(cls, constants: Constants) -> 'Layout':
        """Return the layout of a kind of Constants."""
        numbers, arrays = flatten(constants)
        before, _ = flatten(constants[: constants._fields.index('rotors')])
        rotors, rotors_at, parts = len(constants.rotors), len(before), Variables.of(constants)
        return cls(
            size=parts.size,
            anomaly=parts.anomaly.start if constants.integrates_anomaly else 0,
            rotors=rotors,
            rotors_at=rotors_at,
            events_at=rotors_at + ROTOR_SIZE * rotors if constants.events else 0,
            momenta=parts.momenta.start,
            cuts_first=constants.corner_search.ahead > 0.0,
            numbers=len(numbers),
            arrays=len(arrays),
        )

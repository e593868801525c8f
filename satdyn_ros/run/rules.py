"""
The rules of runs, raised by every change of what a run computes or records.

A bag names those of its run, by which it is run again whatever the version that reads it.  A name
here is the first of the rules by which something is as it is now.
"""

from ..torques.corner_search import CornerSearch

# By rules 0, of versions 0.1 and 0.2, timeouts, drops and halts act where the bag has them.
EVENTS_FOLLOW = 1
# Before, the mountings of the sensors were on /tf.
MOUNTINGS_ARE_LATCHED = 2
# Before, an integrating gyro gave the rotation vector between its samples, divided by their time.
TURNS_ARE_COUNTED = 3
# Before, max_speed acted at ticks: the bag says where it dropped the torque of a rotor.
LIMITS_AT_THEIR_INSTANT = 3
# Before, a plate's coefficients defaulted to those of the key, not to surface.*.
PLATES_FOLLOW_THE_SURFACE = 4
# Before, the status of geodetic was -2, unknown.
GEODETIC_HAS_A_FIX = 4
# Before, tables of an ephemeris and of the Sun ran across rows and leap seconds, and element sets
# that are out of their ranges, or of SGP4-XP, flew.
TABLES_END_WHERE_THEY_MUST = 4
# Before, the compiler contracted products and sums, each version of it in its own way.
SOURCE_DEFINES_THE_BITS = 5
# Before, corners in pairs within a step were missed, and steps beside a contact with the shadow
# were as long as others.
STEPS_SEE_PAIRS = 5
# Before, a step with a corner inside was shortened by its error until the corner was at its end,
# and the corner was looked for by a parabola.
STEPS_END_AT_CORNERS = 6

# Before, a step did not foresee a corner that comes soon after it, at which the next one ends.
STEPS_FORESEE_CORNERS = 7

RULES = 7


def corner_search(rules: int) -> CornerSearch:
    """Return how steps find the corners at which they end."""
    if rules >= STEPS_FORESEE_CORNERS:
        return CornerSearch()
    if rules >= STEPS_END_AT_CORNERS:
        return CornerSearch(reach=0.0)
    return CornerSearch(
        share=1e-3,
        ahead=0.0,
        at_begin=1e-6,
        least=1e-3,
        reach=0.0,
        sees_pairs=rules >= STEPS_SEE_PAIRS,
    )

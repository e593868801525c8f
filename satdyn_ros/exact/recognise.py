"""The closed form of a system and a state, by the conditions of the papers, or why it has none."""

import numpy as np

from ..dynamics.system import State, System
from .exact_motion import ExactMotion
from .free import Free
from .planar import Planar
from .stationary import Stationary
from .steady import Steady
from .symmetric import Symmetric

# The simplest motion first: several hold for a steady rotation or a symmetric body.
CANDIDATES: tuple[type[ExactMotion], ...] = (Steady, Free, Planar, Symmetric, Stationary)

_ON_AN_ELLIPSE = (
    '; there are closed forms there only where the field does not turn the body: three equal '
    'moments, or a spin about the orbit normal of a body symmetric about it'
)


def recognise(system: System, state: State, start_s: float = 0.0) -> ExactMotion | None:
    """
    Return the motion of a system from a state in closed form, or None.

    A condition counts as met where rounding of the input could break it, 1e-12 relative
    (axes.py, equilibria.py).

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state at start_s
    start_s : s
        time from tick 0

    Examples
    --------
    >>> motion = recognise(system, state)  # doctest: +SKIP
    """
    for candidate in CANDIDATES:
        if candidate.why_not(system, state, start_s) is None:
            return candidate(system, state, start_s)
    return None


def explain(system: System, state: State, start_s: float = 0.0) -> str | None:
    """
    Return one sentence that says why there is no closed form, or None if there is one.

    It covers the motions that the field allows: on an orbit only the planar ones, without a field
    the free ones.

    Parameters
    ----------
    system : System
        what moves
    state : State
        its state at start_s
    start_s : s
        time from tick 0
    """
    reasons = {candidate: candidate.why_not(system, state, start_s) for candidate in CANDIDATES}
    if None in reasons.values():
        return None
    if not system.is_newtonian:
        return reasons[Planar]
    if system.orbit.has_lvlh:
        return f'{reasons[Planar]}{_ON_AN_ELLIPSE if system.orbit.is_eccentric else ""}'
    has_field = system.orbit.gradient_at(0.0) != 0.0 or np.any(system.weight_moment)
    of_the_field = (Planar, Symmetric, Stationary) if has_field else (Free, Symmetric)
    return '; '.join(f'{motion.name}: {reasons[motion]}' for motion in of_the_field)

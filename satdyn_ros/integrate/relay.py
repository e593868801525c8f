"""Motions that take over from each other: what a command changes is numbers, not objects."""

import numpy as np

from ..dynamics.system import State, System
from ..dynamics.variables import ATTITUDE, RATE, Variables
from .lanes import REACHED, UNFINISHED
from .one_lane import OneLane
from .propagation import Propagation


class Relay:
    """
    Motions of one body, each a Propagation bit by bit; the next begins where one ends.

    They are computed in one lane, and what a tick needs of them in plain numbers.
    """

    def __init__(self, motion: Propagation):
        system = motion.system
        self._lane = OneLane(system, motion.begin(), motion.new_course(), motion.wanted)
        self._turning: list[tuple[int, float, float, float, float]] = [
            (i, float(rotor.inertia), *rotor.axis.tolist()) for i, rotor in system.turning_rotors
        ]
        self._parts = Variables.of(system)
        self._own_names = [n for torque in system.torques for n in torque.inner_names]
        self._coupled: list[tuple[float, float, float]] = [
            tuple(mode.coupling.tolist()) for mode in system.modes
        ]
        self._t_s = np.zeros(1)
        self._lane.problem.ask(self._t_s)
        # The variables where it stands; of the turning rotors the body rate along the axis and the
        # speed [rad/s]; of the modes d . omega and eta'.
        self._y: list[float] = []
        self._along: list[float] = []
        self._speeds: list[float] = []
        self._moved: list[float] = []
        self._swings: list[float] = []

    def reaches(self, t_s: float) -> bool:
        """Go on to a time [s] since the present motion began; return whether it gets there."""
        problem = self._lane.problem
        self._t_s[0], problem.rows[0], problem.outcome[0] = t_s, 0, UNFINISHED
        while not self._lane.walk_on(self._t_s):
            pass
        if problem.outcome[0] != REACHED:
            return False
        y = self._y = problem.out[0, :, 0].tolist()
        x, y_, z = y[RATE]
        self._along = [x * a + y_ * b + z * c for _, _, a, b, c in self._turning]
        self._speeds = [
            p / J - along
            for p, (_, J, *_), along in zip(
                y[self._parts.momenta], self._turning, self._along, strict=True
            )
        ]
        self._moved = [x * a + y_ * b + z * c for a, b, c in self._coupled]
        momenta = y[self._parts.modal_momenta]
        self._swings = [pi - moved for pi, moved in zip(momenta, self._moved, strict=True)]
        return True

    def takes_over(self, system: System, start_s: float) -> bool:
        """
        Let the next motion begin where this one stands, under the torques of a system.

        start_s: from tick 0.  Return whether it is of the same kind; if not, nothing changes.
        """
        y, parts = self._y, self._parts
        begin = self._lane.problem.begin[0].copy()
        begin[: len(y)] = y
        for n, (_, J, *_) in enumerate(self._turning):
            begin[parts.momenta.start + n] = J * (self._speeds[n] + self._along[n])
        for n, (swing, moved) in enumerate(zip(self._swings, self._moved, strict=True)):
            begin[parts.modal_momenta.start + n] = swing + moved
        begin[parts.work] = 0.0
        return self._lane.takes(system, begin, start_s, self.state)

    def state(self) -> State:
        """Return the state where it stands."""
        y, system = self._y, self._lane.system
        speeds = [np.nan] * len(system.rotors)
        angles = speeds.copy()
        turned = y[self._parts.angles]
        for n, (i, *_) in enumerate(self._turning):
            speeds[i], angles[i] = self._speeds[n], turned[n]
        inner: dict[str, float] = {}
        for mode, eta, swing in zip(
            system.modes, y[self._parts.displacements], self._swings, strict=True
        ):
            inner |= {mode.displacement_name: eta, mode.rate_name: swing}
        inner |= zip(self._own_names, y[self._parts.of_torques], strict=True)
        return State(np.array(y[ATTITUDE]), np.array(y[RATE]), speeds, angles, inner)

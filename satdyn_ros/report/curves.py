"""What is drawn over time, and its bounds in each row."""

import numpy as np

from ..kernel import rotation
from ..run.samples import Samples, merged
from ..torques.gravity_gradient import gravity_gradient

# Samples that are held at a time, with what is drawn of them: a few megabytes.
HELD_TICKS = 4096


def curves(samples: Samples) -> dict[str, np.ndarray]:
    """
    Return what is drawn over time of samples, (N, k) each.

    attitude: roll, pitch and yaw to LVLH, or to inertial axes without an orbit [rad]; rate: body
    rate in body axes [rad/s]; torque: gravity gradient in body axes [N m]; rotor_speed [rad/s].
    """
    states = samples.states
    q = states.q_lb if states.orbit.has_lvlh else states.q_ib
    return {
        'attitude': rotation.roll_pitch_yaw(q),
        'rate': states.omega_bi_b,
        'torque': field_torque(samples),
        'rotor_speed': rotor_columns(states.rotor_speed),
    }


def rotor_columns(values: np.ndarray) -> np.ndarray:
    """Return a quantity of the rotors as a table (N, R), R rotors."""
    return np.reshape(values, (len(values), -1))


def field_torque(samples: Samples) -> np.ndarray:
    """Return the gravity-gradient torque in body axes [N m], (N, 3)."""
    states = samples.states
    gradient = states.orbit.gradient_at(states.orbit_s)
    return gravity_gradient(samples.system.inertia, states.c_b, gradient)


class Bounds:
    """The least and the most of every curve, and the angle turned, over all ticks of each row."""

    def __init__(self, first_tick: int, rows: int, every: int, tick_s: float):
        self._first_tick, self._rows, self._every, self._tick_s = first_tick, rows, every, tick_s
        self.turned = np.zeros(rows)
        self.least: dict[str, np.ndarray] = {}
        self.most: dict[str, np.ndarray] = {}
        self._waiting: list[Samples] = []

    def take(self, samples: Samples) -> None:
        """Take the next samples; a row continues from one block of them to the next."""
        self._waiting.append(samples)
        if samples.first_tick + len(samples) - self._waiting[0].first_tick >= HELD_TICKS:
            self.close()

    def close(self) -> None:
        """Take into account what was taken; whatever acted, the curves are those of the states."""
        if not self._waiting:
            return
        samples, self._waiting = merged(self._waiting), []
        tick = samples.first_tick - self._first_tick + np.arange(len(samples))
        row, begins = np.unique(tick // self._every, return_index=True)
        rate = np.linalg.norm(samples.states.omega_bi_b, axis=-1)
        self.turned[row] += np.add.reduceat(rate, begins) * self._tick_s
        for name, values in curves(samples).items():
            if name not in self.least:
                self.least[name] = np.full((self._rows, values.shape[1]), np.inf)
                self.most[name] = np.full((self._rows, values.shape[1]), -np.inf)
            least, most = self.least[name], self.most[name]
            least[row] = np.minimum(least[row], np.minimum.reduceat(values, begins))
            most[row] = np.maximum(most[row], np.maximum.reduceat(values, begins))

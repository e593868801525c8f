"""What is drawn over time, and its bounds in each row."""

from collections.abc import Iterable

import numpy as np

from ..kernel import rotation
from ..run.samples import Samples, merged
from ..run.scenario import Scenario
from ..run.topics import Topic

# Samples that are held at a time, with what is drawn of them: a few megabytes.
HELD_TICKS = 4096


def topics_with_panels(scenario: Scenario) -> list[Topic]:
    """Return the topics of a scenario that have a panel of their own."""
    return [
        topic
        for topic in scenario.topic_table.values()
        if topic.panel is not None and not topic.lacking(scenario.system)
    ]


def shown(topics: Iterable[Topic], samples: Samples) -> dict[str, np.ndarray]:
    """Return what topics show of samples, (N, k) each, by their names."""
    return {topic.name: topic.shows[0].of(samples) for topic in topics}


def curves(samples: Samples, topics: Iterable[Topic]) -> dict[str, np.ndarray]:
    """
    Return what is drawn over time of samples, (N, k) each.

    attitude: roll, pitch and yaw to LVLH, or to inertial axes without an orbit [rad]; rate: body
    rate in body axes [rad/s]; rotor_speed [rad/s]; and what topics show, by their names.
    """
    states = samples.states
    q = states.q_lb if states.orbit.has_lvlh else states.q_ib
    return {
        'attitude': rotation.roll_pitch_yaw(q),
        'rate': states.omega_bi_b,
        **shown(topics, samples),
        'rotor_speed': rotor_columns(states.rotor_speed),
    }


def rotor_columns(values: np.ndarray) -> np.ndarray:
    """Return a quantity of the rotors as a table (N, R), R rotors."""
    return np.reshape(values, (len(values), -1))


class Bounds:
    """
    The least and the most of every curve, and the angle turned, over all ticks of each row.

    topics: those whose quantities are among the curves.
    """

    def __init__(
        self, first_tick: int, rows: int, every: int, tick_s: float, topics: Iterable[Topic]
    ):
        self._first_tick, self._rows, self._every, self._tick_s = first_tick, rows, every, tick_s
        self._topics = tuple(topics)
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
        for name, values in curves(samples, self._topics).items():
            if name not in self.least:
                self.least[name] = np.full((self._rows, values.shape[1]), np.inf)
                self.most[name] = np.full((self._rows, values.shape[1]), -np.inf)
            least, most = self.least[name], self.most[name]
            least[row] = np.minimum(least[row], np.minimum.reduceat(values, begins))
            most[row] = np.maximum(most[row], np.maximum.reduceat(values, begins))

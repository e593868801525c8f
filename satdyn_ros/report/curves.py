"""What is drawn over time, and its bounds and its mean in each row."""

from collections.abc import Iterable

import numpy as np

from ..dynamics.inertia import ROUNDING, principal_axes
from ..kernel import rotation
from ..run.samples import Samples, merged
from ..run.scenario import Scenario
from ..run.topics import Panel, Topic

# Samples that are held at a time, with what is drawn of them: a few megabytes.
HELD_TICKS = 4096
# Angles that are spread evenly over 220 deg have a mean of this length.
_LEAST_RESULTANT = 0.5


def topics_with_panels(scenario: Scenario) -> list[Topic]:
    """Return the topics of a scenario that have a panel of their own."""
    return [
        topic
        for topic in scenario.topic_table.values()
        if topic.panel is not None and not topic.lacking(scenario.system)
    ]


def component_names(count: int) -> list[str]:
    """Return how the components of what a topic shows are named: those of a vector, or one ''."""
    return [*'xyz'] if count == 3 else [''] * count


def line_names(panel: Panel, count: int) -> list[str]:
    """Return how the lines of a panel of so many are named."""
    return [*panel.lines] or component_names(count)


def shown(topics: Iterable[Topic], samples: Samples) -> dict[str, np.ndarray]:
    """Return what topics show of samples, those with a panel first, (N, k), by their names."""
    return {
        topic.name: np.column_stack(
            [
                part.of(samples)
                for part in topic.shows[: 1 if topic.panel or topic.joints else None]
            ]
        )
        for topic in topics
    }


def curves(samples: Samples, topics: Iterable[Topic]) -> dict[str, np.ndarray]:
    """
    Return what is drawn over time of samples, and what topics show, by their names, (N, k) each.

    Parameters
    ----------
    samples : Samples
        N of them
    topics : iterable of Topic
        what they show is drawn too

    Returns
    -------
    attitude : (N, k), rad
        roll, pitch and yaw to LVLH, or to inertial axes without an orbit, and the angle of the
        axis of least inertia to nadir where there are both
    nadir : (N, 3), rad
        that angle and its parts, see nadir_angles
    rate : (N, 4), rad/s
        body rate in body axes and its length
    rotor_speed : (N, R), rad/s
        of the rotors
    """
    states = samples.states
    omega = states.omega_bi_b
    found = {
        'attitude': rotation.roll_pitch_yaw(states.q_lb if states.orbit.has_lvlh else states.q_ib),
        'rate': np.column_stack([omega, np.linalg.norm(omega, axis=-1)]),
        **shown(topics, samples),
        'rotor_speed': rotor_columns(states.rotor_speed),
    }
    axis_b = least_axis(samples.system.inertia)
    if states.orbit.has_lvlh and axis_b is not None:
        found['nadir'] = nadir_angles(states.q_lb, axis_b)
        found['attitude'] = np.column_stack([found['attitude'], found['nadir'][:, 0]])
    return found


def least_axis(inertia: np.ndarray) -> np.ndarray | None:
    """Return the axis of least inertia (3,), body axes; None: the least two moments are equal."""
    moments, R_bp = principal_axes(inertia)
    least, middle, largest = np.sort(moments)
    return R_bp[:, np.argmin(moments)] if middle - least > ROUNDING * largest else None


def nadir_angles(q_lb: np.ndarray, axis_b: np.ndarray) -> np.ndarray:
    """
    Return the angle of an axis of the body, its nearer end, to nadir and its parts (N, 3) [rad].

    The parts are by how much that end leans along track and towards the orbit normal: the squares
    of their sines add up to that of the angle's.
    """
    axis_l = rotation.rotate(q_lb, axis_b)
    # Nadir is z of LVLH, and y is minus the orbit normal.
    x, y, z = np.moveaxis(axis_l * np.where(axis_l[:, 2:] < 0.0, -1.0, 1.0), -1, 0)
    across = np.hypot(x, y)
    return np.column_stack([np.arctan2(across, z), np.arcsin(np.clip([x, -y], -1.0, 1.0)).T])


def rotor_columns(values: np.ndarray) -> np.ndarray:
    """Return a quantity of the rotors as a table (N, R), R rotors."""
    return np.reshape(values, (len(values), -1))


class Bounds:
    """
    Least, most and mean of every curve, and the angle turned, over all ticks of each row.

    The mean of roll, pitch and yaw is that of directions; nan: there are too many.

    Parameters
    ----------
    row_ticks : (N,) int
        the first tick of each row, which lasts up to the next one's
    tick_s : s
        from tick to tick
    topics : iterable of Topic
        those whose quantities are among the curves
    """

    def __init__(self, row_ticks: np.ndarray, tick_s: float, topics: Iterable[Topic]):
        self._row_ticks, self._rows, self._tick_s = row_ticks, len(row_ticks), tick_s
        self._topics = tuple(topics)
        self.turned = np.zeros(self._rows)
        self.least: dict[str, np.ndarray] = {}
        self.most: dict[str, np.ndarray] = {}
        self._sums: dict[str, np.ndarray] = {}
        self._counts = np.zeros(self._rows)
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
        tick = samples.first_tick + np.arange(len(samples))
        row_of_tick = np.searchsorted(self._row_ticks, tick, side='right') - 1
        row, begins = np.unique(row_of_tick, return_index=True)
        rate = np.linalg.norm(samples.states.omega_bi_b, axis=-1)
        self.turned[row] += np.add.reduceat(rate, begins) * self._tick_s
        self._counts[row] += np.diff(begins, append=len(samples))
        for name, values in curves(samples, self._topics).items():
            if name not in self.least:
                self.least[name] = np.full((self._rows, values.shape[1]), np.inf)
                self.most[name] = np.full((self._rows, values.shape[1]), -np.inf)
                kind = complex if name == 'attitude' else float
                self._sums[name] = np.zeros((self._rows, values.shape[1]), kind)
            least, most = self.least[name], self.most[name]
            least[row] = np.minimum(least[row], np.minimum.reduceat(values, begins))
            most[row] = np.maximum(most[row], np.maximum.reduceat(values, begins))
            added = np.exp(1j * values) if name == 'attitude' else values
            self._sums[name][row] += np.add.reduceat(added, begins)

    @property
    def mean(self) -> dict[str, np.ndarray]:
        """By the name of a curve its mean over all ticks of a row."""
        means = {name: sums / self._counts[:, None] for name, sums in self._sums.items()}
        return means | {'attitude': direction(means['attitude'])}


def direction(mean: np.ndarray) -> np.ndarray:
    """Return the angle [rad] of means of unit numbers; nan: they go all ways."""
    return np.where(np.abs(mean) > _LEAST_RESULTANT, np.angle(mean), np.nan)

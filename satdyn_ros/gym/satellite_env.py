"""One satellite as an environment of Gymnasium."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from ..bag.recordable import RecordableSimulation
from ..run.simulation import RunHalted
from .task import Task
from .tasks import task_of


class SatelliteEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """
    A satellite in an environment of Gymnasium.

    An episode whose motion halts is over there; its info says why, under halted.

    Parameters
    ----------
    task : Task or str
        the task, or the name of a shipped one
    record : str or Path
        a directory for a bag of each episode, episode_0000 and so on; a bag is complete when the
        next one begins, or at close()

    Examples
    --------
    >>> env = SatelliteEnv('Detumble')  # doctest: +SKIP
    >>> seen, info = env.reset(seed=1)  # doctest: +SKIP
    >>> seen, reward, *_ = env.step(env.action_space.sample())  # doctest: +SKIP
    """

    metadata = {'render_modes': []}  # noqa: RUF012 - as its base class has it

    def __init__(self, task: Task | str, record: str | Path | None = None):
        self.task, self._record = task_of(task), record
        self.action_space, self.observation_space = spaces(self.task)
        self._episodes = 0
        self._simulation: RecordableSimulation | None = None
        self._seen: Mapping[str, np.ndarray] = {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """
        Begin an episode and return its first observation.

        Parameters
        ----------
        seed : int
            of what the task draws
        options : dict
            not used

        Raises
        ------
        ValueError
            as for Task.draw
        """
        super().reset(seed=seed)
        scenario = self.task.draw(self.np_random)
        self.close()
        bag = None
        if self._record is not None:
            bag = Path(self._record) / f'episode_{self._episodes:04d}'
        self._simulation = RecordableSimulation(scenario, record=bag)
        self._episodes += 1
        self._simulation.advance(1)
        self._seen = {}
        return self._observe(self._simulation.sample), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """
        Act once.

        Parameters
        ----------
        action : (A,)
            from -1 to 1; beyond, it is cut

        Raises
        ------
        ValueError
            the action has a nan, or another shape
        """
        task, simulation = self.task, self._simulation
        if simulation is None:
            raise gymnasium.error.ResetNeeded('reset the environment before its first step')
        numbers, info = task.actions(action, ()), dict[str, Any]()
        commands = task.commands(numbers)
        try:
            for _ in range(task.ticks_of_an_action):
                sample = simulation.step(**commands)
                commands = task.held(commands)
                if task.senses:
                    self._seen = task.seen(sample, self._seen)
        except RunHalted as halted:
            info['halted'] = str(halted)
        sample = simulation.sample
        reward = float(task.reward(sample, numbers))
        ends = bool(info) or (task.ends is not None and bool(task.ends(sample)))
        return self._observe(sample), reward, ends, simulation.tick >= task.ticks, info

    def _observe(self, sample):
        self._seen = self.task.seen(sample, self._seen)
        return self.task.observed(self._seen, ())

    def close(self) -> None:
        """Complete the bag of the present episode."""
        if self._simulation is not None:
            self._simulation.close()


def spaces(task: Task) -> tuple[Box, Box]:
    """Return the spaces of the actions and of the observations of a task."""
    simulation = RecordableSimulation(task.scenario)
    simulation.advance(1)
    size = task.observed(task.seen(simulation.sample, {}), ()).size
    actions = Box(-1.0, 1.0, (task.action_size,), np.float32)
    return actions, Box(-np.inf, np.inf, (size,), np.float64)

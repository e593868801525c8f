"""Many satellites in step as one vector environment of Gymnasium."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ..run.side_by_side import SideBySide
from .satellite_env import spaces
from .task import Task
from .tasks import task_of


class SatelliteVectorEnv(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """
    Satellites in step, in lanes of the processor: a vector environment of Gymnasium.

    They have the states and the observations of as many SatelliteEnv, the first with the seed of
    reset(), each with one more than the one before.

    Parameters
    ----------
    task : Task or str
        the task, or the name of a shipped one
    num_envs : int
        how many satellites
    autoreset_mode : AutoresetMode
        any of Gymnasium's: at the step after the end of an episode, whose action is then ignored;
        at the last step, with final_obs and final_info in the info; or not at all

    Raises
    ------
    ValueError
        there is no satellite, or the variations make some of different kinds (SideBySide)

    Examples
    --------
    >>> envs = SatelliteVectorEnv('Detumble', 1024)  # doctest: +SKIP
    """

    def __init__(
        self,
        task: Task | str,
        num_envs: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    ):
        if num_envs < 1:
            raise ValueError(f'num_envs is {num_envs}; it must be an integer of at least 1')
        self.task, self.num_envs = task_of(task), num_envs
        self._mode = AutoresetMode(autoreset_mode)
        self.metadata = {'render_modes': [], 'autoreset_mode': self._mode}
        self.single_action_space, self.single_observation_space = spaces(self.task)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._generators: list[np.random.Generator | None] = [None] * num_envs
        self._runs: SideBySide | None = None
        self._seen: Mapping[str, np.ndarray] = {}
        self._are_over = np.zeros(num_envs, bool)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """
        Begin episodes and return their first observations.

        Parameters
        ----------
        seed : int or M of them
            of the first, each further one has one more; or one for each
        options : dict
            reset_mask (M,) bool, which of them begin; by default, and the first time, all
        """
        count = self.num_envs
        if seed is None:
            seed = [None] * count
        seeds = [*seed] if isinstance(seed, Iterable) else [seed + m for m in range(count)]
        if len(seeds) != count:
            raise ValueError(f'seed has the length {len(seeds)}; it must be {count}')
        begin = np.ones(count, bool)
        if options is not None and 'reset_mask' in options and self._runs is not None:
            begin = np.asarray(options['reset_mask'], bool)
            if begin.shape != (count,):
                raise ValueError(f'reset_mask has the shape {begin.shape}; it must be {(count,)}')
        for m in np.flatnonzero(begin).tolist():
            if seeds[m] is not None or self._generators[m] is None:
                self._generators[m], _ = seeding.np_random(seeds[m])
        self._begin(begin)
        self._are_over[begin] = False
        return self._observation(), {}

    def _begin(self, which):
        """Let episodes begin in some of the runs (M,)."""
        scenarios = {
            m: self.task.draw(self._generators[m]) for m in np.flatnonzero(which).tolist()
        }
        if self._runs is None or which.all():
            self._runs = SideBySide([*scenarios.values()])
            self._seen = {}
        elif scenarios:
            self._runs.begin(scenarios)
            # What they have not measured yet is zero.
            self._seen = {k: np.where(which[:, None], 0.0, x) for k, x in self._seen.items()}
        self._seen = self.task.seen(self._runs.sample, self._seen)

    def _observation(self):
        return self.task.observed(self._seen, (self.num_envs,))

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """
        Act once in each.

        Parameters
        ----------
        actions : (M, A)
            from -1 to 1; beyond, they are cut

        Raises
        ------
        ValueError
            an action has a nan, they have another shape, or an episode is over
        """
        task, runs, ended = self.task, self._runs, self._are_over
        if runs is None:
            raise ValueError('reset the environments before their first step')
        if self._mode == AutoresetMode.DISABLED and ended.any():
            raise ValueError(
                f'the episode of run {np.flatnonzero(ended)[0]} is over; reset it, by reset_mask'
            )
        anew = ended.copy()
        numbers = task.actions(actions, (self.num_envs,))
        numbers = np.where(anew[:, None], 0.0, numbers)
        runs.act(**task.commands(numbers))
        for _ in range(task.ticks_of_an_action):
            sample = runs.step(~anew)
            if task.senses:
                self._seen = task.seen(sample, self._seen)
        infos: dict[str, Any] = {}
        rewards = np.where(anew, 0.0, task.reward(runs.sample, numbers))
        halted = np.isin(np.arange(self.num_envs), [*runs.halted]) & ~anew
        over = (
            halted if task.ends is None else halted | (np.asarray(task.ends(runs.sample)) & ~anew)
        )
        out_of_time = (runs.tick >= task.ticks) & ~anew
        said = {m: {'halted': runs.halted[m]} for m in np.flatnonzero(halted).tolist()}
        self._are_over = over | out_of_time
        if self._mode == AutoresetMode.SAME_STEP and self._are_over.any():
            anew = self._are_over
            seen = task.observed(task.seen(runs.sample, self._seen), (self.num_envs,))
            self._are_over = np.zeros(self.num_envs, bool)
            for m in np.flatnonzero(anew).tolist():
                final = {'final_obs': seen[m], 'final_info': said.pop(m, {})}
                infos = self._add_info(infos, final, m)
        for m, info in said.items():
            infos = self._add_info(infos, info, m)
        if anew.any():
            self._begin(anew)
        else:
            self._seen = task.seen(runs.sample, self._seen)
        return self._observation(), rewards, over, out_of_time, infos

"""What an episode is: a scenario and what varies in it, what is seen, done and rewarded."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import isfinite
from typing import Any

import numpy as np

from ..run.in_place import replaced
from ..run.keys import KEYS
from ..run.scenario import Scenario
from ..sweep.plan import Varied, varied

# What a sample holds that is numbers, or has some by name.
_SEEN = (
    *('t_s', 'q_ib', 'omega_bi_b', 'rotor_speed', 'rotor_angle', 'r_i', 'v_i'),
    *('magnetic_field_b', 'sun_b', 'sunlight', 'torques_b', 'measured'),
)
_MOST_SEEDS = int(KEYS['sensors.seed'].high)


@dataclass(frozen=True)
class Task:
    """
    An episode of learning.

    In a sample each run has a row.  Functions that work along the last axis only, [..., 0] and
    axis=-1, serve one run and many.

    Parameters
    ----------
    scenario : Scenario
        the scenario
    observation : dict
        scale factors by name of a part of the sample, such as omega_bi_b, magnetic_field_b or
        measured.gyro; a measurement holds until the sensor measures again, and is zero before
    action : dict
        by keyword of Simulation.step the command at an action of 1, a number or a list of numbers,
        or these by name: {'dipole_b': [0.2, 0.2, 0.2]}, {'rotor_torque': {'rw_x': 1e-3}}; for a
        thruster the on-time [s], with no pulse at an action of 0 or below
    reward : function
        of the sample after an action and of the actions (..., A) from -1 to 1; returns a number,
        or (M,) with one for each run
    duration_s : s
        of an episode
    interval_s : s
        from action to action
    vary : dict
        what is drawn for each episode, as in a sweep file
    ends : function
        of a sample: whether the episode is over there

    Raises
    ------
    ValueError
        a value is not allowed, in one sentence

    Examples
    --------
    >>> task = Task(scenario, observation={'omega_bi_b': 10.0},  # doctest: +SKIP
    ...     action={'torque_b': [1e-3, 1e-3, 1e-3]}, duration_s=60.0, interval_s=0.5,
    ...     reward=lambda sample, action: -np.sum(sample.omega_bi_b**2, axis=-1),
    ...     vary={'initial.attitude': 'sphere'})
    """

    scenario: Scenario
    observation: Mapping[str, float]
    action: Mapping[str, Any]
    reward: Callable[[Any, np.ndarray], Any]
    duration_s: float
    interval_s: float
    vary: Mapping[str, Any] = field(default_factory=dict)
    ends: Callable[[Any], Any] | None = None

    def __post_init__(self) -> None:
        for name in ('interval_s', 'duration_s'):
            given = getattr(self, name)
            ticks = Fraction(str(given)) * self.scenario.rate if isfinite(given) else Fraction(0)
            if ticks < 1 or ticks.denominator != 1:
                raise ValueError(
                    f'{name} is {given}; it must be a multiple of the '
                    f'{float(1 / self.scenario.rate):g} s between ticks'
                )
        words = self.scenario.equipment.of_keyword
        for keyword in self.action:
            if keyword not in words:
                raise ValueError(f'action has {keyword}; it may have {", ".join(words)}')
        if not self.observation:
            raise ValueError(f'observation is empty; a sample holds {", ".join(_SEEN)}')
        for name in self.observation:
            if name.partition('.')[0] not in _SEEN:
                raise ValueError(f'observation has {name}; a sample holds {", ".join(_SEEN)}')
            _, _, sensor = name.rpartition('measured.')
            if sensor != name and sensor not in self.scenario.sensors:
                raise ValueError(
                    f'observation has {name}; sensors.names has '
                    f'{", ".join(self.scenario.sensors) or "none"}'
                )
        assert self._varied is not None

    @cached_property
    def _varied(self) -> tuple[Varied, ...]:
        return varied(self.vary, self.scenario.keys) if self.vary else ()

    @property
    def ticks_of_an_action(self) -> int:
        """The ticks from action to action."""
        return int(Fraction(str(self.interval_s)) * self.scenario.rate)

    @property
    def ticks(self) -> int:
        """The ticks of an episode."""
        return int(Fraction(str(self.duration_s)) * self.scenario.rate)

    @cached_property
    def senses(self) -> bool:
        """Whether a measurement is observed; each tick of an action may have one."""
        return any('measured' in name.split('.') for name in self.observation)

    @cached_property
    def action_size(self) -> int:
        """How many numbers an action has."""
        return sum(np.size(scale) for scale in _leaves(self.action))

    def draw(self, rng: np.random.Generator) -> Scenario:
        """
        Return the scenario of an episode.

        Parameters
        ----------
        rng : Generator
            draws the variations

        Raises
        ------
        ValueError
            a drawn value is not allowed
        """
        values, changes = dict(self.scenario.values), dict[str, Any]()
        for each in self._varied:
            now = each.quantity.changes(values, each.variation.drawn(rng))
            values |= now
            changes |= now
        if self.scenario.sensors:
            changes['sensors.seed'] = int(rng.integers(1, _MOST_SEEDS))
        plain = {k: x.tolist() if isinstance(x, np.ndarray) else x for k, x in changes.items()}
        for name in replaced(plain) & {*plain}:
            del plain[name]
        return self.scenario.with_values(plain)

    def actions(self, given: Any, rows: tuple[int, ...]) -> np.ndarray:
        """
        Return actions, (A,), or (M, A) for rows (M,), cut to -1 to 1; a nan stays one.

        ValueError: they have another shape.
        """
        numbers, shape = np.asarray(given, float), (*rows, self.action_size)
        if numbers.shape != shape:
            raise ValueError(f'the action has the shape {numbers.shape}; it must be {shape}')
        return np.clip(numbers, -1.0, 1.0)

    def commands(self, action: np.ndarray) -> dict[str, Any]:
        """
        Return the commands of actions by keyword.

        Parameters
        ----------
        action : (..., A)
            from -1 to 1, or nan, which its actuator refuses
        """
        found = _scaled(self.action, action, 0)[0]
        held = self.held(found)
        # No pulse is shorter than none.
        return {
            keyword: x if keyword in held else {name: np.maximum(0.0, t) for name, t in x.items()}
            for keyword, x in found.items()
        }

    def held(self, commands: Mapping[str, Any]) -> dict[str, Any]:
        """
        Return those commands that hold; others, such as pulses, are given once per action.

        Parameters
        ----------
        commands : dict
            by keyword
        """
        words = self.scenario.equipment.of_keyword
        return {keyword: x for keyword, x in commands.items() if words[keyword][0].is_held}

    def seen(self, sample: Any, before: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """
        Return the observed parts of a sample by name, unscaled, a row for each run or one.

        Parameters
        ----------
        sample : sample
            of one run or many
        before : dict
            what was seen before; it holds for measurements that are missing now
        """
        found = {}
        for name in self.observation:
            what, _, sensor = name.rpartition('measured.')
            if sensor == name or what:
                found[name] = _attribute(sample, name)
                continue
            now = sample.measured.get(sensor)
            held = before.get(name)
            if held is None:
                size = len(type(self.scenario.sensors[sensor]).columns)
                held = np.zeros((*np.shape(sample.t_s), size))
            if now is not None:
                now = np.reshape(now, held.shape)
                held = np.where(np.isnan(now), held, now)
            found[name] = held
        return found

    def observed(self, seen: Mapping[str, np.ndarray], rows: tuple[int, ...]) -> np.ndarray:
        """
        Return the observation, (O,), or (M, O) for rows (M,).

        Parameters
        ----------
        seen : dict
            parts of a sample by name
        rows : tuple
            empty, or (M,)
        """
        parts = [self.observation[name] * np.reshape(x, (*rows, -1)) for name, x in seen.items()]
        return np.concatenate(parts, axis=-1)


def _attribute(sample, name):
    """Return what a sample has under a name; what is behind a dot is in a mapping there."""
    first, _, key = name.partition('.')
    found = getattr(sample, first)
    if isinstance(found, Mapping):
        if key not in found:
            parts = ', '.join(f'{first}.{part}' for part in found) or 'none'
            raise ValueError(f'observation has {name}; of {first} there is {parts}')
        found = found[key]
    elif key:
        raise ValueError(f'observation has {name}; {first} has no parts with names')
    return np.asarray(found, float)


def _leaves(scales):
    for scale in scales.values():
        if isinstance(scale, Mapping):
            yield from _leaves(scale)
        else:
            yield scale


def _scaled(scales, numbers, first):
    """Return commands by the names of scales from numbers on, and the number after the last."""
    found: dict[str, Any] = {}
    for name, scale in scales.items():
        if isinstance(scale, Mapping):
            found[name], first = _scaled(scale, numbers, first)
        elif np.ndim(scale):
            found[name] = numbers[..., first : first + len(scale)] * scale
            first += len(scale)
        else:
            found[name] = numbers[..., first] * scale
            first += 1
    return found, first

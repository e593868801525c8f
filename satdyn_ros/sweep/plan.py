"""The sweep file: which scenario, what varies, for how long; and the scenario of each run."""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..base import ros_yaml
from ..base.key import Key
from ..base.sentences import nearest
from ..run import in_place, parts, pointing
from ..run.keys import KEYS
from ..run.orbits import type_of
from ..run.scenario import Scenario
from ..torques.body_torque import BodyTorque, named
from .capture import LEAST
from .own_controller import OwnController
from .own_outcome import OwnOutcome
from .quantities import Quantity, quantity
from .sweep_keys import REQUIRED, SWEEP_KEYS, checked
from .variation import Variation, variation

_MOST_SEEDS = int(KEYS['sensors.seed'].high)
# What a body points at is one attitude, that of the scenario.
_OF_ALL_RUNS = ('orbit.j2', 'orbit.reference_radius', *pointing.POINTING)


@dataclass(frozen=True)
class Varied:
    """A quantity by its name in the sweep file, and the values it takes."""

    name: str
    quantity: Quantity
    variation: Variation


@dataclass(frozen=True)
class Plan:
    """
    A validated sweep.

    Its runs are every combination of the grids, the first in the file slowest, draws_per_point
    times each.  Run i is a function of the file and i alone.

    Attributes
    ----------
    scenario : Scenario
        of all runs
    vary : tuple of Varied
        what varies
    duration_s : s
        of a run
    interval_s : s
        between the samples from which the extremes and the capture are found
    draws_per_point : int
        runs of each combination
    seed : int
        of what is drawn
    keeps_samples : bool
        whether the samples are kept in the table
    captured_axis : str
        the axis whose capture is judged (capture.py): x, y, z or least
    bags : tuple of int
        the runs of which a bag is recorded
    outcomes : tuple of OwnOutcome
        columns of one's own
    controller : OwnController or None
        in each run, with sensors whose noise is the run's own
    """

    scenario: Scenario
    vary: tuple[Varied, ...]
    duration_s: float
    interval_s: float = 60.0
    draws_per_point: int = 1
    seed: int = 0
    keeps_samples: bool = False
    captured_axis: str = LEAST
    bags: tuple[int, ...] = ()
    outcomes: tuple[OwnOutcome, ...] = ()
    controller: OwnController | None = None

    @classmethod
    def from_yaml(
        cls,
        path: str | Path,
        satellite: str | None = None,
        outcomes: Sequence[str] = (),
        torques: Iterable[type[BodyTorque]] = (),
        controller: str | None = None,
        controller_parameters: Sequence[str] = (),
    ) -> 'Plan':
        """
        Return the sweep of a file.

        Parameters
        ----------
        path : str or Path
            the sweep file
        satellite : str or None
            which one, where the scenario has several
        outcomes : sequence of str
            columns of one's own (own_outcome.py), each by its path, module:function
        torques : iterable of classes
            of one's own
        controller, controller_parameters : str or None, sequence of str
            in place of that of the file: MODULE:CLASS or FILE.py:CLASS, and each NAME=VALUE

        Raises
        ------
        ValueError
            what is wrong with it, in one sentence
        """
        given = ros_yaml.load(ros_yaml.read_text(path, 'the sweep'), str(path))
        if not isinstance(given, Mapping):
            raise ValueError(f'{path} is not a sweep file; its keys are {", ".join(SWEEP_KEYS)}')
        for name in given:
            if name not in SWEEP_KEYS:
                raise ValueError(
                    f'{name} is not a key of a sweep; the nearest is {nearest(name, SWEEP_KEYS)}; '
                    f'allowed: {", ".join(SWEEP_KEYS)}'
                )
        for name in REQUIRED:
            if name not in given:
                raise ValueError(f'{path} has no {name}, which every sweep needs')
        if not isinstance(given['scenario'], str):
            raise ValueError(f'scenario is {given["scenario"]}; it must be the path of a scenario')
        path_of_scenario = Path(path).parent / given['scenario']
        scenario = Scenario.from_yaml(path_of_scenario, satellite, torques)
        if controller is not None:
            given = {**given, 'controller': controller}
            given['controller_parameters'] = controller_parameters
        elif str(given.get('controller', '')).partition(':')[0].endswith('.py'):
            given = {**given, 'controller': f'{Path(path).parent}/{given["controller"]}'}
        plan = cls._checked(scenario, given, tuple(map(OwnOutcome.at, outcomes)))
        plan._refuse_if_all_fail()
        return plan

    @classmethod
    def from_text(cls, text: str) -> 'Plan':
        """Return the sweep of what to_text gave."""
        given = json.loads(text)
        outcomes = tuple(map(OwnOutcome.at, given['outcomes']))
        for own in outcomes:
            if own.sources != given['outcomes'][own.path]:
                raise ValueError(f'{own.path} is not the one with which the sweep began')
        torques = [named(name) for name in given.get('torques', ())]
        scenario = Scenario.from_yaml_text(given['scenario'], torques=torques)
        plan = cls._checked(scenario, given, outcomes)
        if plan.controller and plan.controller.sources != given['controller_sources']:
            raise ValueError(f'{plan.controller.path} is not the one with which the sweep began')
        return plan

    @classmethod
    def _checked(cls, scenario, given, outcomes):
        duration_s = checked(given, 'duration_s')
        vary = varied(given['vary'], scenario.keys)
        is_shared = type_of(scenario.values).is_shared(scenario.values)
        for each in vary:
            if each.quantity.key.name.startswith('orbit.') and is_shared:
                raise ValueError(
                    f'{each.name} varies; an orbit that is integrated, or of an element set or an '
                    'ephemeris, is the same in all runs of a sweep'
                )
            if each.quantity.key.name in _OF_ALL_RUNS or parts.names_one(each.quantity.key.name):
                raise ValueError(f'{each.name} varies; it must be the same in all runs of a sweep')
        plan = cls(
            scenario=scenario,
            vary=vary,
            duration_s=duration_s,
            interval_s=checked({'interval_s': min(60.0, duration_s)} | given, 'interval_s'),
            draws_per_point=checked(given, 'runs'),
            seed=checked(given, 'seed'),
            keeps_samples=checked(given, 'samples'),
            captured_axis=checked(given, 'captured_axis'),
            outcomes=outcomes,
            controller=_controller(given),
        )
        return replace(plan, bags=_bags(given.get('bags', []), len(plan)))

    def __post_init__(self) -> None:
        if self.interval_s > self.duration_s:
            raise ValueError(
                f'interval_s is {self.interval_s:g}; it must be at most duration_s, '
                f'{self.duration_s:g} s'
            )
        if self.controller is not None:
            for name in ('interval_s', 'duration_s'):
                if (Fraction(str(getattr(self, name))) * self.scenario.rate).denominator != 1:
                    raise ValueError(
                        f'{name} is {getattr(self, name):g}; with a controller it must be a '
                        f'multiple of the {1.0 / float(self.scenario.rate):g} s between ticks'
                    )

    def __len__(self) -> int:
        """Return the number of runs."""
        return math.prod(self.shape) * self.draws_per_point

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """The lengths of the grids, in the order of the file."""
        return tuple(len(v.variation.grid) for v in self.vary if v.variation.grid)

    @cached_property
    def t_s(self) -> np.ndarray:
        """The times of the samples [s] (N,), the last at the end."""
        # An end that rounding puts just behind a sample is that sample.
        count = math.ceil(self.duration_s / self.interval_s - 1e-9)
        return np.minimum(np.arange(count + 1) * self.interval_s, self.duration_s)

    @cached_property
    def ticks(self) -> np.ndarray:
        """The ticks of the samples (N,) int64, where both are multiples of ticks."""
        return np.rint(self.t_s * float(self.scenario.rate)).astype(np.int64)

    def values(self, run: int) -> dict[str, Any]:
        """Return what varies in a run, name to value."""
        return {name: values[0] for name, values in self.values_of([run]).items()}

    def values_of(self, runs: Sequence[int]) -> dict[str, list[Any]]:
        """Return what varies in runs, name to the value in each."""
        at = np.array(runs) // self.draws_per_point
        points = iter(np.unravel_index(at, self.shape) if self.shape else ())
        drawn = iter(self._drawn(runs))
        return {
            v.name: [v.variation.grid[i] for i in next(points)]
            if v.variation.grid
            else next(drawn)
            for v in self.vary
        }

    def _drawn(self, runs):
        """Return, for each quantity that is drawn, its values in runs."""
        drawn = [v.variation for v in self.vary if not v.variation.grid]
        draws = zip(*(self._draws(run, drawn) for run in runs), strict=True)
        for each, numbers in zip(drawn, draws, strict=True):
            values = each.values_of_draws(np.array(numbers)).tolist()
            yield [tuple(value) if isinstance(value, list) else value for value in values]

    def _draws(self, run, drawn):
        """Return the random numbers of a run, which do not depend on other runs."""
        if not drawn:
            return []
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(run,)))
        return [each.draw(rng) for each in drawn]

    def scenario_of(self, values: Mapping[str, Any]) -> Scenario:
        """Return the scenario with the varied values in it; ValueError: as Scenario."""
        changed = self.changed(values).items()
        plain = {name: x.tolist() if isinstance(x, np.ndarray) else x for name, x in changed}
        # What is given in place of another key, Scenario puts there itself.
        for name in in_place.replaced(name for name in in_place.IN_PLACE if plain[name]):
            del plain[name]
        return Scenario(plain, self.scenario.torques)

    def scenario_of_run(self, run: int) -> Scenario:
        """Return the scenario of a run, with noise of its own; ValueError: as Scenario."""
        scenario = self.scenario_of(self.values(run))
        if self.controller is None or not scenario['sensors.names']:
            return scenario
        first = scenario['sensors.seed'] or self.seed + 1
        return scenario.with_values({'sensors.seed': (first + run - 1) % _MOST_SEEDS + 1})

    def changed(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """
        Return the values of every key with the varied ones in them, not yet checked.

        values: of one run, or of many as arrays; then the changed values are arrays too.
        """
        changed = dict(self.scenario.values)
        for varied in self.vary:
            changed |= varied.quantity.changes(changed, values[varied.name])
        return changed

    def to_text(self) -> str:
        """Return all that the table depends on, as JSON; the same sweep, the same text."""
        plain = {
            'scenario': self.scenario.to_yaml(),
            'vary': {v.name: v.variation.given for v in self.vary},
            'duration_s': self.duration_s,
            'interval_s': self.interval_s,
            'runs': self.draws_per_point,
            'seed': self.seed,
            'samples': self.keeps_samples,
            'captured_axis': self.captured_axis,
            'bags': self.bags,
            'outcomes': {own.path: own.sources for own in self.outcomes},
        }
        if self.scenario.torques:
            plain['torques'] = [kind.full_name() for kind in self.scenario.torques]
        if self.controller:
            plain['controller'] = self.controller.path
            plain['controller_parameters'] = list(self.controller.parameters)
            plain['controller_sources'] = self.controller.sources
        return json.dumps(plain, indent=1) + '\n'

    def _refuse_if_all_fail(self):
        """Raise the ValueError of the first run if no run of the first hundred has a scenario."""
        errors = []
        for run in range(min(len(self), 100)):
            try:
                self.scenario_of(self.values(run))
                return
            except ValueError as error:
                errors.append(error)
        raise errors[0]


def varied(given: Any, keys: Mapping[str, Key]) -> tuple[Varied, ...]:
    """Return what varies, as a sweep file has it; ValueError, one sentence: it is not allowed."""
    if not isinstance(given, Mapping) or not given:
        raise ValueError(f'vary is {given}; it must map quantities to how each varies')
    for name, (other, _) in in_place.IN_PLACE.items():
        if name in given and other in given:
            raise ValueError(f'{name} and {other} vary; only one of the two may')
    found = [(str(name), quantity(str(name), keys), how) for name, how in given.items()]
    _refuse_if_replaced([(name, what.part_of) for name, what, _ in found])
    return tuple(Varied(name, what, variation(what.key, how)) for name, what, how in found)


def _refuse_if_replaced(names):
    """Raise ValueError where a quantity would replace the value of one before it."""
    for i, (name, part_of) in enumerate(names):
        for before, key in names[:i]:
            if not part_of and key in in_place.of(name):
                raise ValueError(
                    f'{name} varies after {before}, which is a part of it; the whole must come '
                    'first'
                )
            # Each of them changes all parts of the others' kind.
            kinds = {each.rpartition('.')[0] for each in (name, before)}
            if part_of and part_of == key and len(kinds) > 1:
                raise ValueError(f'{before} and {name} vary; only one of the two may')


def _controller(given):
    if not given.get('controller'):
        return None
    path, parameters = checked(given, 'controller'), given.get('controller_parameters', {})
    if isinstance(parameters, Mapping):
        parameters = [f'{name}={json.dumps(value)}' for name, value in parameters.items()]
    elif not isinstance(parameters, Sequence) or isinstance(parameters, str):
        raise ValueError(
            f'controller_parameters is {parameters}; it must map names of parameters to values'
        )
    return OwnController.at(path, parameters)


def _bags(given, count):
    bag = Key('bags', 'integer', 0, '', '', low=0, high=count - 1)
    try:
        return tuple(sorted({bag.checked(run) for run in given}))
    except (TypeError, ValueError):
        raise ValueError(
            f'bags is {given}; it must be a list of runs, integers from 0 to {count - 1}'
        ) from None

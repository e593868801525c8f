"""What closes a loop inside a run: any class that makes commands of samples."""

import importlib.util
import sys
import traceback
from collections.abc import Iterable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..base import ros_yaml
from ..base.imports import own_module
from .sample import Measurement, Sample
from .sample_columns import SampleColumns
from .scenario import Scenario
from .simulation import RunHalted


class Controller(Protocol):
    """
    A controller.

    Attributes
    ----------
    period_s : s or None
        a multiple of the ticks' interval, None: every tick
    needs_truth : bool
        whether its samples have the true states too
    vectorized : bool
        whether it takes columns: in a sweep its samples then have a row for each run, and so have
        its commands
    """

    period_s: float | None
    needs_truth: bool

    def reset(self, scenario: Scenario, seed: int) -> None:
        """Begin: at the start of a run, and at each request and reset."""

    def command(self, sample: Any) -> Mapping[str, Any]:
        """Return commands by the keywords of Simulation.step; what is left out stays."""


class Seen:
    """
    A sample without the true states: what a controller on board knows.

    Attributes
    ----------
    tick, t_s, stamp_ns : int, s, ns
        the tick, its time from tick 0, and its stamp
    measured : dict
        what each sensor publishes at this tick, with its stamp_ns
    rotor_speed : (R,), rad/s
        of each rotor
    r_i, v_i : (3,), m and m/s, inertial
        orbit
    """

    tick: int
    t_s: float
    stamp_ns: int
    measured: dict[str, Measurement]
    rotor_speed: np.ndarray
    r_i: np.ndarray
    v_i: np.ndarray

    def __init__(self, sample: Sample | SampleColumns):
        self._sample = sample

    def __getattr__(self, name: str) -> Any:
        """Return what is known; AttributeError: it is the truth."""
        if name in Seen.__annotations__:
            return getattr(self._sample, name)
        raise AttributeError(
            f'{name} is not known on board; a class with needs_truth = True sees it'
        )


class ControllerFailed(RunHalted):
    """The end of a run whose controller has failed; its text is one sentence."""


def named(full_name: str, parameters: Iterable[str] = ()) -> Controller:
    """
    Return the controller MODULE:CLASS, or FILE.py:CLASS, made with parameters NAME=VALUE.

    A module is imported from the working directory too.  ValueError, in one sentence: there is
    none, or it takes other parameters.
    """
    source, _, name = full_name.rpartition(':')
    try:
        if not (source and name):
            raise ValueError('it must be MODULE:CLASS, or FILE.py:CLASS')
        kind = getattr(_module(source), name)
        controller = kind(**_values(parameters))
    except (Exception, SystemExit) as error:
        raise ValueError(f'the controller {full_name} cannot be made: {_said(error)}') from None
    if not callable(getattr(controller, 'command', None)):
        raise ValueError(f'the controller {full_name} has no method command')
    return controller


def _values(parameters):
    values = {}
    for text in parameters:
        name, equals, value = text.partition('=')
        if not (equals and name.isidentifier()):
            raise ValueError(f'its parameter is {text}; it must be NAME=VALUE')
        if name in values:
            raise ValueError(f'its parameter {name} is given twice; it may be given once')
        # Not as YAML alone, for which 1e-3 is a text.
        values[name] = ros_yaml.load(value, name)
    return values


def _module(source):
    if source.endswith('.py'):
        path = Path(source).resolve()
        spec = importlib.util.spec_from_file_location(path.stem, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        # Its neighbours are modules that it may import.
        sys.path.insert(0, str(path.parent))
        spec.loader.exec_module(module)
        return module
    return own_module(source)


def sees_truth(controller: Controller) -> bool:
    """Return whether the samples of a controller have the true states too."""
    return bool(getattr(controller, 'needs_truth', False))


def period_of(controller: Controller, scenario: Scenario) -> int:
    """Return the ticks from command to command; ValueError: it is no whole number of ticks."""
    period_s = getattr(controller, 'period_s', None)
    if period_s is None:
        return 1
    try:
        ticks = Fraction(str(period_s)) * scenario.rate
    except ValueError:
        ticks = Fraction(0)
    if ticks < 1 or ticks.denominator != 1:
        raise ValueError(
            f'period_s of the controller {name_of(controller)} is {period_s}; it must be a '
            f'multiple of the {float(1 / scenario.rate):g} s between ticks'
        )
    return int(ticks)


def name_of(controller: Controller) -> str:
    """Return the name of a controller: module:Class."""
    return f'{type(controller).__module__}:{type(controller).__qualname__}'


def failure(controller: Controller, error: BaseException, t_s: float) -> ControllerFailed:
    """Return what ends the run at the time of an error of a controller, by its file and line."""
    own = [frame for frame in traceback.extract_tb(error.__traceback__) if not _is_ours(frame)]
    where = f' in {own[-1].filename}, line {own[-1].lineno}' if own else ''
    sentence = f'the controller {name_of(controller)} failed at {t_s:g} s{where}: {_said(error)}'
    return ControllerFailed(' '.join(sentence.split()))


def _is_ours(frame):
    return Path(frame.filename).is_relative_to(Path(__file__).parents[1])


def _said(error):
    said = str(error)
    is_plain = isinstance(error, ValueError | TypeError | ImportError | AttributeError) and said
    return said if is_plain else f'{type(error).__name__}: {said}'.removesuffix(': ')

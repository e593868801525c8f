"""`satdyn check`: prove an installation on its machine."""

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..actuators import Command
from ..bag.simulate import simulate
from ..bag.verify import Verification, verify
from ..exact import recognise
from ..integrate.propagation import Propagation
from ..kernel import rotation
from ..run.events import Event, Request
from ..run.scenario import Scenario

PERIODS = 3.0
# None of the flights is near a separatrix: in three periods rounding grows to less than this.
ALLOWED_RAD = 1e-9
# The propagation's own error must not show.
_TOLERANCE = 1e-14
_ROWS = 1001

_FIXED = {'orbit.type': 'fixed', 'orbit.gradient': 3.6e-6}
_STILL = {'initial.attitude': [0.0, 0.0, 0.0, 1.0]}
_TILTED = {'initial.attitude': [0.2, 0.4, 0.4, 0.8]}
_PITCHED = {'initial.attitude': [0.0, 0.5, 0.0, 0.75**0.5]}


def _rotor(axis, momentum):
    return {
        'rotor.mode': 'constant_momentum',
        'rotor.axis': axis,
        'rotor.momentum': momentum,
    }


_FREE = {'orbit.type': 'fixed', 'initial.angular_velocity': [0.02, 0.05, -0.04]}

# What each flight is, and its scenario.
FLIGHTS: dict[str, Mapping[str, Any]] = {
    'permanent rotation about the vertical': _FIXED
    | _STILL
    | {'body.inertia': [1000.0, 1500.0, 2000.0], 'initial.angular_velocity': [0.0, 0.0, 0.01]},
    'relative equilibrium of a gyrostat': _STILL
    | _rotor([0.0, 1.0, 0.0], -5.0)
    | {'body.inertia': [800.0, 900.0, 600.0]},
    'free rotation of a triaxial body': _FREE | _TILTED | {'body.inertia': [600.0, 900.0, 1100.0]},
    'free rotation of a gyrostat': _FREE
    | _TILTED
    | _rotor([0.0, 0.0, 1.0], 12.0)
    | {'body.inertia': [600.0, 900.0, 1100.0]},
    'libration on an orbit': _PITCHED | {'body.inertia': [800.0, 900.0, 600.0]},
    'libration of a symmetric gyrostat': _PITCHED
    | _rotor([0.0, 1.0, 0.0], -30.0)
    | {'body.inertia': [900.0, 900.0, 500.0]},
    'tumbling in the plane of an orbit': _PITCHED
    | {'body.inertia': [800.0, 900.0, 600.0], 'initial.angular_velocity': [0.0, 0.004, 0.0]},
    "Beletsky's offset pendulum": _FIXED
    | _PITCHED
    | {'body.inertia': [900.0, 1000.0, 600.0], 'body.weight_moment': [3e-4, 0.0, -6e-4]},
    'symmetric gyrostat under gradient and weight': _FIXED
    | _TILTED
    | _rotor([0.0, 0.0, 1.0], 2.0)
    | {
        'body.inertia': [800.0, 800.0, 500.0],
        'body.weight_moment': [0.0, 0.0, 8e-4],
        'initial.angular_velocity': [0.002, -0.001, 0.004],
    },
    "Lagrange's top": _TILTED
    | {
        'orbit.type': 'fixed',
        'body.inertia': [800.0, 800.0, 500.0],
        'body.weight_moment': [0.0, 0.0, 8e-4],
        'initial.angular_velocity': [0.002, -0.001, 0.04],
    },
    "Agostinelli's stationary motion": _FIXED
    | {
        'body.inertia': [1000.0, 1500.0, 2000.0],
        'initial.attitude': [
            0.2951518843026892,
            -0.08175233917616018,
            0.2541064583652961,
            0.9174049422413442,
        ],
        'initial.angular_velocity': [
            0.0008694826047713662,
            0.0012421180068162372,
            0.0017659275183313722,
        ],
    },
}


class FlightError(NamedTuple):
    """A flight in closed form and its propagation: the largest angle between them [rad]."""

    flight: str
    motion: str
    duration_s: float
    angle_rad: float

    @property
    def is_allowed(self) -> bool:
        """Whether rounding explains the angle."""
        return self.angle_rad <= ALLOWED_RAD


def check() -> bool:
    """Run the closed forms and a bag, print the results, and return whether all are right."""
    print('closed forms against their propagation: the largest angle between the attitudes [rad]')
    is_well = True
    for found in differences():
        is_well &= found.is_allowed
        print(
            f'  {found.flight:45}{found.motion:19}{found.duration_s:8.0f} s'
            f'{found.angle_rad:10.1e}  {_word(found.is_allowed)} (allowed {ALLOWED_RAD:.0e})',
            flush=True,
        )
    print('a bag, written and run again')
    with tempfile.TemporaryDirectory() as directory:
        verdict = round_trip(Path(directory) / 'check')
    is_well &= verdict.is_true and verdict.same_bytes
    print(f'  {verdict}  {_word(verdict.is_true and verdict.same_bytes)}')
    print('all is well' if is_well else 'this installation gives wrong results')
    return is_well


def differences() -> Iterator[FlightError]:
    """Yield the difference of each flight; it is infinite where no closed form is found."""
    for flight, values in FLIGHTS.items():
        scenario = Scenario(values)
        motion = recognise(scenario.system, scenario.initial_state)
        if motion is None:
            yield FlightError(flight, 'no closed form', 0.0, np.inf)
            continue
        duration_s = PERIODS * (motion.period_s or 2000.0)
        t_s = np.linspace(0.0, duration_s, _ROWS)
        exact = motion.at(t_s)
        stepped = Propagation(motion.system, motion.state, tolerance=_TOLERANCE).at(t_s)
        apart = rotation.angle_between(exact.q_ib, stepped.q_ib)
        yield FlightError(flight, motion.name, duration_s, float(np.max(apart)))


def round_trip(directory: Path) -> Verification:
    """Record a driven run into a new bag and return what verify says of it."""
    scenario = Scenario({'publish.rate': 100.0, 'time.epoch_ns': 10**9})
    happening: list[Event] = [
        Command(200, 'torque', (0.0, 0.01, 0.0), until_tick=300),
        Request(500, {'initial.angular_velocity': [0.0, 0.0, 0.01]}),
    ]
    for _ in simulate(scenario, 10, directory, happening):
        pass
    return verify(directory)


def _word(is_allowed):
    return 'good' if is_allowed else 'NOT GOOD'

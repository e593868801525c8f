"""The tasks that come with the package, by the names of their environments."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..run.scenario import Scenario
from .task import Task

# That of config/tumbling_cubesat.yaml, without a magnetometer.
_CUBESAT = {
    'body.inertia': [0.058, 0.062, 0.025],
    'body.dipole': [0.006, -0.004, 0.005],
    'magnetorquer.max_dipole': [0.2, 0.2, 0.2],
    'orbit.type': 'kepler',
    'orbit.semi_major_axis': '6900 km',
    'orbit.inclination': '97.5 deg',
    'environment.magnetic_field': 'igrf',
    'initial.frame': 'inertial',
    'publish.rate': 0.2,
    'time.epoch': '2026-01-01T00:00:00Z',
}
_WHEELS = 'rw_x', 'rw_y', 'rw_z'
_MOST_TORQUE = 1e-3


def detumble() -> Task:
    """
    Damp the tumble of a 3U CubeSat by its magnetorquers, with rate and field known.

    The reward of an action is minus the rotational energy [mJ] after it, times its 5 s.
    """
    scenario = Scenario(_CUBESAT)
    inertia = np.diagonal(scenario.system.inertia)

    def reward(sample: Any, action: np.ndarray) -> Any:
        return -2.5e3 * np.sum(inertia * sample.omega_bi_b**2, axis=-1)

    return Task(
        scenario,
        observation={'omega_bi_b': 10.0, 'magnetic_field_b': 2e4},
        action={'dipole_b': scenario['magnetorquer.max_dipole']},
        reward=reward,
        duration_s=3000.0,
        interval_s=5.0,
        vary={
            'initial.attitude': 'sphere',
            'initial.angular_velocity': {'normal': [[0.0, 0.0, 0.0], [0.05, 0.05, 0.05]]},
        },
    )


def point() -> Task:
    """Bring the body axes of a 6U CubeSat to the inertial ones, from some degrees beside them."""
    attitude = {f'initial.{angle}': {'normal': [0.0, 0.05]} for angle in ('roll', 'pitch', 'yaw')}
    rate = {'normal': [[0.0, 0.0, 0.0], [2e-3, 2e-3, 2e-3]]}
    return _with_wheels(attitude | {'initial.angular_velocity': rate}, duration_s=60.0)


def slew() -> Task:
    """Turn a 6U CubeSat at rest from any attitude until its axes are along the inertial ones."""
    return _with_wheels({'initial.attitude': 'sphere'}, duration_s=120.0)


def _with_wheels(vary: Mapping[str, Any], duration_s: float) -> Task:
    """Return a task whose reward is minus the square of the angle [rad] and of what it takes."""
    base = Scenario.from_yaml('three_wheels')
    without_limits = {f'rotor.{name}.max_speed': 0.0 for name in _WHEELS}
    scenario = base.with_values(
        {
            **without_limits,
            'publish.rate': 10.0,
            'initial.frame': 'inertial',
            'initial.attitude': [0.0, 0.0, 0.0, 1.0],
            'initial.angular_velocity': [0.0, 0.0, 0.0],
        }
    )

    def reward(sample: Any, action: np.ndarray) -> Any:
        half = np.arccos(np.minimum(np.abs(sample.q_ib[..., 3]), 1.0))
        return -4.0 * half**2 - 1e-3 * np.sum(action * action, axis=-1)

    return Task(
        scenario,
        observation={'q_ib': 1.0, 'omega_bi_b': 10.0, 'rotor_speed': 1e-3},
        action={'rotor_torque': dict.fromkeys(_WHEELS, _MOST_TORQUE)},
        reward=reward,
        duration_s=duration_s,
        interval_s=0.2,
        vary=vary,
    )


TASKS: dict[str, Callable[[], Task]] = {'Detumble': detumble, 'Point': point, 'Slew': slew}


def task_of(given: Task | str) -> Task:
    """Return a task, or the one with a name; ValueError: there is no such task."""
    if isinstance(given, Task):
        return given
    if given not in TASKS:
        raise ValueError(f'the task is {given}; it must be one of {", ".join(TASKS)}, or a Task')
    return TASKS[given]()

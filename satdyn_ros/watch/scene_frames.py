"""The frames of a live page: what a satellite publishes, as rows of the scene."""

from collections import deque
from contextlib import suppress
from typing import Any

import numpy as np

from ..dynamics.motion import States
from ..dynamics.torque import angular_momentum
from ..report import scene
from ..report.curves import shown, topics_with_panels
from ..report.earth_map import geodetic_topics
from ..ros.inputs import Refused, accepted
from ..run.samples import Samples
from ..run.scenario import Scenario
from ..run.ticks import Ticks
from ..torques.magnetic import dipole_of
from .listener import HeardState, Listener

_KEPT_ROWS = 9000

Row = dict[str, np.ndarray]


class SceneFrames:
    """The newest sample as a row of the scene (see scene.py), and the rows of the last minutes."""

    def __init__(self) -> None:
        self._rows: deque[Row] = deque(maxlen=_KEPT_ROWS)
        # The tick that is shown; how many samples were left out.
        self.tick, self.left_out = -1, 0
        # By the name under which it is held what was commanded since the last sample; and what
        # acts since before, with the time [s] of its sample.
        self._came_in: dict[str, Any] = {}
        self._commanded: dict[str, tuple[float, Any]] = {}

    def clear(self) -> None:
        """Forget everything so far: another node has taken the name."""
        self._rows.clear()
        self.tick, self.left_out = -1, 0
        self._came_in.clear()
        self._commanded.clear()

    @property
    def is_empty(self) -> bool:
        """Whether nothing was shown yet."""
        return not self._rows

    def take(self, listener: Listener, scenario: Scenario) -> Row | None:
        """
        Return the row of the newest sample, or None where there is no new one.

        A sample is left out whose stamp is no tick of the scenario after the last: a node of the
        same name has published it.
        """
        self._take_commands(listener, scenario)
        ticks = Ticks(scenario.rate, scenario.epoch_ns)
        for sample in reversed(listener.samples()):
            tick = ticks.tick_of(sample.stamp_ns)
            if ticks.stamp_ns(tick) == sample.stamp_ns and tick > self.tick:
                break
            self.left_out += 1
        else:
            return None
        self.tick = tick
        t_s = ticks.seconds(tick)
        for name, x in self._came_in.items():
            actuator = scenario.equipment.of_name[name]
            _, before = self._commanded.get(name, (t_s, actuator.none[name]))
            self._commanded[name] = t_s, actuator.from_instant(name, x, before, t_s)
        self._came_in.clear()
        row = self._row(scenario, sample, t_s, *_rotors(listener, scenario))
        row |= _propellant(listener, scenario)
        self._rows.append(row)
        return row

    def _take_commands(self, listener: Listener, scenario: Scenario) -> None:
        """Hold what came in."""
        for topic, message in listener.commands():
            if (actuator := scenario.equipment.of_topic.get(topic)) is not None:
                # What the node refuses does not act.
                with suppress(Refused):
                    self._came_in |= actuator.held(topic, accepted(scenario, topic, message))

    def history(self) -> Row | None:
        """Return the rows so far that have the columns of the last one, as one table."""
        rows = list(self._rows)
        if not rows:
            return None
        names = rows[-1].keys()
        alike = [row for row in rows if row.keys() == names]
        return {name: np.concatenate([row[name] for row in alike]) for name in names}

    def _row(
        self,
        scenario: Scenario,
        sample: HeardState,
        t_s: float,
        rotor_speed: np.ndarray,
        rotor_angle: np.ndarray,
    ) -> Row:
        acting, at_s = self._acting(scenario, t_s), np.array([t_s])
        system = scenario.equipment.driven(scenario.system, acting)
        dipole_b = dipole_of(system.torques)
        states = States(
            t_s=at_s,
            q_ib=sample.q_ib[None],
            omega_bi_b=sample.omega_bi_b[None],
            rotor_speed=rotor_speed,
            rotor_angle=rotor_angle,
            work=np.zeros(1),
            orbit=system.orbit,
            orbit_s=at_s,
            environment=system.environment,
        )
        samples = Samples(0, np.array([sample.stamp_ns]), states, system)
        return scene.rows(
            states,
            momentum_b=angular_momentum(system, states.omega_bi_b, states.rotor_speed),
            shown=shown([*topics_with_panels(scenario), *geodetic_topics(scenario)], samples),
            applied_b=system.torque_b[None] if system.torque_b.any() else None,
            dipole_b=None if dipole_b is None else dipole_b[None],
        )

    def _acting(self, scenario: Scenario, t_s: float) -> dict[str, Any]:
        """Return what acts of the last commands received, until their timeouts."""
        timeout_s, equipment = scenario['torque.timeout'], scenario.equipment
        return equipment.none | {
            name: x
            for name, (since_s, x) in self._commanded.items()
            if not timeout_s or t_s - since_s <= timeout_s or not equipment.is_held(name)
        }


def _rotors(listener: Listener, scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Return speeds [rad/s] and angles [rad] of the rotors (1, R), nan where unknown."""
    message = listener.joints('rotor')
    unknown = np.full((1, len(scenario.system.rotors)), np.nan)
    if message is None:
        return unknown, unknown
    speed, angle = (
        np.array([given]) if len(given) == unknown.size else unknown
        for given in (message.velocity, message.position)
    )
    return speed, angle


def _propellant(listener: Listener, scenario: Scenario) -> Row:
    """Return the propellant used by each thruster [kg] (1, K) where it is published."""
    message, count = listener.joints('thruster'), len(scenario['thruster.names'])
    if message is None or len(message.position) != count:
        return {}
    return {'propellant': np.array([message.position])}

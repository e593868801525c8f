"""All satellites of the graph on one globe: where each of them is."""

import time
from collections import deque
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray

from ..base.nanoseconds import SECOND_NS
from ..report import earth_map
from ..run.scenario import Scenario
from .listener import Listener, parts
from .reports import Parts, Reports
from .scenario_reader import ScenarioReader
from .view import Send, View

# What is chosen in place of a satellite; names of nodes begin with a slash.
ALL = 'all'


class Globe(View):
    """
    The satellites that fly, each by the orbit of its scenario and the ticks that it reports.

    Their topics are not heard: the diagnostics, once a second, are enough for any number of them.
    """

    name = ALL
    frame_s = 1.0 / 5.0

    def __init__(
        self,
        listener: Listener,
        reader: ScenarioReader,
        send: Send,
    ):
        self._listener, self._reader, self._send = listener, reader, send
        self._flights: dict[str, _Flight] = {}
        send('earth', earth_map.earth(), True)

    @property
    def refusal(self) -> str:
        """Why nothing can be asked."""
        return 'all satellites are shown; choose the one to ask'

    def look(self, found: list[str]) -> None:
        """See which satellites are there, by name, and ask those whose scenario is not known."""
        endpoints = self._listener.endpoints()
        self._flights = {name: self._flight(name, endpoints[name]) for name in found}
        for name, flight in self._flights.items():
            if not isinstance(flight.scenario, Scenario):
                self._reader.read(name)

    def _flight(self, name: str, endpoints: set[bytes]) -> '_Flight':
        known = self._flights.get(name)
        # Others: another node has taken the name.
        return known if known and endpoints in (set(), known.endpoints) else _Flight(endpoints)

    def take_scenario(self, name: str, scenario: Scenario | str) -> None:
        """Take the scenario of a satellite, or why it is not understood."""
        if name in self._flights:
            self._flights[name].scenario = scenario

    def take_diagnostics(self, message: DiagnosticArray) -> None:
        """Take what satellites report."""
        for name, flight in self._flights.items():
            report = parts(message, name)
            if report:
                flight.take_report(report)

    def frame(self) -> None:
        """
        Send what is known of each satellite, plain data.

        name, is_there, is_paused; if there is a position utc_s, its Unix time [s], r_i [m] and v_i
        [m/s]; note, why there is none, or ''.
        """
        now_s = time.monotonic()
        each = [
            {
                'name': name,
                'is_there': flight.reports.is_there,
                'is_paused': flight.reports.is_paused,
                **flight.position(now_s),
            }
            for name, flight in self._flights.items()
        ]
        self._send('globe', {'satellites': each}, False)


class _Flight:
    """What is known of one satellite."""

    def __init__(self, endpoints: set[bytes]) -> None:
        self.endpoints = endpoints
        self.scenario: Scenario | str | None = None
        self.reports = Reports()
        # When the last two reports came [s], and their ticks.
        self._heard_s: deque[float] = deque(maxlen=2)
        self._ticks: deque[int] = deque(maxlen=2)

    def take_report(self, report: Parts) -> None:
        """Take the next report."""
        self.reports.take(report)
        if self.reports.tick is not None:
            self._heard_s.append(time.monotonic())
            self._ticks.append(self.reports.tick)

    def position(self, now_s: float) -> dict[str, Any]:
        """Return where it is, or why that is not known."""
        if len(self.endpoints) > 1:
            return {'note': f'not drawn: {len(self.endpoints)} nodes have this name'}
        if not isinstance(self.scenario, Scenario):
            return {'note': self.scenario or 'its parameters have not arrived yet'}
        if not (self.reports.is_there and self._ticks):
            return {'note': ''}
        t_s = self._tick(now_s) / float(self.scenario.rate)
        try:
            orbit = self.scenario.system.orbit
            if not earth_map.is_about_earth(orbit):
                return {'note': 'not drawn: it has no orbit about the Earth'}
            r_i, v_i = orbit.position_velocity(t_s)
        except ValueError as error:
            return {'note': f'not drawn: {error}'}
        return {
            'note': '',
            'utc_s': self.scenario.epoch_ns / SECOND_NS + t_s,
            'r_i': r_i.tolist(),
            'v_i': v_i.tolist(),
        }

    def _tick(self, now_s: float) -> float:
        """Return the tick of one report ago: between two of them nothing is guessed."""
        ago_s = self._heard_s[-1] - self._heard_s[0]
        return float(np.interp(now_s - ago_s, self._heard_s, self._ticks))

"""A running node, as a page shows it: its samples, its diagnostics, and what the page lacks."""

import json
from collections.abc import Iterator
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray

from ..report import scene
from ..ros.other_users import unreached
from ..run.scenario import Scenario
from .listener import Listener, parts
from .reports import Reports
from .request_form import initial_conditions
from .scenario_reader import ScenarioReader
from .scene_frames import SceneFrames
from .view import Send, View


class Satellite(View):
    """
    A satellite by the name of its node, '/sat1/satdyn'.

    starts: the number of the next motion that pages show.  Of nodes of one name the one is
    shown whose parameters were read, by its ticks; none is asked anything, as all would do it.
    """

    frame_s = 1.0 / 30.0

    def __init__(
        self,
        name: str,
        listener: Listener,
        reader: ScenarioReader,
        send: Send,
        starts: Iterator[int],
    ):
        self.name = name
        self._listener, self._reader = listener, reader
        self._send, self._starts = send, starts
        self._frames = SceneFrames()
        self._reports = Reports()
        self._scenario: Scenario | None = None
        self._fault = ''
        self._start = 0
        self._endpoints: set[bytes] = set()
        self._topics: dict[str, str] = {}

    @property
    def refusal(self) -> str:
        """Why nothing can be asked."""
        return self._of_namesakes() if self._has_namesakes else ''

    def look(self, found: list[str]) -> None:
        """See which topics there are, and whether the node is another one by now."""
        if self.name not in found:
            return
        self._topics = self._listener.look(self.name)
        self._take_endpoints(self._listener.endpoints()[self.name])
        if self._scenario is None:
            self._reader.read(self.name)

    def _take_endpoints(self, endpoints: set[bytes]) -> None:
        """See whether another node has taken the name, or one of several has left it."""
        before, self._endpoints = self._endpoints, endpoints or self._endpoints
        if self._endpoints - before:
            self._scenario = None
        elif self._endpoints < before:
            self._reader.read(self.name)
        if self._frames.left_out and not self._has_namesakes:
            # One that was ending gave the parameters, or it was the one that was shown.
            self._scenario = None

    @property
    def _has_namesakes(self) -> bool:
        return len(self._endpoints) > 1

    def _of_namesakes(self) -> str:
        return (
            f'{len(self._endpoints)} nodes are named {self.name}. One of them is shown; none is '
            'asked anything, since all would do it. End the others, or start them with --ros-args '
            '-r __ns:=/sat2; one that was killed counts for 20 s'
        )

    def take_scenario(self, name: str, scenario: Scenario | str) -> None:
        """Take the parameters that were asked for, or why they are not understood."""
        if name != self.name:
            return
        if isinstance(scenario, str):
            self._fault = scenario
            return
        if self._scenario is None or scenario.epoch_ns != self._scenario.epoch_ns:
            self._frames.clear()
            self._start = next(self._starts)
            self._listener.forget()
        if scenario != self._scenario:
            self._fault = ''
            self._scenario = scenario
            message = {
                'node': name,
                'start': self._start,
                'description': scene.description(scenario, []),
                'values': initial_conditions(scenario),
            }
            self._send('scene', message, True)

    def take_change(self, name: str) -> None:
        """Read the parameters again when one changed: initial conditions do by requests."""
        if name == self.name and self._scenario is not None and not self._has_namesakes:
            self._reader.read(name)

    def take_diagnostics(self, message: DiagnosticArray) -> None:
        """Take what the node reports."""
        if report := parts(message, self.name):
            self._reports.take(report, self._frames.tick if self._has_namesakes else None)

    def take_pause(self, is_paused: bool) -> None:
        """Take an answer to a pause."""
        self._reports.is_paused = is_paused

    def frame(self) -> None:
        """Send the newest sample, if there is one."""
        if self._scenario is None:
            return
        row = self._frames.take(self._listener, self._scenario)
        if row is not None:
            self._send('rows', {'start': self._start, 'table': scene.table(row)}, False)

    def history(self) -> dict[str, str]:
        """Return the rows of the last minutes."""
        # First the start: rows of a later one are then not taken for its own.
        start = self._start
        columns = self._frames.history()
        if columns is None:
            return {}
        message = {'type': 'history', 'start': start, 'table': scene.table(columns)}
        return {'history': json.dumps(message)}

    def status(self) -> dict[str, Any]:
        """Return what the node reports, and what the page lacks."""
        reports = self._reports
        return {
            'is_there': reports.is_there,
            'is_paused': reports.is_paused,
            'has_namesakes': self._has_namesakes,
            'bag': reports.bag,
            'missing': self._missing(),
            'diagnostics': reports.parts,
        }

    def _missing(self) -> list[str]:
        """Return what the page lacks, a sentence each."""
        missing = [self._fault] if self._fault else []
        if self._has_namesakes:
            missing.append(self._of_namesakes())
        if self._reports.is_paused and self._scenario is not None and self._frames.is_empty:
            missing.append(
                'paused since before this page: a node publishes at its ticks alone, so Step or '
                'Resume shows its state'
            )
        if not self._reports.is_there and (why := unreached()):
            missing.append(f'nothing comes from {self.name}{why}')
        topics = self._topics
        if not ('odometry' in topics or 'imu' in topics):
            lacking = [name for name in ('attitude', 'angular_velocity') if name not in topics]
            if lacking:
                missing.append(
                    f'{" and ".join(lacking)} not published: the scene needs odometry, imu, or '
                    'attitude with angular_velocity in publish.topics'
                )
        rotors = scene.description(self._scenario, [])['rotors'] if self._scenario else []
        turning = [rotor for rotor in rotors if rotor['mode'] != 'constant_momentum']
        if turning and 'rotor' not in topics:
            missing.append(
                'rotor is not published: speeds and the momentum with them are unknown; '
                'add it to publish.topics'
            )
        return missing

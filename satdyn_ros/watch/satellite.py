"""A running node as the source of a page."""

import asyncio
import json
import os
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterEvent
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import qos_profile_parameter_events
from rclpy.signals import SignalHandlerOptions

from ..report import html, place, scene
from ..ros.client import Answer, Client
from ..run.scenario import Scenario
from ..torques.body_torque import BodyTorque
from .globe import ALL, Globe
from .hub import Hub
from .listener import Listener, parts, satellites
from .reports import Reports
from .request_form import checked, initial_conditions
from .scenario_reader import ScenarioReader
from .scene_frames import SceneFrames

_FRAME_S, _GLOBE_FRAME_S = 1.0 / 30.0, 1.0 / 5.0
_LOOK_S = 1.0
# The page goes on while a node on a busy machine takes its time.
_ANSWER_S = 20.0
_ACTIONS: dict[str, Callable[[Client], Answer]] = {
    'pause': Client.pause,
    'resume': Client.resume,
    'step': Client.step,
    'reset': Client.reset,
    'record': lambda client: client.record(True),
    'stop': lambda client: client.record(False),
}


class Satellite:
    """
    A running node: its samples at most thirty times a second, its diagnostics, its services.

    node_name: '/sat1/satdyn'; None: the first that is there.  A browser may choose another one,
    or all on a globe, for all browsers.  torques: of one's own that it has.  Of nodes of one name
    the one is shown whose parameters were read, by its ticks; none is asked anything, as all would
    do it.
    """

    page = 'page/live.html'
    files: tuple[str, ...] = (
        *html.SCENE_SCRIPTS,
        'page/live.css',
        'page/connection.js',
        'page/form.js',
        'page/ellipse.js',
        'page/globe.js',
        'page/fleet.js',
        'page/live.js',
    )

    def __init__(self, node_name: str | None = None, torques: Iterable[type[BodyTorque]] = ()):
        self._torques = tuple(torques)
        self._wanted = None if node_name is None else '/' + node_name.lstrip('/')
        self._name = self._wanted
        self._ended = threading.Event()
        # A thread per node: what one is asked keeps its order, and waits for no other node.
        self._asking: defaultdict[str, ThreadPoolExecutor] = defaultdict(
            lambda: ThreadPoolExecutor(1)
        )
        self._frames = SceneFrames()
        self._scenario: Scenario | None = None
        self._starts = 0
        self._endpoints: set[bytes] = set()
        self._found: list[str] = []
        self._reports = Reports()
        self._topics: dict[str, str] = {}
        self._fault = ''
        self._globe: Globe | None = None

    # -- the server's side ------------------------------------------------------------------------

    async def start(self, hub: Hub) -> None:
        """Begin to listen."""
        loop = asyncio.get_running_loop()

        def tell(kind: str, message: dict[str, Any], is_lasting: bool) -> None:
            text = json.dumps({'type': kind} | message)
            loop.call_soon_threadsafe(hub.put, kind, text, is_lasting)

        self._tell = tell
        self._thread = threading.Thread(target=self._listen, name='satellite')
        self._thread.start()

    async def stop(self) -> None:
        """Leave the graph."""
        self._ended.set()
        for asking in self._asking.values():
            asking.shutdown(cancel_futures=True)
        await asyncio.to_thread(self._thread.join)

    async def first(self) -> Mapping[str, str]:
        """Return the rows of the last minutes."""
        return await asyncio.to_thread(self._history)

    async def asked(self, request: dict[str, Any]) -> dict[str, Any]:
        """Do what a browser asks, by the node's services, and return its answer."""
        what = request.get('do')
        act: Callable[[Client], Answer]
        if what == 'request':
            values = checked(request.get('values'))
            act = partial(Client.set_initial_conditions, values=values)
        elif isinstance(what, str) and what in _ACTIONS:
            act = _ACTIONS[what]
        elif what == 'choose':
            return self._choose(request.get('node'))
        else:
            raise ValueError(f'do takes request, choose, {", ".join(_ACTIONS)}')
        name, end_s = self._name, time.monotonic() + _ANSWER_S
        if name is None:
            return {'success': False, 'text': 'no satellite is there'}
        if name == ALL:
            return {'success': False, 'text': 'all satellites are shown; choose the one to ask'}
        if self._has_namesakes:
            return {'success': False, 'text': self._of_namesakes()}
        loop = asyncio.get_running_loop()
        answer = await loop.run_in_executor(self._asking[name], self._ask, name, act, end_s)
        if answer.success and what in ('pause', 'resume') and name == self._name:
            # The answer is newer than the last diagnostics, which come once a second.
            self._reports.is_paused = what == 'pause'
            self._tell_status()
        return {'success': answer.success, 'text': answer.text}

    def _choose(self, name: Any) -> dict[str, Any]:
        if name not in (ALL, *self._found):
            raise ValueError(f'node takes {", ".join([ALL, *self._found])}')
        self._wanted = name
        return {'success': True, 'text': f'the page shows {name}'}

    def _ask(self, name: str, act: Callable[[Client], Answer], end_s: float) -> Answer:
        """Return a node's answer; after end_s, while others asked, it is not asked any more."""
        late = Answer(False, f'{name} did not answer within {_ANSWER_S:g} s')
        left_s = end_s - time.monotonic()
        if left_s <= 0.0:
            return late
        try:
            with Client(name, left_s, self._ended) as client:
                return act(client)
        except TimeoutError:
            return late
        except TypeError as error:
            return Answer(False, str(error))

    def _history(self) -> dict[str, str]:
        # First the start: rows of a later one are then not taken for its own.
        start = self._starts
        columns = self._frames.history()
        if columns is None:
            return {}
        message = {'type': 'history', 'start': start, 'table': scene.table(columns)}
        return {'history': json.dumps(message)}

    # -- the node's side, in a thread of its own --------------------------------------------------

    def _listen(self) -> None:
        context = Context()
        rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
        # Two nodes: what is polled must not wake the executor of the other.
        names = (f'satdyn_watch_{os.getpid()}', f'satdyn_watch_{os.getpid()}_frames')
        asker, poller = (
            rclpy.create_node(name, context=context, start_parameter_services=False)
            for name in names
        )
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(asker)
        asker.create_subscription(DiagnosticArray, '/diagnostics', self._take_diagnostics, 10)
        asker.create_subscription(
            ParameterEvent, '/parameter_events', self._take_event, qos_profile_parameter_events
        )
        self._asker, self._listener = asker, Listener(poller)
        self._reader = ScenarioReader(asker, self._torques, self._take_scenario)
        look_s = frame_s = 0.0
        try:
            while not self._ended.is_set():
                now_s = time.monotonic()
                if now_s >= look_s or self._wanted not in (None, self._name):
                    look_s = now_s + _LOOK_S
                    self._look()
                if now_s >= frame_s:
                    # Late frames are left out, not made up for.
                    each_s = _FRAME_S if self._globe is None else _GLOBE_FRAME_S
                    frame_s = max(frame_s + each_s, now_s)
                    self._frame()
                executor.spin_once(max(0.0, min(frame_s, look_s) - time.monotonic()))
        finally:
            executor.shutdown()
            asker.destroy_node()
            poller.destroy_node()
            context.try_shutdown()

    def _look(self) -> None:
        """See who is there, which topics there are, and whether the node is another one by now."""
        self._found = found = satellites(self._asker)
        if self._wanted not in (None, self._name):
            self._turn_to(self._wanted)
        elif self._wanted is None and self._name not in found and found:
            self._turn_to('/satdyn' if '/satdyn' in found else found[0])
        if self._globe is not None:
            self._globe.look(found)
        elif self._name is not None and self._name in found:
            self._topics = self._listener.look(self._name)
            self._take_endpoints(self._name, self._listener.endpoints()[self._name])
            if self._scenario is None:
                self._reader.read(self._name)
        self._tell_status()

    def _turn_to(self, name: str) -> None:
        """Show another satellite, or all."""
        self._name, self._scenario, self._fault = name, None, ''
        self._endpoints, self._topics = set(), {}
        self._reports = Reports()
        self._frames.clear()
        self._globe = None
        if name == ALL:
            self._listener.leave()
            self._globe = Globe(self._listener, self._reader)
            self._tell('earth', place.earth(), True)

    def _take_endpoints(self, name: str, endpoints: set[bytes]) -> None:
        """See whether another node has taken the name, or one of several has left it."""
        before, self._endpoints = self._endpoints, endpoints or self._endpoints
        if self._endpoints - before:
            self._scenario = None
        elif self._endpoints < before:
            self._reader.read(name)
        if self._frames.left_out and not self._has_namesakes:
            # One that was ending gave the parameters, or it was the one that was shown.
            self._scenario = None

    @property
    def _has_namesakes(self) -> bool:
        return len(self._endpoints) > 1

    def _of_namesakes(self) -> str:
        return (
            f'{len(self._endpoints)} nodes are named {self._name}. One of them is shown; none is '
            'asked anything, since all would do it. End the others, or start them with --ros-args '
            '-r __ns:=/sat2; one that was killed counts for 20 s'
        )

    def _tell_status(self) -> None:
        reports = self._reports
        status = {
            'node': self._name,
            'nodes': [ALL, *self._found] if len(self._found) > 1 else self._found,
            'is_there': reports.is_there,
            'is_paused': reports.is_paused,
            'has_namesakes': self._has_namesakes,
            'bag': reports.bag,
            'missing': self._missing(),
            'diagnostics': reports.parts,
        }
        self._tell('status', status, True)

    def _missing(self) -> list[str]:
        """Return what the page lacks, a sentence each."""
        if self._globe is not None:
            return []
        if self._name is None or self._name not in self._found:
            wanted = self._wanted or 'with the service set_initial_conditions'
            return [f'there is no node {wanted}; satdyn node starts one']
        missing = [self._fault] if self._fault else []
        if self._has_namesakes:
            missing.append(self._of_namesakes())
        if self._reports.is_paused and self._scenario is not None and self._frames.is_empty:
            missing.append(
                'paused since before this page: a node publishes at its ticks alone, so Step or '
                'Resume shows its state'
            )
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

    def _take_scenario(self, name: str, scenario: Scenario | str) -> None:
        if self._globe is not None:
            self._globe.take_scenario(name, scenario)
        if name != self._name:
            return
        if isinstance(scenario, str):
            self._fault = scenario
            return
        if self._scenario is None or scenario.epoch_ns != self._scenario.epoch_ns:
            self._frames.clear()
            self._starts += 1
            self._listener.forget()
        if scenario != self._scenario:
            self._fault = ''
            self._scenario = scenario
            message = {
                'node': name,
                'start': self._starts,
                'description': scene.description(scenario, []),
                'values': initial_conditions(scenario),
            }
            self._tell('scene', message, True)

    def _take_event(self, event: ParameterEvent) -> None:
        """Read the parameters again when one changed: initial conditions do by requests."""
        if event.node == self._name and self._scenario is not None and not self._has_namesakes:
            self._reader.read(event.node)

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        if self._globe is not None:
            self._globe.take_diagnostics(message)
            return
        told = parts(message, self._name) if self._name else {}
        if told:
            self._reports.take(told, self._frames.tick if self._has_namesakes else None)

    def _frame(self) -> None:
        if self._globe is not None:
            self._tell('globe', self._globe.frame(), False)
        if self._scenario is None:
            return
        row = self._frames.take(self._listener, self._scenario)
        if row is not None:
            self._tell('rows', {'start': self._starts, 'table': scene.table(row)}, False)

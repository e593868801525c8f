"""A running node as the source of a page."""

import asyncio
import json
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterEvent
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import qos_profile_parameter_events
from rclpy.signals import SignalHandlerOptions

from ..dynamics.motion import States
from ..dynamics.torque import angular_momentum, gravity_gradient
from ..report import html, scene
from ..ros.client import Answer, Client
from ..run.scenario import RCLPY_PARAMETERS, Scenario
from .hub import Hub
from .listener import Listener, parts, satellites

_FRAME_S = 1.0 / 30.0
_LOOK_S = 1.0
_SILENT_S = 3.5
_KEPT_ROWS = 9000
_ANSWER_S = 5.0
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

    node_name: '/sat1/satdyn'; None: the first that is there.
    """

    page = 'page/live.html'
    files: tuple[str, ...] = (
        *html.SCENE_SCRIPTS,
        'page/live.css',
        'page/connection.js',
        'page/form.js',
        'page/live.js',
    )

    def __init__(self, node_name: str | None = None):
        self._wanted = None if node_name is None else '/' + node_name.lstrip('/')
        self._name = self._wanted
        self._ended = threading.Event()
        self._asking = ThreadPoolExecutor(1)
        self._rows: deque[dict[str, np.ndarray]] = deque(maxlen=_KEPT_ROWS)
        self._scenario: Scenario | None = None
        self._starts = 0
        self._endpoints: set[bytes] = set()
        self._diagnostics: dict[str, Any] = {}
        self._heard_s = -_SILENT_S
        self._applied: tuple[float, np.ndarray] | None = None
        self._parameters: AsyncParameterClient | None = None
        self._topics: dict[str, str] = {}
        self._fault = ''

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
        self._asking.shutdown(cancel_futures=True)
        await asyncio.to_thread(self._thread.join)

    async def first(self) -> Mapping[str, str]:
        """Return the rows of the last minutes."""
        return await asyncio.to_thread(self._history)

    async def asked(self, request: dict[str, Any]) -> dict[str, Any]:
        """Do what a browser asks, by the node's services, and return its answer."""
        what = request.get('do')
        act: Callable[[Client], Answer]
        if what == 'request':
            values = _checked(request.get('values'))
            act = partial(Client.set_initial_conditions, values=values)
        elif isinstance(what, str) and what in _ACTIONS:
            act = _ACTIONS[what]
        else:
            raise ValueError(f'do takes request, {", ".join(_ACTIONS)}')
        loop = asyncio.get_running_loop()
        answer = await loop.run_in_executor(self._asking, self._ask, act)
        return {'success': answer.success, 'text': answer.text}

    def _ask(self, act):
        if self._name is None:
            return Answer(False, 'no satellite is there')
        try:
            with Client(self._name, _ANSWER_S) as client:
                return act(client)
        except (TimeoutError, TypeError) as error:
            return Answer(False, str(error))

    def _history(self):
        rows = list(self._rows)
        if not rows:
            return {}
        names = rows[-1].keys()
        alike = [row for row in rows if row.keys() == names]
        columns = {name: np.concatenate([row[name] for row in alike]) for name in names}
        return {'history': json.dumps({'type': 'history', 'table': scene.table(columns)})}

    # -- the node's side, in a thread of its own --------------------------------------------------

    def _listen(self):
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
        look_s = frame_s = 0.0
        try:
            while not self._ended.is_set():
                now_s = time.monotonic()
                if now_s >= look_s:
                    look_s = now_s + _LOOK_S
                    self._look()
                if now_s >= frame_s:
                    # Late frames are left out, not made up for.
                    frame_s = max(frame_s + _FRAME_S, now_s)
                    self._frame()
                executor.spin_once(max(0.0, min(frame_s, look_s) - time.monotonic()))
        finally:
            executor.shutdown()
            asker.destroy_node()
            poller.destroy_node()
            context.try_shutdown()

    def _look(self):
        """See who is there, which topics there are, and whether the node is another one by now."""
        found = satellites(self._asker)
        if self._wanted is None and self._name not in found and found:
            self._name = '/satdyn' if '/satdyn' in found else found[0]
        if self._name in found:
            self._topics = self._listener.look(self._name)
            endpoints = self._listener.endpoints(self._name)
            if endpoints - self._endpoints:
                self._endpoints = endpoints
                self._scenario = None
            if self._scenario is None:
                self._read_parameters()
        self._tell_status(found)

    def _tell_status(self, found):
        is_there = time.monotonic() - self._heard_s < _SILENT_S
        pacing = self._diagnostics.get('pacing', {})
        recorder = dict(self._diagnostics.get('recorder', {}).get('values', []))
        status = {
            'node': self._name,
            'nodes': found,
            'is_there': is_there,
            'is_paused': pacing.get('text', '').startswith('paused'),
            'bag': recorder.get('bag'),
            'missing': self._missing(found),
            'diagnostics': self._diagnostics if is_there else {},
        }
        self._tell('status', status, True)

    def _missing(self, found):
        """Return what the page lacks, a sentence each."""
        if self._name is None or self._name not in found:
            wanted = self._wanted or 'with the service set_initial_conditions'
            return [f'there is no node {wanted}; satdyn node starts one']
        missing = [self._fault] if self._fault else []
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

    def _read_parameters(self):
        if self._parameters is None or self._parameters.remote_node_name != self._name:
            self._parameters = AsyncParameterClient(self._asker, self._name)
        client = self._parameters

        def listed(future):
            names = [
                name
                for name in future.result().result.names
                if name.split('.')[0] not in RCLPY_PARAMETERS
            ]
            client.get_parameters(
                names, callback=lambda got: self._take_parameters(names, got.result().values)
            )

        if client.services_are_ready():
            client.list_parameters([], 0, callback=listed)

    def _take_parameters(self, names, values):
        given = {
            name: value
            for name, message in zip(names, values, strict=False)
            if (value := parameter_value_to_python(message)) is not None
        }
        try:
            scenario = Scenario({name: _plain(value) for name, value in given.items()})
        except ValueError as error:
            self._fault = f'the parameters of {self._name} are not understood: {error}'
            return
        if self._scenario is None:
            self._starts += 1
            self._rows.clear()
            self._listener.forget()
            self._applied = None
        if scenario != self._scenario:
            self._fault = ''
            self._scenario = scenario
            message = {
                'start': self._starts,
                'description': scene.description(scenario, []),
                'values': _initial_conditions(scenario),
            }
            self._tell('scene', message, True)

    def _take_event(self, event):
        """Read the parameters again when one changed: initial conditions do by requests."""
        if event.node == self._name and self._scenario is not None:
            self._read_parameters()

    def _take_diagnostics(self, message):
        told = parts(message, self._name) if self._name else {}
        if told:
            self._diagnostics, self._heard_s = told, time.monotonic()

    def _frame(self):
        scenario = self._scenario
        if scenario is None:
            return
        sample = self._listener.sample()
        torque_b = self._listener.torque_b()
        if sample is None:
            return
        t_s = (sample.stamp_ns - scenario.epoch_ns) * 1e-9
        if torque_b is not None:
            self._applied = t_s, torque_b
        row = self._row(scenario, sample, t_s)
        self._rows.append(row)
        self._tell('rows', {'start': self._starts, 'table': scene.table(row)}, False)

    def _row(self, scenario, sample, t_s):
        system = scenario.system
        at_s = np.array([t_s])
        speed, angle = self._rotor_state(scenario)
        states = States(
            t_s=at_s,
            q_ib=sample.q_ib[None],
            omega_bi_b=sample.omega_bi_b[None],
            rotor_speed=speed,
            rotor_angle=angle,
            work=np.zeros(1),
            orbit=system.orbit,
            orbit_s=at_s,
        )
        gradient = states.orbit.gradient_at(at_s)
        return scene.rows(
            states,
            momentum_b=angular_momentum(system, states.omega_bi_b, states.rotor_speed),
            torque_b=gravity_gradient(system.inertia, states.c_b, gradient),
            applied_b=self._applied_torque(scenario, t_s),
        )

    def _rotor_state(self, scenario: Scenario) -> tuple[np.ndarray, np.ndarray]:
        """Return speeds [rad/s] and angles [rad] of the rotors (1, R), nan where unknown."""
        message = self._listener.rotors()
        unknown = np.full((1, len(scenario.system.rotors)), np.nan)
        if message is None:
            return unknown, unknown
        speed, angle = (
            np.array([given]) if len(given) == unknown.size else unknown
            for given in (message.velocity, message.position)
        )
        return speed, angle

    def _applied_torque(self, scenario, t_s):
        """Return the torque (1, 3) [N m] that came in last, until its timeout, or None."""
        if self._applied is None:
            return None
        since_s, torque_b = self._applied
        timeout_s = scenario['torque.timeout']
        return torque_b[None] if not timeout_s or t_s - since_s <= timeout_s else None


def _initial_conditions(scenario):
    """Return what a request can change, those of rotors where their modes have them."""
    modes = {'momentum': ('constant_momentum',), 'speed': ('free', 'motor')}
    names = scenario.initial_conditions
    values = {name: scenario[name] for name in names if name.startswith('initial.')}
    for name, value in scenario.values.items():
        rotor, _, what = name.rpartition('.')
        if rotor.startswith('rotor') and scenario[f'{rotor}.mode'] in modes.get(what, ()):
            values[name] = value
    return values


def _plain(value):
    return value.tolist() if hasattr(value, 'tolist') else value


def _checked(values) -> dict[str, Any]:
    """Return the values of a request as parameters can hold them; ValueError: they are none."""
    if not isinstance(values, dict) or not values or len(values) > 32:
        raise ValueError('values takes at least one initial condition')
    checked = {}
    for name, value in values.items():
        value = _float(value)
        if isinstance(value, list) and len(value) <= 16:
            value = [_float(x) for x in value]
        try:
            Parameter(name, value=value)
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f'{name} takes a number, numbers or a text') from None
        checked[name] = value
    return checked


def _float(value):
    """Return a number as a float: no initial condition is an integer."""
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value

"""The satellites of the ROS graph as the source of a page, which shows one of them or all."""

import asyncio
import json
import os
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from itertools import count
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import ParameterEvent
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import qos_profile_parameter_events

from ..report import html
from ..ros.client import Answer, Client
from ..ros.context import init
from ..ros.other_users import unreached
from ..run.scenario import Scenario
from ..torques.body_torque import BodyTorque
from .globe import ALL, Globe
from .hub import Hub
from .listener import Listener, satellites
from .request_form import checked
from .satellite import Satellite
from .scenario_reader import ScenarioReader
from .view import View

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


class RosGraph:
    """
    The satellites of the graph: one of them at most thirty times a second, or all on a globe.

    A browser may choose another one, or all, for all browsers.

    Parameters
    ----------
    node_name : str or None
        such as /sat1/satdyn; None: the first that is there
    torques : iterable of classes
        of one's own that satellites have
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
        self._ended = threading.Event()
        # A thread per node: what one is asked keeps its order, and waits for no other node.
        self._asking: defaultdict[str, ThreadPoolExecutor] = defaultdict(
            lambda: ThreadPoolExecutor(1)
        )
        self._starts = count(1)
        self._found: list[str] = []
        self._view = View()

    # -- the server's side ------------------------------------------------------------------------

    async def start(self, hub: Hub) -> None:
        """Begin to listen; OSError: ROS cannot write its log."""
        loop = asyncio.get_running_loop()

        def send(kind: str, message: dict[str, Any], is_lasting: bool) -> None:
            text = json.dumps({'type': kind} | message)
            loop.call_soon_threadsafe(hub.put, kind, text, is_lasting)

        self._send = send
        context = Context()
        init(context=context)
        self._thread = threading.Thread(target=self._listen, args=(context,), name='graph')
        self._thread.start()

    async def stop(self) -> None:
        """Leave the graph."""
        self._ended.set()
        for asking in self._asking.values():
            asking.shutdown(cancel_futures=True)
        await asyncio.to_thread(self._thread.join)

    async def first(self) -> Mapping[str, str]:
        """Return the rows of the last minutes."""
        return await asyncio.to_thread(self._view.history)

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
        view, end_s = self._view, time.monotonic() + _ANSWER_S
        if view.refusal:
            return {'success': False, 'text': view.refusal}
        loop = asyncio.get_running_loop()
        asking = self._asking[view.name]
        answer = await loop.run_in_executor(asking, self._ask, view.name, act, end_s)
        if answer.success and what in ('pause', 'resume') and view is self._view:
            view.take_pause(what == 'pause')
            self._send_status()
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
            return late._replace(text=late.text + unreached())
        except TypeError as error:
            return Answer(False, str(error))

    # -- the side of ROS, in a thread of its own --------------------------------------------------

    def _listen(self, context: Context) -> None:
        # Two nodes: what is polled must not wake the executor of the other.
        names = (f'satdyn_watch_{os.getpid()}', f'satdyn_watch_{os.getpid()}_frames')
        asker, poller = (
            rclpy.create_node(name, context=context, start_parameter_services=False)
            for name in names
        )
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(asker)

        # Each asks for the view of that moment.
        def take_diagnostics(message: DiagnosticArray) -> None:
            self._view.take_diagnostics(message)

        def take_change(event: ParameterEvent) -> None:
            self._view.take_change(event.node)

        def take_scenario(name: str, scenario: Scenario | str) -> None:
            self._view.take_scenario(name, scenario)

        asker.create_subscription(DiagnosticArray, '/diagnostics', take_diagnostics, 10)
        asker.create_subscription(
            ParameterEvent, '/parameter_events', take_change, qos_profile_parameter_events
        )
        self._asker, self._listener = asker, Listener(poller)
        self._reader = ScenarioReader(asker, self._torques, take_scenario)
        look_s = frame_s = 0.0
        try:
            while not self._ended.is_set():
                now_s = time.monotonic()
                if now_s >= look_s or self._wanted not in (None, self._view.name):
                    look_s = now_s + _LOOK_S
                    self._look()
                if now_s >= frame_s:
                    # Late frames are left out, not made up for.
                    frame_s = max(frame_s + self._view.frame_s, now_s)
                    self._view.frame()
                executor.spin_once(max(0.0, min(frame_s, look_s) - time.monotonic()))
        finally:
            executor.shutdown()
            asker.destroy_node()
            poller.destroy_node()
            context.try_shutdown()

    def _look(self) -> None:
        """See who is there, and let the view do so."""
        self._found = found = satellites(self._asker)
        wanted, shown = self._wanted, self._view.name
        if wanted is None and found and shown not in found:
            wanted = '/satdyn' if '/satdyn' in found else found[0]
        if wanted not in (None, shown):
            self._turn_to(wanted)
        self._view.look(found)
        self._send_status()

    def _turn_to(self, name: str) -> None:
        """Show another satellite, or all."""
        self._listener.leave()
        if name == ALL:
            self._view = Globe(self._listener, self._reader, self._send)
        else:
            self._view = Satellite(name, self._listener, self._reader, self._send, self._starts)

    def _send_status(self) -> None:
        status = {
            'node': self._view.name,
            'nodes': [ALL, *self._found] if len(self._found) > 1 else self._found,
            **self._view.status(),
        }
        if self._view.name not in (ALL, *self._found):
            wanted = self._wanted or 'with the service set_initial_conditions'
            status['missing'] = [f'there is no node {wanted}; satdyn node starts one']
        self._send('status', status, True)

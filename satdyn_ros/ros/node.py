"""The node: declares its parameters, builds what a scenario describes, and connects the parts."""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from datetime import datetime, timezone
from importlib.util import find_spec
from threading import Lock
from typing import TYPE_CHECKING, Any

import rclpy.logging
import rclpy.node
from rclpy.exceptions import ParameterException

from ..base.interruption import uninterrupted
from ..base.nanoseconds import SECOND_NS
from ..base.sentences import one_sentence
from ..integrate.propagation import Propagation
from ..run.controlled import ControlledSimulation
from ..run.controllers import Controller
from ..run.events import Event, Halt, Topics, TorquesDropped
from ..run.parameter_file import ParameterFile, with_own_frames, with_texts, without_rclpys
from ..run.requests import try_out
from ..run.samples import Samples
from ..run.scenario import Scenario
from ..run.simulation import Simulation
from ..torques.body_torque import BodyTorque
from . import realtime
from .diagnostics import (
    Diagnostics,
    InputsReport,
    PacingReport,
    PropagationReport,
    connections_report,
    recorder_report,
)
from .inputs import CommandInputs
from .lateness import Lateness
from .pacing import Pacing
from .parameter_service import ParameterService
from .parameters import NodeParameters, give_rclpy_its_own, given_parameters
from .publishing import STEADY, PackedTicks, Publishing
from .services import Services

if TYPE_CHECKING:
    from .recorder import Recorder

# What a node builds once the epoch is known takes less on a busy machine too: the first one, and
# each of several.
_LEAD_NS, _LEAD_OF_EACH_NS = 200_000_000, 100_000_000


@dataclass(frozen=True)
class Moment:
    """One moment by two clocks."""

    wall_ns: int
    monotonic_ns: int

    @classmethod
    def soon(cls, node_count: int = 1) -> 'Moment':
        """Return when so many nodes, one begun after the other, can have their first tick."""
        lead_ns = _LEAD_NS + node_count * _LEAD_OF_EACH_NS
        # The wall clock's first: no message comes before its stamp.
        return cls(time.time_ns() + lead_ns, time.monotonic_ns() + lead_ns)


class SatdynNode(rclpy.node.Node):
    """
    A satellite: it propagates, publishes at a fixed rate, answers requests and records.

    The ticks begin at once, in a thread, or with begin(); spin the node for its services.
    destroy_node() ends the ticks and completes the bag.  Further keywords are those of rclpy's
    Node.

    Parameters
    ----------
    values : dict, ParameterFile, function or None
        parameters by name, which those that ROS gives it (files, command line,
        parameter_overrides) override; or a file that has them, or what reads it
    torques : iterable of classes
        of one's own
    folder : str
        where in record.directory its bags go
    begins : bool
        whether the ticks begin at once
    ros_files : ParameterFile or None
        those of ROS, whose frames for several nodes get the namespace before them as the file's do
    section : str or None
        the satellite of the file, if not the one of the node's full name
    controller : function or None
        makes one, which closes the loop
    kwargs : dict
        of rclpy's Node

    Raises
    ------
    ValueError
        a parameter is not allowed
    OSError
        no bag can be made

    Examples
    --------
    >>> node = SatdynNode({'publish.rate': 10.0}, namespace='sat1')  # doctest: +SKIP
    """

    def __init__(
        self,
        values: Mapping[str, Any] | ParameterFile | Callable[[], ParameterFile] | None = None,
        torques: Iterable[type[BodyTorque]] = (),
        folder: str = '',
        begins: bool = True,
        ros_files: ParameterFile | None = None,
        section: str | None = None,
        controller: Callable[[], Controller] | None = None,
        **kwargs: Any,
    ):
        name = kwargs.pop('node_name', 'satdyn')
        try:
            super().__init__(name, start_parameter_services=False, **kwargs)
        except ParameterException as error:
            raise ValueError(str(error)) from error
        # Why the exit code is 1: the ticks have ended, or a bag does not hold what it should.
        self.failure: str | None = None
        # Whether the ticks have ended by an error; nothing is left to spin for.
        self.has_ended = False
        self._read = lambda: Scenario(self._given(values or {}, ros_files, section), torques)
        self._folder, self._controller = folder, controller
        self._opening = Lock()
        self._forget()
        try:
            self._start(begins)
        except BaseException:
            with uninterrupted():
                self.destroy_node()
            raise

    def _forget(self):
        """Know nothing of ticks, which have not begun or have ended."""
        self._own_parameters: NodeParameters | None = None
        self._own_services: Services | None = None
        self._pacing: Pacing | None = None
        self._recorder: Recorder | None = None
        # The row of samples that was published last.
        self._latest: tuple[Samples, int] | None = None
        # Changes of the published topics, asked for and in force.
        self._topics_asked = self._topics_in_force = 0

    def _start(self, begins):
        self._prepare(self._read())
        if begins:
            self.begin()

    def _given(self, values, ros_files, section):
        """Return the parameters of the scenario, with the frames of a node in its namespace."""
        full_name = self.get_fully_qualified_name()
        if callable(values):
            values = values()
        if isinstance(values, ParameterFile):
            name = section or full_name
            own, values = values.own(name), values.parameters(name)
        else:
            own = set(values)
        give_rclpy_its_own(self, values)
        of_ros = with_texts(given_parameters(self))
        common = ros_files.common(full_name) if ros_files else {}
        own |= {key for key, value in of_ros.items() if key not in common or common[key] != value}
        return with_own_frames({**without_rclpys(values), **of_ros}, full_name, own)

    def _prepare(self, scenario):
        """Build, compile and try out what needs no instant of tick 0."""
        if scenario['time.publish_clock'] and self.get_parameter('use_sim_time').value:
            raise ValueError(
                'time.publish_clock and use_sim_time are both true; a node that publishes /clock '
                'cannot follow it'
            )
        # Some orbits need an instant, and tick 0 has none before all this is done.
        soon = scenario.with_epoch(time.time_ns())
        self._publishing = Publishing(self, soon)
        topics = self._publishing.open(soon.topics)
        _try_out(soon)
        # What ticks load and compile takes longer than tick 0 is ahead.
        _, samples = Simulation(soon).advance(2)
        self._publishing.pack(samples, topics)
        if scenario['record.enabled']:
            _recorder_class()
        self._scenario = scenario.with_seed().with_values({'publish.topics': topics})

    def begin(self, moment: Moment | None = None) -> None:
        """
        Let the ticks begin, and the node answer; moment: that of tick 0, if not as soon as can be.

        ValueError and OSError: as of the node, which is then to be destroyed.
        """
        moment = moment or Moment.soon()
        scenario = self._scenario.with_epoch(moment.wall_ns)
        self._is_ending = False
        self._publishing.latch(scenario)
        parameters = NodeParameters(self, scenario, self._prepare_change, self._change)
        self._own_parameters = parameters
        ParameterService(self, parameters.lock)
        controller = None if self._controller is None else self._controller()
        self._simulation = ControlledSimulation(scenario, controller=controller)
        warn = self.get_logger().warning
        realtime.lock_memory(scenario, warn)
        self._pacing = Pacing(
            self._simulation,
            self,
            scenario['time.factor'],
            self._fail,
            lambda: realtime.raise_priority(scenario, warn),
            moment.monotonic_ns,
        )
        self._inputs = CommandInputs(self, scenario, self._simulation.ticks, self._pacing)
        self._own_services = Services(self, parameters, self._pacing, self._record)
        if find_spec('simulation_interfaces'):
            from .standard_services import StandardServices

            StandardServices(
                self, self._own_services, self._pacing, scenario, lambda: self._latest
            )
        self._inputs_report = InputsReport(
            self._inputs.counts, self._simulation, lambda: self._latest
        )
        self._propagation = PropagationReport(scenario['motion.tolerance'])
        Diagnostics(
            self,
            {
                'propagation': self._propagation,
                'pacing': PacingReport(self._pacing, float(scenario.rate), warn),
                'recorder': lambda: recorder_report(self._recorder),
                'inputs': self._inputs_report,
                'connections': lambda: connections_report(
                    self._publishing.publishers, self._inputs.subscriptions
                ),
            },
        )
        self.create_timer(1.0, self._close_publishers, clock=STEADY)
        with uninterrupted():
            if scenario['record.enabled']:
                self._recorder = self._open_recorder()
            self._pacing.start()
            # Not before: for its first line rclpy looks some 50 ms for the caller.
            self.get_logger().info(self._what_begins(scenario))
            for warning in scenario.warnings:
                self.get_logger().warning(warning)

    def _what_begins(self, scenario):
        """Return the line that is logged at the start."""
        topics = ', '.join(self._simulation.topics + tuple(scenario.sensors)) or 'nothing'
        epoch = datetime.fromtimestamp(scenario.epoch_ns / SECOND_NS, timezone.utc)
        factor = scenario['time.factor']
        pace = f'factor {factor:g}' if factor else 'as fast as possible'
        bag = f'recording {self._recorder.directory}' if self._recorder else 'not recording'
        return (
            f'publishing {topics} at {scenario["publish.rate"]:g} Hz, {pace}; tick 0 is at '
            f'{epoch:%Y-%m-%d %H:%M:%S.%f} UTC; {bag}'
        )

    @property
    def lateness(self) -> Lateness:
        """The lags of the ticks behind their deadlines since the start."""
        return Lateness() if self._pacing is None else self._pacing.lateness

    def destroy_node(self) -> None:
        """End the ticks, complete the bag, leave the graph, and log how late the ticks were."""
        self._end()
        name = self.get_logger().name
        super().destroy_node()
        if len(self.lateness):
            # A logger of its own: what is logged under the node's name goes to /rosout as well,
            # whose publisher has lost its context, yet lives as long as any handle is in use.
            rclpy.logging.get_logger(f'{name}.pacing').info(str(self.lateness))

    def _end(self):
        """End the ticks and complete the bag."""
        if self._own_services is not None:
            self._own_services.close()
        if self._pacing is not None:
            self._pacing.stop()
        with self._opening:
            self._is_ending = True
            recorder, self._recorder = self._recorder, None
        if recorder is not None:
            recorder.close()

    # -- what the ticks hold, from the pacing thread --------------------------------------------

    def prepare(self, samples: Samples) -> PackedTicks:
        """Return the messages of ticks, which may yet be computed anew."""
        return self._publishing.pack(samples, self._simulation.topics)

    def published(
        self, happened: list[Event], samples: Samples, messages: PackedTicks, count: int
    ) -> None:
        """Log and record what happened at the first tick, and the `count` ticks published."""
        for event in happened:
            if isinstance(event, TorquesDropped):
                self.get_logger().error(
                    'the torques that acted are dropped: with them tick '
                    f'{event.tick} cannot be reached'
                )
        if any(isinstance(event, Halt) for event in happened) and self._simulation.halted:
            self.get_logger().error(
                f'no tick follows until a request or a reset: {self._simulation.halted}'
            )
        self._inputs_report.take(happened)
        self._topics_in_force += sum(isinstance(event, Topics) for event in happened)
        if count:
            self._latest = samples, count - 1
            self._propagation.take(self._simulation.motion, samples)
        recorder = self._recorder
        if recorder is not None:
            for_snapshots = self._simulation.snapshot_copy()
            recorder.put(happened, samples, messages.rows, count, for_snapshots)

    # -- changes, made by the threads of the services --------------------------------------------

    def _prepare_change(self, scenario, names):
        """Open the publishers of topics to be published; ValueError: their QoS is not allowed."""
        if 'publish.topics' in names:
            self._publishing.open(scenario.topics)

    def _change(self, scenario, names):
        """Apply parameters changed at run time."""
        pacing = self._pacing
        assert pacing is not None  # the executor spins when all is built
        if 'time.factor' in names:
            pacing.set_factor(scenario['time.factor'])
        if 'torque.timeout' in names:
            self._inputs.timeout_s = scenario['torque.timeout']
        if 'publish.topics' in names:
            topics = self._publishing.open(scenario.topics)
            self._topics_asked += 1
            pacing.put(lambda tick: Topics(tick, topics))

    def _close_publishers(self):
        """Close what is published no more, unless topics are yet to change."""
        if self._topics_asked == self._topics_in_force:
            self._publishing.close_others(self._simulation.topics)

    def _record(self, enabled):
        """Open a bag, or close the open one; return whether that worked and what was done."""
        recorder = self._recorder
        if not enabled:
            if recorder is None:
                return False, 'no bag is open'
            self._recorder = None
            recorder.close()
            if recorder.failure is not None:
                return False, one_sentence(recorder.failure)
            return True, f'closed {recorder.directory}'
        if recorder is not None:
            if recorder.failure is None:
                return False, f'{recorder.directory} is open already'
            recorder.close()
        try:
            recorder = self._open_recorder()
        except Exception as error:
            is_expected = isinstance(error, OSError | ValueError)
            return False, one_sentence(error if is_expected else repr(error))
        with self._opening:
            if not self._is_ending:
                self._recorder = recorder
                return True, f'recording {recorder.directory}'
        recorder.close()
        return False, 'the node ends'

    def _open_recorder(self):
        scenario = self._simulation.scenario
        return _recorder_class()(
            scenario,
            self._simulation.topics,
            lambda name: self.resolve_topic_name(scenario.topic_table[name].name),
            self._lose_recording,
            self._publishing.offered,
            self._folder,
            self._simulation.control,
        )

    def _lose_recording(self, sentence):
        """Report, and end with exit code 1, that a bag does not hold all that it should."""
        self.failure = sentence
        self.get_logger().error(sentence)

    def _fail(self, error):
        """End the node: a tick could not be computed, or, at the end, not be published."""
        if not self.context.ok():
            return
        self.failure = str(error)
        self.get_logger().fatal(f'the ticks have ended: {self.failure}')
        self.has_ended = True
        if self.executor is not None:
            self.executor.wake()


def _recorder_class():
    """Return Recorder, imported and its code loaded when a node records, which takes time."""
    try:
        from ..bag.write_run import load_code
        from .recorder import Recorder
    except ModuleNotFoundError as error:
        package = (error.name or '').split('.')[0]
        raise ValueError(f'recording needs {package}: pip install {package}') from error
    load_code()
    return Recorder


def _try_out(scenario):
    """Compile the equations, if needed, and refuse a state from which no motion can start."""
    if scenario['motion.method'] == 'auto':
        # A torque may ask for it later.
        Propagation(scenario.system, scenario.initial_state).at(0.0)
    try_out(scenario, 0)

"""A node in a process of its own, and a participant in this one that listens and asks."""

import itertools
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import yaml
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import QoSProfile
from std_srvs.srv import SetBool, Trigger
from type_description_interfaces.srv import GetTypeDescription

from satdyn_ros.messages.contents import message
from satdyn_ros.ros.publishing import message_class
from satdyn_ros.run.parameter_file import with_own_frames
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.run.topics import TOPICS

ROOT = Path(__file__).parents[2]
DEFAULT = ROOT / 'config' / 'default.yaml'
# An installation of ROS is there by the PYTHONPATH too.
_PATHS = str(ROOT), str(ROOT / 'test'), os.environ.get('PYTHONPATH')
ENVIRONMENT = os.environ | {'PYTHONPATH': os.pathsep.join(filter(None, _PATHS))}
# Long enough for a loaded machine; nothing waits so long where all is well.
# To compile the equations of a node takes minutes where all cores are busy.
PATIENCE_S = 300.0
EPOCH_NS = 1_700_000_000 * 10**9

_numbers = itertools.count(1)


class LiveNode:
    """
    The node as a process, in a namespace of its own.

    values: parameters by dotted name, written to a file.  ros_args: what follows --ros-args;
    options: what comes before it.  module: of which the command is.
    environment: variables beside those of this process.
    file_limit_bytes: no file of the process may be larger.
    """

    def __init__(
        self,
        directory,
        values,
        ros_args=(),
        namespace=None,
        file_limit_bytes=None,
        options=(),
        module='start',
        environment=None,
    ):
        self.namespace = namespace or f'/test{os.getpid()}_{next(_numbers)}'
        self.values = {'time.epoch_ns': EPOCH_NS} | values
        self._file = directory / f'{self.namespace.strip("/")}.yaml'
        self.name = f'{self.namespace}/satdyn'
        self.write(self.values)
        self.process = start(
            [
                '--params-file',
                str(self._file),
                *options,
                '--ros-args',
                '-r',
                f'__ns:={self.namespace}',
                *ros_args,
            ],
            directory,
            file_limit_bytes,
            module,
            environment,
        )

    def write(self, values):
        """Let these be the values in the file."""
        self._file.write_text(yaml.safe_dump({self.name: {'ros__parameters': values}}))

    @property
    def scenario(self):
        """The scenario that was given, with the frames of a node in a namespace."""
        return Scenario(with_own_frames(self.values, self.name, self.values))

    @property
    def body_frame(self):
        """The frame of the body, if none is given."""
        return f'{self.namespace[1:]}/base_link'

    def end(self, number=signal.SIGINT):
        """Send a signal; return the exit code and what stood on stderr."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        _, errors = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, errors


def start(arguments, directory, file_limit_bytes=None, module='start', environment=None):
    """Start the command `satdyn_node`, or that of another module."""

    def limit():
        # Without its signal, a write beyond the limit fails as on a full disk.
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (file_limit_bytes, file_limit_bytes))

    return subprocess.Popen(
        [sys.executable, '-m', f'satdyn_ros.ros.{module}', *arguments],
        cwd=directory,
        env=ENVIRONMENT | (environment or {}),
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=limit if file_limit_bytes else None,
    )


class Participant:
    """A ROS node that lives in this process beside a live node, in its namespace."""

    def __init__(self, namespace, **kwargs):
        self.node = Node(f'participant{next(_numbers)}', namespace=namespace, **kwargs)
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()

    def wait_until(self, condition, what='the condition', patience_s=PATIENCE_S):
        """Take messages until the condition holds."""
        end_s = time.monotonic() + patience_s
        while not condition():
            assert time.monotonic() < end_s, f'{what} did not come'
            self.executor.spin_once(timeout_sec=0.05)

    def spin(self, duration_s):
        """Take messages for some seconds."""
        end_s = time.monotonic() + duration_s
        while (left_s := end_s - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left_s)

    def listen(self, name, raw=False, depth=20000, table=TOPICS):
        """Return a list that fills with the messages on a topic, by its name in the scenario."""
        messages: list = []
        topic = table[name]
        self.node.create_subscription(
            message_class(topic.type),
            topic.name,
            messages.append,
            QoSProfile(depth=depth),
            raw=raw,
        )
        return messages

    def hear(self, messages, count, patience_s=PATIENCE_S):
        """Wait until a list has `count` messages more, and return those."""
        before = len(messages)
        self.wait_until(lambda: len(messages) >= before + count, f'{count} messages', patience_s)
        return messages[before : before + count]

    def call(self, kind, name, request):
        """Call a service of the live node and return its answer."""
        client = self.node.create_client(kind, name)
        self.wait_until(client.service_is_ready, name)
        self.wait_until_known(name.rpartition('/')[0])
        future = client.call_async(request)
        self.wait_until(future.done, f'the answer of {name}')
        self.node.destroy_client(client)
        return future.result()

    def wait_until_known(self, node_name):
        """
        Wait until a node knows the clients that were made here.

        It loses its answer to one that it has not discovered.  It discovers them in their order:
        once it answers a later one, it knows those before.
        """
        # Of all nodes, configured or not; one that asks for no type hash makes rcl complain.
        name = f'{node_name}/get_type_description'
        request = GetTypeDescription.Request(type_hash=f'RIHS01_{64 * "0"}')
        later = self.node.create_client(GetTypeDescription, name)
        self.wait_until(later.service_is_ready, name)
        end_s = time.monotonic() + PATIENCE_S
        future = later.call_async(request)
        self.executor.spin_until_future_complete(future, 0.5)
        while not future.done():
            assert time.monotonic() < end_s, f'the answer of {name} did not come'
            future = later.call_async(request)
            self.executor.spin_until_future_complete(future, 0.5)
        self.node.destroy_client(later)

    def request(self, values):
        """Ask for initial conditions; return whether they were taken, and the reason if not."""
        request = SetParametersAtomically.Request(parameters=parameter_messages(values))
        answer = self.call(SetParametersAtomically, 'satdyn/set_initial_conditions', request)
        return answer.result.successful, answer.result.reason

    def trigger(self, name):
        answer = self.call(Trigger, f'satdyn/{name}', Trigger.Request())
        return answer.success, answer.message

    def switch(self, name, data):
        answer = self.call(SetBool, f'satdyn/{name}', SetBool.Request(data=data))
        return answer.success, answer.message

    def set(self, values):
        """Set parameters one by one; return whether each was taken, and the reasons."""
        request = SetParameters.Request(parameters=parameter_messages(values))
        results = self.call(SetParameters, 'satdyn/set_parameters', request).results
        return [(result.successful, result.reason) for result in results]

    def get(self, name):
        request = GetParameters.Request(names=[name])
        answer = self.call(GetParameters, 'satdyn/get_parameters', request)
        return parameter_value_to_python(answer.values[0])


def parameter_messages(values) -> list[ParameterMessage]:
    return [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]


def stamp_ns(message):
    """Return the stamp of a message with a header."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def raw_stamp_ns(data):
    """Return the stamp of a serialised message that begins with a header."""
    return int.from_bytes(data[4:8], 'little') * 10**9 + int.from_bytes(data[8:12], 'little')


def expected(scenario, topic, count, events=()):
    """Return the serialised messages of the first ticks, from stamps to bytes."""
    simulation = Simulation(scenario, events)
    packer = message(TOPICS[topic], scenario.frames, scenario.system)
    packed = {}
    while simulation.next_tick < count:
        _, samples = simulation.advance(count - simulation.next_tick)
        rows = packer.pack(samples)
        for stamp, row in zip(samples.stamps_ns.tolist(), rows, strict=True):
            packed[stamp] = row.tobytes()
    return packed

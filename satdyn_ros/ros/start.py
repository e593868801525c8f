"""The command `satdyn_node`, which is `satdyn node`: one node or a fleet, until asked to end."""

import gc
import logging
import re
import signal
import sys
import warnings
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from pathlib import Path

import rclpy
import rclpy.logging
from rclpy.exceptions import NameValidationException, NotInitializedException
from rclpy.executors import ExternalShutdownException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.signals import install_signal_handlers

from ..base import ros_yaml
from ..base.interruption import interruptible, uninterrupted
from ..base.one_line_parser import OneLineParser
from ..base.regular_file import regular_file
from ..base.sentences import one_sentence
from ..run import controllers
from ..run.parameter_file import ParameterFile, folder_of
from ..torques.body_torque import named
from .context import init
from .executor import Executor
from .node import Moment, SatdynNode

# The pacing thread waits at most this long for another thread of Python.
_SWITCH_INTERVAL_S = 0.0005
# A signal may wake an executor just before it ends ROS, and never again.
_LOOK_S = 0.5
# Options of --ros-args whose files ROS reads.
_FILE_OPTIONS = '--params-file', '--log-config-file'
# An argument of --ros-args that gives the node a name or a namespace, or a rule that may.
_NAMES_THE_NODE = re.compile(r'(.*:)?__(ns|node|name):=')
# rcl's words for a list of values of several kinds, and what to write in its place.
_OF_TWO_KINDS = 'Sequence should be of same type'
_HINT = (
    '; in a list every number must have a point, as in [0.0, 0.0, 0.002], and a text that ROS '
    "takes for true or false must be quoted, as 'y'"
)

RCLError = rclpy_implementation.RCLError
UnknownROSArgsError = rclpy_implementation.UnknownROSArgsError
# What is wrong with the input.
_REFUSED = ValueError, OSError, NameValidationException


def main(
    argv: Sequence[str] | None = None, kind: type[SatdynNode] = SatdynNode, begins: bool = True
) -> int:
    """
    Run the nodes and return the exit code: 0 ended as asked, 1 one failed, 2 the input is wrong.

    Parameters
    ----------
    argv : sequence of str or None
        [--params-file FILE ...] [--satellite NAME ...] [--section NAME]
        [--torque MODULE:CLASS ...] [--controller MODULE:CLASS]
        [--controller-parameter NAME=VALUE ...] [--ros-args ...]; None: that of the process
    kind : class
        of the nodes
    begins : bool
        whether the ticks begin at once; else the nodes read their files when asked to begin
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    at = arguments.index('--ros-args') if '--ros-args' in arguments else len(arguments)
    own, of_ros = _parser().parse_args(arguments[:at]), arguments[at:]
    try:
        torques = [named(name) for name in own.torque]
        controller = _controller(own)
        file = ParameterFile.read(own.params_file or ())
        names, section = _satellites(own, of_ros, file)
        _init(of_ros)
    except KeyboardInterrupt:
        return 0
    except (RCLError, UnknownROSArgsError, *_REFUSED) as error:
        return _refuse(error)
    sys.setswitchinterval(_SWITCH_INTERVAL_S)
    try:
        # Nodes that begin later read their files then, as they will be.
        values = file if begins else partial(ParameterFile.read, own.params_file)
        make = partial(
            kind,
            values if file.origin else None,
            torques,
            begins=False,
            ros_files=_ros_files(of_ros),
            section=section,
            controller=controller,
        )
        # Other satellites than that of a section are for the nodes beside this one.
        return _run(names, make, begins, None if section else file)
    except _REFUSED as error:
        return _refuse(error)
    except KeyboardInterrupt:
        return 0
    except (RCLError, NotInitializedException):
        # A signal may end ROS at any moment, even between a check of rclpy's and what relies on
        # it.
        if rclpy.ok():
            raise
        return 0
    finally:
        rclpy.try_shutdown()


def _parser():
    """Return the parser of what stands before --ros-args."""
    parser = OneLineParser('satdyn node', description='A satellite as a ROS 2 node.')
    parser.add_argument('--params-file', action='append', metavar='FILE', help='the scenario')
    parser.add_argument('--satellite', action='append', default=[], metavar='NAME')
    parser.add_argument(
        '--section', metavar='NAME', help='fly this satellite under the name of --ros-args'
    )
    parser.add_argument('--torque', action='append', default=[], metavar='MODULE:CLASS')
    parser.add_argument('--controller', metavar='MODULE:CLASS', help='what closes the loop')
    parser.add_argument(
        '--controller-parameter', action='append', default=[], metavar='NAME=VALUE'
    )
    return parser


def _controller(own):
    """Return what makes the controller, which is made once to see that it can be; None: none."""
    if own.controller is None:
        if own.controller_parameter:
            raise ValueError('--controller-parameter needs --controller, of which it is one')
        return None
    make = partial(controllers.named, own.controller, own.controller_parameter)
    make()
    return make


def _satellites(own, of_ros, file):
    """Return the full names of the nodes, and the satellite that one under another name flies."""
    is_named = any(_NAMES_THE_NODE.match(argument) for argument in of_ros)
    if is_named and own.satellite:
        raise ValueError('--satellite and --ros-args both name the node; one of them must')
    if own.section and own.satellite:
        raise ValueError('--satellite and --section both choose a satellite; one of them must')
    section = own.section and file.full_name(own.section)
    names = ['/satdyn'] if is_named or section else file.full_names(own.satellite)
    return names, section


def _init(of_ros):
    """Begin ROS with its arguments, whose files it reads by itself and for as long as they go."""
    for option, path in pairwise(of_ros):
        if option in _FILE_OPTIONS and Path(path).exists():
            regular_file(path)
    init(['satdyn', *of_ros])


def _ros_files(arguments):
    """
    Return what the parameter files of ROS arguments say.

    Without those that launch writes, under /** too, of the parameters of one node.
    """
    paths = [
        path
        for option, path in pairwise(arguments)
        if option == '--params-file' and not Path(path).name.startswith('launch_params_')
    ]
    return ParameterFile.of_texts(
        [(ros_yaml.read_text(path, 'the scenario'), path) for path in paths]
    )


def _run(names, make, begins, file):
    # Nothing may tear what a running or ending node does, such as completing its bag: the handlers
    # of rclpy, which call these, let a spinning executor end.
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, frame: signals.append(number))
    nodes: list[SatdynNode] = []
    # A node is built, and its equations compiled, under handlers that interrupt at once.
    with interruptible() as heard:
        _show_notices()
        # Garbage is collected between ticks.
        gc.disable()
        try:
            _build(nodes, names, make, begins, file)
        except BaseException:
            with uninterrupted():
                for node in nodes:
                    node.destroy_node()
            raise
    install_signal_handlers()
    if heard or signals:
        rclpy.try_shutdown()
    with ThreadPoolExecutor(len(nodes), 'executor') as pool:
        list(pool.map(_spin, nodes))
    return 0 if all(node.failure is None for node in nodes) else 1


def _build(nodes, names, make, begins, file):
    """Add the nodes of satellites, and let them begin, all with one tick 0, once all are there."""
    for full_name in names:
        namespace, _, name = full_name.rpartition('/')
        folder = folder_of(full_name) if names[1:] else ''
        with _named(full_name, names):
            nodes.append(make(folder=folder, node_name=name, namespace=namespace))
    own_names = [node.get_fully_qualified_name() for node in nodes]
    for sentence in file.unused(*own_names) if file else ():
        logging.getLogger('satdyn_ros').warning(sentence)
    if not begins:
        return
    moment = Moment.soon(len(nodes))
    for full_name, node in zip(names, nodes, strict=True):
        with _named(full_name, names):
            node.begin(moment)


@contextmanager
def _named(name, names):
    """Let a refusal say which of several satellites it is about."""
    try:
        yield
    except (ValueError, OSError) as error:
        if names[1:]:
            raise ValueError(f'{name}: {one_sentence(error)}') from error
        raise


def _spin(node):
    """Serve a node until ROS or its ticks end, and end it."""
    try:
        executor = Executor(node)
        while not node.has_ended and node.context.ok():
            executor.spin_once(_LOOK_S)
    except ExternalShutdownException:
        pass
    except (RCLError, NotInitializedException):
        if node.context.ok():
            raise
    finally:
        node.destroy_node()


class _ToRosLog(logging.Handler):
    def emit(self, record):
        logger = rclpy.logging.get_logger('satdyn')
        # Apart, since rclpy allows a line of code one severity.
        if record.levelno < logging.WARNING:
            logger.info(record.getMessage())
        else:
            logger.warning(record.getMessage())


def _show_notices():
    """
    Show in the log of ROS what the package logs, such as that it compiles, and warnings of Python.

    rclpy gives one when a client has left before its reply.
    """
    log = logging.getLogger('satdyn_ros')
    log.setLevel(logging.INFO)
    log.handlers = [_ToRosLog()]
    warnings.showwarning = lambda message, *where: log.warning('%s', message)


def _refuse(error):
    """Say in a sentence what is wrong with the input, and return the exit code for it."""
    if isinstance(error, UnknownROSArgsError):
        error = f'--ros-args does not allow {error}'
    elif isinstance(error, RCLError) and _OF_TWO_KINDS in str(error):
        error = f'{error}{_HINT}'
    print(f'satdyn node: {one_sentence(error)}', file=sys.stderr)
    return 2


if __name__ == '__main__':
    sys.exit(main())

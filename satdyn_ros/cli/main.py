"""The command `satdyn`: each sub-command calls the room that does its work."""

import gc
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from ..base.interruption import Terminated, interruptible
from ..base.one_line_parser import INPUT_IS_WRONG
from ..base.sentences import one_sentence
from .command_line import parser
from .output import output_that_may_fail, progress, show_notices

DONE, ANSWER_IS_NO, INTERRUPTED, TERMINATED = 0, 1, 130, 143

# What is not part of every installation: extras, and what a distribution of ROS does not have.  A
# checkout, a package and a workspace of colcon have different commands for an extra; the libraries
# themselves have one.
_OPTIONAL = (
    *('aiohttp', 'dask', 'distributed', 'matplotlib', 'pyarrow'),
    *('llvmlite', 'lz4', 'mcap', 'zstandard'),
)
_ROS = (
    'ROS 2: source an installation of it, '
    "or pip install 'ros-jazzy-rclpy[fastrtps]' ros-jazzy-common-interfaces"
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code; argv: without it that of the process."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        if arguments[:1] == ['node'] and not {'-h', '--help'} & set(arguments):
            return _node(arguments[1:])
        with interruptible(), output_that_may_fail(' '.join(arguments[:1])):
            given = parser().parse_args(arguments)
            if getattr(given, 'controller_parameter', []) and given.controller is None:
                raise ValueError('--controller-parameter needs --controller, of which it is one')
            show_notices()
            if given_torques := getattr(given, 'torque', []):
                from ..torques.body_torque import named

                given.torque = [named(name) for name in given_torques]
            return _COMMANDS[given.command](given)
    except (ValueError, OSError) as error:
        return _refuse(arguments, _sentence(error))
    except RuntimeError as error:
        # Before Python 3.12 what interrupts the making of a class comes in a RuntimeError.
        if isinstance(error.__cause__, Terminated):
            return TERMINATED
        if isinstance(error.__cause__, KeyboardInterrupt):
            return INTERRUPTED
        if not _says_no(error):
            raise
        _refuse(arguments, _sentence(error))
        return ANSWER_IS_NO
    except ImportError as error:
        package = (error.name or '').split('.')[0]
        if package == 'rclpy':
            return _refuse(arguments, f'this needs {_ROS}')
        if package not in _OPTIONAL:
            raise
        return _refuse(arguments, f'this needs {package}: pip install {package}')
    except Terminated:
        return TERMINATED
    except KeyboardInterrupt:
        # Only a signal ends watch: Ctrl-C is its normal end, as that of a node.
        return DONE if arguments[:1] == ['watch'] else INTERRUPTED


def _refuse(arguments, sentence):
    print(f'satdyn {arguments[0]}: {sentence}', file=sys.stderr)
    return INPUT_IS_WRONG


def _says_no(error):
    from ..bag.simulate import Untrue
    from ..dynamics.motion import Halted
    from ..run.simulation import RunHalted
    from ..sweep.workers import Failed

    return isinstance(error, Failed | Halted | RunHalted | Untrue)


def _warn(given, scenario):
    for warning in scenario.warnings:
        print(f'satdyn {given.command}: {warning}', file=sys.stderr)


def _sentence(error):
    if isinstance(error, OSError) and error.strerror:
        return f'{error.filename}: {error.strerror}' if error.filename else error.strerror
    return one_sentence(error)


# -- the commands ---------------------------------------------------------------------------------


def _node(arguments):
    # Nothing that a start imports is garbage; the node itself collects between ticks.
    gc.disable()
    from ..ros.start import main as run_node

    return run_node(arguments)


def _request(given):
    from ..ros.client import Answer, Client, assignment

    chosen = {
        name: value
        for name in ('reset', 'pause', 'resume', 'step', 'record', 'set', 'get')
        if (value := getattr(given, name)) is not None and value is not False
    }
    if bool(given.values) == bool(chosen):
        raise ValueError(
            'give either KEY=VALUE ..., or one of --reset, --pause, --resume, --step, --record, '
            '--set and --get'
        )
    assignments = [assignment(text) for text in given.values]
    values = dict(assignments)
    for name in values:
        if [other for other, _ in assignments].count(name) > 1:
            raise ValueError(f'{name} is given twice; it may be given once')
    change = assignment(given.set) if given.set else None
    try:
        with Client(given.node, given.timeout) as client:
            match chosen:
                case {'step': ticks}:
                    answer = client.step(None if ticks is True else ticks)
                case {'record': switch}:
                    answer = client.record(switch == 'on')
                case {'set': _} if change:
                    answer = client.set_parameter(*change)
                case {'get': name}:
                    answer = client.get_parameter(name)
                case {}:
                    for action in chosen:
                        answer = getattr(client, action)()
                    if values:
                        answer = client.set_initial_conditions(values)
    except TimeoutError as error:
        answer = Answer(False, str(error))
    print(answer.text if answer.success else f'no: {answer.text}')
    return DONE if answer.success else ANSWER_IS_NO


def _simulate(given):
    from ..bag.simulate import simulate
    from ..run.controllers import named

    # All are read before the first is written.
    runs = {out: _run_of(given, name) for name, out in _bags(given).items()}
    for out, (scenario, happening, begin, count) in runs.items():
        done = 0
        try:
            with progress('simulating', 'ticks') as show:
                controller = None
                if given.controller is not None:
                    controller = named(given.controller, given.controller_parameter)
                for done in simulate(scenario, given.duration, out, happening, begin, controller):
                    show(done, count)
        finally:
            if done:
                print(f'{out}: {done} ticks, {done / float(scenario.rate):g} s')
    return DONE


def _bags(given):
    """Return the bag of each satellite that --satellite names: of several BAG/sat4, BAG/sat5."""
    from ..run.parameter_file import ParameterFile, folder_of

    if len(given.satellite) < 2:
        return {given.satellite[0] if given.satellite else None: given.out}
    if given.origin is not None:
        raise ValueError('--from begins one run; --satellite names several')
    file = ParameterFile.read([given.file])
    names = file.full_names(given.satellite)
    for warning in file.unused(*names):
        print(f'satdyn simulate: {warning}', file=sys.stderr)
    return {name: Path(given.out, folder_of(name)) for name in names}


def _run_of(given, satellite):
    """Return scenario, events, begin and number of ticks of what is to be simulated."""
    from ..bag.continuation import begun_in_aem, begun_in_bag, is_aem
    from ..bag.simulate import tick_count
    from ..run import events
    from ..run.parameter_file import ParameterFile, without_rclpys
    from ..run.scenario import Scenario

    file = ParameterFile.read([given.file])
    full_name = file.full_name(satellite)
    # Of several satellites one warning says which sections none of them uses.
    warnings = [] if given.satellite[1:] else file.unused(full_name)
    scenario = Scenario(without_rclpys(file.flown(full_name)), given.torque, warnings)
    if given.rate is not None:
        scenario = scenario.with_values({'publish.rate': given.rate})
    if (given.origin is None) != (given.at is None):
        raise ValueError(
            '--from and --at belong together: a bag and the second in it, or an AEM and an epoch'
        )
    begin = None
    if given.origin is not None:
        if is_aem(given.origin):
            scenario = begun_in_aem(scenario, given.origin, given.at)
        else:
            scenario, begin = begun_in_bag(scenario, given.origin, given.at)
    # The age of an element set is that at tick 0.
    scenario = scenario.with_epoch(time.time_ns())
    _warn(given, scenario)
    happening = events.from_yaml(given.events, scenario) if given.events else []
    first = begin['tick'] if begin else 0
    count = tick_count(scenario, given.duration, first)
    for warning in events.warnings(happening, first + count, scenario):
        print(f'satdyn simulate: {warning}', file=sys.stderr)
    return scenario, happening, begin, count


def _replay(given):
    from ..ros.replay import replay

    count = replay(
        given.bag,
        rate=given.rate,
        loop=given.loop,
        publish_clock=given.clock,
        start_offset_s=given.start_offset,
        wait=given.wait,
    )
    print(f'{given.bag}: {count} messages')
    return DONE


def _verify(given):
    from ..bag.verify import verify
    from ..rosbag2.errors import Damaged

    try:
        with progress('verifying', 'ticks') as show:
            verdict = verify(given.bag, show)
    except Damaged as error:
        print(f'satdyn verify: {_sentence(error)}', file=sys.stderr)
        return ANSWER_IS_NO
    print(f'{given.bag}: {verdict}')
    return DONE if verdict.is_true else ANSWER_IS_NO


def _recover(given):
    from ..rosbag2.recover import recover

    recovered = recover(given.bag, given.out)
    files = ', '.join(recovered.files) or 'nothing'
    print(f'{given.out or given.bag}: completed {files}; {recovered.message_count} messages')
    for loss in recovered.losses:
        print(loss)
    return ANSWER_IS_NO if recovered.losses else DONE


def _export(given):
    from ..bag.export import Options, export

    options = Options(
        step_s=given.step,
        columns=tuple(given.columns),
        with_rates=given.rates,
        frame=given.frame,
        center=given.center,
        aem_version=given.aem_version,
    )
    with progress('exporting', 'ticks') as show:
        rows = export(given.bag, given.out, options, show)
    print(f'{given.out}: {rows} rows')
    return DONE


def _plot(given):
    sweeps = [bag for bag in given.bag if (Path(bag) / 'sweep.json').exists()]
    if sweeps:
        from ..report.outcomes import plot_sweep

        if given.bag[1:] or given.against is not None:
            raise ValueError(f'{sweeps[0]} is a sweep, which is drawn alone, without --against')
        if given.begin is not None or given.end is not None:
            raise ValueError(f'{sweeps[0]} is a sweep; --begin and --end choose a part of a bag')
        plot_sweep(sweeps[0], given.out, given.what)
        return DONE
    from ..report.plot import plot

    plot(given.bag, given.out, given.what, given.begin, given.end, given.unwrap, given.against)
    return DONE


def _report(given):
    from ..report.html import report

    report(given.bag, given.out, given.begin, given.end)
    return DONE


def _describe(given):
    import json

    from ..run.describe import describe
    from ..run.scenario import Scenario
    from .description import print_description
    from .sensor_sheets import print_sensors, sheets

    scenario = Scenario.from_yaml(given.file, given.satellite, given.torque)
    # As of a run that begins now.
    scenario = scenario.with_epoch(time.time_ns())
    _warn(given, scenario)
    if given.json and (given.code or given.urdf):
        raise ValueError('--json is for the description and for --sensors')
    if given.code:
        print(_code_of(scenario))
    elif given.urdf:
        from ..messages.robot_description import urdf

        print(urdf(scenario))
    elif given.sensors and given.json:
        print(json.dumps(sheets(scenario), indent=2))
    elif given.sensors:
        print_sensors(scenario)
    elif given.json:
        print(json.dumps(describe(scenario), indent=2))
    else:
        print_description(scenario)
    return DONE


def _code_of(scenario):
    """Return the IR of the step by which a scenario is propagated."""
    from ..integrate.propagation import Propagation
    from ..integrate.step_code import text_of

    motion = scenario.motion()
    if not isinstance(motion, Propagation):
        raise ValueError(
            f'the motion is the closed form {motion.name}, which takes no steps; --code needs '
            'motion.method numeric'
        )
    return text_of(motion.constants, 1)


def _constellation(given):
    from ..run.constellation import write_constellation

    count = write_constellation(given.file, given.out, given.name)
    print(f'{given.out}: {count} satellites')
    return DONE


def _watch(given):
    from ..watch.server import Source, serve

    source: Source
    if given.bag is not None:
        from ..watch.bag_page import Recorded

        source = Recorded(given.bag)
    else:
        from ..watch.ros_graph import RosGraph

        source = RosGraph(given.node, given.torque)
    number = serve(source, given.host, given.port, lambda url: print(f'watch: {url}', flush=True))
    return TERMINATED if number == signal.SIGTERM else DONE


def _sweep(given):
    from ..run.shipped import sweep_path
    from ..sweep.run import sweep
    from ..sweep.table import summary

    with progress('sweep', 'runs') as show:
        table = sweep(
            sweep_path(given.file),
            given.out,
            given.workers,
            given.dask,
            show,
            satellite=given.satellite,
            outcomes=tuple(given.outcome),
            torques=given.torque,
            controller=given.controller,
            controller_parameters=given.controller_parameter,
        )
    print(f'{table}: {summary(table)}')
    return DONE


def _check(given):
    from ..run.scenario import Scenario
    from .accuracy import check_run
    from .check import check

    alone = given.out or given.satellite
    if (given.file is None) != (given.duration is None) or (alone and given.file is None):
        raise ValueError('FILE and --duration belong together, and -o and --satellite need both')
    if given.file is None:
        return DONE if check() else ANSWER_IS_NO
    scenario = Scenario.from_yaml(given.file, given.satellite, given.torque)
    _warn(given, scenario)
    try:
        check_run(scenario, given.file, given.duration, given.out)
    except RuntimeError as error:
        print(f'satdyn check: {error}', file=sys.stderr)
        return ANSWER_IS_NO
    return DONE


_COMMANDS = {
    'request': _request,
    'simulate': _simulate,
    'replay': _replay,
    'verify': _verify,
    'recover': _recover,
    'export': _export,
    'plot': _plot,
    'report': _report,
    'watch': _watch,
    'describe': _describe,
    'constellation': _constellation,
    'sweep': _sweep,
    'check': _check,
}


if __name__ == '__main__':
    sys.exit(main())

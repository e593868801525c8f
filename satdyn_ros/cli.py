"""The command `satdyn`: what each sub-command takes; the work is done in the rooms."""

import argparse
import signal
import sys
import threading
from collections.abc import Sequence
from contextlib import contextmanager

DONE, ANSWER_IS_NO, INPUT_IS_WRONG, INTERRUPTED = 0, 1, 2, 130

# What is not part of every installation, and how one comes by it.
_EXTRAS = {
    'rclpy': 'ROS 2: source an installation of it, or pip install "satdyn_ros[ros]"',
    'matplotlib': 'matplotlib: pip install "satdyn_ros[plot]"',
    'plotly': 'plotly: pip install "satdyn_ros[plot]"',
    'dask': 'dask: pip install "satdyn_ros[sweep]"',
    'distributed': 'distributed: pip install "satdyn_ros[sweep]"',
    'pyarrow': 'pyarrow: pip install "satdyn_ros[sweep]"',
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code; argv: without it that of the process."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        if arguments[:1] == ['node'] and not {'-h', '--help'} & set(arguments):
            return _node(arguments[1:])
        given = parser().parse_args(arguments)
        return given.run(given)
    except (ValueError, OSError) as error:
        return _refuse(arguments, _sentence(error))
    except ImportError as error:
        package = (error.name or '').split('.')[0]
        if package not in _EXTRAS:
            raise
        return _refuse(arguments, f'this needs {_EXTRAS[package]}')
    except KeyboardInterrupt:
        return INTERRUPTED


def _refuse(arguments, sentence):
    print(f'satdyn {arguments[0]}: {sentence}', file=sys.stderr)
    return INPUT_IS_WRONG


def _sentence(error):
    if isinstance(error, OSError) and error.strerror:
        return f'{error.filename}: {error.strerror}' if error.filename else error.strerror
    return ' '.join(str(error).split())


# -- the commands ---------------------------------------------------------------------------------


def _node(arguments):
    from .ros.main import main as run_node

    return run_node(arguments)


def _request(given):
    from .ros.client import ask

    return ask(given.values, given.action, given.node, given.timeout)


def _simulate(given):
    from . import events, offline
    from .progress import progress
    from .scenario import Scenario

    scenario = Scenario.from_yaml(given.file)
    if given.rate is not None:
        scenario = scenario.with_values({'publish.rate': given.rate})
    if (given.bag is None) != (given.at is None):
        raise ValueError('--from and --at belong together: a bag and the second in it')
    if given.bag is not None:
        scenario = offline.begun_in_bag(scenario, given.bag, given.at)
    happening = events.from_yaml(given.events, scenario) if given.events else []
    count = offline.tick_count(scenario, given.duration)
    run = offline.simulate(scenario, given.duration, given.out, happening)
    with (
        _interruption() as interrupted,
        progress('simulating', count, 'ticks') as show,
    ):
        for done in run:
            show(done)
            if interrupted.is_set():
                run.close()
                break
    print(f'{given.out}: {done} ticks, {done / float(scenario.rate):g} s')
    return INTERRUPTED if interrupted.is_set() else DONE


@contextmanager
def _interruption():
    """Yield an event that Ctrl-C sets, to be seen where it does no harm: between blocks."""
    interrupted = threading.Event()
    before = signal.signal(signal.SIGINT, lambda *_: interrupted.set())
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, before)


def _replay(given):
    from .ros.replay import replay

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
    from .bag.verify import verify

    verdict = verify(given.bag)
    print(f'{given.bag}: {verdict}')
    return DONE if verdict.is_true else ANSWER_IS_NO


def _recover(given):
    from .bag.recover import recover

    recovered = recover(given.bag)
    files = ', '.join(recovered.files) or 'nothing'
    print(f'{given.bag}: completed {files}; {recovered.message_count} messages')
    return DONE


def _export(given):
    from .bag.export import export

    export(given.bag, given.out)
    return DONE


def _plot(given):
    from .report.plot import plot

    plot(given.bag, given.out, given.what)
    return DONE


def _report(given):
    from .report.html import report

    report(given.bag, given.out)
    return DONE


def _sweep(given):
    from .sweep.run import sweep

    print(sweep(given.file, given.out, given.workers, given.dask))
    return DONE


def _check(given):
    from .check import check

    return DONE if check() else ANSWER_IS_NO


# -- what they take -------------------------------------------------------------------------------


class _Parser(argparse.ArgumentParser):
    """A parser whose help begins with examples and whose errors are one sentence."""

    examples = ''

    def format_help(self):
        examples = ''.join(f'  {line}\n' for line in self.examples.splitlines())
        return f'examples:\n{examples}\n{super().format_help()}'

    def error(self, message):
        self.exit(INPUT_IS_WRONG, f'{self.prog}: {message}; {self.prog} --help says more\n')


_NODE_EXAMPLES = """\
satdyn node --params-file config/default.yaml
satdyn node --params-file config/default.yaml --ros-args -p record.enabled:=true -r __ns:=/sat1"""


def parser() -> argparse.ArgumentParser:
    """Return what reads the arguments of every command."""
    satdyn = _Parser('satdyn', description='Attitude dynamics of gyrostat satellites.')
    satdyn.examples = """\
satdyn node --params-file config/default.yaml
satdyn request initial.angular_velocity=[0,0,0.01]
satdyn simulate config/default.yaml --duration 6000 -o orbit
satdyn verify orbit
satdyn check"""
    commands = satdyn.add_subparsers(metavar='COMMAND', required=True, parser_class=_Parser)

    def command(name, run, text, examples):
        added = commands.add_parser(name, help=text, description=f'{text[0].upper()}{text[1:]}.')
        added.examples = examples
        added.set_defaults(run=run)
        return added

    added = command('node', None, 'the node, paced; needs ROS 2', _NODE_EXAMPLES)
    added.add_argument('--params-file', metavar='FILE', help='the scenario')
    added.add_argument('--ros-args', nargs='...', metavar='', help='what ROS 2 nodes take')
    _add_request(command)
    _add_simulate(command)
    _add_replay(command)
    _add_bag_commands(command)
    _add_sweep(command)
    command(
        'check',
        _check,
        'prove this install: closed forms against propagation, a bag round trip',
        'satdyn check',
    )
    return satdyn


def _add_request(command):
    added = command(
        'request',
        _request,
        'ask a running node and print its answer; needs ROS 2',
        'satdyn request initial.angular_velocity=[0,0,0.01] initial.frame=lvlh\n'
        'satdyn request --reset\n'
        'satdyn request --node /sat1/satdyn --pause',
    )
    added.add_argument(
        'values',
        nargs='*',
        metavar='KEY=VALUE',
        help='new initial conditions: initial.*, rotor.momentum, rotor.speed',
    )
    what = added.add_mutually_exclusive_group()
    for name, text in (
        ('reset', 'restart from the initial conditions in force'),
        ('pause', 'let no tick pass'),
        ('resume', 'let ticks pass again'),
        ('step', 'step.ticks ticks, while paused'),
    ):
        what.add_argument(f'--{name}', dest='action', action='store_const', const=name, help=text)
    added.add_argument('--node', default='satdyn', metavar='NAME', help='default: satdyn')
    added.add_argument(
        '--timeout', type=float, default=5.0, metavar='S', help='how long to wait; default: 5'
    )


def _add_simulate(command):
    added = command(
        'simulate',
        _simulate,
        'scenario to bag: no ROS, no pacing',
        'satdyn simulate config/default.yaml --duration 6000 -o orbit\n'
        'satdyn simulate config/default.yaml --duration 86400 --rate 10 -o day\n'
        'satdyn simulate config/default.yaml --duration 60 --events events.yaml -o pushed\n'
        'satdyn simulate config/default.yaml --duration 60 --from orbit --at 3000 -o onward',
    )
    added.add_argument('file', metavar='FILE', help='the scenario, a ROS 2 parameter file')
    added.add_argument(
        '--duration', required=True, metavar='S', help='the ticks k with k / rate < S'
    )
    added.add_argument('--rate', type=float, metavar='HZ', help='in place of publish.rate')
    added.add_argument('--events', metavar='FILE', help='what happens: requests, torques ...')
    added.add_argument('--from', dest='bag', metavar='BAG', help="begin with this bag's state")
    added.add_argument('--at', metavar='S', help="at this second from the bag's tick 0")
    _add_out(added, 'BAG', 'the new bag, a directory')


def _add_replay(command):
    added = command(
        'replay',
        _replay,
        "publish a bag's topics again; needs ROS 2",
        'satdyn replay orbit\nsatdyn replay orbit --rate 10 --clock --wait',
    )
    _add_bag(added)
    added.add_argument(
        '--rate', type=float, default=1.0, metavar='X', help='so many times as fast; default: 1'
    )
    added.add_argument('--loop', action='store_true', help='again and again')
    added.add_argument('--clock', action='store_true', help='publish /clock')
    added.add_argument(
        '--start-offset', type=float, default=0.0, metavar='S', help='begin later in the bag'
    )
    added.add_argument('--wait', action='store_true', help='wait for a subscriber')


def _add_bag_commands(command):
    _add_bag(
        command(
            'verify',
            _verify,
            'run a bag again from its own scenario and events and compare every message',
            'satdyn verify orbit',
        )
    )
    _add_bag(
        command(
            'recover', _recover, 'complete a bag whose writer was killed', 'satdyn recover orbit'
        )
    )
    added = command(
        'export', _export, 'the states of a bag as a table', 'satdyn export orbit -o orbit.csv'
    )
    _add_bag(added)
    _add_out(added, 'FILE', 'a .csv, .npz or .parquet file')
    added = command(
        'plot',
        _plot,
        'draw a bag',
        'satdyn plot orbit -o orbit.png\nsatdyn plot orbit -o phase.png --what phase',
    )
    _add_bag(added)
    _add_out(added, 'FILE', 'a picture')
    added.add_argument('--what', nargs='+', default=(), metavar='PANEL', help='the panels to draw')
    added = command(
        'report', _report, 'a bag as one page to play', 'satdyn report orbit -o orbit.html'
    )
    _add_bag(added)
    _add_out(added, 'FILE', 'an .html file')


def _add_sweep(command):
    added = command(
        'sweep', _sweep, 'many runs at once', 'satdyn sweep sweep.yaml -o runs --workers 8'
    )
    added.add_argument('file', metavar='SWEEP.yaml', help='a scenario and what varies')
    _add_out(added, 'DIR', 'where the results go')
    where = added.add_mutually_exclusive_group()
    where.add_argument('--workers', type=int, metavar='N', help='processes; default: one a core')
    where.add_argument('--dask', metavar='ADDR', help='the scheduler of a cluster')


def _add_bag(command):
    command.add_argument('bag', metavar='BAG', help='a bag: a directory or an .mcap file')


def _add_out(command, metavar, text):
    command.add_argument('-o', dest='out', required=True, metavar=metavar, help=text)


if __name__ == '__main__':
    sys.exit(main())

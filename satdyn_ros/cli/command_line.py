"""The arguments of the command `satdyn`; its help begins with examples."""

import argparse

from ..base import numbers
from ..base.one_line_parser import OneLineParser
from ..base.units import Unfit, fitting, in_unit, is_quantity


class _Parser(OneLineParser):
    """A parser whose help begins with examples and ends with notes."""

    examples = ''
    notes = ''

    def format_help(self):
        examples = ''.join(f'  {line}\n' for line in self.examples.splitlines())
        return f'examples:\n{examples}\n{self.format_usage_and_options()}'

    def format_usage_and_options(self):
        """Return the help without its examples."""
        notes = f'\n{self.notes}\n' if self.notes else ''
        return f'{super().format_help()}{notes}'


# The commands that compute a run, or read one that was computed.
_WITH_TORQUES = (
    *('simulate', 'verify', 'export', 'plot', 'report', 'watch'),
    *('describe', 'sweep', 'check'),
)
_SCENARIO = 'a ROS 2 parameter file, or the name of a shipped scenario'
_NODE_EXAMPLES = """\
satdyn node --params-file config/default.yaml
satdyn node --params-file constellation --satellite /sat4 --satellite /sat5
satdyn node --params-file config/default.yaml --ros-args -r __ns:=/sat1 -p publish.rate:=50.0"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of every command."""
    satdyn = _Parser('satdyn', description='Attitude dynamics of gyrostat satellites.')
    satdyn.examples = """\
satdyn node --params-file config/default.yaml
satdyn request initial.angular_velocity=[0,0,0.01]
satdyn simulate config/default.yaml --duration 6000 -o orbit
satdyn verify orbit
satdyn check"""
    commands = satdyn.add_subparsers(
        dest='command', metavar='COMMAND', required=True, parser_class=_Parser
    )

    def command(name, text, examples):
        added = commands.add_parser(name, help=text, description=f'{text[0].upper()}{text[1:]}.')
        added.examples = examples
        return added

    for add in (
        *(_add_node, _add_request, _add_simulate, _add_replay, _add_bag_commands, _add_watch),
        *(_add_describe, _add_constellation, _add_sweep, _add_check),
    ):
        add(command)
    for name in _WITH_TORQUES:
        _add_torque(commands.choices[name])
    return satdyn


def _seconds(text: str) -> str:
    """Return a time such as '12 min' as the text of its seconds, and any other text as it is."""
    return _in_unit(text, 's')


def _number_of_seconds(text: str) -> float:
    """Return a time such as '12 min' or '720' as its seconds."""
    return float(_in_unit(text, 's'))


def _rate(text: str) -> float:
    """Return a rate such as '10 Hz' or '10' as a number of Hz."""
    return float(_in_unit(text, 'Hz'))


def _in_unit(text, unit):
    """Return the text of a quantity as that of its number in a unit, any other as it is."""
    if numbers.number(text) is not None or text.startswith('[') or not is_quantity(text):
        return text
    try:
        return str(in_unit(text, unit))
    except Unfit as unfit:
        raise argparse.ArgumentTypeError(
            f'{text!r}; {unfit}; units that fit: {fitting(unit)}'
        ) from None


_number_of_seconds.__name__, _rate.__name__ = 'time', 'rate'


def _add_node(command):
    added = command('node', 'the node, paced; needs ROS 2', _NODE_EXAMPLES)
    added.add_argument(
        '--params-file',
        action='append',
        metavar='FILE',
        help=f'{_SCENARIO}; if there are several, later ones prevail, as in ROS',
    )
    added.add_argument(
        '--satellite',
        action='append',
        metavar='NAME',
        help='which satellite, if the scenario has several: /sat4/satdyn, or /sat4; may be '
        'repeated; default: all, each a node of its own',
    )
    added.add_argument(
        '--section',
        metavar='NAME',
        help='fly this satellite of the scenario under the name that --ros-args gives, as the '
        'launch files do in pushed namespaces',
    )
    _add_torque(added)
    _add_controller(added)
    added.add_argument(
        '--ros-args', nargs='...', metavar='', help='the usual arguments of ROS 2 nodes'
    )


def _add_request(command):
    added = command(
        'request',
        'ask a running node and print its answer; needs ROS 2',
        'satdyn request initial.angular_velocity=[0,0,0.01] initial.frame=lvlh\n'
        "satdyn request 'initial.roll_pitch_yaw=[5, 0, 10] deg'\n"
        'satdyn request --pause\n'
        'satdyn request --step 10\n'
        'satdyn request --set time.factor=10\n'
        'satdyn request --node /sat1/satdyn --record on',
    )
    added.add_argument(
        'values',
        nargs='*',
        metavar='KEY=VALUE',
        help='new initial conditions: initial.*, momentum and speed of the rotors',
    )
    what = added.add_mutually_exclusive_group()
    for name, text in (
        ('reset', 'restart from the initial conditions in force'),
        ('pause', 'stop the ticks'),
        ('resume', 'resume the ticks'),
    ):
        what.add_argument(f'--{name}', action='store_true', help=text)
    what.add_argument(
        '--step',
        nargs='?',
        type=int,
        const=True,
        metavar='N',
        help='advance by step.ticks ticks while paused; N: set step.ticks first',
    )
    what.add_argument(
        '--record', choices=('on', 'off'), help='start a new bag, or close the open one'
    )
    what.add_argument('--set', metavar='PARAMETER=VALUE', help='set a parameter')
    what.add_argument('--get', metavar='PARAMETER', help='print the value of a parameter')
    added.add_argument('--node', default='satdyn', metavar='NAME', help='default: satdyn')
    added.add_argument(
        '--timeout',
        type=_number_of_seconds,
        default=5.0,
        metavar='S',
        help='how long to wait; default: 5',
    )


def _add_simulate(command):
    added = command(
        'simulate',
        'scenario to bag: no ROS, no pacing',
        'satdyn simulate config/default.yaml --duration 6000 -o orbit\n'
        "satdyn simulate config/default.yaml --duration '1 d' --rate 10 -o day\n"
        'satdyn simulate config/default.yaml --duration 60 --events events.yaml -o pushed\n'
        'satdyn simulate config/default.yaml --duration 60 --from orbit --at 3000 -o onward\n'
        'satdyn simulate cubesat_adcs --duration 60 '
        '--controller examples/controllers/nadir.py:Nadir -o pointed\n'
        'satdyn simulate constellation --satellite /sat4 --satellite /sat5 --duration 60 -o pair',
    )
    added.add_argument('file', metavar='FILE', help=_SCENARIO)
    added.add_argument(
        '--satellite',
        action='append',
        default=[],
        metavar='NAME',
        help='which satellite, if the scenario has several: /sat4/satdyn, or /sat4; '
        'several fly one after another, into the bags BAG/sat4, BAG/sat5 ...',
    )
    added.add_argument(
        '--duration',
        required=True,
        type=_seconds,
        metavar='S',
        help="simulate the ticks k with k / rate < S; or a time with its unit, '12 min'",
    )
    added.add_argument('--rate', type=_rate, metavar='HZ', help='in place of publish.rate')
    added.add_argument('--events', metavar='FILE', help='requests, torques and so on, a YAML file')
    added.add_argument(
        '--from',
        dest='origin',
        metavar='BAG|AEM',
        help='continue from a tick of this bag, or start from an attitude in a CCSDS message',
    )
    added.add_argument(
        '--at',
        type=_seconds,
        metavar='S|EPOCH',
        help="with --from: seconds from the bag's tick 0, or an epoch in the message, in UTC",
    )
    _add_out(added, 'BAG', 'the new bag, a directory')
    _add_controller(added)


def _add_replay(command):
    added = command(
        'replay',
        "publish a bag's topics again; needs ROS 2",
        'satdyn replay orbit\nsatdyn replay orbit --rate 10 --clock --wait',
    )
    _add_bag(added)
    added.add_argument(
        '--rate',
        type=float,
        default=1.0,
        metavar='X',
        help='speed relative to the recording; default: 1',
    )
    added.add_argument(
        '--loop',
        action='store_true',
        help='repeat until interrupted; stamps, and with --clock the time, jump back each time',
    )
    added.add_argument('--clock', action='store_true', help='publish /clock')
    added.add_argument(
        '--start-offset',
        type=_number_of_seconds,
        default=0.0,
        metavar='S',
        help='start this many seconds into the bag',
    )
    added.add_argument('--wait', action='store_true', help='wait for a subscriber')


_PANELS = """\
The panels of a bag; by default the first four, those of its own torques and of its sensors are
drawn:

  attitude       roll, pitch and yaw to LVLH, or to inertial axes without an orbit, and the angle
                 of the axis of least inertia to nadir
  rates          body rate in body axes, and its length
  torque         gravity-gradient torque in body axes
  drift          relative drift of the first integrals
  nadir          that angle, counted from the nearer end of the axis, and its parts along track and
                 to the orbit normal: in place of roll, pitch and yaw where pitch is near 90 deg
  rotor          speed of each rotor relative to the body
  thruster       when the valve of each thruster is open, drawn too where thruster.names has some
  polhode        body rate on the ellipsoids of energy and momentum
  phase          pitch and pitch rate in LVLH, with the separatrix of planar libration
  loops          flux density of hysteresis rods over the field along them, in their large loops
  NAME_torque    a torque of your own that acts, in body axes: the name of its topic; likewise
                 flexible and hysteresis, the modes of flexible parts and the flux in rods
  SENSOR         measured minus true values of a sensor, by its name, in its axes, with three sigma
  geodetic       the ground track on a map, drawn too where geodetic is published, with UTC below
                 the time; dashed in the umbra where environment.sun is given

Applied torques are shaded; a line marks a request or a reset, a dash at the upper edge a rotor
that meets its max_torque or max_speed.  Where a curve goes up and down within a few pixels, or the
body turns more than a quarter turn between two points, a band from least to most and the mean
replace the line."""


def _add_bag_commands(command):
    _add_bag(
        command(
            'verify',
            'run a bag again from its own scenario and events and compare every message',
            'satdyn verify orbit',
        )
    )
    added = command(
        'recover',
        'repair a bag that is damaged, or whose writer was killed',
        'satdyn recover orbit\nsatdyn recover orbit -o recovered',
    )
    _add_bag(added)
    added.add_argument(
        '-o', dest='out', metavar='BAG', help='write a new bag; default: repair in place'
    )
    _add_export(command)
    _add_plot(command)
    added = command(
        'report',
        'write a bag as one self-contained page',
        'satdyn report orbit -o orbit.html\n'
        "satdyn report day -o hour.html --begin '1 h' --end '2 h'",
    )
    _add_bag(added)
    _add_out(added, 'FILE', 'the .html file')
    _add_window(added)


def _add_export(command):
    added = command(
        'export',
        "the states of a bag as a table, or in other tools' formats",
        'satdyn export orbit -o orbit.csv --columns t_s roll_rad pitch_rad yaw_rad\n'
        'satdyn export orbit -o orbit.parquet --step 10\n'
        'satdyn export pair/sat4 -o gyro.csv --columns t_s gyro_measured_x_rad_s '
        'gyro_true_x_rad_s\n'
        'satdyn export orbit -o orbit.aem --rates\n'
        'satdyn export orbit -o orbit.oem --step 60\n'
        'satdyn export orbit -o orbit.czml --step 60\n'
        'satdyn export orbit -o orbit.bc --rates',
    )
    _add_bag(added)
    _add_out(
        added,
        'FILE',
        'tables: .csv, .npz, .parquet; CCSDS messages: .aem (attitude), .oem (orbit); '
        'STK attitude: .a; scene for CesiumJS: .czml; '
        'SPICE C-kernel: .bc, with .tsc and .tf',
    )
    added.add_argument(
        '--step', type=_seconds, metavar='S', help='one row per S seconds, a multiple of the tick'
    )
    added.add_argument(
        '--columns',
        nargs='+',
        default=(),
        metavar='NAME',
        help='the columns of the table; default: all but the truth of sensors, SENSOR_true_...',
    )
    added.add_argument(
        '--rates', action='store_true', help='write body rates to .aem, .a and .bc too'
    )
    added.add_argument(
        '--aem-version',
        choices=('1.0', '2.0'),
        help='version of an .aem; default: 2.0 with --rates, else 1.0, which has rates of '
        'Euler angles',
    )
    added.add_argument(
        '--frame', metavar='NAME', help='name for the inertial axes; default: EME2000'
    )
    added.add_argument(
        '--center', metavar='NAME', help='name for the attracting body; default: EARTH'
    )


def _add_plot(command):
    added = command(
        'plot',
        'draw a bag or a sweep',
        'satdyn plot orbit -o orbit.png\nsatdyn plot orbit -o phase.png --what phase\n'
        'satdyn plot orbit -o begin.png --what attitude rates --end 600\n'
        'satdyn plot pair/sat4 pair/sat5 -o pair.png --what attitude rates\n'
        'satdyn plot orbit -o angle.png --what attitude --against orbit.aem',
    )
    added.add_argument(
        'bag',
        nargs='+',
        metavar='BAG|SWEEP_DIR',
        help='a bag, several side by side, or the directory of a finished sweep',
    )
    _add_out(added, 'FILE', 'the image file')
    added.add_argument(
        '--what',
        nargs='+',
        default=(),
        metavar='PANEL',
        help='the panels to draw, see below; for a sweep, the columns',
    )
    added.add_argument(
        '--against',
        metavar='AEM',
        help='draw the angle to the attitudes in a CCSDS message too',
    )
    added.add_argument(
        '--unwrap', action='store_true', help='unwrap roll, pitch and yaw beyond a full turn'
    )
    _add_window(added)
    added.notes = _PANELS


_SWEEP_FORM = """\
SWEEP.yaml (docs/sweeps.md explains each key, and the columns of DIR/table.parquet):

  scenario: ../gravity_gradient_boom.yaml     # relative to SWEEP.yaml
  duration_s: 60530        # or 16.8 h
  interval_s: 60           # between samples; default 60
  runs: 100                # per combination of the grids; default 1
  seed: 1                  # for the draws; default 0
  samples: false           # keep attitudes and rates at the samples
  captured_axis: least     # or x, y, z
  bags: [0, 7]             # runs to record as bags too; default none
  controller: b_dot.py:BDot               # in each run; default none
  controller_parameters: {gain: 1.0e5}
  vary:
    body.inertia.x: {linspace: [1190, 1220, 4]}                     # a grid
    orbit.inclination: {values: [28.5 deg, 51.6 deg]}               # a grid
    initial.attitude: sphere                                        # drawn: any attitude
    initial.angular_velocity: {normal: [[0, 0, 0], [1e-3, 1e-3, 1e-3]]}    # drawn
    orbit.true_anomaly: {uniform: [0 deg, 360 deg]}                 # drawn

A run counts as captured when its axis of least inertia, or captured_axis, does not cross the local
horizontal during at least the last orbit: one of its ends stays toward nadir."""


def _add_watch(command):
    added = command(
        'watch',
        'a live page of a running node, or of a bag; a node needs ROS 2',
        'satdyn watch\nsatdyn watch --node /sat1/satdyn --port 8091\n'
        'satdyn watch orbit --port 8092\nsatdyn watch --host 0.0.0.0 --port 8093',
    )
    what = added.add_mutually_exclusive_group()
    what.add_argument('bag', nargs='?', metavar='BAG', help='a bag instead of a node')
    what.add_argument('--node', metavar='NAME', help='default: the first one found')
    added.add_argument(
        '--host',
        default='127.0.0.1',
        metavar='ADDRESS',
        help='address to listen on; on addresses other than loopback the page asks for the token '
        'that is printed; default: 127.0.0.1',
    )
    added.add_argument(
        '--port',
        type=_port,
        default=8090,
        metavar='PORT',
        help='0: any free port; default: 8090',
    )


def _port(text):
    port = int(text)
    if not 0 <= port < 65536:
        raise ValueError
    return port


_port.__name__ = 'port'


def _add_describe(command):
    added = command(
        'describe',
        'what theory says about a scenario: closed form, constants, equilibria, stability',
        'satdyn describe config/default.yaml\nsatdyn describe config/euler_poinsot.yaml --json\n'
        'satdyn describe constellation --satellite /sat4\n'
        'satdyn describe config/default.yaml --code\n'
        'satdyn describe config/cubesat_leo.yaml --urdf\n'
        'satdyn describe config/cubesat_sensors.yaml --sensors',
    )
    added.add_argument('file', metavar='FILE', help=_SCENARIO)
    _add_satellite(added)
    added.add_argument('--json', action='store_true', help='as JSON, with --sensors too')
    how = added.add_mutually_exclusive_group()
    how.add_argument(
        '--code',
        action='store_true',
        help='print the code of its step instead, with its equations of motion in it, as LLVM IR',
    )
    how.add_argument(
        '--urdf',
        action='store_true',
        help='print its body as a URDF instead: box, plates, wheels and sensors',
    )
    how.add_argument(
        '--sensors',
        action='store_true',
        help='instead its sensors, in SI and in the units of datasheets, with the Allan '
        'deviations of what they measure',
    )


def _add_constellation(command):
    added = command(
        'constellation',
        'write a parameter file with a satellite for each element set in a file',
        'satdyn constellation stations.json -o stations.yaml\n'
        "satdyn constellation stations.json --name '*zarya*' -o iss.yaml",
    )
    added.add_argument(
        'file',
        metavar='FILE',
        help='two or three lines each, or OMMs as JSON, CSV, XML or keywords',
    )
    added.add_argument(
        '--name',
        default='*',
        metavar='PATTERN',
        help='only those whose name matches; * is any text and ? a letter',
    )
    _add_out(added, 'FILE.yaml', 'the parameter file')


def _add_sweep(command):
    added = command(
        'sweep',
        'many runs of one scenario with quantities that vary',
        'satdyn sweep monte_carlo -o runs --workers 8\n'
        'satdyn plot runs -o runs.png --what captured lvlh_angle_max_rad\n'
        'satdyn sweep detumbling -o tumbles --controller examples/controllers/b_dot.py:BDot',
    )
    added.add_argument(
        'file', metavar='SWEEP.yaml', help='a sweep file, or the name of a shipped one'
    )
    added.notes = _SWEEP_FORM
    _add_satellite(added)
    _add_out(added, 'DIR', 'the directory for the results')
    added.add_argument(
        '--outcome',
        action='append',
        default=[],
        metavar='MODULE:FUNCTION',
        help='add a column: a function of the states (M, N) of M runs to numbers (M,); repeatable',
    )
    _add_controller(added)
    where = added.add_mutually_exclusive_group()
    where.add_argument(
        '--workers', type=int, metavar='N', help='number of processes; default: one per core'
    )
    where.add_argument('--dask', metavar='ADDR', help='scheduler of a dask cluster')


def _add_check(command):
    added = command(
        'check',
        'check this installation, or how accurate a run of a scenario is',
        'satdyn check\n'
        "satdyn check config/default.yaml --duration '1 d'\n"
        'satdyn check config/default.yaml --duration 86400 -o growth.png',
    )
    added.add_argument('file', nargs='?', metavar='FILE', help='a scenario')
    _add_satellite(added)
    added.add_argument('--duration', type=_seconds, metavar='S', help='how long to simulate it')
    added.add_argument('-o', dest='out', metavar='FILE.png', help='plot how the error grows')
    added.notes = """\
Without FILE: compare closed forms with their propagation, and verify a bag written here.  With
FILE: compare the scenario at its own motion.tolerance with a hundredth of it, and with the closed
form where there is one.  docs/accuracy.md explains the output."""


def _add_controller(command):
    command.add_argument(
        '--controller',
        metavar='MODULE:CLASS',
        help='a controller that closes the loop, or FILE.py:CLASS; its commands are in the bag',
    )
    command.add_argument(
        '--controller-parameter',
        action='append',
        default=[],
        metavar='NAME=VALUE',
        help='a keyword argument of the class; may be repeated',
    )


def _add_torque(command):
    command.add_argument(
        '--torque',
        action='append',
        default=[],
        metavar='MODULE:CLASS',
        help="a torque of one's own; may be repeated",
    )


def _add_satellite(command):
    command.add_argument(
        '--satellite',
        metavar='NAME',
        help='which satellite, if the scenario has several: /sat4/satdyn, or /sat4',
    )


def _add_bag(command):
    command.add_argument('bag', metavar='BAG', help='a bag: a directory or an .mcap file')


def _add_window(command):
    for name, where in (('begin', 'from'), ('end', 'up to')):
        command.add_argument(
            f'--{name}',
            type=_number_of_seconds,
            metavar='S',
            help=f'only {where} this time from tick 0 [s]',
        )


def _add_out(command, metavar, text):
    command.add_argument('-o', dest='out', required=True, metavar=metavar, help=text)

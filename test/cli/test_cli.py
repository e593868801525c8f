"""The command: exit codes, one sentence for what is wrong, help that begins with examples."""

import json
import math
import os
import pty
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from flights import sequence

from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.base.nanoseconds import DAY_NS, stamp_ns
from satdyn_ros.cli.main import main
from satdyn_ros.run.describe import describe
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.trace.load import Code

ROOT = Path(__file__).parents[2]
DEFAULT = str(ROOT / 'config/default.yaml')
COMMANDS = (
    'node',
    'request',
    'simulate',
    'replay',
    'verify',
    'recover',
    'export',
    'plot',
    'report',
    'watch',
    'describe',
    'sweep',
    'check',
)


def satdyn(*arguments, before=''):
    """Run the command in a process of its own, after a line of Python."""
    program = f'import sys\n{before}\nfrom satdyn_ros.cli.main import main\nsys.exit(main())'
    return subprocess.run(
        [sys.executable, '-c', program, *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of one second."""
    directory = tmp_path_factory.mktemp('cli') / 'bag'
    assert main(['simulate', DEFAULT, '--duration', '1', '-o', str(directory)]) == 0
    return directory


# -- help -----------------------------------------------------------------------------------------


@pytest.mark.parametrize('command', COMMANDS)
def test_help_begins_with_examples(command, capsys):
    """Every command's help begins with lines to copy, which the command's own parser takes."""
    with pytest.raises(SystemExit) as end:
        main([command, '--help'])
    assert end.value.code == 0
    first, example, *_ = capsys.readouterr().out.splitlines()
    assert first == 'examples:'
    assert example.strip().startswith(f'satdyn {command}')


def test_help_names_every_command():
    """The help of all lists the commands; nothing heavy is loaded for it."""
    result = satdyn(
        '--help', before='import atexit; atexit.register(print_loaded := lambda: None)'
    )
    assert result.returncode == 0
    assert all(f'  {command} ' in result.stdout for command in COMMANDS)


def test_help_loads_nothing_heavy():
    """Help does not wait for the libraries of physics, bags, ROS or pictures."""
    printing = (
        'import atexit; atexit.register(lambda: print(sorted(sys.modules), file=sys.stderr))'
    )
    loaded = satdyn('--help', before=printing).stderr
    heavy = ('numpy', 'scipy', 'numba', 'mcap', 'yaml', 'rclpy', 'rich', 'matplotlib', 'dask')
    assert [name for name in heavy if f"'{name}'" in loaded] == []


# -- what is wrong --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        ([], 'the following arguments are required: COMMAND'),
        (['fly'], "invalid choice: 'fly'"),
        (['simulate', DEFAULT], 'the following arguments are required: --duration, -o'),
        (['simulate', 'no.yaml', '--duration', '1', '-o', 'x'], 'the scenario no.yaml cannot be'),
        (['simulate', DEFAULT, '--duration', '-1', '-o', 'x'], 'the duration is -1'),
        (['simulate', DEFAULT, '--duration', '1', '--rate', '0', '-o', 'x'], 'publish.rate is 0'),
        (['simulate', DEFAULT, '--duration', '1', '--rate', 'x', '-o', 'x'], "value: 'x'"),
        (['simulate', DEFAULT, '--duration', '1', '--at', '3', '-o', 'x'], 'belong together'),
        (['simulate', DEFAULT, '--duration', '1', '--events', 'no', '-o', 'x'], 'the events no'),
        (
            [
                *('simulate', DEFAULT, '--duration', '1', '-o', 'x'),
                '--controller-parameter',
                'a=1',
            ],
            '--controller-parameter needs --controller',
        ),
        (['simulate', DEFAULT, '--duration', '1', '-o', DEFAULT], 'already exists'),
        (['simulate', DEFAULT, '--duration', '1', '-o', '/proc/x'], '/proc/x cannot be created'),
        (['simulate', 'constellation', '--duration', '1', '-o', 'x'], 'has 8 satellites; --sat'),
        (
            [
                *('simulate', 'constellation', '--duration', '1', '-o', 'x', '--from', 'b'),
                *('--at', '1', '--satellite', '/sat1', '--satellite', '/sat2'),
            ],
            '--from begins one run; --satellite names several',
        ),
        (['describe', 'constellation'], ': /sat1/satdyn, /sat2/satdyn, '),
        (
            ['describe', 'constellation', '--satellite', '/sat9'],
            'has no satellite /sat9; it has /',
        ),
        (['check', 'constellation', '--duration', '9'], 'has 8 satellites; --satellite must'),
        (['check', '--satellite', '/sat1'], 'and -o and --satellite need both'),
        (['verify', 'no'], 'no is not a bag'),
        (['verify', str(ROOT / 'config')], 'it has no .mcap file'),
        (['recover', 'no'], 'no is not a bag'),
        (['export', 'no', '-o', 'x.csv'], 'no is not a bag'),
        (['plot', 'no', '-o', 'x.png'], 'no is not a bag'),
        (['report', 'no', '-o', 'x.html'], 'no is not a bag'),
        (['sweep', 'no.yaml', '-o', 'x'], 'no.yaml cannot be read'),
        (['replay', 'no'], 'no is not a bag'),
        (['request'], 'give either KEY=VALUE'),
        (['request', '--reset', 'a=1'], 'give either KEY=VALUE'),
        (['request', 'initial.attitude'], 'must have the form KEY=VALUE'),
        (['request', 'initial.attitude=[0'], 'initial.attitude is not YAML'),
        (['request', 'initial.attitude={a: 1}'], 'it must be a number, a list or a text'),
        (['request', '--reset', '--step'], 'not allowed with argument'),
    ],
)
def test_wrong_input_is_one_sentence(arguments, sentence, capsys):
    """Exit code 2, and one line on stderr that says what is wrong."""
    if arguments[:1] == ['sweep']:
        pytest.importorskip('pyarrow')
    try:
        code: str | int | None = main(arguments)
    except SystemExit as end:
        code = end.code
    said = capsys.readouterr()
    assert code == 2
    assert said.out == ''
    assert said.err.startswith('satdyn')
    assert said.err.count('\n') == 1
    assert sentence in said.err


def test_a_sentence_has_a_limit(capsys):
    """A text that was given in the wrong position does not fill the screen."""
    assert main(['request', 5000 * 'x']) == 2
    assert len(capsys.readouterr().err) < 600


def test_a_bag_that_is_not_ours_has_no_run(tmp_path, capsys):
    """A file that is no MCAP at all is refused in one sentence."""
    (tmp_path / 'noise.mcap').write_bytes(os.urandom(100))
    assert main(['verify', str(tmp_path / 'noise.mcap')]) == 2
    assert 'is not an MCAP file' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('arguments', 'missing', 'sentence'),
    [
        (['watch'], 'aiohttp', 'this needs aiohttp: pip install aiohttp'),
        (['watch'], 'rclpy', 'this needs ROS 2'),
        (['node'], 'rclpy', 'this needs ROS 2: source an installation of it, or pip install'),
        (['request', '--reset'], 'rclpy', 'this needs ROS 2'),
        (['replay', 'BAG'], 'rclpy', 'this needs ROS 2'),
        (['plot', 'BAG', '-o', 'x.png'], 'matplotlib', 'pip install matplotlib'),
    ],
)
def test_what_is_not_installed_is_one_sentence(bag, arguments, missing, sentence):
    """A command whose extra is missing says what to install."""
    arguments = [bag if argument == 'BAG' else argument for argument in arguments]
    result = satdyn(*arguments, before=f'sys.modules[{missing!r}] = None')
    assert result.returncode == 2
    assert result.stderr.count('\n') == 1
    assert sentence in result.stderr


# -- what is right --------------------------------------------------------------------------------


def test_describe(capsys):
    """The text names the closed form and its constants; --json is the data of the function."""
    path = str(ROOT / 'config/euler_poinsot.yaml')
    assert main(['describe', path]) == 0
    text = capsys.readouterr().out
    assert text.startswith('free rotation (textbook')
    assert 'T1 = ' in text
    assert 'unstable: the energy has a saddle' in text
    assert 'stable rate; attitude drifts by 0.0432' in text
    assert main(['describe', path, '--json']) == 0
    assert json.loads(capsys.readouterr().out) == describe(Scenario.from_yaml(path))
    assert main(['describe', str(ROOT / 'config/elliptic_orbit.yaml')]) == 0
    assert 'about [0, 1, 0]: p = 2.82927, libration forced' in capsys.readouterr().out


def test_describe_in_si_and_in_common_units(capsys):
    """An angle and a rate have both, exactly pi/180 apart."""
    assert main(['describe', str(ROOT / 'config/euler_poinsot.yaml')]) == 0
    text = capsys.readouterr().out
    ((in_rad_s, in_deg_s),) = re.findall(r'Om_P = (\S+) rad/s = (\S+) deg/s', text)
    # Six digits each.
    assert float(in_deg_s) == pytest.approx(math.degrees(float(in_rad_s)), rel=2e-6)


def test_describe_of_sensors_is_their_datasheet(tmp_path, capsys):
    """
    What is typed of a gyro comes back, with its Allan deviations.

    IEEE Std 952: 0.15 deg/sqrt(h) is 0.15 * 60 deg/h over 1 s, and over 10000 s a hundredth of it,
    to which 1.2 deg/h/sqrt(h) adds 1.2 sqrt(10000 s / 3 h).
    """
    path = tmp_path / 'gyro.yaml'
    path.write_text(
        '/**: {ros__parameters: {publish: {rate: 10.0}, sensors: {names: [gyro, st], '
        'st: {type: star_tracker, cross_boresight: 7 arcsec}, gyro: {noise_density: '
        '0.15 deg/sqrt(h), bias_random_walk: 1.2 deg/h/sqrt(h), scale_factor: '
        "'[300, 300, 300] ppm', max_rate: 400 deg/s}}}}\n"
    )
    assert main(['describe', str(path), '--sensors']) == 0
    text = capsys.readouterr().out
    for line in ('noise_density .* 0.15 deg/sqrt', 'bias_random_walk .* 1.2 deg/h/sqrt', 'arcsec'):
        assert re.search(line, text)
    assert '[300, 300, 300] ppm' in text
    assert '400 deg/s' in text
    assert re.search('over 1 s .* 9[.0-9]* deg/h', text)
    (last,) = re.findall(r'over 10000 s .* (\S+) deg/h', text)
    walk = 1.2 * math.sqrt(10_000.0 / 3600.0 / 3.0)
    assert float(last) == pytest.approx(math.hypot(9.0 / 100.0, walk), rel=1e-5)
    assert main(['describe', str(path), '--sensors', '--json']) == 0
    sheet = json.loads(capsys.readouterr().out)
    noise = sheet['gyro']['given']['noise_density']
    assert noise.pop('value') == pytest.approx(math.radians(0.15) / 60.0, rel=4e-16)
    assert noise == {'unit': 'rad/s/sqrt(Hz)', 'trade': '0.15 deg/sqrt(h)'}
    assert [one['tau_s'] for one in sheet['gyro']['allan']] == [1.0, 100.0, 10_000.0]
    assert sheet['st']['given']['cross_boresight']['trade'] == '7 arcsec'
    assert main(['describe', str(path), '--code', '--json']) == 2
    assert capsys.readouterr().err.startswith('satdyn describe: --json is for')
    assert main(['describe', DEFAULT, '--sensors']) == 2
    assert capsys.readouterr().err.startswith('satdyn describe: sensors.names is empty')


def test_times_may_have_units(tmp_path, capsys):
    """0.005 min is 0.3 s, exactly 30 ticks; what is no time is refused with the units that fit."""
    path = str(tmp_path / 'bag')
    assert main(['simulate', DEFAULT, '--duration', '0.005 min', '-o', path]) == 0
    assert '30 ticks, 0.3 s' in capsys.readouterr().out
    table = str(tmp_path / 'rows.csv')
    assert main(['export', path, '-o', table, '--step', '100 ms']) == 0
    assert 'rows.csv: 3 rows' in capsys.readouterr().out
    onward = ['--from', path, '--at', '200 ms', '--duration', '1 s', '-o', str(tmp_path / 'next')]
    assert main(['simulate', DEFAULT, *onward]) == 0
    window = ['--begin', '0.1 s', '--end', '200 ms']
    assert main(['plot', path, '-o', str(tmp_path / 'x.png'), *window]) == 0
    slow = ['--duration', '2 s', '--rate', '0.01 kHz', '-o', str(tmp_path / 'slow')]
    assert main(['simulate', DEFAULT, *slow]) == 0
    assert '20 ticks, 2 s' in capsys.readouterr().out
    for text, sentence in (('5 m', 'units that fit: s, min, h and d'), ('[1, 2] s', 'above 0 s')):
        with suppress(SystemExit):
            assert main(['simulate', DEFAULT, '--duration', text, '-o', 'x']) == 2
        assert sentence in capsys.readouterr().err


def test_describe_with_code(tmp_path, capsys):
    """LLVM takes what is printed, of one motion; a closed form, without steps, says so."""
    assert main(['describe', DEFAULT, '--code']) == 0
    said = capsys.readouterr()
    assert 'define void @attempt(' in said.out
    assert '<8 x double>' not in said.out
    assert Code(said.out).address('attempt')
    path = tmp_path / 'free.yaml'
    path.write_text('/**: {ros__parameters: {orbit: {type: fixed}, motion: {method: exact}}}\n')
    assert main(['describe', str(path), '--code']) == 2
    said = capsys.readouterr()
    assert (said.out, said.err.count('\n')) == ('', 1)
    assert said.err.startswith('satdyn describe: the motion is the closed form ')


def test_describe_of_an_element_set_begins_now(tmp_path, capsys):
    """As a run without time.epoch does: its age is that of now, and its orbit is said."""
    pytest.importorskip('sgp4')
    lines = (
        "'1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927', "
        "'2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537'"
    )
    path = tmp_path / 'station.yaml'
    path.write_text(f'/**: {{ros__parameters: {{orbit: {{type: tle, tle: [{lines}]}}}}}}\n')
    before_ns = time.time_ns()
    assert main(['describe', str(path), '--json']) == 0
    said = capsys.readouterr()
    age_ns = json.loads(said.out)['orbit']['age_days'] * DAY_NS
    elements_ns = stamp_ns('2008-09-20T12:25:40.104192')
    # An age of years, in days of a double, is known to some microseconds.
    assert before_ns - 10**6 < elements_ns + age_ns < time.time_ns() + 10**6
    assert 'days from tick 0' in said.err
    assert main(['describe', str(path)]) == 0
    first, second, *_ = capsys.readouterr().out.splitlines()
    assert first.startswith('elements of 2008-09-20T12:25:40 by SGP4, ')
    assert second == (
        '  perigee 348.8 km, apogee 357.8 km, period 5495.74 s (91.6 min), inclination 51.6416 deg'
    )


def test_one_satellite_of_several(tmp_path, capsys):
    """It flies by its own section; that others are not used is said on stderr."""
    path, chosen = str(ROOT / 'config/constellation.yaml'), ['--satellite', '/sat4']
    assert main(['describe', path, *chosen, '--json']) == 0
    said = capsys.readouterr()
    scenario = Scenario.from_yaml(path, '/sat4')
    assert json.loads(said.out) == describe(scenario)
    assert said.err.startswith(
        f'satdyn describe: {path}: /sat4/satdyn does not use the sections /'
    )
    bag = tmp_path / 'bag'
    assert main(['simulate', path, *chosen, '--duration', '1', '-o', str(bag)]) == 0
    assert 'satdyn simulate: ' in capsys.readouterr().err
    assert RecordedRun(bag).scenario['orbit.true_anomaly'] == scenario['orbit.true_anomaly']


def test_several_satellites_of_one_file(tmp_path, capsys):
    """Each flies by its own section into a bag of its name; a name that is none stops them all."""
    command = ['simulate', 'constellation', '--duration', '1', '-o', str(tmp_path / 'pair')]
    pair = ['--satellite', '/sat4', '--satellite', '/sat5/satdyn']
    assert main([*command, *pair, '--satellite', '/sat9']) == 2
    assert 'has no satellite /sat9' in capsys.readouterr().err
    assert not (tmp_path / 'pair').exists()
    assert main([*command, *pair]) == 0
    for name in ('sat4', 'sat5'):
        scenario = RecordedRun(tmp_path / 'pair' / name).scenario
        expected = Scenario.from_yaml('constellation', f'/{name}')
        assert scenario['orbit.true_anomaly'] == expected['orbit.true_anomaly']
        assert scenario['rotor.mode'] == expected['rotor.mode']
    said = capsys.readouterr()
    reported = [line.split(': ')[0] for line in said.out.splitlines()]
    assert reported == [str(tmp_path / 'pair' / name) for name in ('sat4', 'sat5')]
    # What was asked for is not among what is not used, which one sentence lists.
    (unused,) = [line for line in said.err.splitlines() if 'not use' in line]
    others = ', '.join(f'/sat{k}/satdyn' for k in (1, 2, 3, 6, 7, 8))
    assert unused.endswith(f'/sat4/satdyn, /sat5/satdyn do not use the sections {others}')


def test_simulate_and_verify(bag, capsys):
    """A bag that was simulated verifies, and verify says how many messages are the same."""
    assert main(['verify', str(bag)]) == 0
    assert '600 messages, the same byte for byte' in capsys.readouterr().out


def test_verify_says_no(tmp_path, capsys):
    """A bag from which messages were cut away is answered with exit code 1."""
    directory = tmp_path / 'bag'
    command = ['simulate', DEFAULT, '--duration', '300', '--rate', '10', '-o', str(directory)]
    assert main(command) == 0
    file = directory / 'bag_0.mcap'
    file.write_bytes(file.read_bytes()[:-3000])
    assert main(['verify', str(directory)]) == 1
    assert 'satdyn recover completes it' in capsys.readouterr().out


@pytest.mark.long
def test_compiling_is_reported(tmp_path):
    """The first use of a closed form says why it takes seconds, the second prints nothing."""
    command = [sys.executable, '-m', 'satdyn_ros.cli.main', 'simulate', 'config/balli_grioli.yaml']
    environment = os.environ | {'NUMBA_CACHE_DIR': str(tmp_path / 'cache')}
    said = [
        subprocess.run(
            [*command, '--duration', '1', '-o', str(tmp_path / name)],
            cwd=ROOT,
            env=environment,
            stderr=subprocess.PIPE,
            text=True,
            check=True,
        ).stderr
        for name in ('first', 'second')
    ]
    assert said == ['compiling, for some ten seconds: the code is kept for the next start\n', '']


def test_the_rate_is_overridden(tmp_path):
    """--rate replaces publish.rate, also for the instants of events."""
    happening = tmp_path / 'events.yaml'
    happening.write_text('- {at_s: 0.5, topics: [imu]}\n')
    directory = tmp_path / 'bag'
    command = ['simulate', DEFAULT, '--duration', '1', '--rate', '10', '-o', str(directory)]
    assert main([*command, '--events', str(happening)]) == 0
    names = [name for name, _, _ in sequence(directory)]
    assert (names.count('/attitude'), names.count('/imu')) == (5, 10)


def test_from_a_bag(bag, tmp_path):
    """--from and --at begin with a bag's state and stamp."""
    onward = tmp_path / 'onward'
    command = ['simulate', DEFAULT, '--duration', '0.5', '--from', str(bag), '--at', '0.5']
    assert main([*command, '-o', str(onward)]) == 0
    first = {name: (log_time_ns, data) for name, log_time_ns, data in sequence(bag)[300:306]}
    begun = {name: (log_time_ns, data) for name, log_time_ns, data in sequence(onward)[:6]}
    assert begun['/attitude'] == first['/attitude']
    assert begun['/angular_velocity'] == first['/angular_velocity']


def test_from_an_attitude_message(bag, tmp_path, capsys):
    """--from FILE.aem and --at EPOCH begin with the attitude of a message; no row, no run."""
    message = tmp_path / 'bag.aem'
    assert main(['export', str(bag), '-o', str(message), '--rates', '--step', '0.5']) == 0
    assert capsys.readouterr().out == f'{message}: 2 rows\n'
    epoch = message.read_text().splitlines()[-2].split()[0]
    onward = tmp_path / 'onward'
    command = ['simulate', DEFAULT, '--duration', '0.5', '--from', str(message), '--at']
    assert main([*command, epoch, '-o', str(onward)]) == 0
    (_, first_ns, _), *_ = sequence(onward)
    assert first_ns == sequence(bag)[300][1]
    assert main([*command, '2020-01-01T00:00:00', '-o', str(tmp_path / 'never')]) == 2
    assert 'the nearest is ' in capsys.readouterr().err
    assert not (tmp_path / 'never').exists()


def test_from_a_message_of_another_suffix(tmp_path, capsys):
    """XML, as .xml, with the axes of the body along x, y and z; what is no message is said."""
    message = tmp_path / 'attitude.xml'
    message.write_text(
        '<aem id="CCSDS_AEM_VERS" version="2.0"><body><segment><metadata>\n'
        '<REF_FRAME_A>EME2000</REF_FRAME_A><REF_FRAME_B>SC_BODY_1</REF_FRAME_B>\n'
        '<TIME_SYSTEM>UTC</TIME_SYSTEM><ATTITUDE_TYPE>QUATERNION</ATTITUDE_TYPE></metadata>\n'
        '<data><attitudeState><quaternionEphemeris><EPOCH>2026-01-31T12:00:00</EPOCH><quaternion>'
        '<Q1>0</Q1><Q2>0</Q2><Q3>0</Q3><QC>1</QC></quaternion></quaternionEphemeris>'
        '</attitudeState></data></segment></body></aem>\n'
    )
    command = ['simulate', DEFAULT, '--duration', '0.1', '--at', '2026-01-31T12:00:00', '--from']
    onward = tmp_path / 'onward'
    assert main([*command, str(message), '-o', str(onward)]) == 0
    assert RecordedRun(onward).scenario['initial.attitude'] == (0.0, 0.0, 0.0, 1.0)
    message.write_text('no message')
    assert main([*command, str(message), '-o', str(tmp_path / 'never')]) == 2
    assert 'attitude.xml: this is not an Attitude Ephemeris Message' in capsys.readouterr().err


def test_ctrl_c_closes_the_bag(tmp_path):
    """Interrupted, a run ends quietly with a complete bag and exit code 130."""
    directory = tmp_path / 'bag'
    command = ['simulate', DEFAULT, '--duration', '1e8', '-o', str(directory)]
    process = subprocess.Popen(
        [sys.executable, '-m', 'satdyn_ros.cli.main', *command], cwd=ROOT, stderr=subprocess.PIPE
    )
    file = directory / 'bag_0.mcap'
    while not (file.exists() and file.stat().st_size > 100_000):
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (130, b'')
    assert (directory / 'metadata.yaml').exists()
    assert verify(directory).same_bytes


@pytest.mark.long
def test_a_bar_on_a_terminal_alone(tmp_path):
    """Progress with rate and time left is shown on a terminal; a pipe sees the last line only."""
    command = [
        sys.executable,
        '-m',
        'satdyn_ros.cli.main',
        'simulate',
        DEFAULT,
        '--duration',
        '20',
    ]
    piped = subprocess.run(
        [*command, '-o', str(tmp_path / 'piped')], cwd=ROOT, capture_output=True, text=True
    )
    assert piped.stderr == ''
    assert piped.stdout == f'{tmp_path}/piped: 2000 ticks, 20 s\n'
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [*command, '-o', str(tmp_path / 'shown')], cwd=ROOT, stderr=theirs, stdout=subprocess.PIPE
    )
    os.close(theirs)
    shown = b''
    try:
        while block := os.read(ours, 65536):
            shown += block
    except OSError:  # how a terminal ends on Linux
        pass
    os.close(ours)
    assert process.wait() == 0
    assert b'simulating' in shown
    assert b'ticks/s' in shown


def test_a_doubtful_scenario_flies_with_a_warning(tmp_path, capsys):
    """A rate that few satellites have is allowed, and doubted in one line on stderr."""
    file = tmp_path / 'fast.yaml'
    file.write_text(
        '/**: {ros__parameters: {initial: {angular_velocity: [20.0, 0.0, 0.0]}, '
        'publish: {rate: 1000.0}}}'
    )
    assert main(['simulate', str(file), '--duration', '0.01', '-o', str(tmp_path / 'bag')]) == 0
    said = capsys.readouterr()
    assert 'initial.angular_velocity' in said.err
    assert said.out == f'{tmp_path / "bag"}: 10 ticks, 0.01 s\n'


def test_an_event_after_the_end_is_named(tmp_path, capsys):
    """It does not act, also where the run goes on from a bag; one before the end does."""
    events = tmp_path / 'events.yaml'
    command = ['simulate', 'default', '--rate', '1', '--events', str(events)]
    events.write_text('[{at_s: 3, reset: true}, {at_s: 4, reset: true}]')
    bag, onward = str(tmp_path / 'bag'), str(tmp_path / 'onward')
    assert main([*command, '--duration', '4', '-o', bag]) == 0
    (line,) = (x for x in capsys.readouterr().err.splitlines() if 'compil' not in x)
    assert line.startswith('satdyn simulate: the Reset at 4 s (tick 4) does not act')
    events.write_text('[{at_s: 5, reset: true}, {at_s: 6, reset: true}]')
    command += ['--from', bag, '--at', '2']
    assert main([*command, '--duration', '4', '-o', onward]) == 0
    (line,) = (x for x in capsys.readouterr().err.splitlines() if 'compil' not in x)
    assert line.startswith('satdyn simulate: the Reset at 6 s (tick 6) does not act')

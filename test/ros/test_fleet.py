"""A fleet: several satellites of one file in one process."""

import signal
import subprocess
import sys

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import GetParameters
from ros.live import (
    ENVIRONMENT,
    EPOCH_NS,
    PATIENCE_S,
    Participant,
    expected,
    raw_stamp_ns,
    start,
)

from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.verify import verify
from satdyn_ros.rosbag2.reader import Bag
from satdyn_ros.run.scenario import Scenario

# A fleet of which one satellite ends by an error, some ticks after its tenth.
BROKEN = """
import sys
from satdyn_ros.ros import node, start

prepare = node.SatdynNode.prepare

def broken(self, samples):
    if self.get_namespace() == '/a' and samples.first_tick >= 10:
        raise RuntimeError('it broke')
    return prepare(self, samples)

node.SatdynNode.prepare = broken
sys.exit(start.main(['--params-file', 'fleet.yaml']))
"""
# The pieces of a file: what all have in common, and what each has of its own.
COMMON = f"""
/**:
  ros__parameters:
    time: {{epoch_ns: {EPOCH_NS}}}
    publish: {{rate: 20.0, topics: [attitude]}}
    record: {{enabled: true, directory: bags}}
"""
SECTION = '/{name}:\n  ros__parameters: {parameters}\n'


def write(directory, sections):
    own = (SECTION.format(name=name, parameters=own) for name, own in sections.items())
    (directory / 'fleet.yaml').write_text(COMMON + ''.join(own))


@pytest.fixture
def fleet(tmp_path):
    """Return a function that starts the satellites of a file, which end with the test."""
    running = []

    def begin(sections, *arguments):
        write(tmp_path, sections)
        running.append(start(['--params-file', 'fleet.yaml', *arguments], tmp_path))
        return running[-1]

    yield begin
    for process in running:
        if process.poll() is None:
            process.kill()
        process.communicate()


def test_every_satellite_of_a_file_flies(fleet, tmp_path):
    """Each on its own orbit from one tick 0 on, with its own frames, services, reports and bag."""
    process = fleet(
        {
            'sat1/satdyn': '{orbit.true_anomaly: 0.5}',
            'sat2/satdyn': '{orbit.true_anomaly: 1.5}',
            'mysat': '{orbit.true_anomaly: 2.5}',
        }
    )
    beside = [Participant(f'/sat{i}') for i in (1, 2)]
    try:
        heard = [participant.listen('attitude', raw=True) for participant in beside]
        reports: list[DiagnosticArray] = []
        beside[0].node.create_subscription(DiagnosticArray, '/diagnostics', reports.append, 10)
        for i, (participant, messages) in enumerate(zip(beside, heard, strict=True), 1):
            participant.hear(messages, 3)
            assert participant.get('frames.body') == f'sat{i}/base_link'
            scenario = Scenario.from_yaml(tmp_path / 'fleet.yaml', f'/sat{i}')
            # The ticks that came while this one waited for the first are among them.
            packed = expected(scenario, 'attitude', 20 * int(PATIENCE_S))
            assert all(packed[raw_stamp_ns(data)] == data for data in messages)
        assert beside[1].request({'initial.attitude': [0.0, 0.0, 0.0, 1.0]}) == (True, '')
        request = GetParameters.Request(names=['frames.body'])
        answer = beside[0].call(GetParameters, '/mysat/get_parameters', request)
        assert answer.values[0].string_value == 'base_link'

        def reported():
            return {s.name.split(': ')[0] for report in reports for s in report.status}

        beside[0].wait_until(
            lambda: reported() >= {'sat1/satdyn', 'sat2/satdyn', 'mysat'}, 'a report of each'
        )
    finally:
        for participant in beside:
            participant.close()
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    log = errors.splitlines()
    assert all(line.startswith('[INFO] ') for line in log), errors
    for folder, logger, anomaly in (
        ('sat1', 'sat1.satdyn', 0.5),
        ('sat2', 'sat2.satdyn', 1.5),
        ('mysat', 'mysat', 2.5),
    ):
        (bag,) = (tmp_path / 'bags' / folder).iterdir()
        assert verify(bag).same_bytes
        assert RecordedRun(bag).scenario['orbit.true_anomaly'] == anomaly
        assert sum(f'[{logger}]: publishing' in line for line in log) == 1
        assert sum(f'[{logger}.pacing]: lateness' in line for line in log) == 1
    assert len(list((tmp_path / 'bags').iterdir())) == 3


@pytest.mark.parametrize(
    ('namespace', 'arguments'),
    [
        ('/sat2', ['--satellite', '/sat2']),
        ('/sat2', ['--ros-args', '-r', '__ns:=/sat2']),
        ('/a/b', ['--section', '/sat2', '--ros-args', '-r', '__ns:=/a/b']),
    ],
    ids=['--satellite', '__ns', '--section'],
)
def test_a_satellite_that_is_named_flies_alone(fleet, tmp_path, namespace, arguments):
    """By its own section, with its frames, and its bag where those of one satellite go."""
    process = fleet(
        {
            'sat1/satdyn': '{publish.rate: 0}',
            'sat2/satdyn': '{orbit.true_anomaly: 1.5}',
        },
        *arguments,
    )
    beside = Participant(namespace)
    try:
        beside.hear(beside.listen('attitude'), 1)
        assert beside.get('orbit.true_anomaly') == 1.5
        assert beside.get('frames.body') == f'{namespace[1:]}/base_link'
    finally:
        beside.close()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    # Who gives one section has the others for other nodes.
    reported = '/sat2/satdyn does not use the section /sat1/satdyn' in errors
    assert reported == ('--section' not in arguments)
    (bag,) = (tmp_path / 'bags').glob('satdyn_*')
    assert verify(bag).same_bytes


def test_one_that_is_wrong_stops_all(fleet, tmp_path):
    """In one sentence that names it; nothing was published or recorded by then."""
    process = fleet({'a/satdyn': '{}', 'b/satdyn': '{publish.rate: -1}'})
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    sentence = errors.splitlines()[-1]
    assert sentence.startswith('satdyn node: /b/satdyn: publish.rate is -1; it must be a number')
    assert 'publishing' not in errors
    assert not (tmp_path / 'bags').exists()


def test_several_of_a_file_are_chosen(fleet):
    """By --satellite, repeated; a name that is none of the file's stops them all."""
    sections = {f'sat{i}/satdyn': '{}' for i in (1, 2, 3)}
    process = fleet(sections, '--satellite', '/sat1', '--satellite', '/sat4')
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    assert 'fleet.yaml has no satellite /sat4; it has /sat1/satdyn, /sat2/satdyn' in errors
    process = fleet(sections, '--satellite', '/sat1', '--satellite', '/sat3/satdyn')
    beside = [Participant(f'/sat{i}') for i in (1, 3)]
    try:
        for participant in beside:
            participant.hear(participant.listen('attitude'), 1)
        names = {name for _, name in beside[0].node.get_node_names_and_namespaces()}
    finally:
        for participant in beside:
            participant.close()
    assert {'/sat1', '/sat3'} <= names
    assert '/sat2' not in names


def test_one_that_fails_ends_alone(tmp_path):
    """It leaves the graph with its bag complete; the other flies on; the exit code says so."""
    write(tmp_path, {'a/satdyn': '{}', 'b/satdyn': '{}'})
    process = subprocess.Popen(
        [sys.executable, '-c', BROKEN],
        cwd=tmp_path,
        env=ENVIRONMENT,
        stderr=subprocess.PIPE,
        text=True,
    )
    beside = Participant('/b')
    try:
        heard = beside.listen('attitude', raw=True)
        # Ticks enough that the other has come to the one at which it breaks.
        beside.hear(heard, 30)

        def names():
            return beside.node.get_node_names_and_namespaces()

        beside.wait_until(lambda: ('satdyn', '/a') not in names(), 'the end of /a')
        beside.hear(heard, 5)
        assert beside.get('frames.body') == 'b/base_link'
    finally:
        beside.close()
        process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    assert '[a.satdyn]: the ticks have ended: it broke' in errors
    counts = {}
    for name in 'ab':
        (bag,) = (tmp_path / 'bags' / name).iterdir()
        assert verify(bag).same_bytes
        counts[name] = Bag(bag).messages(f'/{name}/attitude').log_times_ns.size
    assert 10 <= counts['a'] < counts['b']

"""The thread that records: what ends it is reported, and what can still be written is."""

import subprocess
import sys

import pytest
from commands import torque_command
from flights import GYROSTAT, sequence
from ros.live import ENVIRONMENT

from satdyn_ros.bag.verify import verify
from satdyn_ros.bag.write_run import Recording
from satdyn_ros.messages.packers import packer
from satdyn_ros.ros.recorder import Recorder
from satdyn_ros.run.events import Topics
from satdyn_ros.run.simulation import Simulation

SCENARIO = GYROSTAT.with_values({'publish.topics': ('attitude',)})


@pytest.fixture
def begin(tmp_path):
    """Return a function that opens a recorder, and the sentences that it reports."""
    reported: list[str] = []

    def open_recorder(scenario=SCENARIO):
        scenario = scenario.with_values({'record.directory': str(tmp_path)})
        recorder = Recorder(scenario, SCENARIO.topics, lambda name: f'/{name}', reported.append)
        return recorder, reported

    return open_recorder


def put(recorder, simulation, count):
    """Let ticks pass, and hand them over as the node does."""
    happened, samples = simulation.advance(count)
    rows = {name: packer(name, SCENARIO).pack(samples) for name in simulation.topics}
    recorder.put(happened, samples, rows, len(samples), simulation.snapshot_copy())


def test_topics_may_change_before_the_first_sample(begin):
    """The bag was opened with the topics of before: it takes those that come, and is true."""
    recorder, reported = begin()
    simulation = Simulation(
        SCENARIO, [Topics(0, ('imu', 'rotor')), torque_command(4, (0.1, 0.0, 0.0))]
    )
    for _ in range(3):
        put(recorder, simulation, 4)
    recorder.close()
    assert (recorder.failure, reported) == (None, [])
    assert {topic for topic, _, _ in sequence(recorder.directory)} == {'/imu', '/rotor', '/torque'}
    assert verify(recorder.directory).same_bytes


def test_any_error_ends_a_recording_in_the_open(begin, monkeypatch):
    """It is reported once, at once; the bag is completed with what was written before."""
    recorder, reported = begin()
    simulation = Simulation(SCENARIO)
    put(recorder, simulation, 5)
    write, broken = Recording.samples, []

    def samples(self, stamps_ns, rows, snapshot):
        if len(stamps_ns) == 7:
            broken.append(True)
            raise KeyError('imu')
        write(self, stamps_ns, rows, snapshot)

    monkeypatch.setattr(Recording, 'samples', samples)
    for count in (7, 3, 7):
        put(recorder, simulation, count)
    recorder.close()
    (sentence,) = reported
    assert recorder.failure == sentence
    assert sentence == f"the recording of {recorder.directory} has ended: KeyError('imu')"
    assert len(broken) == 1
    assert len(sequence(recorder.directory)) == recorder.message_count == 5
    assert verify(recorder.directory).is_true


def test_what_the_bag_holds_is_compared_with_what_was_given(begin, monkeypatch):
    """A recording that leaves out ticks in silence is found when it is closed."""
    recorder, reported = begin()
    write = Recording.samples

    def samples(self, stamps_ns, rows, snapshot):
        fewer = {name: table[1:] for name, table in rows.items()}
        write(self, stamps_ns[1:], fewer, lambda row: snapshot(row + 1))

    monkeypatch.setattr(Recording, 'samples', samples)
    put(recorder, Simulation(SCENARIO), 5)
    recorder.close()
    assert reported == [recorder.failure]
    assert recorder.failure == (
        f'{recorder.directory} holds 4 messages of attitude; 5 were to be recorded'
    )


def test_after_its_end_nothing_is_recorded(begin):
    """A tick that is published while the bag is being closed is in no account."""
    recorder, reported = begin()
    simulation = Simulation(SCENARIO)
    put(recorder, simulation, 5)
    recorder.close()
    put(recorder, simulation, 5)
    recorder.close()
    assert reported == []
    assert len(sequence(recorder.directory)) == 5


def test_a_node_without_mcap_says_that_recording_needs_it(tmp_path):
    """Asked to record from the start it ends with one sentence; it would fly without."""
    program = (
        "import sys; sys.modules['mcap'] = None; "
        'from satdyn_ros.ros.start import main; sys.exit(main(sys.argv[1:]))'
    )
    argv = [sys.executable, '-c', program, '--ros-args', '-p', 'record.enabled:=true']
    ended = subprocess.run(argv, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    sentence = 'satdyn node: recording needs mcap: pip install mcap\n'
    assert (ended.returncode, ended.stderr) == (2, sentence)
    assert list(tmp_path.iterdir()) == []

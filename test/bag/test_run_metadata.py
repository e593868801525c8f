"""What a bag says of its run is taken as data: a false record is refused in one sentence."""

import json

import flights
import pytest

from satdyn_ros.bag import run_metadata
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.rosbag2.errors import Damaged
from satdyn_ros.rosbag2.scan import scan
from satdyn_ros.run.events import RotorCommand, Torque
from satdyn_ros.run.simulation import Simulation


@pytest.mark.parametrize(
    'event', [event for event in flights.EVENTS if not isinstance(event, Torque | RotorCommand)]
)
def test_events_come_back(event):
    """Each kind as it was."""
    assert run_metadata.event_from_record(run_metadata.event_record(event)) == event


@pytest.mark.parametrize(
    'record',
    [
        {},
        {'event': 'from_yaml', 'path': '"/etc/passwd"'},
        {'event': 'np', 'tick': '1'},
        {'event': '__class__', 'tick': '1'},
        {'event': 'Reset'},
        {'event': 'Reset', 'tick': '-1'},
        {'event': 'Reset', 'tick': 'true'},
        {'event': 'Reset', 'tick': '1.5'},
        {'event': 'Reset', 'tick': '1', 'more': '2'},
        {'event': 'Reset', 'tick': '[' * 100_000},
        {'event': 'Reset', 'tick': '{'},
        {'event': 'Topics', 'tick': '1', 'names': '3'},
        {'event': 'Topics', 'tick': '1', 'names': '["no such topic"]'},
        {'event': 'Request', 'tick': '1', 'values': '[]'},
        {'event': 'Timeout', 'tick': '1', 'topic': '3'},
        {'event': 'RotorLimited', 'tick': '1', 'rotor': '"rotor"', 'limit': 'null'},
        {'event': 'Torque', 'tick': '1', 'torque_b': '"x"', 'until_tick': 'null'},
        {'event': 'RotorCommand', 'tick': '1', 'torques': '3', 'until_tick': 'null'},
    ],
)
def test_what_is_no_event_is_refused(record):
    """No name from a bag is looked up in the program."""
    with pytest.raises(ValueError):
        run_metadata.event_from_record(record)


SNAPSHOT = Simulation(flights.GYROSTAT).snapshot(0)


@pytest.mark.parametrize(
    'change',
    [
        {'tick': -1},
        {'tick': None},
        {'begin_tick': 7},
        {'begin_state': []},
        {'begin_state': SNAPSHOT['begin_state'] | {'q_ib': [1.0, 0.0]}},
        {'begin_state': SNAPSHOT['begin_state'] | {'omega_bi_b': 'abc'}},
        {'torque_b': [[0.0], [0.0], [0.0]]},
        {'torque_b': {'drag': [0.0, 0.0]}},
        {'dipole_b': [0.0, 0.0]},
        {'until': {'torque': 'soon'}},
        {'topics': ['none']},
    ],
)
def test_what_is_no_snapshot_is_refused(change):
    """Ticks, vectors and topics have their form."""
    good = run_metadata.to_record(SNAPSHOT)
    assert run_metadata.snapshot_from_record(good) == json.loads(json.dumps(SNAPSHOT))
    with pytest.raises(ValueError):
        run_metadata.snapshot_from_record(run_metadata.to_record(SNAPSHOT | change))


@pytest.mark.parametrize(
    ('key', 'text', 'sentence'),
    [
        ('scenario', '{"a', 'satdyn_ros/scenario: its scenario is not YAML'),
        ('topics', '{"attitude"', 'satdyn_ros/scenario: its values are not JSON'),
        ('topics', '{}', 'satdyn_ros/scenario: its topics have no rotor_command'),
        (
            'topics',
            '{"rotor_command": "/rotor_command", "torque/drag": "/torque/drag"}',
            'satdyn_ros/scenario: its inputs are not torque, as torque.names says',
        ),
        ('machine', None, 'satdyn_ros/scenario: it has no machine'),
    ],
)
def test_a_damaged_scenario_says_so(tmp_path, key, text, sentence):
    """In words that name the record, however sound the file."""
    path = flights.record(tmp_path / 'bag', ticks=5, events=()) / 'bag_0.mcap'

    def changed(record):
        mapping = dict(record.metadata)
        if key in mapping and text is None:
            del mapping[key]
        elif key in mapping:
            mapping[key] = text
        return mapping

    records = [found.item for found in scan(path)]
    forged = flights.rewritten(records, tmp_path / 'forged.mcap', changed)
    forged.finish()
    with pytest.raises(Damaged, match=sentence):
        RecordedRun(forged.path)

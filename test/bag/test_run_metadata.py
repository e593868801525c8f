"""What a bag says of its run is taken as data: a false record is refused in one sentence."""

import json

import flights
import pytest
import yaml
from run.test_one_mind import EPHEMERIS

from satdyn_ros.actuators import Command
from satdyn_ros.bag import run_metadata
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.base import ros_yaml
from satdyn_ros.rosbag2.errors import Damaged
from satdyn_ros.rosbag2.integrity import check
from satdyn_ros.rosbag2.recover import recover
from satdyn_ros.rosbag2.scan import scan
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation


@pytest.mark.parametrize(
    'event', [event for event in flights.EVENTS if not isinstance(event, Command)]
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
        {'event': 'Command', 'tick': '1', 'topic': '"torque"', 'value': '3', 'until_tick': 'null'},
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
        {'rotor_torque': [0.0, 0.0]},
        {'until': {'torque': 'soon'}},
        {'topics': ['none']},
    ],
)
def test_what_is_no_snapshot_is_refused(change):
    """Ticks, vectors and topics have their form."""
    good = run_metadata.to_record(SNAPSHOT)
    assert run_metadata.snapshot_from_record(good, flights.GYROSTAT) == json.loads(
        json.dumps(SNAPSHOT)
    )
    with pytest.raises(ValueError):
        run_metadata.snapshot_from_record(
            run_metadata.to_record(SNAPSHOT | change), flights.GYROSTAT
        )


def test_a_scenario_that_no_bag_holds_is_refused_before_it_begins(tmp_path, monkeypatch):
    """What could not be read back; no directory is made."""
    monkeypatch.setattr(ros_yaml, 'MOST_VALUES', 100)
    with pytest.raises(ValueError, match=r'^the scenario, written out for a bag, has more than'):
        flights.record(tmp_path / 'bag')
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    'comment',
    [
        pytest.param(
            'COMMENT caf\xe9 \u4e2d\u6587 \U0001f600\xe9\xe9\xe9\n', id='in any language'
        ),
        pytest.param('COMMENT\n', id='short lines'),
    ],
)
def test_a_long_ephemeris_comes_back_from_its_bag(tmp_path, comment):
    """To the last character, and to other readers: of 1.4 MB, in each of two files."""
    head, rest = EPHEMERIS.split('\n', 1)
    text = f'{head}\n{comment * (1_400_000 // len(comment.encode()))}{rest}'
    scenario = Scenario(
        {
            'orbit.type': 'oem',
            'orbit.file': text,
            'time.epoch': '2026-03-01T12:00:00',
            'publish.topics': ('attitude',),
            'publish.rate': 10.0,
            'record.max_duration_s': 0.5,
        }
    )
    path = flights.record(tmp_path / 'bag', scenario, 10, ())
    assert RecordedRun(path).scenario == scenario
    assert check(RecordedRun(path).bag) == []
    outer = yaml.load((path / 'metadata.yaml').read_text(encoding='utf-8'), yaml.CSafeLoader)
    said = outer['rosbag2_bagfile_information']
    assert [file['message_count'] for file in said['files']] == [6, 4]
    nested = yaml.load(said['custom_data']['scenario'], yaml.CSafeLoader)
    assert nested['/**']['ros__parameters']['orbit']['file'] == text
    (path / 'metadata.yaml').unlink()
    assert recover(path).files == ('metadata.yaml',)
    assert RecordedRun(path / 'bag_1.mcap').scenario == scenario


@pytest.mark.parametrize(
    ('key', 'text', 'sentence'),
    [
        ('scenario', '{"a', 'satdyn_ros/scenario: its scenario is not YAML'),
        ('topics', '{"attitude"', 'satdyn_ros/scenario: its values are not JSON'),
        ('topics', '{}', 'satdyn_ros/scenario: its topics have no rotor_command'),
        (
            'topics',
            '{"rotor_command": "/rotor_command", "torque/drag": "/torque/drag"}',
            'satdyn_ros/scenario: its topics have no torque',
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

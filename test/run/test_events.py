"""Events as data and as YAML."""

import pytest
from commands import dipole_command, motor_command, torque_command
from hypothesis import given
from hypothesis import strategies as st

from satdyn_ros.actuators.wheels import MOST_TORQUE
from satdyn_ros.run import events
from satdyn_ros.run.events import Request, Reset, Timeout, Topics
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.topics import STATE_TOPICS

MOTOR = Scenario(
    {
        'rotor.mode': 'motor',
        'rotor.inertia': 0.5,
        'publish.rate': 10.0,
        'magnetorquer.max_dipole': [0.2, 0.2, 0.2],
        'torque.timeout': 2.0,
    }
)
# With names torques superpose.
NAMED = MOTOR.with_values({'torque.names': ['control', 'drag']})


def test_the_documented_file_is_read():
    """The example at the head of the module means what its comment says, in order of time."""
    lines = [line.strip() for line in events.__doc__.splitlines() if line.startswith('    - ')]
    assert events.from_yaml_text('\n'.join(lines), MOTOR) == [
        torque_command(125, (0.0, 0.0, 0.01), until_tick=145),
        Request(200, {'initial.angular_velocity': [0.0, 0.0, 0.1]}),
        motor_command(400, {'rotor': 0.05}, until_tick=450),
        dipole_command(500, (0.0, 0.0, 0.1), until_tick=520),
        Topics(600, ('attitude',)),
        Reset(3000),
    ]


@pytest.mark.parametrize(
    ('text', 'tick'),
    [('at_s: 12.1', 121), ('at_s: 0.3', 3), ('at_s: 0.31', 4), ('at_s: 1e-3', 1), ('tick: 7', 7)],
)
def test_an_instant_is_taken_by_its_decimals(text, tick):
    """12.1 s at 10 Hz is tick 121, though the double 12.1 is above it; between ticks the next."""
    assert events.from_yaml_text(f'- {{{text}, reset: true}}', MOTOR) == [Reset(tick)]


@pytest.mark.parametrize(
    ('until', 'timeout_s', 'tick'),
    [
        ('', 2.0, 30),
        ('', 0.0, None),
        (', until_s: 1.5', 2.0, 15),
        (', until_tick: 99', 2.0, 99),
        (', until_tick: null', 2.0, None),
    ],
)
def test_a_torque_ends_as_in_the_node_unless_given(until, timeout_s, tick):
    """By default torque.timeout applies, 0: never; until_* overrides it, null: never."""
    scenario = MOTOR.with_values({'torque.timeout': timeout_s})
    text = f'- {{at_s: 1, torque: [1, 0, 0]{until}}}'
    assert events.from_yaml_text(text, scenario) == [torque_command(10, (1.0, 0.0, 0.0), tick)]


def test_a_torque_with_a_name_is_an_event_of_its_own():
    """Each of an entry ends as the entry says, and is written as it is read."""
    text = '- {at_s: 1, torque: {drag: [0, 0, 1], control: [1, 0, 0]}, until_s: 3}'
    read = events.from_yaml_text(text, NAMED)
    assert read == [
        torque_command(10, (0.0, 0.0, 1.0), 30, 'torque/drag'),
        torque_command(10, (1.0, 0.0, 0.0), 30, 'torque/control'),
    ]
    given = [*read, Timeout(30, 'torque/drag')]
    assert events.from_yaml_text(events.to_yaml(given), NAMED) == given


def test_an_entry_without_a_name_commands_nothing():
    """As an empty mapping does where rotors and thrusters are named."""
    assert events.from_yaml_text('- {at_s: 1, torque: {}}', NAMED) == []


def test_nested_keys_of_a_request_are_dotted():
    """A request is written as the scenario's file is."""
    text = '- tick: 3\n  request:\n    initial: {frame: inertial, angular_velocity: [0, 0, 1]}'
    assert events.from_yaml_text(text, MOTOR) == [
        Request(3, {'initial.frame': 'inertial', 'initial.angular_velocity': [0, 0, 1]})
    ]


@pytest.mark.parametrize(
    ('entry', 'lengths'),
    [
        ('at_s: 1, torque: [1, 0, 0], until_s: 1.03', ('0.03 s', '0.1 s')),
        ('at_s: 3, magnetorquer: [1, 0, 0], until_s: 3.25', ('0.25 s', '0.3 s')),
        ('at_s: 2.02, rotor_torque: 1.0, until_s: 2.18', ('0.16 s', '0.1 s')),
        ('at_s: 2.05, rotor_torque: 1.0, until_tick: 22', ('0.15 s', '0.1 s')),
        ('tick: 3, torque: [1, 0, 0], until_s: 0.35', ('0.05 s', '0.1 s')),
        ('at_s: 1, torque: [1, 0, 0], until_s: 1.3', None),
        ('at_s: 2.02, torque: [1, 0, 0], until_s: 2.12', None),
        ('at_s: 2.02, torque: [1, 0, 0], until_tick: null', None),
        ('at_s: 2.02, torque: [1, 0, 0]', None),
        ('at_s: 2.02, reset: true', None),
    ],
)
def test_a_pulse_of_another_length_than_its_times_say_is_reported(entry, lengths, caplog):
    """At 10 Hz, by hand: both ends move up to a tenth; a warning has both lengths, or is none."""
    events.from_yaml_text(f'- {{tick: 0, reset: true}}\n- {{{entry}}}', MOTOR)
    logged = [record.getMessage() for record in caplog.records]
    if lengths is None:
        assert logged == []
    else:
        asked, acts = lengths
        (sentence,) = logged
        assert sentence.startswith('events, event 2: from ')
        assert sentence.endswith(f' it is {asked}; in whole ticks of 10 Hz it acts for {acts}')


def test_a_timeout_between_ticks_is_reported_once(caplog):
    """Every torque without an end is held for it: 0.25 s are three ticks of 10 Hz."""
    scenario = MOTOR.with_values({'torque.timeout': 0.25})
    text = '- {at_s: 1, torque: [1, 0, 0]}\n- {at_s: 2, rotor_torque: 1.0}'
    events.from_yaml_text(text, scenario)
    (record,) = caplog.records
    assert record.getMessage() == (
        'events: torque.timeout is 0.25 s; in whole ticks of 10 Hz it acts for 0.3 s'
    )


numbers = st.floats(allow_nan=False, allow_infinity=False)
torques = st.floats(-MOST_TORQUE, MOST_TORQUE)
ticks = st.integers(0, 10**12)
later = st.none() | st.integers(10**12 + 1, 10**13)
some_event = st.one_of(
    st.builds(Request, ticks, st.fixed_dictionaries({'initial.attitude': st.lists(numbers)})),
    st.builds(Reset, ticks),
    st.builds(torque_command, ticks, st.tuples(numbers, numbers, numbers), later),
    st.builds(motor_command, ticks, st.dictionaries(st.just('rotor'), torques, min_size=1), later),
    st.builds(Timeout, ticks, st.sampled_from(['torque', 'rotor_torque'])),
    st.builds(Topics, ticks, st.lists(st.sampled_from(STATE_TOPICS), unique=True).map(tuple)),
)


@given(st.lists(some_event))
def test_what_is_written_is_read(happened):
    """Writing and reading keeps every event, to the last bit of its numbers."""
    ordered = sorted(happened, key=lambda event: event.tick)
    assert events.from_yaml_text(events.to_yaml(happened), MOTOR) == ordered


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('{tick: 3, reset: true}', 'events must be a list of events'),
        ('- reset', 'events, event 1: it is reset; it must be keys and values'),
        ('- {tick: 3}', 'event 1: it has none of torque'),
        ('- {reset: true}', 'event 1: it has none of at_s, tick; it must have exactly one'),
        ('- {at_s: 1, tick: 3, reset: true}', 'it has at_s and tick of'),
        ('- {tick: 3, reset: true, torque: [0, 0, 0]}', 'it has torque and reset of'),
        ('- {tick: 3, rest: true}', 'event 1: rest is not a key of an event'),
        ('- {tick: -1, reset: true}', 'tick is -1; it must be an integer at least 0'),
        ('- {at_s: .nan, reset: true}', 'at_s is nan; it must be a number at least 0 s'),
        ('- {tick: 1.5, reset: true}', 'tick is 1.5; it must be an integer'),
        ('- {tick: 3, reset: false}', 'reset is false; it must be true'),
        ('- {tick: 3, torque: [0, 0]}', 'torque is [0, 0]; it must be a list of 3 numbers N m'),
        ('- {tick: 3, torque: [0, 0, .inf]}', 'torque is [0, 0, inf]'),
        ('- {tick: 3, torque: [0, 0, 1], until_tick: 3}', 'is 3; it must be after tick, 3'),
        (
            '- {at_s: 2.02, torque: [0, 0, 1], until_s: 2.05}',
            'until_s is 2.05 and at_s 2.02: both fall on tick 21 (2.1 s)',
        ),
        ('- {at_s: 2.08, torque: [0, 0, 1], until_s: 2.03}', 'it must be after at_s, 2.08'),
        (f'- {{tick: {10**400}, reset: true}}', 'it must be an integer at least 0 and at most'),
        ('- {tick: 3, magnetorquer: [0, 0]}', 'magnetorquer is [0, 0]; it must be a list of 3 nu'),
        ('- {tick: 3, magnetorquer: [0, 0, .nan]}', 'magnetorquer is [0, 0, nan]'),
        ('- {tick: 3, reset: true, until_tick: 9}', 'reset does not end'),
        ('- {tick: 3, request: 5}', 'request is 5; it must be keys and values'),
        ('- {tick: 3, topics: [altitude]}', 'publish.topics is'),
        ('- {tick: 3, timeout: tork}', "timeout is 'tork'"),
        ('- {tick: 3', 'events is not YAML'),
        ('- {tick: 3, torque: [0, 0, 1], torque: [0, 0, 2]}', 'events gives torque twice, again'),
    ],
)
def test_refused(text, sentence):
    """What is wrong is stated in one sentence that names the event and what is allowed."""
    with pytest.raises(ValueError) as refusal:
        events.from_yaml_text(text, MOTOR)
    assert sentence in str(refusal.value)
    assert '\n' not in str(refusal.value)


@pytest.mark.parametrize(
    ('scenario', 'text', 'sentence'),
    [
        (
            NAMED,
            '[0, 0, 1]',
            'torque is [0, 0, 1]; with torque.names torques are given by name, such as {control:',
        ),
        (
            MOTOR,
            '{1: a, 2: b, 3: c}',
            "torque is {1: 'a', 2: 'b', 3: 'c'}; without torque.names it must be a list of 3 num",
        ),
        (NAMED, '{rw: [0, 0, 1]}', 'there is no torque rw; torque.names has control, drag'),
        (NAMED, '{drag: [0, 1]}', 'torque/drag is [0, 1]; it must be a list of 3 numbers N m'),
        (NAMED, '{drag: [0, 0, 1], drag: [0, 0, 2]}', 'events gives drag twice, again'),
    ],
)
def test_a_torque_is_given_by_name_where_there_are_names(scenario, text, sentence):
    """And only there; the sentence says what was given and what is allowed."""
    with pytest.raises(ValueError) as refusal:
        events.from_yaml_text(f'- {{tick: 3, torque: {text}}}', scenario)
    assert sentence in str(refusal.value)
    assert '\n' not in str(refusal.value)


def test_a_rotor_torque_takes_a_motor():
    """As the node, a file cannot drive a rotor that has no motor."""
    with pytest.raises(ValueError, match=r'rotor\.mode is none; it must be motor'):
        events.from_yaml_text('- {tick: 3, rotor_torque: 1.0}', Scenario())


def test_a_dipole_takes_a_magnetorquer():
    """What is given is written as it was read, and needs a torquer along one axis at least."""
    read = events.from_yaml_text('- {at_s: 1, magnetorquer: [0, 0.5, 0], until_s: 3}', MOTOR)
    assert read == [dipole_command(10, (0.0, 0.5, 0.0), 30)]
    given = [*read, Timeout(30, 'magnetorquer_command')]
    assert events.from_yaml_text(events.to_yaml(given), MOTOR) == given
    with pytest.raises(ValueError, match=r'magnetorquer\.max_dipole is 0 along all axes'):
        events.from_yaml_text('- {tick: 3, magnetorquer: [0, 0, 1]}', Scenario())


def test_a_file_that_is_not_there():
    """A missing file is refused by name."""
    with pytest.raises(ValueError, match=r'the events no/such\.yaml cannot be read'):
        events.from_yaml('no/such.yaml', MOTOR)

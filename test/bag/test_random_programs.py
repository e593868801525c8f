"""
Random programs without ROS: each bag proves itself, whatever happened at whichever tick.

A test has the seed of its program as its name, and prints the program where it fails.
"""

from collections import defaultdict
from fractions import Fraction

import pytest
import yaml
from flights import sequence
from programs import Draw

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.cli.main import main
from satdyn_ros.run.simulation import RunHalted
from satdyn_ros.run.topics import STATE_TOPICS

# Most have equations of their own, and so code of their own to make; the first five do not.  The
# sixth has modes and rods.
SHORT = [7, 10, 13, 14, 19, 17, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6))]
LONG = range(1000, 2000)
# Every so many programs other commands read the bag too, which takes longer than all the rest.
READ_BY_ALL = 5


def recorded(program, directory):
    """Run a program and return how many ticks it has: less than it asks for, if it halts."""
    done = [0]
    try:
        done += simulate(program.scenario, program.duration_s, directory, program.events)
    except RunHalted:
        return done[-1]
    assert done[-1] == program.ticks
    return done[-1]


def assert_verifies(bag, program):
    """Assert that a bag, and each of its files alone, holds what its events give."""
    for path in (bag, *sorted(bag.glob('*.mcap'))):
        verdict = verify(path)
        assert verdict.is_true, f'{path.name}: {verdict}\n{program}'
        assert verdict.same_bytes, f'{path.name}: {verdict}\n{program}'


def stamps_ns(program):
    """Return the stamps of all ticks, counted from the epoch: exact, rounded half to even."""
    return [round(Fraction(10**9) * k / program.scenario.rate) for k in range(program.ticks)]


def assert_complete(bag, program, ticks):
    """
    Assert that each topic has the stamps of all ticks at which it was published.

    The rerun cannot show it: it ends with the bag.  Of several changes of the topics at a tick
    the last one holds.
    """
    scenario = program.scenario
    changes = {program.tick(e): e['topics'] for e in program.entries if 'topics' in e}
    published = scenario['publish.topics']
    expected = defaultdict(list)
    for k, stamp_ns in enumerate(stamps_ns(program)[:ticks]):
        published = changes.get(k, published)
        for name in published:
            expected[f'/{name}'].append(scenario.epoch_ns + stamp_ns)
    found = defaultdict(list)
    for topic, stamp_ns, _ in sequence(bag):
        found[topic].append(stamp_ns)
    for topic in (f'/{name}' for name in STATE_TOPICS):
        assert found[topic] == expected[topic], f'{topic}\n{program}'
    given = [(program.tick(entry), entry) for entry in program.entries]
    for topic in scenario.inputs:
        at = [tick for tick, entry in given if topic in recorded_on(entry)]
        before = [tick for tick in at if tick < ticks]
        # What comes at the tick that a halted run does not reach may be reported.
        at_end = [tick for tick in at if tick == ticks]
        most = len(before) + (len(at_end) if ticks < program.ticks else 0)
        assert len(before) <= len(found[f'/{topic}']) <= most, f'{topic}\n{program}'


def recorded_on(entry):
    """Return the topics of the messages that an entry of an events file becomes."""
    match entry:
        case {'torque': dict() as named}:
            return [f'torque/{name}' for name in named]
        case {'torque': _}:
            return ['torque']
        case {'rotor_torque': _}:
            return ['rotor_command']
        case {'magnetorquer': _}:
            return ['magnetorquer_command']
        case {'thrusters': _}:
            return ['thruster_command']
    return []


def assert_refused(program, directory):
    """Assert that one event that is not allowed refuses the run before a bag is made."""
    with pytest.raises(ValueError, match='the event Request at tick'):
        recorded(program._replace(entries=[*program.entries, program.refused]), directory)
    assert not directory.exists(), f'{program}'


def assert_readable(bag, program, capsys):
    """Assert that the other commands open the bag, if any tick has a message in it."""
    capsys.readouterr()
    if not any(topic[1:] in STATE_TOPICS for topic, _, _ in sequence(bag)):
        return
    pytest.importorskip('matplotlib')
    for command, output in (('export', 'x.csv'), ('report', 'x.html'), ('plot', 'x.png')):
        code = main([command, str(bag), '-o', str(bag.parent / output)])
        assert code == 0, f'{command}: {capsys.readouterr().err}\n{program}'
        assert (bag.parent / output).stat().st_size, f'{command}\n{program}'


def assert_continues(bag, program, ticks):
    """
    Assert that the run goes on from a tick in its bag with the messages that the bag has.

    It begins at a tick with messages at which nothing is given, with the events after it.
    """
    taken = {program.tick(entry) for entry in program.entries}
    ticks_of = {program.scenario.epoch_ns + stamp: k for k, stamp in enumerate(stamps_ns(program))}
    free = sorted({ticks_of[stamp] for _, stamp, _ in sequence(bag)} - taken)
    if not free:
        return
    rate = program.scenario.rate
    first = free[len(free) // 2]
    later = [entry for entry in program.entries if program.tick(entry) > first]
    scenario, events, onward = (bag.parent / name for name in ('s.yaml', 'e.yaml', 'onward'))
    scenario.write_text(program.scenario.to_yaml())
    events.write_text(yaml.safe_dump(later))
    # Half a tick before it: the first tick at or after that is it.
    at_s = max(0.0, float((first - 0.5) / rate))
    origin = ['--from', str(bag), '--at', f'{at_s:.9f}']
    duration = ['--duration', str((program.ticks - first) / rate)]
    argv = ['simulate', str(scenario), *origin, *duration, '--events', str(events)]
    assert main([*argv, '-o', str(onward)]) == (ticks < program.ticks), f'{program}'
    begin_ns = program.scenario.epoch_ns + stamps_ns(program)[first]
    # Each file of a bag begins with the mountings.
    rest, going = (
        [message for message in sequence(path) if message[0] != '/tf_static']
        for path in (bag, onward)
    )
    # Compared first: pytest would print both, to the last byte.
    is_same = going == [message for message in rest if message[1] >= begin_ns]
    assert is_same, f'from tick {first}\n{program}'
    assert_verifies(onward, program)


def run(seed, tmp_path, capsys):
    """Run the program of a seed, and assert what holds of every bag."""
    program = Draw(seed).program()
    bag = tmp_path / 'bag'
    if program.refused:
        assert_refused(program, bag)
    ticks = recorded(program, bag)
    assert_verifies(bag, program)
    assert_complete(bag, program, ticks)
    if seed % READ_BY_ALL == 0:
        assert_readable(bag, program, capsys)


def go_on(seed, tmp_path):
    """Run the program of a seed, and go on from the middle of its bag."""
    program = Draw(seed).program()
    ticks = recorded(program, tmp_path / 'bag')
    assert_continues(tmp_path / 'bag', program, ticks)


@pytest.mark.parametrize('seed', SHORT)
def test_a_program_proves_itself(seed, tmp_path, capsys):
    """Its bag is complete and verifies with the same bytes, each file alone too."""
    run(seed, tmp_path, capsys)


@pytest.mark.torture
@pytest.mark.parametrize('seed', LONG)
def test_a_thousand_programs_prove_themselves(seed, tmp_path, capsys):
    """The same with other seeds."""
    run(seed, tmp_path, capsys)


@pytest.mark.parametrize('seed', SHORT)
def test_a_program_goes_on_from_its_bag(seed, tmp_path):
    """The unchanged file, begun within the bag, gives the messages that the bag has from there."""
    go_on(seed, tmp_path)


@pytest.mark.torture
@pytest.mark.parametrize('seed', LONG)
def test_a_thousand_programs_go_on_from_their_bags(seed, tmp_path):
    """The same with other seeds."""
    go_on(seed, tmp_path)

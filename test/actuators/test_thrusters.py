"""Thrusters: pulses between ticks, against reference cases and closed forms."""

import copy
import json
import math
import re

import numpy as np
import pytest
import yaml
from cases import REFERENCE

from satdyn_ros.bag.continuation import begun_in_bag
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.dynamics.motion import States
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel import rotation
from satdyn_ros.run import events
from satdyn_ros.run.events import Request, Reset
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation
from satdyn_ros.run.topics import TOPICS
from satdyn_ros.sweep.run import sweep
from satdyn_ros.torques.thrust import thrust_of

CASES = {
    case['name']: case for case in json.loads((REFERENCE / 'thrusters.json').read_text())['cases']
}
NAMES = {'orbit.type': 'fixed', 'initial.frame': 'inertial', 'thruster.names': ['a', 'b']}
# A tall satellite with two thrusters that turn it about x, either way.
PAIR = NAMES | {
    'body.inertia': [2.0, 1.5, 1.0],
    'initial.attitude': [0.0, 0.0, 0.0, 1.0],
    'publish.rate': 10.0,
    'publish.topics': ['attitude', 'angular_velocity', 'thruster_wrench', 'thruster'],
    'thruster.a.position': [0.0, 0.5, 0.0],
    'thruster.a.thrust': 3.0,
    'thruster.a.specific_impulse': 50.0,
    'thruster.b.position': [0.0, -0.5, 0.0],
    'thruster.b.thrust': 3.0,
    'thruster.b.time_constant': 0.05,
    'thruster.b.delay': 0.02,
}


def pulse(at_s, **on_times):
    return {'at_s': at_s, 'thrusters': on_times}


def commanded(scenario, *entries):
    """Return the events of entries as an events file has them."""
    return events.from_yaml_text(yaml.safe_dump([*entries]), scenario)


def flown(simulation, ticks):
    """Return the tables of a run up to a number of ticks, block by block."""
    blocks = []
    while simulation.next_tick < ticks:
        blocks.append(simulation.advance(ticks - simulation.next_tick)[1])
    return blocks


def state_at(blocks, tick):
    """Return the state at a tick, and thrust and propellant used by the thrusters' names."""
    for block in blocks:
        if 0 <= (row := tick - block.first_tick) < len(block):
            thrust, at_s = thrust_of(block.system), block.states.orbit_s[row : row + 1]
            tables = thrust.thrusts(at_s), thrust.propellant_used(at_s)
            return block.states[row], *(
                dict(zip(thrust.thrusters, t[0], strict=True)) for t in tables
            )
    raise AssertionError(f'there is no tick {tick}')


@pytest.mark.parametrize('name', CASES)
def test_reference_cases(name):
    """States, thrusts, propellant and torques of another program, within the case's bound."""
    case = CASES[name]
    scenario = Scenario.from_dict(case['scenario'])
    rate, bound = case['scenario']['publish']['rate'], case['bound']
    ticks = [round(truth['t'] * rate) for truth in case['states']]
    given = events.from_yaml_text(yaml.safe_dump(case['events']), scenario)
    blocks = flown(Simulation(scenario, given), max(ticks) + 1)
    most = max(np.abs(truth['omega']).max() for truth in case['states'])
    largest = max(np.abs(field['thruster_torque']).max() for field in case['fields'])
    for tick, truth, field in zip(ticks, case['states'], case['fields'], strict=True):
        state, thrust, used = state_at(blocks, tick)
        turned = rotation.multiply(rotation.conjugate(np.array(truth['q_xyzw'])), state.q_ib)
        assert 2.0 * np.linalg.norm(turned[:3]) <= bound
        np.testing.assert_allclose(state.omega_bi_b, truth['omega'], rtol=0.0, atol=bound * most)
        for each, force in truth['thrust'].items():
            assert thrust[each] == pytest.approx(force, rel=1e-12, abs=1e-15)
        for each, mass in truth['propellant'].items():
            assert used[each] == pytest.approx(mass, rel=1e-12)
        block = next(x for x in reversed(blocks) if x.first_tick <= tick)
        shown = TOPICS['thruster_wrench'].shows[0].of(block)[tick - block.first_tick]
        np.testing.assert_allclose(shown, field['thruster_torque'], rtol=0.0, atol=1e-12 * largest)


@pytest.mark.parametrize('name', CASES)
def test_in_lanes(name):
    """The motions of all commands of a case, side by side, have the bits that each has alone."""
    case = CASES[name]
    scenario = Scenario.from_dict(case['scenario'])
    given = events.from_yaml_text(yaml.safe_dump(case['events']), scenario)
    simulation, motions = Simulation(scenario, given), {}
    while simulation.next_tick <= given[-1].tick:
        simulation.advance(given[-1].tick + 1 - simulation.next_tick)
        motions[simulation.motion.start_s] = simulation.motion
    assert len(motions) > min(len(given), 2)
    t_s = np.linspace(0.0, 3.0, 31)
    alone = [
        Propagation(each.system, each.state, each.start_s).at(t_s) for each in motions.values()
    ]
    together = propagate_all(
        [Propagation(each.system, each.state, each.start_s) for each in motions.values()], t_s
    )
    for a, b in zip(alone, together, strict=True):
        assert isinstance(b, States)
        np.testing.assert_array_equal(b.omega_bi_b, a.omega_bi_b)
        np.testing.assert_array_equal(b.q_ib, a.q_ib)


def test_the_rate_of_ticks_does_not_matter():
    """The states at 0, 100, 200 and 300 s, where commands are given, are those of other rates."""
    found = []
    for rate in (1.0, 10.0, 29.97, 100.0):
        scenario = Scenario(
            PAIR | {'publish.rate': rate, 'initial.angular_velocity': [0.01, 0.02, 0.1]}
        )
        given = commanded(
            scenario, pulse(0, a=0.0301), pulse(100, a=0.007, b=0.4), pulse(200, a=1.5, b=0.003)
        )
        blocks = flown(Simulation(scenario, given), round(300 * rate) + 1)
        states = [state_at(blocks, round(t_s * rate))[0] for t_s in (0, 100, 200, 300)]
        found.append([(*state.q_ib, *state.omega_bi_b) for state in states])
    for other in found[1:]:
        # By sines of a turn of 30 rad, whose rounding is 4e-15.
        np.testing.assert_allclose(other, found[0], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize('rate', [1.0, 10.0, 29.97, 100.0])
@pytest.mark.parametrize(('name', 'sign'), [('a', 1.0), ('b', -1.0)])
def test_the_impulse_of_a_pulse_is_thrust_times_its_time(rate, name, sign):
    """F T r / I of rate, to 1e-12 of it, whatever the chamber and the ticks do to the thrust."""
    on_time = 0.0317
    scenario = Scenario(PAIR | {'publish.rate': rate})
    # After 40 time constants nothing of the decay is left.
    ticks = math.ceil(2.5 * rate) + 1
    blocks = flown(Simulation(scenario, commanded(scenario, pulse(0, **{name: on_time}))), ticks)
    rate_b = blocks[-1].states.omega_bi_b[-1]
    assert rate_b[0] == pytest.approx(sign * 3.0 * on_time * 0.5 / 2.0, rel=1e-12)
    _, thrust, used = state_at(blocks, ticks - 1)
    assert thrust[name] == pytest.approx(0.0, abs=1e-15)
    assert used['a'] == pytest.approx((name == 'a') * 3.0 * on_time / (9.80665 * 50.0), rel=1e-12)
    assert math.isnan(used['b'])


def test_a_step_commands_as_a_file_does():
    """A pulse goes on beyond its step; the other steps leave it alone."""
    scenario = Scenario(PAIR)
    stepping = Simulation(scenario)
    for tick in range(30):
        stepping.step(**({'thrusters': {'a': 0.25, 'b': '30 ms'}} if tick in (3, 20) else {}))
    blocks = flown(
        Simulation(
            scenario, commanded(scenario, pulse(0.3, a=0.25, b=0.03), pulse(2, a=0.25, b=0.03))
        ),
        31,
    )
    state, *_ = state_at(blocks, 30)
    np.testing.assert_array_equal(stepping.state.omega_bi_b, state.omega_bi_b)
    np.testing.assert_array_equal(stepping.state.q_ib, state.q_ib)


def test_copies_and_snapshots_in_the_middle_of_a_pulse():
    """Both go on with the same bits, by plain data through JSON too."""
    scenario = Scenario(PAIR)
    first = Simulation(scenario, commanded(scenario, pulse(0.5, a=2.0, b=1.05)))
    flown(first, 13)
    copied = copy.deepcopy(first)
    snapshot = json.loads(json.dumps(first.snapshot(first.tick)))
    again = Simulation.from_snapshot(scenario, snapshot)
    expected, *others = (state_at(flown(each, 40), 39) for each in (first, copied, again))
    for state, thrust, used in others:
        np.testing.assert_array_equal(state.omega_bi_b, expected[0].omega_bi_b)
        assert (thrust, str(used)) == (expected[1], str(expected[2]))


@pytest.mark.parametrize('event', [Reset(8), Request(8, {'initial.angular_velocity': [0, 0, 0]})])
def test_what_restarts_the_motion_closes_the_valves(event):
    """They stay closed, what was still to come does not, and the propellant used stays."""
    scenario = Scenario(PAIR | {'thruster.b.specific_impulse': 50.0, 'thruster.b.delay': 0.35})
    given = [*commanded(scenario, pulse(0.5, a=2.0, b=0.2)), event]
    blocks = flown(Simulation(scenario, given), 40)
    for tick in (8, 9, 20, 39):
        state, thrust, used = state_at(blocks, tick)
        assert thrust == {'a': 0.0, 'b': 0.0}
        # 0.3 s of a; the valve of b would have opened at 0.85 s.
        assert used['a'] == pytest.approx(3.0 * 0.3 / (9.80665 * 50.0), rel=1e-12)
        assert used['b'] == 0.0
        np.testing.assert_array_equal(state.omega_bi_b, 0.0)


def test_two_commands_at_one_tick():
    """The last one holds, for the thrusters that it names."""
    scenario = Scenario(PAIR)
    found = [
        state_at(flown(Simulation(scenario, commanded(scenario, *entries)), 40), 39)
        for entries in (
            [pulse(1, a=1.0, b=0.5), pulse(1, a=0.2)],
            [pulse(1, a=0.0, b=0.5), pulse(1, a=0.2)],
            [pulse(1, a=0.2, b=0.5)],
        )
    ]
    for state, _, used in found:
        np.testing.assert_allclose(state.omega_bi_b, found[-1][0].omega_bi_b, rtol=0.0, atol=1e-15)
        assert used['a'] == pytest.approx(3.0 * 0.2 / (9.80665 * 50.0), rel=1e-12)


def test_valves_that_switch_at_one_instant():
    """Instants that are one but for rounding make no step of their own that could fail."""
    scenario = Scenario(PAIR | {'thruster.b.time_constant': 0.0, 'thruster.b.delay': 0.1})
    given = commanded(scenario, pulse(0.1, b=0.1), pulse(0.2, a=0.1), pulse(86400, a=0.1, b=0.1))
    simulation = Simulation(scenario, given)
    blocks = flown(simulation, 864_010)
    assert simulation.halted is None
    # Equal and opposite.
    np.testing.assert_allclose(blocks[-1].states.omega_bi_b[-1], 0.0, atol=1e-10)


@pytest.mark.parametrize(
    ('given', 'sentence'),
    [
        ({'c': 0.1}, 'there is no thruster c; thruster.names has a, b'),
        ({'a': -0.1}, 'on-time of the thruster a is -0.1; it must be a number at least 0 and at '
         'most 86400 s'),
        ({'a': math.nan}, 'on-time of the thruster a is nan; it must be a number at least 0'),
        ({'a': math.inf}, 'on-time of the thruster a is inf; it must be a number at least 0'),
        ({'a': 86401}, 'on-time of the thruster a is 86401; it must be a number at least 0'),
        ({'a': 'long'}, "on-time of the thruster a is 'long'; it must be a number at least 0"),
        (0.1, 'thrusters is 0.1; on-times are given by name, such as {a: 0.03}'),
    ],
)  # fmt: skip
def test_a_command_that_is_not_allowed(given, sentence):
    """One sentence, the same from a file and from Python."""
    scenario = Scenario(PAIR)
    with pytest.raises(ValueError, match=re.escape(sentence)):
        Simulation(scenario).step(thrusters=given)
    with pytest.raises(ValueError, match='events, event 1: ' + re.escape(sentence)):
        commanded(scenario, {'at_s': 1, 'thrusters': given})


@pytest.mark.parametrize(
    ('values', 'sentence'),
    [
        ({'thruster.a.direction': [0, 0, 0]}, 'thruster.a.direction is [0.0, 0.0, 0.0]; it must '
         'not be zero'),
        ({'thruster.a.thrust': -1}, 'thruster.a.thrust is -1; it must be a number at least 0'),
        ({'thruster.a.time_constant': 1e-9}, 'thruster.a.time_constant is 1e-09; it must be 0 or '
         'at least 1e-06 s'),
        ({'thruster.c.thrust': 1.0}, 'thruster.c.thrust is given, but thruster.names has no c'),
        ({'thruster.a.force': 1.0}, 'thruster.a.force is not a parameter of a scenario; '
         'thruster.a has part, position, direction, thrust'),
        ({'thruster.names': ['1']}, "thruster.names has '1'; a name has letters"),
        ({'motion.method': 'exact'}, 'motion.method is exact, but there is no closed form'),
    ],
)  # fmt: skip
def test_a_scenario_that_is_not_allowed(values, sentence):
    """One sentence that names the key."""
    with pytest.raises(ValueError, match=re.escape(sentence)):
        Scenario(PAIR | values)


@pytest.mark.parametrize(
    'change', [{'since_s': math.nan}, {'switches_s': [2.0, 1.0]}, {'switches_s': [math.inf]}]
)
def test_what_is_no_firing_is_refused(change):
    """As a damaged bag may have it, in its snapshot."""
    scenario = Scenario(PAIR)
    snapshot = Simulation(scenario).snapshot(0)
    assert scenario.equipment.from_plain(snapshot) == scenario.equipment.none
    snapshot['firings']['a'] |= change
    with pytest.raises(ValueError, match='they must be finite, and the switches ascend'):
        scenario.equipment.from_plain(snapshot)


def test_a_thruster_without_thrust_is_warned_of():
    """It would do nothing in silence."""
    assert Scenario(PAIR).warnings == ()
    sentence = 'thruster.a.thrust is 0, so that it has no effect'
    assert Scenario(PAIR | {'thruster.a.thrust': 0.0}).warnings == (sentence,)


def test_many_fly_in_a_sweep(tmp_path):
    """Thrusts may be varied; no run is refused, and about a principal axis each keeps its rate."""
    parquet = pytest.importorskip('pyarrow.parquet')
    (tmp_path / 'pair.yaml').write_text(Scenario(PAIR).to_yaml())
    (tmp_path / 'sweep.yaml').write_text(
        'scenario: pair.yaml\nduration_s: 10\nvary:\n'
        '  initial.angular_velocity.x: {values: [0.01, 0.02]}\n'
        '  thruster.a.thrust: {values: [1.0, 2.0]}\n'
    )
    sweep(tmp_path / 'sweep.yaml', tmp_path / 'out')
    found = parquet.read_table(tmp_path / 'out' / 'table.parquet').to_pylist()
    assert [row['failure'] for row in found] == 4 * [None]
    rates = sorted(row['omega_bi_b'][0] for row in found)
    np.testing.assert_allclose(rates, [0.01, 0.01, 0.02, 0.02], rtol=1e-12)


def test_a_pulse_ends_by_itself():
    """An entry with an end is refused; without thrusters, so is every on-time."""
    scenario = Scenario(PAIR)
    with pytest.raises(ValueError, match='thrusters does not end; until_s and until_tick'):
        commanded(scenario, pulse(1, a=0.1) | {'until_s': 2})
    with pytest.raises(ValueError, match=r'thrusters is .*, and thruster\.names has none'):
        commanded(Scenario(), pulse(1, a=0.1))
    entries = commanded(scenario, pulse(1, a=0.1))
    assert events.from_yaml_text(events.to_yaml(entries), scenario) == entries


@pytest.mark.parametrize('time_constant', [0.05, 0.3, 2.0])
def test_the_balance_of_energy_knows_the_thrust_that_fades(tmp_path, time_constant):
    """
    A body almost at rest has, until the thrust is gone, no other size of energy than its work.

    Measured with the closed valves of the ticks before, its bag was refused.
    """
    scenario = Scenario(
        PAIR
        | {
            'initial.angular_velocity': [-4e-3, 5e-3, 1e-3],
            'thruster.a.time_constant': time_constant,
        }
    )
    given = commanded(scenario, pulse(0.1, a=0.0445))
    for _ in simulate(scenario, 4.0, tmp_path / 'bag', given):
        pass
    verdict = verify(tmp_path / 'bag')
    assert verdict.is_true, verdict
    assert verdict.drift['energy_balance'] > 0.0


@pytest.mark.parametrize('time_constant', [0.0, 0.3])
def test_a_pulse_goes_on_with_another_thrust(tmp_path, time_constant):
    """
    Where a run goes on from a bag with another engine, its impulse is that which turns the body.

    Without a time constant it is the old thrust up to then and the new one from then on.
    """
    scenario = Scenario(PAIR | {'thruster.a.time_constant': time_constant})
    begun = tmp_path / 'begun'
    for _ in simulate(scenario, 1.5, begun, commanded(scenario, pulse(0.5, a=3.0))):
        pass
    weaker = scenario.with_values({'thruster.a.thrust': 1.0, 'thruster.a.time_constant': 0.0})
    onward, begin = begun_in_bag(weaker, begun, 1.25)
    for _ in simulate(onward, 3.0, tmp_path / 'onward', begin=begin):
        pass
    assert verify(tmp_path / 'onward').same_bytes
    simulation = Simulation.from_snapshot(onward, begin)
    assert simulation.next_tick == 13
    state, thrust, used = state_at(flown(simulation, 43), 42)
    assert thrust['a'] == 0.0
    impulse = used['a'] * 9.80665 * 50.0
    assert state.omega_bi_b[0] == pytest.approx(0.5 * impulse / 2.0, rel=1e-12)
    if not time_constant:
        assert impulse == pytest.approx(3.0 * (1.3 - 0.5) + 1.0 * (3.5 - 1.3), rel=1e-12)

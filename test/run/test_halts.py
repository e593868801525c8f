"""Runs whose next tick cannot be reached: what is dropped, where they halt, what resumes them."""

from pathlib import Path

import numpy as np
import pytest
from commands import torque_command
from flights import sequence

from satdyn_ros import exact
from satdyn_ros.actuators import Command
from satdyn_ros.bag.read_run import RecordedRun
from satdyn_ros.bag.simulate import Untrue, simulate
from satdyn_ros.bag.verify import verify
from satdyn_ros.bag.write_run import Recording
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.report.history import history
from satdyn_ros.run.events import Event, Halt, Request, Reset, Timeout, TorquesDropped
from satdyn_ros.run.requests import try_out
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import RunHalted, Simulation
from satdyn_ros.run.ticks import LAST_STAMP_NS

CONFIG = Path(__file__).parents[2] / 'config'
SCENARIO = Scenario({'publish.topics': ['attitude'], 'time.epoch_ns': 10**18})
TOO_STRONG = (1e30, 0.0, 0.0)
WILD = {'initial.angular_velocity': [9e7, 0.0, 0.0]}


def run(scenario, events, ticks, block=50):
    """Return the events that happened and the attitudes (N, 4) at the ticks that were reached."""
    simulation, happened, attitudes = Simulation(scenario, events), [], []
    while simulation.next_tick < ticks and not simulation.halted:
        applied, samples = simulation.advance(min(block, ticks - simulation.next_tick))
        happened += applied
        attitudes.append(samples.states.q_ib)
    return happened, np.concatenate(attitudes)


@pytest.mark.parametrize('block', [1, 50])
def test_a_torque_that_leads_nowhere_is_dropped(block):
    """The motion goes on from the tick before as if the torque had never acted."""
    happened, flown = run(SCENARIO, [torque_command(5, TOO_STRONG, until_tick=20)], 40, block)
    assert happened == [torque_command(5, TOO_STRONG, until_tick=20), TorquesDropped(6)]
    # To the rounding of the restart.
    np.testing.assert_allclose(flown, run(SCENARIO, [], 40)[1], rtol=0.0, atol=1e-14)


def test_a_motion_that_cannot_go_on_halts_until_a_request():
    """All ticks before it come; none passes while it halts; torques meanwhile change nothing."""
    simulation = Simulation(SCENARIO, [Request(7, WILD)])
    assert len(simulation.advance(50)[1]) == 7
    applied, samples = simulation.advance(50)
    assert (applied, len(samples)) == ([Request(7, WILD)], 1)
    applied, samples = simulation.advance(50)
    assert (applied, len(samples)) == ([Halt(8)], 0)
    assert 'more than 1000000 steps' in (simulation.halted or '')
    simulation.schedule(torque_command(8, (1.0, 0.0, 0.0), until_tick=9))
    assert [len(simulation.advance(50)[1]) for _ in range(3)] == [0, 0, 0]
    calm = {'initial.angular_velocity': [0.0, 0.0, 0.0]}
    simulation.request(calm)
    applied, samples = simulation.advance(50)
    assert applied == [Request(8, calm)]
    assert (samples.first_tick, len(samples)) == (8, 1)
    assert samples.system.torque_b[0] == 1.0
    assert simulation.advance(5)[0] == [Timeout(9, 'torque')]


def test_a_request_that_loses_its_closed_form_halts_until_the_next(monkeypatch):
    """Checked at one tick, it may by rounding have none at the tick where it acts."""
    recognise = exact.recognise
    lost_s: float | None = 0.03

    def lose(system, state, start_s=0.0):
        return None if start_s == lost_s else recognise(system, state, start_s)

    monkeypatch.setattr(exact, 'recognise', lose)
    calm = {'initial.attitude': [0.0, 0.0, 0.0, 1.0]}
    simulation = Simulation(Scenario(calm | {'motion.method': 'exact'}), [Request(3, calm)])
    assert len(simulation.advance(50)[1]) == 3
    applied, samples = simulation.advance(50)
    assert (applied, len(samples)) == ([Request(3, calm), Halt(3)], 0)
    assert simulation.halted is not None
    assert simulation.halted.startswith('motion.method is exact, but there is no closed form: ')
    lost_s = None
    simulation.reset()
    applied, samples = simulation.advance(1)
    assert applied == [Reset(3)]
    assert (samples.first_tick, len(samples)) == (3, 1)


def test_given_halts_and_drops_happen_only_where_they_are_true():
    """An events file cannot make a run drop a torque or halt."""
    lies = [TorquesDropped(3), torque_command(5, (0.1, 0.0, 0.0)), TorquesDropped(6), Halt(7)]
    happened, rates = run(SCENARIO, lies, 30)
    assert happened == [torque_command(5, (0.1, 0.0, 0.0))]
    np.testing.assert_array_equal(rates, run(SCENARIO, lies[1:2], 30)[1])
    calm = Request(9, {'initial.angular_velocity': [0.0, 0.0, 0.0]})
    truth = [torque_command(5, TOO_STRONG), TorquesDropped(6), Request(8, WILD), Halt(9), calm]
    assert run(SCENARIO, truth, 30)[0] == truth


def test_a_run_goes_on_from_a_snapshot_wherever_it_is_taken():
    """More steps than a tick may take lie between the motion's start and a snapshot."""
    spinning = SCENARIO.with_values({'initial.angular_velocity': [0.0, 3e5, 1e5]})
    simulation = Simulation(spinning)
    # Some ten thousand steps a tick.
    _, samples = simulation.advance(200)
    assert isinstance(simulation.motion, Propagation)
    assert simulation.motion.steps > 10**6
    again = Simulation.from_snapshot(spinning, simulation.snapshot(198))
    _, later = again.advance(2)
    np.testing.assert_array_equal(later.states.q_ib, samples.states.q_ib[198:])


def test_stamps_end_where_those_of_ros_do():
    """The run halts at the last stamp, and no request resumes it."""
    late = SCENARIO.with_values({'time.epoch_ns': LAST_STAMP_NS - 5 * 10**7})
    simulation = Simulation(late)
    _, samples = simulation.advance(50)
    assert int(samples.stamps_ns[-1]) == LAST_STAMP_NS
    assert len(samples) == 6
    assert simulation.advance(50)[0] == [Halt(6)]
    assert simulation.halted == 'the next tick comes after the last stamp of ROS, 2147483647 s'
    with pytest.raises(ValueError, match='last stamp of ROS'):
        try_out(late, 6)
    simulation.reset()
    assert simulation.advance(50)[0] == [Reset(6), Halt(6)]


@pytest.mark.parametrize(
    'values',
    [
        {'orbit.type': 'fixed', 'orbit.gradient': 1e30},
        {'orbit.type': 'fixed', 'body.weight_moment': [0.0, 1e200, 0.0]},
        {'rotor.mode': 'constant_momentum', 'rotor.momentum': 1e15},
        {'body.inertia': [1e-320, 1e-320, 1e-320]},
    ],
)
def test_a_start_that_begins_no_motion_is_refused(values, tmp_path):
    """In one sentence, before a bag is made."""
    with pytest.raises(ValueError, match='no motion can start from these values: the prop'):
        list(simulate(Scenario(values), 10, tmp_path / 'bag'))
    assert not (tmp_path / 'bag').exists()


@pytest.mark.parametrize('rest', [(), (torque_command(10, (0.0, 0.0, 0.0)),), (Reset(10),)])
def test_a_torque_dropped_where_something_ends_is_reported_once(rest, tmp_path):
    """It times out at the tick that it does not reach; whatever acts there, the bag is true."""
    cubesat = Scenario.from_yaml(CONFIG / 'cubesat.yaml').with_values({'publish.rate': 1.0})
    events = [torque_command(9, (1e6, 0.0, 0.0), until_tick=10), *rest]
    for _ in simulate(cubesat, 15, tmp_path / 'bag', events):
        pass
    assert RecordedRun(tmp_path / 'bag').events == [events[0], TorquesDropped(10), *rest]
    assert verify(tmp_path / 'bag').same_bytes


def test_what_came_at_the_tick_of_a_halt_is_shown(tmp_path):
    """The bag is true, and its states are those of the ticks before."""
    wild, torque = Request(7, WILD), torque_command(8, (1.0, 0.0, 0.0))
    with pytest.raises(RunHalted, match='has 8 ticks'):
        list(simulate(SCENARIO, 0.2, tmp_path / 'bag', [wild, torque]))
    assert RecordedRun(tmp_path / 'bag').events == [wild, Halt(8), torque]
    assert verify(tmp_path / 'bag').same_bytes
    assert history(tmp_path / 'bag').ticks == 8


def test_what_is_announced_and_does_not_follow_is_reported(tmp_path):
    """The run of an events file is complete, and its timeouts and halts are compared with it."""
    truth: list[Event] = [torque_command(5, (0.1, 0.0, 0.0), until_tick=9), Timeout(9, 'torque')]
    list(simulate(SCENARIO, 0.2, tmp_path / 'true', truth))
    lie = [*truth, Timeout(7, 'torque'), Halt(12)]
    with pytest.raises(Untrue, match='the event Timeout at tick 7 did not happen'):
        list(simulate(SCENARIO, 0.2, tmp_path / 'untrue', lie))
    assert sequence(tmp_path / 'untrue') == sequence(tmp_path / 'true')


@pytest.mark.long
def test_bags_of_drops_and_halts_prove_themselves(tmp_path):
    """The bag ends where the run halts, has what happened, and is run again to the byte."""
    events: list[Event] = [
        torque_command(5, TOO_STRONG),
        torque_command(20, (0.1, 0.0, 0.0)),
        Request(30, WILD),
    ]
    with pytest.raises(RunHalted, match=r'the propagation came to a halt at .* has 31 ticks'):
        list(simulate(SCENARIO, 10, tmp_path / 'bag', events))
    recorded = RecordedRun(tmp_path / 'bag').events
    # After its timeout a torque has ended, the dropped one has none.
    assert [type(event) for event in recorded] == [
        Command,
        TorquesDropped,
        Command,
        Request,
        TorquesDropped,
        Halt,
    ]
    verdict = verify(tmp_path / 'bag')
    assert verdict.is_true, verdict
    assert verdict.message_count == 31 + 2
    assert verdict.same_bytes


def test_a_bag_that_ends_ahead_of_its_first_sample_is_true(tmp_path):
    """Recording began and ended between an input and its tick: there is nothing to hold it to."""
    recording = Recording(tmp_path / 'bag', SCENARIO, SCENARIO.topics)
    recording.event(torque_command(7, (0.1, 0.0, 0.0)), 10**18 + 7 * 10**7)
    recording.close()
    verdict = verify(tmp_path / 'bag')
    assert verdict.is_true, verdict
    assert verdict.message_count == 1

"""A loop closed inside a run: what a controller sees, when its commands act, how it ends."""

import copy
import pickle
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from satdyn_ros.actuators import Command
from satdyn_ros.run.controlled import ControlledSimulation
from satdyn_ros.run.controllers import ControllerFailed, Seen, named
from satdyn_ros.run.events import Event, Request, Timeout
from satdyn_ros.run.sample import Measurement
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

SCENARIO = Scenario(
    {
        'publish.rate': 10.0,
        'torque.timeout': 0.5,
        'initial.angular_velocity': [0.01, 0.02, 0.03],
        'sensors.names': ['gyro'],
        'sensors.gyro.divisor': 10,
        'sensors.seed': 3,
    }
)


class Counter:
    """Commands how often it was asked, about x; every two seconds."""

    period_s: float | None = 2.0
    needs_truth = False

    def __init__(self):
        self.seen, self.resets = [], []

    def reset(self, scenario, seed):
        self.resets.append((scenario['initial.angular_velocity'], seed))

    def command(self, sample):
        self.seen.append((sample.tick, *sample.measured))
        return {'torque_b': (len(self.seen), 0.0, 0.0)}


def controlled(controller: Any, events: Iterable[Event] = ()) -> Any:
    return ControlledSimulation(SCENARIO, events, controller=controller)


def flown(simulation, ticks):
    """Return the events and the rates of so many ticks."""
    happened, rates = [], []
    while simulation.next_tick < ticks:
        events, samples = simulation.advance(ticks - simulation.next_tick)
        happened += events
        rates += [*samples.states.omega_bi_b]
    return happened, np.array(rates)


def test_a_command_holds_until_the_next_whatever_the_timeout():
    """At ticks that are multiples of its period; the motion is that of the same events."""
    controller = Counter()
    happened, rates = flown(controlled(controller), 50)
    assert happened == [
        Command(0, 'torque', (1.0, 0.0, 0.0)),
        Command(20, 'torque', (2.0, 0.0, 0.0)),
        Command(40, 'torque', (3.0, 0.0, 0.0)),
    ]
    assert controller.seen == [(0, 'gyro'), (20, 'gyro'), (40, 'gyro')]
    np.testing.assert_array_equal(rates, flown(Simulation(SCENARIO, happened), 50)[1])


def test_it_takes_over_from_an_event_of_its_tick():
    """What an events file lets end at its time then no longer ends."""
    event = Command(20, 'torque', (2.0, 0.0, 0.0), until_tick=25)
    happened, _ = flown(controlled(Counter(), [event]), 40)
    assert happened[1:] == [event, Command(20, 'torque', (2.0, 0.0, 0.0))]
    assert not any(isinstance(event, Timeout) for event in happened)


def test_it_begins_anew_at_each_request_and_reset():
    """With the initial conditions then in force, ahead of its command at that tick."""
    controller = Counter()
    request = Request(20, {'initial.angular_velocity': [0.0, 0.0, 0.1]})
    simulation = controlled(controller, [request])
    flown(simulation, 23)
    simulation.reset()
    flown(simulation, 30)
    assert controller.resets[0] == ((0.01, 0.02, 0.03), 3)
    assert controller.resets[1:] == 2 * [((0.0, 0.0, 0.1), 3)]


def test_a_copy_has_a_controller_of_its_own():
    """Both go on alike, each with its own memory."""
    simulation = controlled(Counter())
    flown(simulation, 25)
    other = copy.deepcopy(simulation)
    (mine, a), (theirs, b) = flown(simulation, 45), flown(other, 45)
    assert mine == theirs == [Command(40, 'torque', (3.0, 0.0, 0.0))]
    np.testing.assert_array_equal(a, b)
    assert [len(each.controller.seen) for each in (simulation, other)] == [3, 3]


@pytest.mark.parametrize('tick', [20, 23])
def test_rewinding_asks_it_anew(tick):
    """It stands then where it stood before that tick, and commands the same."""
    simulation = controlled(Counter())
    flown(simulation, 20)
    first = simulation.advance(20)
    simulation.rewind(tick)
    rest = flown(simulation, 40)
    assert rest[0] == (first[0] if tick == 20 else [])
    np.testing.assert_array_equal(rest[1], first[1].states.omega_bi_b[tick - 20 :])
    assert [tick for tick, *_ in simulation.controller.seen] == [0, 20]


def test_one_that_comes_later_stays_when_the_run_goes_back():
    """Even to a tick before it came."""
    simulation = ControlledSimulation(SCENARIO)
    simulation.advance(5)
    simulation.control_by(Counter())
    simulation.rewind(0)
    assert simulation.advance(1)[0] == [Command(0, 'torque', (1.0, 0.0, 0.0))]


def test_without_truth_a_sample_has_what_is_known_on_board():
    """Sensors at the ticks where they publish, with their stamps; the rest is refused by name."""

    class Looks(Counter):
        period_s = None

        def command(self, sample):
            self.seen.append(sample)
            return {}

    controller = Looks()
    flown(controlled(controller), 12)
    assert all(isinstance(sample, Seen) for sample in controller.seen)
    measured = {s.tick: s.measured['gyro'].stamp_ns for s in controller.seen if s.measured}
    assert measured == {0: 0, 10: 10**9}
    last = controller.seen[-1]
    assert (last.t_s, last.stamp_ns, last.r_i.shape, last.v_i.shape) == (
        1.1,
        11 * 10**8,
        (3,),
        (3,),
    )
    with pytest.raises(
        AttributeError, match='omega_bi_b is not known on board; a class with needs_truth'
    ):
        _ = last.omega_bi_b


def test_a_measurement_keeps_its_stamp():
    """In copies, and in another process."""
    found = Measurement.of(np.array([1.0, 2.0]), 5)
    for each in (found.copy(), copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert (each.tolist(), each.stamp_ns) == ([1.0, 2.0], 5)


def test_one_that_fails_ends_the_run_in_a_sentence():
    """With its file and line; so does a command that is not allowed, with what is."""

    class Fails(Counter):
        def command(self, sample):
            return {'torque_b': (0.0, 0.0, 1.0 / (20 - sample.tick))}

    class Wrong(Counter):
        def command(self, sample):
            return {'dipole_b': (0.0, 0.0, 1.0)}

    event = Command(20, 'torque', (0.0, 1.0, 0.0), until_tick=25)
    simulation = controlled(Fails(), [event])
    with pytest.raises(ControllerFailed) as failed:
        flown(simulation, 40)
    where = rf'in {__file__}, line \d+: ZeroDivisionError: .*division by zero$'
    assert failed.match(rf'^the controller .*test_controlled:.*Fails failed at 2 s {where}')
    # What acts at that tick does so if the run goes on without it.
    simulation.controller = None
    assert simulation.advance(1)[0] == [event]
    with pytest.raises(ControllerFailed, match=r'magnetorquer\.max_dipole is 0 along all axes'):
        flown(controlled(Wrong()), 1)


@pytest.mark.parametrize('period_s', [0.25, 0.0, -1.0, float('nan'), 'often'])
def test_a_period_that_is_no_whole_number_of_ticks_is_refused(period_s):
    """Before anything moves."""
    controller = Counter()
    controller.period_s = period_s
    with pytest.raises(ValueError, match=r'it must be a multiple of the 0\.1 s between ticks'):
        controlled(controller)


GIVEN = """
class Given:
    def __init__(self, **parameters):
        self.parameters = parameters

    def command(self, sample):
        return {}
"""


def test_parameters_are_read_as_those_of_ros(tmp_path):
    """rcl, and JSON, by which a sweep hands them on, write 1e-05, which YAML takes for a text."""
    path = tmp_path / 'given.py'
    path.write_text(GIVEN)
    made: Any = named(f'{path}:Given', ['gain=1e-05', 'axes=[1e-3, 2, -.5]', 'name=x', 'on=true'])
    assert made.parameters == {
        'gain': 1e-5,
        'axes': [1e-3, 2, -0.5],
        'name': 'x',
        'on': True,
    }
    with pytest.raises(
        ValueError, match='its parameter gain is given twice; it may be given once'
    ):
        named(f'{path}:Given', ['gain=1', 'gain=2'])

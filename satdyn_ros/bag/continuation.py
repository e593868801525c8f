"""Where a run begins, if not with its scenario: in a bag, or at an attitude of another tool."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..actuators import ACTUATORS
from ..base import nanoseconds
from ..base.sentences import distinct_texts
from ..dynamics.system import State
from ..exchange.aem_reader import attitude_at
from ..kernel import rotation
from ..run.events import Timeout
from ..run.keys import NAMES_OF_EACH
from ..run.rules import EVENTS_FOLLOW
from ..run.scenario import Scenario
from ..run.simulation import Simulation, state_record
from ..sensors import Suite
from ..torques import ENVIRONMENT_TORQUES
from .read_run import RecordedRun
from .run_recorder import BLOCK_TICKS

# What a motion follows from, besides its state.
_OF_MOTION = (
    'body.',
    'orbit.',
    'environment.',
    'motion.',
    *(f'{name.partition(".")[0]}.' for name in NAMES_OF_EACH),
    *(key.name for kind in ENVIRONMENT_TORQUES for key in kind.keys),
    *(key.name for kind in ACTUATORS.values() for key in kind.keys),
)


def begun_in_bag(
    scenario: Scenario, bag: str | Path, at_s: str | float
) -> tuple[Scenario, dict[str, Any]]:
    """
    Return the scenario with the ticks of a bag's run, and the snapshot from which it continues.

    The motion in force goes on; where the scenario has other keys than the bag's on which a motion
    depends (_OF_MOTION), one begins anew from the state.  Initial conditions, topics and sensors
    go on as they are in the bag, those that the scenario changes are as it says.

    Parameters
    ----------
    scenario : Scenario
        what flies from there on
    bag : str or Path
        the bag
    at_s : s
        from tick 0; it continues at the first tick there or after

    Raises
    ------
    ValueError
        the bag has no such tick, another rate or epoch is asked for, or a rotor turns faster than
        it may
    """
    run = RecordedRun(bag)
    _check_ticks(scenario, run)
    simulation = _at(run, at_s)
    scenario = scenario.with_values({'time.epoch_ns': run.scenario.epoch_ns})
    if not scenario['sensors.seed'] and scenario['sensors.names']:
        scenario = scenario.with_values({'sensors.seed': run.scenario['sensors.seed']}).with_seed()
    snapshot = simulation.snapshot(simulation.tick)
    if run.rules < EVENTS_FOLLOW:
        snapshot['until'] = _recorded_ends(run, simulation.tick)
    before = run.scenario.values
    kept = {key for key, value in scenario.values.items() if before.get(key) == value}
    if {key for key in scenario.values if key.startswith(_OF_MOTION)} - kept:
        acted = simulation.scenario.equipment.to_plain(simulation.acting)
        others = {name: part for name, part in snapshot.items() if name not in acted}
        snapshot = others | _motion_anew(scenario, simulation, snapshot['until'])
        snapshot['sensors'] = simulation.sensors_of_a_new_motion.to_plain()
    snapshot['conditions'] = {
        key: value for key, value in snapshot['conditions'].items() if key in kept
    }
    if 'publish.topics' not in kept:
        snapshot['topics'] = list(scenario.topics)
    memories = Suite.of(scenario.sensors).to_plain()
    for name in memories.keys() & snapshot['sensors'].keys():
        of_sensor = {key for key in scenario.values if key.startswith(f'sensors.{name}.')}
        if {'sensors.seed', *of_sensor} <= kept:
            memories[name] = snapshot['sensors'][name]
    return scenario, snapshot | {'sensors': memories}


def is_aem(path: str | Path) -> bool:
    """Whether a path is that of a message, by its suffix: of any file but one of a bag."""
    suffix = Path(path).suffix
    return suffix == '.aem' or (suffix != '.mcap' and Path(path).is_file())


def begun_in_aem(scenario: Scenario, path: str | Path, epoch: str) -> Scenario:
    """
    Return the scenario started with the attitude, and rate, of an AEM.

    Without rates in the file the scenario's initial.angular_velocity is used, relative to the
    frame that the scenario names.  The epoch is the stamp of tick 0 unless time.epoch_ns is set.

    Parameters
    ----------
    scenario : Scenario
        what flies
    path : str or Path
        the message
    epoch : str
        in UTC

    Raises
    ------
    ValueError
        see attitude_at
    """
    attitude = attitude_at(path, epoch)
    if not scenario.epoch_ns:
        # Which refuses the one epoch whose stamp is none.
        scenario = scenario.with_values({'time.epoch': nanoseconds.epoch(attitude.stamp_ns)})
    omega_bi_b = attitude.omega_bi_b
    if omega_bi_b is None:
        omega_bi_b = np.array(scenario['initial.angular_velocity'])
        if scenario['initial.frame'] == 'lvlh':
            lvlh_rate_i = scenario.system.orbit.lvlh_rate(0.0)
            omega_bi_b += rotation.rotate(rotation.conjugate(attitude.q_ib), lvlh_rate_i)
    return scenario.with_values(
        {
            'initial.frame': 'inertial',
            'initial.attitude': attitude.q_ib,
            'initial.angular_velocity': omega_bi_b,
        }
    )


def _check_ticks(scenario: Scenario, run: RecordedRun) -> None:
    """Refuse other ticks than those of the run."""
    for key, other in (('publish.rate', None), ('time.epoch_ns', 0)):
        given, recorded = scenario[key], run.scenario[key]
        if given not in (recorded, other):
            raise ValueError(
                f'{key} is {given}; the run in {run.bag.path} continues with {recorded}'
            )


def _at(run: RecordedRun, at_s: str | float) -> Simulation:
    """Return the run in a bag when the first tick at or after at_s has happened."""
    bag, ticks = run.bag.path, run.ticks
    if run.snapshot is None:
        raise ValueError(f'{bag} has no samples')
    first, last = run.first_tick, run.last_tick()
    try:
        tick = ticks.ceil(at_s)
    except (ValueError, ZeroDivisionError):
        raise ValueError(f'the instant is {at_s}; it must be a number of seconds') from None
    if not first <= tick <= last:
        begin_s, end_s = ticks.seconds(first), ticks.seconds(last)
        raise ValueError(
            f'{bag} has no state at {at_s} s; it goes from {begin_s:g} to {end_s:g} s'
        )
    simulation = run.simulation()
    while simulation.tick < tick:
        _, samples = simulation.advance(min(BLOCK_TICKS, tick + 1 - simulation.next_tick))
        if len(samples) == 0:
            raise ValueError(f'the run in {bag} cannot continue: {simulation.halted}')
    return simulation


def _recorded_ends(run: RecordedRun, tick: int) -> dict[str, int]:
    """Return by topic the tick after a tick at which a torque ends, as a bag of rules 0 says."""
    later = [e for e in run.events if isinstance(e, Timeout) and e.tick > tick]
    return {event.topic: event.tick for event in reversed(later)}


def _motion_anew(
    scenario: Scenario, simulation: Simulation, until: Mapping[str, int]
) -> dict[str, Any]:
    """Return, of a snapshot, the motion of a scenario that begins in the state of a run."""
    state, begin = simulation.state, scenario.initial_state
    speeds, angles = begin.rotor_speed.copy(), begin.rotor_angle.copy()
    before = {rotor.label: i for i, rotor in enumerate(simulation.system.rotors)}
    for i, rotor in enumerate(scenario.system.rotors):
        k = before.get(rotor.label)
        if k is None or not (rotor.turns_freely and simulation.system.rotors[k].turns_freely):
            continue
        speeds[i], angles[i] = state.rotor_speed[k], state.rotor_angle[k]
        # The body may have driven it beyond the limit that it had.
        is_new = rotor.max_speed != simulation.system.rotors[k].max_speed
        if is_new and 0.0 < rotor.max_speed < abs(speeds[i]):
            given, most = distinct_texts(abs(speeds[i]), rotor.max_speed)
            raise ValueError(
                f'max_speed of the rotor {rotor.label} is {most} rad/s; the run continues at '
                f'{given} rad/s, beyond it'
            )
    kept = {n: x for n, x in state.inner.items() if n in scenario.system.inner_names}
    inner = {**begin.inner, **kept}
    equipment = scenario.equipment
    at_s = simulation.ticks.seconds(simulation.tick)
    acting = equipment.kept(simulation.acting, simulation.scenario.equipment, at_s)
    record = state_record(State(state.q_ib, state.omega_bi_b, speeds, angles, inner))
    return {
        'begin_tick': simulation.tick,
        'begin_state': record,
        'state': record,
        **equipment.to_plain(acting),
        'until': {name: tick for name, tick in until.items() if name in acting},
    }

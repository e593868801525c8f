"""
Satellites to train on: a thousand in step, damped by magnetorquers, an action every 5 s.

Beside them the bare propagation of as many bodies, begun anew at each action; single environments,
as Gymnasium steps them in turn; and Basilisk's own torque bars in the field of a centred dipole,
commanded by a message before each action: with steps of 0.1 s, after which its rates are within
1e-10 rad/s of those with shorter ones at the end, and with steps of 1 s, within 1e-6.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from common import QUICK, Claim, medians, show
from gymnasium.vector import SyncVectorEnv
from loop import timed

from satdyn_ros.dynamics.system import State
from satdyn_ros.gym import SatelliteEnv, SatelliteVectorEnv
from satdyn_ros.gym.tasks import detumble
from satdyn_ros.integrate.batch import propagate_all
from satdyn_ros.integrate.propagation import Propagation
from satdyn_ros.kernel.rotation import IDENTITY

MANY, FEW = (64, 8) if QUICK else (1024, 32)
ACTIONS = 3 if QUICK else 40
TASK = detumble()
STEPS_S = 0.1, 1.0
# Of Basilisk's one satellite, so that its time can be measured.
LAPS = 1 if QUICK else 10


def actions(count):
    """Return random actions of so many satellites, the same each time."""
    rng = np.random.default_rng(1)
    return [rng.uniform(-1.0, 1.0, (count, 3)).astype(np.float32) for _ in range(ACTIONS)]


def stepped(envs):
    """Return what acts on environments that have begun."""
    envs.reset(seed=1)
    given = actions(envs.num_envs)

    def run():
        for each in given:
            envs.step(each)

    return run


def bare():
    """Return what propagates as many bodies for an interval, once for each action."""
    rng, scenario = np.random.default_rng(1), TASK.scenario
    at_start = scenario.initial_state
    states = [
        State(IDENTITY, omega_b, at_start.rotor_speed, at_start.rotor_speed)
        for omega_b in rng.normal(scale=0.05, size=(MANY, 3))
    ]
    equipment, given = scenario.equipment, actions(MANY)
    (actuator, _), *_ = [equipment.of_keyword[word] for word in TASK.action]

    def run():
        for each in given:
            systems = [
                equipment.driven(
                    scenario.system, equipment.none | {actuator.topic: tuple(dipole)}, [actuator]
                )
                for dipole in (0.2 * each.astype(float)).tolist()
            ]
            motions = [Propagation(*pair) for pair in zip(systems, states, strict=True)]
            propagate_all(motions, [TASK.interval_s])

    return run


def basilisk(step_s):
    """Return a function that acts on one satellite of Basilisk; ImportError: it is not there."""
    from Basilisk.architecture import messaging
    from Basilisk.simulation import (
        GravityGradientEffector,
        MtbEffector,
        magneticFieldCenteredDipole,
        spacecraft,
    )
    from Basilisk.utilities import SimulationBaseClass, macros, simIncludeGravBody

    simulation = SimulationBaseClass.SimBaseClass()
    task = simulation.CreateNewTask('task', macros.sec2nano(step_s))
    simulation.CreateNewProcess('dynamics').addTask(task)
    body = spacecraft.Spacecraft()
    inertia = TASK.scenario.system.inertia
    body.hub.mHub, body.hub.IHubPntBc_B = 4.0, inertia.tolist()
    gravity = simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.isCentralBody = True
    gravity.addBodiesTo(body)
    r_i, v_i = TASK.scenario.system.orbit.position_velocity(0.0)
    body.hub.r_CN_NInit, body.hub.v_CN_NInit = r_i[:, None].tolist(), v_i[:, None].tolist()
    body.hub.sigma_BNInit, body.hub.omega_BN_BInit = [[0.0]] * 3, [[0.05], [-0.08], [0.1]]
    field = magneticFieldCenteredDipole.MagneticFieldCenteredDipole()
    field.addSpacecraftToModel(body.scStateOutMsg)
    bars = MtbEffector.MtbEffector()
    shape = messaging.MTBArrayConfigMsgPayload()
    shape.numMTB, shape.maxMtbDipoles = 3, [0.2, 0.2, 0.2]
    shape.GtMatrix_B = np.eye(3).ravel().tolist()
    shape_message = messaging.MTBArrayConfigMsg().write(shape)
    command = messaging.MTBCmdMsg()
    bars.mtbParamsInMsg.subscribeTo(shape_message)
    bars.mtbCmdInMsg.subscribeTo(command)
    bars.magInMsg.subscribeTo(field.envOutMsgs[0])
    body.addDynamicEffector(bars)
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    body.addDynamicEffector(gradient)
    for model in (field, bars, gradient, body):
        simulation.AddModelToTask('task', model)
    simulation.InitializeSimulation()
    given = [each[0].tolist() for _ in range(LAPS) for each in actions(1)]

    def run():
        for k, action in enumerate(given):
            payload = messaging.MTBCmdMsgPayload()
            payload.mtbDipoleCmds = [0.2 * x for x in action]
            command.write(payload)
            simulation.ConfigureStopTime(macros.sec2nano((k + 1) * TASK.interval_s))
            simulation.ExecuteSimulation()
            state, seen = body.scStateOutMsg.read(), field.envOutMsgs[0].read()
        return state.omega_BN_B, seen.magField_N, gravity, shape_message

    return run


def main(rounds=5):
    """Run all; return title, claims and text."""
    task = replace(TASK, duration_s=1e6)
    single = SyncVectorEnv([lambda: SatelliteEnv(task)] * FEW)
    contenders: dict[str | float, Callable[[], object]] = {
        'ours': stepped(SatelliteVectorEnv(task, MANY)),
        'bare': bare(),
        'single': stepped(single),
    }
    for step_s in STEPS_S:
        contenders[step_s] = timed(partial(basilisk, step_s))
    cpu_s = medians(contenders, rounds)
    count: dict[str | float, int] = {'ours': MANY, 'bare': MANY, 'single': FEW}
    per_s = {name: count.get(name, LAPS) * ACTIONS / seconds for name, seconds in cpu_s.items()}
    beside: dict[str | float, tuple[str, float | None]] = {
        # At most three times its cost.
        'bare': ('their bare propagation, begun anew at each action', 1.0 / 3.0),
        'single': ('single environments in turn', 20.0),
        STEPS_S[0]: (f'one of Basilisk, in steps of {STEPS_S[0]:g} s', 100.0),
        STEPS_S[1]: (f'one of Basilisk, in steps of {STEPS_S[1]:g} s', None),
    }
    claims = [
        Claim(
            f'{MANY} satellites in step, damped by magnetorquers, beside {what}',
            f'{per_s["ours"]:.0f} actions/s',
            f'{per_s[name]:.0f} actions/s',
            per_s['ours'] / per_s[name],
            must=must,
        )
        for name, (what, must) in beside.items()
    ]
    return 'Satellites to train on', show(claims), ''


if __name__ == '__main__':
    main()

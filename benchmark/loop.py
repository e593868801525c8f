"""
A loop closed in Python: new torques of three wheels at every tick of 50 Hz, on a circular orbit.

Beside it, of the same body, loops of a step a tick: the equations written with NumPy, by the
classical Runge-Kutta method of four stages and by SciPy's DOP853; and Basilisk's own wheels and
gravity gradient, commanded by a message before each step and read after it.
"""

import time

import numpy as np
from common import QUICK, Claim, medians, show
from scipy.integrate import solve_ivp

from satdyn_ros.run.controlled import ControlledSimulation
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.simulation import Simulation

TICKS = 50 if QUICK else 2000
STEP_S = 0.02
WHEEL = 1e-3
INERTIA = np.array([10.0, 12.0, 8.0])
CARRIER = INERTIA - WHEEL
RATE = np.array([0.01, -0.02, 0.015])
MU, RADIUS_M = 3.986004418e14, 6_878_137.0
MEAN_MOTION = np.sqrt(MU / RADIUS_M**3)
AXES = {'x': [1.0, 0.0, 0.0], 'y': [0.0, 1.0, 0.0], 'z': [0.0, 0.0, 1.0]}


def torque(tick):
    """Return what the motors are commanded [N m], another at every tick."""
    return 1e-4 * (tick % 7 + 1), -1e-4 * (tick % 5 + 1), 1e-4 * (tick % 3 + 1)


def scenario():
    """Return the satellite with its wheels."""
    values = {
        'publish.rate': 1.0 / STEP_S,
        'body.inertia': INERTIA.tolist(),
        'orbit.semi_major_axis': RADIUS_M,
        'orbit.mu': MU,
        'initial.frame': 'inertial',
        'initial.attitude': [0.0, 0.0, 0.0, 1.0],
        'initial.angular_velocity': RATE.tolist(),
        'rotor.names': [*AXES],
    }
    for name, axis in AXES.items():
        values |= {f'rotor.{name}.mode': 'motor', f'rotor.{name}.axis': axis}
        values |= {f'rotor.{name}.inertia': WHEEL, f'rotor.{name}.max_torque': 0.1}
    return Scenario(values)


def ours():
    """Return the state after all ticks, by Simulation.step."""
    simulation = Simulation(scenario())

    def run():
        for tick in range(TICKS):
            x, y, z = torque(tick)
            sample = simulation.step(rotor_torque={'x': x, 'y': y, 'z': z})
        return sample

    return run


class Commanding:
    """A controller inside the run, which gives these torques at every tick."""

    period_s: float | None = None
    needs_truth = False

    def reset(self, scenario, seed):
        """Begin; it has no memory."""

    def command(self, seen):
        """Return the torques of the sample's tick."""
        return {'rotor_torque': dict(zip(AXES, torque(seen.tick), strict=True))}


def controller_inside():
    """Return the state after all ticks, of a run with its controller inside."""
    simulation = ControlledSimulation(scenario(), controller=Commanding())

    def run():
        while simulation.next_tick <= TICKS:
            simulation.advance(TICKS + 1 - simulation.next_tick)
        return simulation.sample

    return run


def rates(t, y, applied):
    """Return dy/dt of attitude, rate and momenta of the wheels, as on the textbook page."""
    q, w, h = y[:4], y[4:7], y[7:]
    f = MEAN_MOTION * t
    c_i = np.array([np.cos(f), np.sin(f), 0.0])
    c = c_i + 2.0 * np.cross(-q[:3], np.cross(-q[:3], c_i) + q[3] * c_i)
    H = CARRIER * w + h
    gradient = 3.0 * MEAN_MOTION**2 * np.cross(c, INERTIA * c)
    w_dot = (np.cross(H, w) + gradient - applied) / CARRIER
    q_dot = 0.5 * np.array([*(q[3] * w + np.cross(q[:3], w)), -q[:3] @ w])
    return np.concatenate([q_dot, w_dot, applied])


def begin():
    """Return attitude, rate and momenta of the wheels at the start."""
    return np.array([0.0, 0.0, 0.0, 1.0, *RATE, *(WHEEL * RATE)])


def numpy_loop():
    """Return the rate after all ticks, by RK4."""
    y = begin()
    for tick in range(TICKS):
        t, applied = tick * STEP_S, np.array(torque(tick))
        k1 = rates(t, y, applied)
        k2 = rates(t + STEP_S / 2.0, y + STEP_S / 2.0 * k1, applied)
        k3 = rates(t + STEP_S / 2.0, y + STEP_S / 2.0 * k2, applied)
        k4 = rates(t + STEP_S, y + STEP_S * k3, applied)
        y = y + STEP_S / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return y[4:7]


def scipy_loop():
    """Return the rate after all ticks, by one call of solve_ivp each."""
    y = begin()
    for tick in range(TICKS):
        span = tick * STEP_S, (tick + 1) * STEP_S
        applied = (np.array(torque(tick)),)
        solution = solve_ivp(rates, span, y, 'DOP853', args=applied, rtol=1e-12, atol=1e-12)
        y = solution.y[:, -1]
    return y[4:7]


def basilisk_loop():
    """Return a function that goes through all ticks by ExecuteSimulation; ImportError: none."""
    from Basilisk.architecture import messaging
    from Basilisk.simulation import (
        GravityGradientEffector,
        reactionWheelStateEffector,
        spacecraft,
    )
    from Basilisk.utilities import SimulationBaseClass, macros, simIncludeGravBody, simIncludeRW

    simulation = SimulationBaseClass.SimBaseClass()
    task = simulation.CreateNewTask('task', macros.sec2nano(STEP_S))
    simulation.CreateNewProcess('dynamics').addTask(task)
    body = spacecraft.Spacecraft()
    body.hub.mHub, body.hub.IHubPntBc_B = 1e6, np.diag(CARRIER).tolist()
    gravity = simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.isCentralBody, earth.mu = True, MU
    gravity.addBodiesTo(body)
    body.hub.r_CN_NInit = [[RADIUS_M], [0.0], [0.0]]
    body.hub.v_CN_NInit = [[0.0], [MEAN_MOTION * RADIUS_M], [0.0]]
    body.hub.sigma_BNInit, body.hub.omega_BN_BInit = [[0.0]] * 3, [[x] for x in RATE]
    wheels = simIncludeRW.rwFactory()
    for axis in AXES.values():
        wheels.create('custom', axis, Js=WHEEL, Omega_max=1e5, u_max=0.1)
    effector = reactionWheelStateEffector.ReactionWheelStateEffector()
    wheels.addToSpacecraft('wheels', effector, body)
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    body.addDynamicEffector(gradient)
    command = messaging.ArrayMotorTorqueMsg()
    effector.rwMotorCmdInMsg.subscribeTo(command)
    for model in (effector, gradient, body):
        simulation.AddModelToTask('task', model)
    simulation.InitializeSimulation()

    def run():
        for tick in range(TICKS):
            payload = messaging.ArrayMotorTorqueMsgPayload()
            payload.motorTorque = list(torque(tick))
            command.write(payload)
            simulation.ConfigureStopTime(macros.sec2nano((tick + 1) * STEP_S))
            simulation.ExecuteSimulation()
            state = body.scStateOutMsg.read()
            read = state.sigma_BN, state.omega_BN_B, effector.rwSpeedOutMsg.read().wheelSpeeds
        return read, gravity, wheels

    return run


def main(rounds=5):
    """Run all; return title, claims and text."""
    found = ours()().omega_bi_b
    # RK4 of this step is right to some 1e-13 in a rate.
    np.testing.assert_allclose(found, numpy_loop(), rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(found, scipy_loop(), rtol=0.0, atol=1e-10)
    assert np.array_equal(found, controller_inside()().omega_bi_b)
    contenders = {
        'ours': timed(ours),
        'inside': timed(controller_inside),
        'NumPy': numpy_loop,
        'SciPy': scipy_loop,
    }
    basilisk_loop()
    contenders['Basilisk'] = timed(basilisk_loop)
    cpu_s = medians(contenders, rounds)
    per_s = {name: TICKS / seconds for name, seconds in cpu_s.items()}
    musts = {'NumPy': 3.0, 'SciPy': 3.0, 'Basilisk': 1.0}
    claims = [
        Claim(
            f'a loop of 50 Hz, three wheels commanded at every tick, beside {name}',
            f'{per_s["ours"]:.0f} steps/s',
            f'{per_s[name]:.0f} steps/s',
            per_s['ours'] / per_s[name],
            must=must,
        )
        for name, must in musts.items()
    ]
    claims.append(
        Claim(
            'the same by a controller inside the run, beside NumPy',
            f'{per_s["inside"]:.0f} steps/s',
            f'{per_s["NumPy"]:.0f} steps/s',
            per_s['inside'] / per_s['NumPy'],
        )
    )
    return 'A loop closed in Python', show(claims), ''


def timed(prepared):
    """Return what measures itself: a new simulation each time, whose making does not count."""

    def run():
        go = prepared()
        begin = time.process_time()
        go()
        return time.process_time() - begin

    return run


if __name__ == '__main__':
    main()

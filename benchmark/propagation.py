"""The propagation beside SciPy, heyoka and Basilisk, at the same error of the attitude."""

import io
import time
from pathlib import Path

import heyoka as hy
import numpy as np
from common import QUICK, Claim, medians, milliseconds, show
from matplotlib.figure import Figure
from problem import (
    DURATION_S,
    GRID_S,
    ORBIT_S,
    SEMI_MAJOR_AXIS,
    START,
    check,
    error_rad,
    from_lvlh,
    heyoka_equations,
    right_hand_side,
    right_hand_side_floats,
    system,
    to_lvlh,
)
from scipy.integrate import solve_ivp

from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.integrate.propagation import Propagation

# heyoka flies in inertial axes as the rest do, and in LVLH, where its equations are shortest.
# The loosest tolerances with which each stays within MAX_ERROR_RAD, which every run checks.
OURS, SCIPY, HEYOKA = 3e-13, 1e-13, 5e-12

# Made once, as heyoka's integrators are.
SYSTEM = system()
Y_0 = np.concatenate([START.q_ib, START.omega_bi_b])


def ours(t_s, of=SYSTEM, tolerance=OURS):
    """Propagate to t_s; return attitudes."""
    return Propagation(of, START, tolerance=tolerance).at(t_s).q_ib


def scipy_dop853(f, t_s, tolerance=SCIPY):
    """Integrate f with SciPy's DOP853; return attitudes at t_s."""
    solution = solve_ivp(
        f, (0.0, DURATION_S), Y_0, 'DOP853', t_eval=t_s, rtol=tolerance, atol=tolerance * 1e-2
    )
    return solution.y[:4].T


class Heyoka:
    """heyoka's adaptive Taylor integrator, compiled once; lvlh: of q_lb in place of q_ib."""

    def __init__(self, tolerance=HEYOKA, lvlh=False):
        attitude = to_lvlh(START.q_ib) if lvlh else START.q_ib
        self.lvlh, self.start = lvlh, np.concatenate([attitude, START.omega_bi_b])
        self.integrator = hy.taylor_adaptive(heyoka_equations(lvlh), self.start, tol=tolerance)

    def check(self):
        """Check all that it returns against the truth."""
        for run, t_s in (
            (self.final, np.array([DURATION_S])),
            (self.grid, GRID_S),
            (self.c_output, GRID_S),
        ):
            q_ib = from_lvlh(run(), t_s) if self.lvlh else run()
            check(f'heyoka {"LVLH " if self.lvlh else ""}{run.__name__}', q_ib, t_s)

    def _begin(self):
        self.integrator.time = 0.0
        self.integrator.state[:] = self.start

    def final(self):
        """Return the last attitude."""
        self._begin()
        self.integrator.propagate_until(DURATION_S)
        return self.integrator.state[None, :4]

    def grid(self):
        """Return the attitudes of propagate_grid."""
        self._begin()
        return self.integrator.propagate_grid(GRID_S)[-1][:, :4]

    def c_output(self):
        """Return the attitudes of the continuous output."""
        self._begin()
        output = self.integrator.propagate_until(DURATION_S, c_output=True)[4]
        return output(GRID_S)[:, :4]


def basilisk():
    """
    Return the CPU seconds of Basilisk's RK4 with 0.1 s steps and a recorder.

    It has no rotor of this kind, and goes without.
    """
    from Basilisk.simulation import GravityGradientEffector, spacecraft
    from Basilisk.utilities import SimulationBaseClass, macros, orbitalMotion, simIncludeGravBody

    sim = SimulationBaseClass.SimBaseClass()
    process = sim.CreateNewProcess('dynamics')
    process.addTask(sim.CreateNewTask('task', macros.sec2nano(0.1)))
    body = spacecraft.Spacecraft()
    body.hub.mHub = 500.0
    body.hub.IHubPntBc_B = [[900.0, 0.0, 0.0], [0.0, 800.0, 0.0], [0.0, 0.0, 600.0]]
    gravity = simIncludeGravBody.gravBodyFactory()
    earth = gravity.createEarth()
    earth.isCentralBody = True
    gravity.addBodiesTo(body)
    elements = orbitalMotion.ClassicElements()
    elements.a, elements.e = SEMI_MAJOR_AXIS, 0.0
    elements.i = elements.Omega = elements.omega = elements.f = 0.0
    r, v = orbitalMotion.elem2rv(earth.mu, elements)
    body.hub.r_CN_NInit, body.hub.v_CN_NInit = r, v
    body.hub.sigma_BNInit = [[0.1], [0.2], [-0.3]]
    body.hub.omega_BN_BInit = [[0.01], [0.02], [-0.015]]
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    body.addDynamicEffector(gradient)
    sim.AddModelToTask('task', body)
    sim.AddModelToTask('task', gradient)
    recorder = body.scStateOutMsg.recorder()
    sim.AddModelToTask('task', recorder)
    sim.InitializeSimulation()
    sim.ConfigureStopTime(macros.sec2nano(DURATION_S))
    begin = time.process_time()
    sim.ExecuteSimulation()
    return time.process_time() - begin


def peers(rounds=7):
    """Return the claims against the peers."""
    heyoka, lvlh, end = Heyoka(), Heyoka(lvlh=True), np.array([DURATION_S])
    final = {
        'ours': lambda: ours(end),
        'SciPy, NumPy': lambda: scipy_dop853(right_hand_side, end),
    }
    grid = {
        'ours': lambda: ours(GRID_S),
        'SciPy, NumPy': lambda: scipy_dop853(right_hand_side, GRID_S),
        'SciPy, floats': lambda: scipy_dop853(right_hand_side_floats, GRID_S),
    }
    for name, run in final.items():
        check(f'final, {name}', run(), end)
    for name, run in grid.items():
        check(f'grid, {name}', run(), GRID_S)
    for axes, peer in (('', heyoka), (', LVLH', lvlh)):
        peer.check()
        final[f'heyoka{axes}'] = peer.final
        grid[f'heyoka propagate_grid{axes}'] = peer.grid
        grid[f'heyoka c_output{axes}'] = peer.c_output
    grid['Basilisk RK4 0.1 s'] = basilisk
    end_s, grid_s = medians(final, rounds), medians(grid, rounds)

    def claim(what, times, peer, must, aim=None, at_most=False):
        ratio = times['ours'] / times[peer] if at_most else times[peer] / times['ours']
        return Claim(
            f'{what} {peer}',
            milliseconds(times['ours']),
            milliseconds(times[peer]),
            ratio,
            must,
            aim,
            at_most,
        )

    outputs, last = '571 201 outputs, against', 'final state, against'
    return [
        claim(outputs, grid_s, 'SciPy, NumPy', 300.0, 400.0),
        claim(outputs, grid_s, 'SciPy, floats', 60.0, 80.0),
        claim(outputs, grid_s, 'heyoka propagate_grid', 4.0),
        claim(outputs, grid_s, 'heyoka propagate_grid, LVLH', 4.0),
        claim(outputs, grid_s, 'heyoka c_output', 2.0),
        claim(outputs, grid_s, 'heyoka c_output, LVLH', 2.0),
        claim(outputs, grid_s, 'Basilisk RK4 0.1 s', 400.0, 500.0),
        claim(last, end_s, 'heyoka', 1.0, 0.8, at_most=True),
        claim(last, end_s, 'heyoka, LVLH', 1.0, 0.8, at_most=True),
        claim(last, end_s, 'SciPy, NumPy', 1000.0),
    ]


def same_code(rounds=7):
    """Return the claim that ellipses, rotors and torques cost about what the circle does."""
    end = np.array([DURATION_S])
    free = Rotor('free', np.array([0.0, 1.0, 0.0]), inertia=0.05)
    contenders = {
        'circle': lambda: ours(end),
        'ellipse, e = 0.1': lambda: ours(end, system(0.1)),
        'free rotor': lambda: ours(end, system(rotor=free)),
    }
    seconds = medians(contenders, rounds)
    return [
        Claim(
            f'{name} over circle',
            milliseconds(seconds[name]),
            milliseconds(seconds['circle']),
            seconds[name] / seconds['circle'],
            2.0,
            at_most=True,
        )
        for name in list(contenders)[1:]
    ]


def work():
    """Print cost against duration and tolerance, draw it, and return the text."""
    lines = ['| orbits | steps | CPU |', '| --- | --- | --- |']
    ours([1.0])  # loads the compiled code
    for orbits in (1, 10, 100, 1000):
        motion = Propagation(SYSTEM, START, tolerance=OURS)
        begin = time.process_time()
        motion.at([ORBIT_S * orbits])
        cost = milliseconds(time.process_time() - begin)
        lines.append(f'| {orbits} | {motion.steps} | {cost} |')
    curves = precision()
    lines += ['', '| tolerance | CPU | error [rad] |', '| --- | --- | --- |']
    for tolerance, seconds, error in curves['satdyn_ros']:
        lines.append(f'| {tolerance:.0e} | {milliseconds(seconds)} | {error:.2g} |')
    draw(curves)
    lines += ['', '![Cost against error of the final attitude](work_precision.png)']
    text = '\n'.join(lines)
    print(text)
    return text


def precision():
    """Return, by integrator, tolerance, CPU time [s] and error [rad] of the final attitude."""
    end = np.array([DURATION_S])

    def heyoka(tolerance):
        integrator = Heyoka(tolerance)
        return integrator.final

    def scipy(tolerance):
        return lambda: scipy_dop853(right_hand_side_floats, end, tolerance)

    curves: dict[str, list[tuple[float, float, float]]] = {}
    for name, begin, least in (
        ('satdyn_ros', lambda tolerance: lambda: ours(end, tolerance=tolerance), 13),
        ('heyoka', heyoka, 15),
        ('SciPy DOP853, floats', scipy, 13),
    ):
        curves[name] = []
        for exponent in range(6, least + 1):
            run = begin(10.0**-exponent)
            seconds = medians({name: run}, 3)[name]
            curves[name].append((10.0**-exponent, seconds, error_rad(run(), end)))
    return curves


def draw(curves):
    """Draw the work-precision curves beside this file."""
    figure = Figure(figsize=(6.4, 4.2), layout='constrained')
    axes = figure.add_subplot()
    for (name, points), marker in zip(curves.items(), 'os^', strict=True):
        _, seconds, error = np.transpose(points)
        axes.loglog(error, 1e3 * seconds, marker=marker, label=name)
    axes.set(xlabel='error of the final attitude [rad]', ylabel='CPU time of ten orbits [ms]')
    axes.invert_xaxis()
    axes.grid(alpha=0.3)
    axes.legend()
    picture = io.BytesIO() if QUICK else Path(__file__).with_name('work_precision.png')
    figure.savefig(picture, dpi=110)


def main():
    """Run all; return title, claims and text."""
    claims = show(peers() + same_code())
    return 'Propagation', claims, work()


if __name__ == '__main__':
    main()

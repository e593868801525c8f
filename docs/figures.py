"""Draw the pictures of the documentation: closed forms, the page, and the maps of the sweeps."""

import re
import shutil
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from satdyn_ros.bag.export import table
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.dynamics.rotor import Rotor
from satdyn_ros.dynamics.system import State, System
from satdyn_ros.exact import FluidBody, Free, Immersed, Symmetric, recognise
from satdyn_ros.kernel import rotation
from satdyn_ros.orbits import FixedDirection
from satdyn_ros.report import html, maps
from satdyn_ros.report.history import history
from satdyn_ros.report.outcomes import draw_sweep
from satdyn_ros.report.panels import COLOURS, STYLES
from satdyn_ros.run import events
from satdyn_ros.run.controllers import named
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.sensors import Gyro
from satdyn_ros.sweep.run import sweep

FIGURES = Path(__file__).parent / 'figures'
CONFIG = Path(__file__).parents[1] / 'config'
CONTROLLERS = Path(__file__).parents[1] / 'examples' / 'controllers'


def _sphere(axes):
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 31), np.linspace(0, 2 * np.pi, 61))
    x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    axes.plot_surface(x, y, z, color='0.85', alpha=0.35, linewidth=0)
    axes.set_box_aspect((1, 1, 1))


def _axis_system(inertia, gradient, weight=0.0, momentum=0.0):
    rotor = Rotor()
    if momentum:
        rotor = Rotor('constant_momentum', np.array([0.0, 0.0, 1.0]), momentum)
    return System(
        np.diag(inertia), (rotor,), FixedDirection(gradient), np.array([0.0, 0.0, weight])
    )


def stationary():
    """Draw paths of the vertical on the body: both families and the separatrix, nu = 0.1."""
    moments, nu = np.array([1.0, 1.5, 2.0]), 0.1
    N = 1.0 - 2.0 * nu * moments
    alpha = np.sqrt(np.prod(N)) / N
    system = System(np.diag(moments), orbit=FixedDirection(1.0))
    figure = Figure(figsize=(5.2, 5.0), layout='constrained')
    axes = figure.add_subplot(projection='3d')
    _sphere(axes)
    starts = [(t, 0.0) for t in (0.25, 0.55, 0.85, 1.2, 1.45)]
    starts += [(np.pi / 2 - 0.05, p) for p in (0.15, 0.5)]
    for k, (theta, phi) in enumerate(starts):
        for sign in (1.0, -1.0):
            g = sign * np.array(
                [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
            )
            q_ib = rotation.conjugate(_turn_from_z(g))
            motion = recognise(system, State(q_ib, alpha * g))
            assert motion is not None
            c_b = motion.at(np.linspace(0.0, motion.period_s or 1.0, 400)).c_b
            axes.plot(*c_b.T, color=COLOURS[k % len(COLOURS)], lw=1.5)
    axes.set(xlabel='$g_1$', ylabel='$g_2$', zlabel='$g_3$')
    return figure


def _turn_from_z(direction):
    axis = np.cross([0.0, 0.0, 1.0], direction)
    return rotation.normalise([*axis, 1.0 + direction[2]])


def _planar_curves(axes, system, starts, span_s):
    for k, (angle, rate) in enumerate(starts):
        q_ib = rotation.about([0.0, 1.0, 0.0], -angle)
        motion = recognise(system, State(q_ib, np.array([0.0, -rate, 0.0])))
        assert motion is not None
        t_s = np.linspace(0.0, motion.period_s or span_s, 600)
        states = motion.at(t_s)
        theta = np.unwrap(np.arctan2(states.c_b[:, 0], states.c_b[:, 2]))
        axes.plot(
            np.degrees(theta),
            -states.omega_bi_b[:, 1],
            color=COLOURS[k % len(COLOURS)],
            ls=STYLES[0 if motion.period_s else 1],
            lw=1.5,
        )
    axes.set(xlabel=r'$\theta$ [deg]', ylabel=r"$\theta'$ [rad/s]", xlim=(-180, 180))
    axes.grid(alpha=0.3)


def planar():
    """Draw the phase portrait of planar libration and tumbling, with the separatrix."""
    system = System(np.diag([2.0, 2.5, 1.0]), orbit=FixedDirection(1.0))
    N = np.sqrt(0.4)
    figure = Figure(figsize=(6.4, 3.6), layout='constrained')
    starts = [(a, 0.0) for a in (0.3, 0.7, 1.1, 1.4, np.pi - 0.4, np.pi - 1.0)]
    starts += [(-sign * np.pi, sign * N * k) for sign in (1, -1) for k in (1.2, 1.5)]
    _planar_curves(figure.add_subplot(), system, starts, 30.0)
    axes = figure.axes[0]
    theta = np.linspace(-np.pi, np.pi, 400)
    for sign in (1, -1):
        axes.plot(np.degrees(theta), sign * N * np.abs(np.cos(theta)), '--', color='0.3', lw=1.0)
    return figure


def offset_pendulum():
    """Draw the phase portrait of the pendulum whose mass centre lies off the fixed point."""
    system = System(
        np.diag([2.0, 2.5, 1.0]),
        orbit=FixedDirection(1.0),
        weight_moment=np.array([0.12, 0.0, -0.18]),
    )
    figure = Figure(figsize=(6.4, 3.6), layout='constrained')
    starts = [(a, 0.0) for a in (0.2, 0.6, 1.0, 2.2, 2.6, 3.0, -1.0)]
    starts += [(-np.pi, 0.9), (np.pi, -0.9), (-np.pi, 1.2)]
    _planar_curves(figure.add_subplot(), system, starts, 30.0)
    return figure


def symmetric():
    """Draw nutation for four patterns of roots, and the path of the axis of one of them."""
    patterns = {
        'two wells': (_axis_system([1.0, 1.0, 0.4], 25.0), [0.3, 1.1, 1.5]),
        'complex pair': (_axis_system([2.0, 2.0, 1.0], 1.0, 0.5), [0.3, 0.2, 1.0]),
        'oblate': (_axis_system([1.0, 1.0, 1.6], 1.0, 0.5), [0.2, 0.5, 1.2]),
        'Lagrange': (_axis_system([2.0, 2.0, 1.0], 0.0, 0.7), [0.1, 0.1, 2.0]),
    }
    figure = Figure(figsize=(9.0, 3.8), layout='constrained')
    left = figure.add_subplot(1, 2, 1)
    right = figure.add_subplot(1, 2, 2, projection='3d')
    _sphere(right)
    start = rotation.about([1.0, 0.0, 0.0], 0.9)
    for k, (name, (system, omega)) in enumerate(patterns.items()):
        motion = Symmetric(system, State(start, np.array(omega)))
        t_s = np.linspace(0.0, 12.0, 1200)
        axis = rotation.rotate(motion.at(t_s).q_ib, [0.0, 0.0, 1.0])
        left.plot(t_s, axis[:, 2], STYLES[k], color=COLOURS[k], label=name, lw=1.4)
        if name in ('oblate', 'Lagrange'):
            right.plot(*axis.T, color=COLOURS[k], lw=1.2)
    left.set(xlabel='time [s]', ylabel=r'$\cos\theta$')
    left.legend(fontsize=8, ncols=4, loc='lower center', bbox_to_anchor=(0.5, 1.0))
    left.grid(alpha=0.3)
    return figure


def rolling():
    """Draw a quadric of revolution and the pole of rotation that stays on it."""
    from satdyn_ros.exact.geometry import Rolling

    figure = Figure(figsize=(9.0, 4.2), layout='constrained')
    for k, gradient in enumerate((2.0, -14.0)):
        system = _axis_system([1.0, 1.0, 1.6], gradient)
        motion = Symmetric(
            system, State(rotation.about([1.0, 0.0, 0.0], 0.9), np.array([0.4, 0.5, 1.2]))
        )
        c2, c1, c0 = Rolling.of(motion).coefficients
        states = motion.at(np.linspace(0.0, 40.0, 3000))
        v = rotation.rotate(states.q_ib, states.omega_bi_b)
        axes = figure.add_subplot(1, 2, k + 1, projection='3d')
        height = np.linspace(v[:, 2].min() - 0.3, v[:, 2].max() + 0.3, 60)
        square = c2 * height**2 + c1 * height + c0
        height, radius = height[square >= 0.0], np.sqrt(square[square >= 0.0])
        phi = np.linspace(0.0, 2.0 * np.pi, 61)
        axes.plot_surface(
            radius * np.cos(phi)[:, None],
            radius * np.sin(phi)[:, None],
            np.broadcast_to(height, (61, len(height))),
            color='0.8',
            alpha=0.35,
            linewidth=0,
        )
        axes.plot(*v.T, color=COLOURS[k], lw=1.0)
        axes.set_title(Rolling.of(motion).kind, fontsize=9)
        axes.set(xlabel='$v_x$ [rad/s]', ylabel='$v_y$ [rad/s]', zlabel='$v_z$ [rad/s]')
    return figure


def immersed():
    """Draw the path of a helicoidal solid in a fluid."""
    body = FluidBody(a11=2.0, a33=3.0, a44=1.0, a66=0.8, a14=0.3, a36=-0.4)
    motion = Immersed(
        body,
        q_ib=rotation.about([1.0, 0.0, 0.0], 0.6),
        omega_bi_b=np.array([0.3, 0.4, 0.9]),
        P0=1.2,
    )
    x_i = motion.at(np.linspace(0.0, 60.0, 3000)).x_i
    figure = Figure(figsize=(4.6, 4.6), layout='constrained')
    axes = figure.add_subplot(projection='3d')
    axes.plot(*x_i.T, color=COLOURS[0], lw=1.2)
    axes.set(xlabel='x [m]', ylabel='y [m]', zlabel='z, along the impulse [m]')
    return figure


def allan_deviation():
    """Draw the Allan deviation of a gyro whose data sheet has a floor, and its parts."""
    hour, N, K = np.radians(1.0) / 3600.0, np.radians(0.05) / 60.0, 1e-8
    gyro = Gyro(1, 0.01, noise_density=N, bias_random_walk=K, bias_instability=1.62 * 0.5 * hour)
    parts = {
        'white noise': replace(gyro, bias_random_walk=0.0, bias_instability=0.0),
        'slow bias': replace(gyro, noise_density=0.0, bias_random_walk=0.0),
        'random walk': replace(gyro, noise_density=0.0, bias_instability=0.0),
    }
    taus = np.logspace(-2, 5, 200)
    figure = Figure(figsize=(7.0, 4.2))
    figure.set_layout_engine('constrained')
    axes = figure.add_subplot()
    for (name, part), colour in zip(parts.items(), COLOURS[1:], strict=False):
        values = [part.allan_deviation(tau) / hour for tau in taus]
        axes.loglog(taus, values, '--', color=colour, lw=1.2, label=name)
    axes.loglog(
        taus, [gyro.allan_deviation(t) / hour for t in taus], color=COLOURS[0], label='all'
    )
    axes.axhline(0.5, color='0.5', lw=0.8)
    axes.annotate('floor of the data sheet', (0.02, 0.52), color='0.35', fontsize=8)
    axes.axvline(1893.0, color='0.5', lw=0.8, ls=':')
    axes.annotate('1.893 T', (2000.0, 0.025), color='0.35', fontsize=8)
    axes.set(xlabel='tau [s]', ylabel='Allan deviation [deg/h]', ylim=(0.02, 50.0))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    return figure


def datasheets():
    """Draw what docs/how-to/datasheets.md flies: Allan plot, errors of the attitude, wheels."""
    page = (Path(__file__).parent / 'how-to' / 'datasheets.md').read_text(encoding='utf-8')
    files = dict(re.findall(r'```yaml (\S+)\n(.*?)```', page, re.DOTALL))
    sheets, push = files['sheets.yaml'], files['push.yaml']
    scenario = Scenario.from_yaml_text(sheets)
    with tempfile.TemporaryDirectory() as directory:
        bag = Path(directory) / 'sheets'
        for _ in simulate(scenario, 10800, bag, events.from_yaml_text(push, scenario)):
            pass
        flown, rows = history(bag, 108000), table(bag)
    tracker, gyro = flown.sensors['st1'], scenario.sensors['gyro']
    hour = np.radians(1.0) / 3600.0
    angle = np.cumsum(flown.sensors['gyro'].error, axis=0)
    counts = np.unique(np.geomspace(1, len(angle) // 5, 25).astype(int))
    found = []
    for n in counts:
        means = (angle[n:] - angle[:-n]) / n
        found.append(np.sqrt(np.mean((means[n:] - means[:-n]) ** 2) / 2.0))
    taus = counts / float(scenario.rate)
    figure = Figure(figsize=(10.0, 3.4), layout='constrained')
    allan, attitude, speeds = figure.subplots(1, 3)
    allan.loglog(taus, np.array(found) / hour, 'o', ms=4, color=COLOURS[0], label='as measured')
    typed = [gyro.allan_deviation(tau) / hour for tau in taus]
    allan.loglog(taus, typed, color=COLOURS[1], label='as typed')
    allan.set(xlabel='tau [s]', ylabel='Allan deviation [deg/h]', title='gyro, all axes')
    allan.legend(fontsize=8)
    for k in (2, 1, 0):
        off = np.degrees(tracker.error[:, k]) * 3600.0
        attitude.plot(tracker.t_s / 60.0, off, '.', ms=1, color=COLOURS[k])
    attitude.set(
        xlim=(0.0, 30.0),
        xlabel='time [min]',
        ylabel='error about x, y, z [arcsec]',
        title='star tracker',
    )
    for name, colour in zip(scenario['rotor.names'], COLOURS, strict=False):
        speed = rows[f'{name}_speed_rad_s'] * 30.0 / np.pi
        speeds.plot(rows['t_s'] / 60.0, speed, color=colour, label=name)
    speeds.set(xlim=(0.0, 5.0), xlabel='time [min]', ylabel='speed [rpm]', title='wheels')
    speeds.legend(fontsize=8)
    for axes in (allan, attitude, speeds):
        axes.grid(alpha=0.3)
    return figure


def free():
    """Draw polhodes on the energy ellipsoid, and a herpolhode."""
    moments = np.array([1.0, 2.0, 2.5])
    system = System(np.diag(moments))
    figure = Figure(figsize=(9.0, 4.2), layout='constrained')
    left = figure.add_subplot(1, 2, 1, projection='3d')
    right = figure.add_subplot(1, 2, 2)
    for k, (o1, o3) in enumerate(((0.1, 1.0), (0.45, 0.9), (0.9, 0.6), (1.2, 0.3))):
        o2 = np.sqrt(max(2.6 - o1**2 - 2.5 * o3**2, 0.0) / 2.0)
        for signs in ((1, 1, 1), (-1, 1, -1)):
            omega = np.array(signs) * np.array([o1, o2, o3])
            motion = Free(system, State(rotation.IDENTITY, omega))
            assert motion.period_s is not None
            states = motion.at(np.linspace(0.0, motion.period_s, 600))
            left.plot(*states.omega_bi_b.T, color=COLOURS[k], lw=1.4)
        if k == 0:
            assert motion.period_s is not None
            states = motion.at(np.linspace(0.0, 12.0 * motion.period_s, 4000))
            L_i = rotation.rotate(states.q_ib, states.omega_bi_b * moments)[0]
            to_z = rotation.conjugate(_turn_from_z(L_i / np.linalg.norm(L_i)))
            v = rotation.rotate(rotation.multiply(to_z, states.q_ib), states.omega_bi_b)
            right.plot(v[:, 0], v[:, 1], color=COLOURS[k], lw=0.8)
    left.set(xlabel=r'$\Omega_1$', ylabel=r'$\Omega_2$', zlabel=r'$\Omega_3$ [rad/s]')
    left.set_title('polhodes', fontsize=9)
    right.set_title('herpolhode', fontsize=9)
    right.set(xlabel='[rad/s]', ylabel='[rad/s]', aspect='equal')
    return figure


class _Screenshot:
    """A picture of a page in Chromium, at twice the resolution; saved as a figure is."""

    def __init__(self, page: str, script: str, chromium: str):
        self._page, self._script, self._chromium = page, script, chromium

    def savefig(self, path: Path, dpi: int) -> None:
        from selenium import webdriver
        from selenium.webdriver.support.ui import WebDriverWait

        options = webdriver.ChromeOptions()
        for flag in ('headless=new', 'no-sandbox', 'use-angle=swiftshader', 'hide-scrollbars'):
            options.add_argument(f'--{flag}')
        options.add_argument('--enable-unsafe-swiftshader')
        with tempfile.TemporaryDirectory() as directory:
            file = Path(directory) / 'page.html'
            file.write_text(self._page, encoding='utf-8')
            options.binary_location = self._chromium
            service = webdriver.ChromeService(shutil.which('chromedriver'))
            with webdriver.Chrome(options, service) as browser:
                size = {'width': 1280, 'height': 720, 'deviceScaleFactor': 2, 'mobile': False}
                browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', size)
                dark = [{'name': 'prefers-color-scheme', 'value': 'dark'}]
                browser.execute_cdp_cmd('Emulation.setEmulatedMedia', {'features': dark})
                browser.get(file.as_uri())
                frames = 'return satdyn.stage.scene.frames.length'
                before = browser.execute_script(f'{self._script}; {frames}')
                WebDriverWait(browser, 60).until(lambda b: b.execute_script(frames) > before)
                browser.save_screenshot(path)


def page():
    """Draw the report of a CubeSat that turns to nadir with wheels: the picture in the README."""
    chromium = shutil.which('chromium')
    if not (chromium and shutil.which('chromedriver')):
        print("figures/page.png needs Debian's chromium and chromium-driver; it stays as it is")
        return None
    text = (CONFIG / 'cubesat_adcs.yaml').read_text(encoding='utf-8')
    # Then it is over the lit side of the Earth.
    scenario = Scenario.from_yaml_text(text.replace('T12:30:00Z', 'T12:09:00Z'))
    controller = named(f'{CONTROLLERS}/nadir.py:Nadir')
    with tempfile.TemporaryDirectory() as directory:
        bag = Path(directory) / 'cubesat'
        for _ in simulate(scenario, 300, bag, controller=controller):
            pass
        text = html.page(history(bag, 12000), 'cubesat')
    return _Screenshot(text, 'satdyn.timeline.seek(60)', chromium)


def _swept(name, directory):
    """Run a sweep of config/sweeps and return the path of its table."""
    return sweep(CONFIG / 'sweeps' / f'{name}.yaml', Path(directory) / name)


def smelt_map():
    """Draw which bodies stay upright: ten thousand propagations and linear theory."""
    with tempfile.TemporaryDirectory() as directory:
        return maps.smelt_map(_swept('smelt', directory))


def capture_map():
    """Draw which rotors hold a satellite that was left rolling."""
    with tempfile.TemporaryDirectory() as directory:
        return maps.capture_map(_swept('capture', directory))


def monte_carlo():
    """Draw what becomes of releases with random attitudes and rates."""
    with tempfile.TemporaryDirectory() as directory:
        return draw_sweep(_swept('monte_carlo', directory))


def stroboscopic_map():
    """Draw libration on an ellipse, once per orbit: islands in a chaotic sea."""
    scenario = Scenario.from_yaml(CONFIG / 'sweeps' / 'beletsky_satellite.yaml')
    rate = float(np.linalg.norm(scenario.system.orbit.lvlh_rate(0.0)))
    with tempfile.TemporaryDirectory() as directory:
        return maps.stroboscopic_map(_swept('beletsky_map', directory), rate)


DRAWINGS = (
    page,
    smelt_map,
    capture_map,
    monte_carlo,
    stroboscopic_map,
    stationary,
    planar,
    offset_pendulum,
    symmetric,
    rolling,
    immersed,
    allan_deviation,
    datasheets,
    free,
)


def main():
    """Draw those that are named, or all."""
    FIGURES.mkdir(exist_ok=True)
    for drawing in DRAWINGS:
        if len(sys.argv) == 1 or drawing.__name__ in sys.argv[1:]:
            figure = drawing()
            if figure is None:
                continue
            figure.savefig(FIGURES / f'{drawing.__name__}.png', dpi=110)
            print(f'figures/{drawing.__name__}.png')


if __name__ == '__main__':
    main()

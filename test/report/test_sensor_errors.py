"""Measurement minus truth: what plot and report show of sensors is what the messages say."""

from dataclasses import replace

import browser as pages
import numpy as np
import pytest
from commands import torque_command
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.report.history import history
from satdyn_ros.report.html import playable, report
from satdyn_ros.report.plot import draw, plot
from satdyn_ros.report.sensor_errors import with_gaps
from satdyn_ros.run.events import Event, Request
from satdyn_ros.run.scenario import Scenario
from satdyn_ros.run.segment import Segment

RATE_HZ, LATENCY, RESTART = 20.0, 5, 1001
MOUNTING = [0.0, 0.7071067811865476, 0.0, 0.7071067811865476]
SCENARIO = Scenario(
    {
        'publish.rate': RATE_HZ,
        'publish.topics': ['attitude', 'angular_velocity'],
        'time.epoch_ns': 10**9,
        'initial.angular_velocity': [0.02, -0.01, 0.03],
        'record.max_duration_s': 31.0,
        'sensors.names': ['gyro', 'star_tracker'],
        'sensors.seed': 11,
        'sensors.gyro.mounting': MOUNTING,
        'sensors.gyro.noise_density': 1e-4,
        'sensors.gyro.initial_bias': [0.002, -0.003, 0.001],
        'sensors.gyro.scale_factor': [0.01, 0.02, -0.03],
        'sensors.gyro.misalignment': [0.001, 0.002, 0.003, -0.001, -0.002, -0.003],
        'sensors.star_tracker.mounting': MOUNTING,
        'sensors.star_tracker.divisor': 4,
        'sensors.star_tracker.latency': LATENCY,
        'sensors.star_tracker.cross_boresight': 5e-5,
        'sensors.star_tracker.roll': 3.5e-4,
    }
)


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag in several files, with a restart in it."""
    path = tmp_path_factory.mktemp('errors') / 'bag'
    restart = Request(RESTART, {'initial.angular_velocity': [0.0, 0.01, 0.0]})
    for _ in simulate(SCENARIO, 100, path, [restart]):
        pass
    return path


def vector(part):
    """Return the numbers of a vector or a quaternion."""
    return [getattr(part, name) for name in 'xyzw' if hasattr(part, name)]


CONTENTS = {
    'attitude': lambda message: vector(message.quaternion),
    'angular_velocity': lambda message: vector(message.velocity.angular),
    'gyro': lambda message: vector(message.angular_velocity),
    'star_tracker': lambda message: vector(message.orientation),
}


@pytest.fixture(scope='module')
def messages(bag):
    """Return stamps [s from tick 0] and numbers by topic, as mcap-ros2-support reads them."""
    found: dict[str, tuple[list, list]] = {name: ([], []) for name in CONTENTS}
    for file in sorted(bag.glob('*.mcap')):
        with file.open('rb') as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            for _, channel, _, message in reader.iter_decoded_messages(
                [f'/{name}' for name in CONTENTS]
            ):
                stamps, values = found[channel.topic[1:]]
                stamps.append(message.header.stamp.sec - 1 + message.header.stamp.nanosec * 1e-9)
                values.append(CONTENTS[channel.topic[1:]](message))
    return {name: (np.array(t_s), np.array(values)) for name, (t_s, values) in found.items()}


def test_gyro_against_the_messages(bag, messages):
    """Measured minus true rate: that of the topics, the truth turned into the sensor's axes."""
    errors = history(bag).sensors['gyro']
    t_s, measured = messages['gyro']
    _, omega = messages['angular_velocity']
    true = Rotation.from_quat(MOUNTING).inv().apply(omega)
    np.testing.assert_allclose(errors.t_s, t_s, atol=1e-12)
    np.testing.assert_allclose(errors.error, measured - true, atol=1e-15)
    xy, xz, yx, yz, zx, zy = SCENARIO['sensors.gyro.misalignment']
    sx, sy, sz = SCENARIO['sensors.gyro.scale_factor']
    wrong = np.array([[sx, xy, xz], [yx, sy, yz], [zx, zy, sz]])
    systematic = true @ wrong.T + SCENARIO['sensors.gyro.initial_bias']
    np.testing.assert_allclose(errors.systematic, systematic, atol=1e-15)


def test_star_tracker_against_the_messages(bag, messages):
    """The rotation from true to measured axes at the exposure, which the stamp names."""
    errors = history(bag).sensors['star_tracker']
    t_s, measured = messages['star_tracker']
    _, q_ib = messages['attitude']
    exposed = np.rint(t_s * RATE_HZ).astype(int)
    true = Rotation.from_quat(q_ib[exposed]) * Rotation.from_quat(MOUNTING)
    angles = (true.inv() * Rotation.from_quat(measured)).as_rotvec()
    np.testing.assert_allclose(errors.t_s, t_s, atol=1e-12)
    np.testing.assert_allclose(errors.error, angles, atol=1e-14)
    assert np.all(np.abs(errors.systematic) < 1e-14)
    assert errors.t_s[-1] < 100.0 - LATENCY / RATE_HZ


def test_noise_is_within_its_sigma(bag):
    """The mean square of the noise over sigma is 1, within what so few numbers allow."""
    run = history(bag)
    for name, count in (('gyro', 6000), ('star_tracker', 1500)):
        errors = run.sensors[name]
        noise = (errors.error - errors.systematic) / errors.sigma
        assert abs(noise.size - count) < 10
        # The variance of a mean of squares is 2 / n; 3.5 standard deviations.
        assert abs(np.mean(noise**2) - 1.0) < 3.5 * np.sqrt(2.0 / noise.size)


def test_any_part_has_the_same_errors(bag):
    """From a later file, through the bias of its snapshot; and in fewer rows every n-th one."""
    whole = history(bag).sensors
    part = history(bag / 'bag_1.mcap').sensors
    fewer = history(bag, 300, 20.0, 80.0).sensors
    for name, errors in whole.items():
        for some in (part[name], fewer[name]):
            rows = np.searchsorted(errors.t_s, some.t_s - 1e-9)
            np.testing.assert_array_equal(some.t_s, errors.t_s[rows])
            np.testing.assert_array_equal(some.error, errors.error[rows])
            np.testing.assert_array_equal(some.systematic, errors.systematic[rows])
    assert len(fewer['gyro'].t_s) == 241  # each fifth of 1201 ticks
    assert len(fewer['star_tracker'].t_s) < 301
    # An exposure of the file before is still on its way at the begin of this one.
    assert part['star_tracker'].t_s[0] >= part['gyro'].t_s[0]


@pytest.mark.parametrize('method', ['numeric', 'exact'])
@pytest.mark.parametrize('divisor', [1, 3])
def test_an_integrating_gyro_against_the_attitudes(tmp_path, method, divisor):
    """
    Without noise an integrating gyro has no error: at a start, a restart, under torques, fast.

    Attitudes are off by the tolerance of 1e-13, in the time of a tick.
    """
    values = {
        'publish.rate': 2.0,
        'time.epoch_ns': 10**9,
        'orbit.type': 'fixed',
        'initial.frame': 'inertial',
        'initial.angular_velocity': [0.5, -0.3, 9.0],
        'motion.method': 'auto' if method == 'exact' else method,
        'sensors.names': ['gyro'],
        'sensors.gyro.integrating': True,
        'sensors.gyro.divisor': divisor,
        'record.max_duration_s': 11.0,
    }
    events: list[Event] = [
        torque_command(5, (100.0, 0.0, 0.0), 11),
        torque_command(23, (0.0, 50.0, -80.0), 24),
        Request(37, {'initial.angular_velocity': [8.0, 0.0, 0.1]}),
    ]
    for _ in simulate(Scenario(values), 25, tmp_path / 'bag', events):
        pass
    for path in (tmp_path / 'bag', tmp_path / 'bag' / 'bag_1.mcap'):
        errors = history(path).sensors['gyro'].error
        np.testing.assert_allclose(errors, np.zeros_like(errors), atol=1e-11)


def test_a_gyro_that_counts_wrong_has_errors(tmp_path, monkeypatch):
    """The reference does not follow the gyro: where it misses a turn, the error is that turn."""
    values = {
        'publish.rate': 1.0,
        'time.epoch_ns': 10**9,
        'orbit.type': 'fixed',
        'initial.frame': 'inertial',
        'initial.angular_velocity': [0.0, 0.0, 4.0],
        'sensors.names': ['gyro'],
        'sensors.gyro.integrating': True,
    }
    for _ in simulate(Scenario(values), 5, tmp_path / 'bag'):
        pass
    counted = Segment.states

    def folded(*given, **more):
        states = counted(*given, **more)
        assert states.turn_b is not None
        return replace(states, turn_b=states.turn_b - [0.0, 0.0, 2.0 * np.pi])

    monkeypatch.setattr(Segment, 'states', folded)
    errors = history(tmp_path / 'bag').sensors['gyro'].error
    np.testing.assert_allclose(errors[1:], [[0.0, 0.0, -2.0 * np.pi]] * 4, atol=1e-11)


def test_panels(bag):
    """Lines are the errors, dashed ones three sigma about the bias; drawn without being asked."""
    pytest.importorskip('matplotlib')
    run = history(bag)
    figure = draw(run)
    assert len(figure.axes) == 6
    for axes, name, unit in zip(
        figure.axes[4:], ('gyro', 'star_tracker'), (1e-3, np.radians(1 / 3600)), strict=True
    ):
        errors = run.sensors[name]
        lines = [line for line in axes.get_lines() if np.size(line.get_xdata()) == len(errors.t_s)]
        for k in range(3):
            error, low, high = (line.get_ydata() * unit for line in lines[3 * k : 3 * k + 3])
            np.testing.assert_allclose(error, errors.error[:, k], atol=1e-15)
            np.testing.assert_allclose(high - low, 6.0 * errors.sigma[k], atol=1e-12)
            np.testing.assert_allclose((high + low) / 2, errors.systematic[:, k], atol=1e-12)
    assert 'mrad/s' in figure.axes[4].get_ylabel()
    assert 'arcsec' in figure.axes[5].get_ylabel()


def test_sensors_of_a_kind_are_drawn_to_one_scale(tmp_path):
    """Of two gyros with noise a hundredfold apart: that of the coarser, on plot and page."""
    pytest.importorskip('matplotlib')
    names = ['fine', 'coarse', 'star_tracker']
    gyros = {
        f'sensors.{name}.{key}': value
        for name, noise in (('fine', 1e-5), ('coarse', 1e-3))
        for key, value in (('type', 'gyro'), ('noise_density', noise))
    }
    others = {'sensors.names': names, 'sensors.star_tracker.roll': 1e-4, 'time.epoch_ns': 10**9}
    for _ in simulate(Scenario(gyros | others), 10.0, tmp_path / 'bag'):
        pass
    run = history(tmp_path / 'bag')
    fine, coarse, _ = (axes.get_ylim() for axes in draw(run, names).axes)
    assert fine == coarse
    page = playable(run)['sensors']
    most = np.abs(run.sensors['coarse'].error).max()
    assert most <= page['fine']['largest'] == page['coarse']['largest'] < 1.5 * most
    assert page['star_tracker']['largest'] is None


def test_no_line_goes_across_a_pause(bag):
    """Without the measurements of ten seconds: a gap there, and all others as they were."""
    errors = history(bag).sensors['star_tracker']
    kept = (errors.t_s < 40.0) | (errors.t_s > 50.0)
    paused = replace(
        errors, t_s=errors.t_s[kept], error=errors.error[kept], systematic=errors.systematic[kept]
    )
    drawn = with_gaps(paused)
    measured = np.isfinite(drawn.error[:, 0])
    np.testing.assert_array_equal(drawn.error[measured], paused.error)
    np.testing.assert_array_equal(drawn.t_s[measured], paused.t_s)
    (gap_s,) = drawn.t_s[~measured]
    assert 39.0 < gap_s < 50.0
    assert len(with_gaps(errors).t_s) == len(errors.t_s)


def test_a_run_without_sensors_is_refused(tmp_path):
    """The panel of a sensor that the run does not have: one sentence."""
    pytest.importorskip('matplotlib')
    for _ in simulate(Scenario({'time.epoch_ns': 10**9}), 1, tmp_path / 'bag'):
        pass
    with pytest.raises(ValueError, match='the panel is gyro; allowed: attitude, rates'):
        plot(tmp_path / 'bag', tmp_path / 'gyro.png', ['gyro'])


def test_report_shows_the_errors(bag, tmp_path, browser):
    """The page has a chart of each sensor, whose numbers at a time are the last sample's."""
    report(bag, tmp_path / 'page.html')
    browser.get((tmp_path / 'page.html').as_uri())
    pages.wait(browser, 'window.satdyn && satdyn.stage.scene.frames.length > 0')
    browser.execute_script('satdyn.timeline.seek(77.71)')
    charts = {
        chart.find_element('tag name', 'b').text: chart
        for chart in browser.find_elements('css selector', '.chart')
    }
    run = history(bag).sensors
    for title, name, unit in (
        ('gyro error, 3 σ', 'gyro', 1e-3),
        ('star tracker error, 3 σ', 'star_tracker', np.radians(1.0 / 3600.0)),
    ):
        shown = charts[title].find_elements('css selector', 'output')
        numbers = [float(element.text.replace('−', '-')) for element in shown]
        errors = run[name]
        last = np.flatnonzero(errors.t_s <= 77.71)[-1]
        # Shown are four digits of the largest.
        largest = np.abs(errors.error).max() / unit
        np.testing.assert_allclose(numbers, errors.error[last] / unit, atol=1e-3 * largest)
    assert pages.errors(browser) == []

"""Figures of bags: what they show is what the run says."""

import numpy as np
import pytest

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.dynamics import rotation
from satdyn_ros.report.history import history
from satdyn_ros.report.plot import PANELS, draw, plot
from satdyn_ros.run.events import Request
from satdyn_ros.run.scenario import Scenario

matplotlib = pytest.importorskip('matplotlib')

SCENARIO = Scenario.from_dict(
    {
        'publish': {'rate': 1.0, 'topics': ['attitude']},
        'time': {'epoch_ns': 10**18},
        'rotor': {'mode': 'free', 'inertia': 0.5, 'speed': 10.0},
    }
)
EVENTS = [Request(6000, {'initial.angular_velocity': [0.0, 0.0005, 0.0]})]


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp('plot') / 'bag'
    for _ in simulate(SCENARIO, 12000, path, EVENTS):
        pass
    return path


def test_history_thins_the_rows_not_the_numbers(bag):
    """A row in ten keeps the states' bits and the drift of all ticks."""
    every, tenth = history(bag, 12000), history(bag, 1200)
    assert (len(every.t_s), len(tenth.t_s)) == (12000, 1200)
    np.testing.assert_array_equal(tenth.states.q_ib, every.states.q_ib[::10])
    assert tenth.largest_drift == every.largest_drift
    for name, values in tenth.drift.items():
        np.testing.assert_array_equal(values, every.drift[name][::10])
    # The motion of the request begins with no drift.
    assert every.drift['jacobi'][6000] == 0.0
    assert [t_s for t_s, _ in every.events] == [6000.0]


def test_lines_are_the_run(bag):
    """The lines of the attitude are roll, pitch and yaw in degrees over hours."""
    run = history(bag, 1200)
    lines = draw(run, ['attitude']).axes[0].get_lines()
    states = SCENARIO.motion().at(run.t_s[run.t_s < 6000.0])
    truth = np.degrees(rotation.roll_pitch_yaw(states.q_lb))
    for line, column in zip(lines[:3], truth.T, strict=True):
        assert line.get_label() in ('roll', 'pitch', 'yaw')
        np.testing.assert_allclose(line.get_ydata()[: len(column)], column, atol=1e-9)
        np.testing.assert_allclose(line.get_xdata() * 3600.0, run.t_s)


def test_every_panel_has_units(bag):
    """Every axis of every panel says its unit, and the events are marked."""
    figure = draw(history(bag), PANELS)
    for axes in figure.axes:
        labels = [axes.get_ylabel(), axes.get_zlabel() if hasattr(axes, 'get_zlabel') else '[]']
        assert all('[' in label for label in labels)
        dashed = [line for line in axes.get_lines() if len(set(line.get_xdata())) == 1]
        if axes.get_shared_x_axes().get_siblings(axes)[1:]:
            assert [line.get_xdata()[0] for line in dashed] == [6000.0 / 3600.0]
    assert '[h]' in figure.axes[len(PANELS) - 3].get_xlabel()


@pytest.mark.parametrize('kind', ['png', 'pdf', 'svg'])
def test_file(bag, tmp_path, kind):
    """A figure is written as its name says."""
    plot(bag, tmp_path / f'figure.{kind}')
    assert (tmp_path / f'figure.{kind}').stat().st_size > 10000


def test_refused(bag, tmp_path):
    """An unknown panel, a kind of image that is none, and a bag that is none: one sentence."""
    with pytest.raises(ValueError, match='the panel is nonsense; it takes attitude'):
        plot(bag, tmp_path / 'figure.png', ['nonsense'])
    with pytest.raises(ValueError, match='cannot be drawn'):
        plot(bag, tmp_path / 'figure.xyz')
    with pytest.raises(ValueError, match='is no bag'):
        plot(tmp_path / 'none', tmp_path / 'figure.png')

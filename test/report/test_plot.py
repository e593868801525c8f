"""Figures of bags: what they show is what the run says."""

import re
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest
from commands import motor_command, torque_command

from satdyn_ros import environment
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.cli import command_line
from satdyn_ros.cli.main import main
from satdyn_ros.exchange.aem import AemWriter
from satdyn_ros.exchange.ccsds import Subject
from satdyn_ros.kernel import rotation
from satdyn_ros.report import panels
from satdyn_ros.report.envelope import envelope
from satdyn_ros.report.history import history
from satdyn_ros.report.plot import PANELS, draw, draw_beside, plot
from satdyn_ros.run.events import Request, Reset
from satdyn_ros.run.scenario import Scenario

matplotlib = pytest.importorskip('matplotlib')
pytest.importorskip('matplotlib.image')

SCENARIO = Scenario.from_dict(
    {
        'publish': {'rate': 1.0, 'topics': ['attitude']},
        'time': {'epoch_ns': 10**18},
        'rotor': {'mode': 'free', 'inertia': 0.5, 'speed': 10.0},
        'sensors': {'names': ['gyro', 'star_tracker'], 'seed': 1, 'star_tracker': {'roll': 1e-4}},
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
    """A row in ten, and the last, keep the states' bits and the drift of all ticks."""
    every, tenth = history(bag, 12000), history(bag, 1200)
    assert len(every.t_s) == 12000
    chosen = [*range(0, 12000, 10), 11999]
    np.testing.assert_array_equal(tenth.t_s, chosen)
    np.testing.assert_array_equal(tenth.states.q_ib, every.states.q_ib[chosen])
    assert tenth.largest_drift == every.largest_drift
    for name, values in tenth.drift.items():
        np.testing.assert_array_equal(values, every.drift[name][chosen])
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
        x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        np.testing.assert_allclose(y[: len(column)], column, atol=1e-9)
        np.testing.assert_allclose(x * 3600.0, run.t_s)


def test_a_drift_is_drawn_where_its_integral_is_one(tmp_path):
    """While a torque acts there is the balance of energy, and the Jacobi integral before it."""
    for _ in simulate(SCENARIO, 100, tmp_path / 'bag', [torque_command(60, (1e-3, 0.0, 0.0))]):
        pass
    axes = draw(history(tmp_path / 'bag'), ['drift']).axes[0]
    drawn = {line.get_label(): np.isfinite(line.get_ydata()) for line in axes.get_lines()}
    acts = np.arange(100) >= 60
    np.testing.assert_array_equal(drawn['jacobi'], ~acts)
    np.testing.assert_array_equal(drawn['energy balance'], acts)


def segments(marks):
    """Return the lines (N, 2) that are drawn as one collection."""
    assert isinstance(marks, matplotlib.collections.LineCollection)
    return marks.get_segments()


def test_every_panel_has_units(bag):
    """Every axis of every panel says its unit, and the events are marked."""
    # Of loops another run has something to draw.
    figure = draw(history(bag), [name for name in PANELS if name != 'loops'])
    for axes in figure.axes:
        labels = [axes.get_ylabel(), axes.get_zlabel() if hasattr(axes, 'get_zlabel') else '[]']
        assert all('[' in label for label in labels)
        if axes.get_shared_x_axes().get_siblings(axes)[1:]:
            (mark,) = segments(axes.collections[-1])
            assert mark[:, 0].tolist() == [6000.0 / 3600.0] * 2
    assert '[h]' in figure.axes[len(PANELS) - 4].get_xlabel()


def test_loops_are_drawn_inside_the_large_one(tmp_path):
    """A line for each rod with two curves; without rods the panel is refused."""
    rods = Scenario.from_yaml('passive_magnetic').with_values({'publish.rate': 1.0})
    for _ in simulate(rods, 300, tmp_path / 'bag'):
        pass
    (axes,) = draw(history(tmp_path / 'bag'), ['loops']).axes
    legend = axes.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ['rods_x', 'rods_y']
    rod, high, low = (np.array(line.get_data()) for line in axes.get_lines()[:3])
    assert np.all(np.interp(rod[0], *high) >= rod[1])
    assert np.all(np.interp(rod[0], *low) <= rod[1])


def test_loops_need_rods(bag):
    """In one sentence."""
    with pytest.raises(ValueError, match='the panel loops needs hysteresis rods'):
        draw(history(bag), ['loops'])


def test_angles_have_gaps_where_they_wrap(bag):
    """A free body that turns about z at 0.01 rad/s for 6000 s goes through 180 deg ten times."""
    free = {'orbit.type': 'fixed', 'initial.attitude': [0.0, 0.0, 0.0, 1.0]}
    spin = {'initial.angular_velocity': [0.0, 0.0, 0.01], 'publish.rate': 1.0}
    path = bag.parent / 'spun'
    for _ in simulate(Scenario(free | spin | {'time.epoch_ns': 10**18}), 6000, path):
        pass
    run = history(path, 3000)
    yaw = draw(run, ['attitude']).axes[0].get_lines()[2].get_ydata()
    assert np.nanmax(np.abs(np.diff(yaw))) < 2.0
    assert np.count_nonzero(np.isnan(yaw)) == 10
    counted = draw(run, ['attitude'], unwrap=True).axes[0].get_lines()[2].get_ydata()
    np.testing.assert_allclose(np.asarray(counted), np.degrees(0.01 * run.t_s), atol=1e-9)


def reduced(ufunc, values):
    """Return what a function makes of the values of 12000 ticks in rows of ten, and the last."""
    return ufunc.reduceat(values, [*range(0, 12000, 10), 11999])


def test_bounds_hold_all_ticks(bag):
    """A row stands for the least and the most of every tick up to the next row."""
    every, tenth = history(bag, 12000), history(bag, 1200)
    for name in ('attitude', 'rate', 'gravity_gradient', 'rotor_speed'):
        np.testing.assert_array_equal(tenth.least[name], reduced(np.minimum, every.least[name]))
        np.testing.assert_array_equal(tenth.most[name], reduced(np.maximum, every.most[name]))
    omega = np.linalg.norm(every.states.omega_bi_b, axis=-1)
    np.testing.assert_allclose(tenth.turned, reduced(np.add, omega), rtol=1e-12)


def test_mean_is_that_of_all_ticks(bag):
    """Each row has the mean of every tick up to the next; of angles, of their directions."""
    every, tenth = history(bag, 12000), history(bag, 1200)
    counts = reduced(np.add, np.ones(12000))[:, None]
    for name in ('rate', 'gravity_gradient', 'rotor_speed', 'nadir'):
        mean = reduced(np.add, every.mean[name]) / counts
        np.testing.assert_allclose(tenth.mean[name], mean, rtol=1e-12, atol=1e-15)
    directions = reduced(np.add, np.exp(1j * every.mean['attitude']))
    np.testing.assert_allclose(tenth.mean['attitude'], np.angle(directions), atol=1e-12)


def test_what_is_denser_than_the_pixels_is_a_band():
    """A curve of 400 waves has a band and its mean in 130 steps; one of three is a line."""
    x = np.linspace(0.0, 1.0, 4000)
    is_far = np.zeros(4000, bool)
    curve = 3.0 + 2.0 * np.sin(2 * np.pi * 400 * x)
    band = envelope(curve, 130, is_far, (curve, curve, curve))
    assert np.all(band.is_band)
    # Ten rows a wave: a crest is missed by at most half a row.
    np.testing.assert_allclose(band.least, 1.0, atol=2.0 * (1.0 - np.cos(np.pi / 10)))
    np.testing.assert_allclose(band.most, 5.0, atol=2.0 * (1.0 - np.cos(np.pi / 10)))
    # A step has three waves and a part of one, at most half a one, whose integral is 1 / pi.
    np.testing.assert_allclose(band.mean, 3.0, atol=2.0 / np.pi / 3.0)
    slow = 3.0 + 2.0 * np.sin(2 * np.pi * 3 * x)
    assert not np.any(envelope(slow, 130, is_far, (slow, slow, slow)).is_band)
    spun = (360.0 * 400 * x + 180.0) % 360.0 - 180.0
    mean = envelope(spun, 130, is_far, (spun, spun, spun), turns=True).mean
    # It points all ways; what nods about 180 deg has that as its mean, whatever its sign.
    assert np.all(np.isnan(mean))
    nods = 180.0 + 20.0 * np.sin(2 * np.pi * 400 * x)
    nods -= 360.0 * (nods > 180.0)
    mean = envelope(nods, 130, is_far, (nods, nods, nods), turns=True).mean
    np.testing.assert_allclose(np.abs(mean), 180.0, atol=20.0 / np.pi / 3.0)


def test_the_angles_of_the_axis_are_a_choice(bag):
    """The panel nadir has the angle of the least axis, attitude too, and rates |omega|."""
    run = history(bag, 1200)
    attitude, nadir, rates = draw(run, ['attitude', 'nadir', 'rates']).axes
    # The body's axis of least inertia is z.
    assert run.q_lb is not None
    z_l = rotation.rotate(run.q_lb, np.array([0.0, 0.0, 1.0]))
    truth = np.degrees(np.arccos(np.abs(z_l[:, 2])))
    for axes in (attitude, nadir):
        lines = {line.get_label(): np.asarray(line.get_ydata()) for line in axes.get_lines()}
        # An arc cosine near one.
        np.testing.assert_allclose(lines['axis to nadir'], truth, atol=1e-6)
    parts = np.sin(np.radians([lines['along track'], lines['to the orbit normal']]))
    np.testing.assert_allclose(parts, [z_l[:, 0], -z_l[:, 1]] * np.sign(z_l[:, 2]), atol=1e-12)
    speed = np.asarray(rates.get_lines()[3].get_ydata())
    omega = np.linalg.norm(run.states.omega_bi_b, axis=-1)
    np.testing.assert_allclose(np.radians(speed), omega, rtol=1e-12)
    free = replace(run, q_lb=None)
    with pytest.raises(ValueError, match='the panel nadir needs LVLH'):
        draw(free, ['nadir'])


def test_fast_body_is_a_band(bag):
    """Where the body turns too far between two rows there is no line; turns are not counted."""
    fast = SCENARIO.with_values({'initial.angular_velocity': [0.0, 0.0, 0.5]})
    path = bag.parent / 'fast'
    for _ in simulate(fast, 1000, path):
        pass
    run = history(path, 100)
    axes = draw(run, ['attitude']).axes[0]
    lines = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
    assert all(np.all(np.isnan(lines[name])) for name in ('roll', 'pitch', 'yaw'))
    assert len(axes.collections) == 4
    with pytest.raises(ValueError, match='unwrap cannot count the turns'):
        draw(run, ['attitude'], unwrap=True)
    assert not np.any(history(path, 100, 0.0, run.window_s - 1.0).turns_too_far)


def test_torques_are_shaded_and_restarts_marked(bag):
    """A stream of torques is one shaded interval, from the first to its timeout."""
    path = bag.parent / 'driven'
    stream = [torque_command(k, (0.001 * k, 0.0, 0.0), 601) for k in range(100, 600)]
    for _ in simulate(SCENARIO, 1200, path, [*stream, Reset(900)]):
        pass
    run = history(path)
    assert run.driven == [(100.0, 601.0)]
    axes = draw(run, ['rates']).axes[0]
    shades, marks = axes.collections
    minutes = panels.time_unit(run)[0]
    (shade,) = shades.get_paths()
    width = [100.0 / minutes, 601.0 / minutes]
    np.testing.assert_allclose(shade.get_extents().intervalx, width, rtol=1e-15)
    assert [mark[:, 0].tolist() for mark in segments(marks)] == [[900.0 / minutes] * 2]
    unmarked = draw(replace(run, events=[], driven=[]), ['rates']).axes[0]
    assert axes.get_ylim() == unmarked.get_ylim()


@pytest.mark.long
def test_thousands_of_restarts_are_one_mark_each(bag):
    """However many there are at one tick."""
    path = bag.parent / 'restarted'
    for _ in simulate(SCENARIO, 100, path, [Reset(k) for k in range(100) for _ in range(30)]):
        pass
    (marks,) = draw(history(path), ['rates']).axes[0].collections
    assert len(segments(marks)) == 100


@pytest.mark.parametrize('rows', [1, 7, 100, 4000])
def test_a_figure_ends_at_the_last_tick(bag, rows):
    """Whatever the rows: from 3 s to 1234 s of 1 Hz the axis, the curves and the span do."""
    run = history(bag, rows, 3.0, 1234.0)
    assert (run.t_s[0], run.t_s[-1], run.span_s) == (3.0, 1234.0, 1231.0)
    axes = draw(run, ['rates']).axes[0]
    seconds, _ = panels.time_unit(run)
    assert axes.get_xlim() == (3.0 / seconds, 1234.0 / seconds)
    assert np.asarray(axes.get_lines()[0].get_xdata())[-1] == 1234.0 / seconds


def test_where_a_rotor_meets_its_limits_is_marked(bag):
    """
    By hand: 2 N m are cut to 1 N m at 10 s, which bring 0.5 kg m^2 from 10 to 20 rad/s in 5 s.

    That is recorded at the first tick after it.  Instants closer than a pixel or so are one mark.
    """
    wheel = {'rotor.inertia': 0.5, 'rotor.max_torque': 1.0, 'rotor.max_speed': 20.0}
    body = {'body.inertia': [1e6, 1e6, 1e6], 'torque.timeout': 0.0}
    scenario = SCENARIO.with_values({'rotor.mode': 'motor', 'rotor.axis': [0.0, 1.0, 0.0]} | wheel)
    path = bag.parent / 'limited'
    stream = [motor_command(k, {'rotor': 2.0}) for k in (10, *range(600, 700))]
    for _ in simulate(scenario.with_values(body), 1200, path, stream):
        pass
    run = history(path)
    (first, speed, again) = run.limited
    assert first == (10.0, 10.0)
    assert speed[0] == speed[1]
    assert speed[0] in (15.0, 16.0)
    assert again == (600.0, 699.0)
    edge = draw(run, ['rates']).axes[0].collections[-1]
    seconds, _ = panels.time_unit(run)
    spans = [np.array(drawn.get_extents().intervalx) * seconds for drawn in edge.get_paths()]
    np.testing.assert_allclose(spans, run.limited)


def test_a_part_is_drawn(bag):
    """From begin to end, both included; a part that the bag does not hold is refused."""
    run = history(bag, begin_s=100.5, end_s=200.0)
    assert (run.t_s[0], run.t_s[-1], run.ticks) == (101.0, 200.0, 100)
    whole = history(bag, 12000)
    np.testing.assert_array_equal(run.states.q_ib, whole.states.q_ib[101:201])
    np.testing.assert_array_equal(run.drift['jacobi'], whole.drift['jacobi'][101:201])
    with pytest.raises(ValueError, match='has no ticks within --begin 20000; it holds those'):
        history(bag, begin_s=20000.0)
    for begin_s in (nan, -inf):
        with pytest.raises(ValueError, match=f'--begin is {begin_s}; it must be a finite number'):
            history(bag, begin_s=begin_s)


def test_help_lists_the_panels(bag):
    """`satdyn plot --help` names every panel, those of the figure as it comes first."""
    named = re.findall(r'^  (\w+)   +', command_line._PANELS, re.MULTILINE)
    assert tuple(named) == (*PANELS, 'NAME_torque', 'SENSOR', 'geodetic')
    run = history(bag, 100)
    first, as_it_comes = (
        [axes.get_ylabel() for axes in draw(run, what).axes] for what in (PANELS[:4], ())
    )
    assert first == as_it_comes[:4]


@pytest.mark.parametrize(
    'kind',
    ['png', *(pytest.param(kind, marks=pytest.mark.long) for kind in ('pdf', 'svg'))],
)
def test_file(bag, tmp_path, kind):
    """A figure is written as its name says."""
    plot(bag, tmp_path / f'figure.{kind}')
    assert (tmp_path / f'figure.{kind}').stat().st_size > 10000


def test_refused(bag, tmp_path):
    """An unknown panel, a kind of image that is none, and a bag that is none: one sentence."""
    with pytest.raises(ValueError, match='the panel is nonsense; allowed: attitude'):
        plot(bag, tmp_path / 'figure.png', ['nonsense'])
    with pytest.raises(ValueError, match='cannot be drawn'):
        plot(bag, tmp_path / 'figure.xyz')
    with pytest.raises(ValueError, match='is not a bag'):
        plot(tmp_path / 'none', tmp_path / 'figure.png')


def test_the_track_is_where_the_body_is(tmp_path):
    """A line through all points, once around; what is in the umbra is dashed, and UTC is there."""
    given = {
        'publish': {'rate': 0.1, 'topics': ['attitude', 'geodetic']},
        'environment': {'sun': 'ephemeris'},
        'orbit': {'altitude': 500e3, 'inclination': 1.7},
        'time': {'epoch': '2026-03-20T06:00:00Z'},
    }
    scenario = Scenario.from_dict(given)
    for _ in simulate(scenario, 8500, tmp_path / 'bag'):
        pass
    run = history(tmp_path / 'bag')
    rates, track = draw(run, ['rates', 'geodetic']).axes
    stamps_ns = scenario.epoch_ns + np.rint(run.t_s * 1e9).astype(np.int64)
    r_t = environment.turned(environment.gcrs_to_itrs(stamps_ns), run.states.r_i)
    truth = np.degrees(environment.geodetic(r_t)[1::-1]).T
    lines = {line.get_label(): np.array(line.get_data()).T for line in track.get_lines()}
    is_dark = environment.lit_fraction(run.states.r_i, environment.sun_position(stamps_ns)) == 0.0
    assert 0.2 < np.mean(is_dark) < 0.5
    for label, chosen in (('in sunlight', ~is_dark), ('in the umbra', is_dark)):
        line = lines[label][np.isfinite(lines[label][:, 0])]
        apart = np.linalg.norm(truth[chosen][:, None] - line, axis=-1).min(axis=1)
        # The tables of the environment, and a row on the edge of the umbra.
        assert np.sort(apart)[-4] < 1e-4
    assert np.nanmax(np.abs(np.diff(lines['in sunlight'][:, 0]))) < 100.0
    assert lines['from 2026-03-20 06:00:00 UTC'] == pytest.approx(truth[:1], abs=1e-4)
    (utc,) = rates.child_axes
    assert utc.get_xlabel() == 'UTC'


def test_there_is_no_map_without_a_position(bag):
    """It is not drawn, and asking for it says what there is."""
    assert len(draw(history(bag)).axes) == 6
    with pytest.raises(ValueError, match='the panel is geodetic; allowed: '):
        plot(bag, bag.parent / 'map.png', ['geodetic'])


def message_beside(bag, path, turn_rad, rows=slice(None)):
    """Write an AEM of the bag's attitudes, turned about the body's z axis, by scipy."""
    from scipy.spatial.transform import Rotation

    run = history(bag, 1200)
    stamps_ns = 10**18 + np.rint(run.t_s * 1e9).astype(np.int64)
    q_ib = Rotation.from_quat(run.states.q_ib) * Rotation.from_rotvec([0.0, 0.0, turn_rad])
    with open(path, 'w+') as file:
        writer = AemWriter(file, Subject('SAT'))
        writer.write(stamps_ns[rows], q_ib.as_quat()[rows], np.zeros((len(stamps_ns[rows]), 3)))
        writer.end_segment()
    return path


def test_the_angle_to_another_tools_attitude_is_drawn(bag, tmp_path):
    """Of a message that is turned by 2 deg and ends halfway: 2 deg up to there, then nothing."""
    path = message_beside(bag, tmp_path / 'other.aem', np.radians(2.0), slice(0, 600))
    run = history(bag, 1200)
    axes = draw(run, ['attitude'], against=path).axes[-1]
    assert axes.get_ylabel() == 'angle [deg]'
    angle = np.asarray(axes.get_lines()[0].get_ydata())
    np.testing.assert_allclose(angle[:600], 2.0, rtol=0.0, atol=1e-12)
    assert np.all(np.isnan(angle[600:]))


def test_several_bags_are_drawn_side_by_side(bag, tmp_path):
    """By the command: twice as wide as one, with the angle below each."""
    path, one, two = (tmp_path / name for name in ('same.aem', 'one.png', 'two.png'))
    message_beside(bag, path, 0.0)
    what = ['--what', 'attitude', '--against', str(path)]
    assert main(['plot', str(bag), '-o', str(one), *what]) == 0
    assert main(['plot', str(bag), str(bag), '-o', str(two), *what]) == 0
    (height, width), (height_of_two, width_of_two) = (
        matplotlib.image.imread(each).shape[:2] for each in (one, two)
    )
    assert width_of_two == 2 * width
    # The name of each bag stands above it.
    assert 0 < height_of_two - height < 100


def test_bags_side_by_side_have_one_scale(bag, tmp_path):
    """Where they show the same in the same unit: curves are there to be compared."""
    slow = SCENARIO.with_values({'initial.angular_velocity': [0.0, 0.0, 1e-4]})
    for _ in simulate(slow, 1200, tmp_path / 'slow'):
        pass
    runs = [history(each, 1200) for each in (bag, tmp_path / 'slow')]
    figure = draw_beside(['bag', 'slow'], runs, ['attitude', 'rates'])
    left, right = (part.axes for part in figure.subfigs)
    alone = draw(runs[1], ['attitude', 'rates']).axes
    for axes, other, by_itself in zip(left, right, alone, strict=True):
        assert axes.get_ylabel() == other.get_ylabel() == by_itself.get_ylabel()
        assert axes.get_ylim() == other.get_ylim() != by_itself.get_ylim()
        low, high = axes.get_ylim()
        for line in (*axes.get_lines(), *other.get_lines()):
            shown = np.asarray(line.get_ydata(), float)
            assert np.all((low <= shown) & (shown <= high))


def test_attitudes_of_another_time_are_refused(bag, tmp_path, capsys):
    """In one sentence with the file; so is a file that is none."""
    path = message_beside(bag, tmp_path / 'other.aem', 0.0)
    path.write_text(re.sub(r'(?m)\b2001-', '2002-', path.read_text()))
    for text, sentence in (
        (path.read_text(), 'has no attitude at a tick from 2001-09-09T01:46:40'),
        ('CCSDS_AEM_VERS = 2.0\nMETA\n', r'other\.aem: line 2: a row that begins with META'),
    ):
        path.write_text(text)
        out = tmp_path / 'x.png'
        assert main(['plot', str(bag), '-o', str(out), '--against', str(path)]) == 2
        said = capsys.readouterr().err
        assert re.search(sentence, said)
        assert said.count('\n') == 1
        assert not out.exists()

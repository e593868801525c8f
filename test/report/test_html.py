"""The report opened as a user opens it: in a browser, from a file, without network."""

import re

import browser as pages
import numpy as np
import pytest
from commands import motor_command, torque_command

from satdyn_ros import environment
from satdyn_ros.bag.simulate import simulate
from satdyn_ros.kernel import rotation
from satdyn_ros.report.history import history
from satdyn_ros.report.html import TABLE_ROWS, playable, report
from satdyn_ros.run.events import Request, Reset
from satdyn_ros.run.scenario import Scenario

EVENTS = [
    torque_command(50000, (0.0, 0.02, 0.0), 60000),
    Request(300000, {'initial.angular_velocity': [0.0, 0.0005, 0.0]}),
]


def bag(path, duration_s, given, events=()):
    """Write a bag of a scenario."""
    scenario = Scenario.from_dict({'time': {'epoch_ns': 10**18}} | given)
    for _ in simulate(scenario, duration_s, path, list(events)):
        pass
    return path


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp('report')


@pytest.fixture(scope='module')
def long_bag(folder):
    """Return a bag of a million messages."""
    return bag(
        folder / 'bag',
        10000,
        {
            'publish': {'rate': 50.0, 'topics': ['attitude', 'imu']},
            'rotor': {'mode': 'free', 'inertia': 0.5, 'speed': 40.0},
        },
        EVENTS,
    )


@pytest.fixture(scope='module')
def page(long_bag, folder):
    report(long_bag, folder / 'report.html')
    return folder / 'report.html'


def opened(browser, page):
    """Open a page and wait until the scene was drawn."""
    browser.get(page.as_uri())
    pages.wait(browser, 'window.satdyn && satdyn.stage.scene.frames.length > 0')


def test_page_needs_nothing_else(page):
    """A bag of a million messages gives less than 10 MB that loads nothing from anywhere."""
    text = page.read_text()
    assert page.stat().st_size < 10e6
    # From the first tick to the last, whichever rows are drawn.
    assert '500000 ticks at 50 Hz, 9999.98 s; 15626 of them are drawn' in text
    assert not re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="(?!data:)', text)
    assert 'jacobi' in text
    assert 'no closed form' in text


def test_says_what_differs_from_the_defaults(page):
    """The table of the scenario has what was given, without the defaults."""
    rows = re.findall(r'<tr><td>([a-z.]+)</td>', page.read_text())
    assert {'rotor.mode', 'rotor.speed', 'publish.rate'} <= set(rows)
    assert not {'body.inertia', 'orbit.mu', 'frames.body'} & set(rows)
    assert 'applied torque until 1200 s' in page.read_text()


def test_shows_the_motion(long_bag, page, browser):
    """At any time the page has the attitude, and the angles, that the motion has there."""
    opened(browser, page)
    run = history(long_bag, TABLE_ROWS)
    for t_s in (0.0, 2345.6, 7000.0):
        q_ib = browser.execute_script(
            f'satdyn.timeline.seek({t_s}); return satdyn.stage.scene.row.q_ib'
        )
        begin = max(tick for tick in run.motions if tick / 50.0 <= t_s)
        states = run.motions[begin].at(t_s - begin / 50.0)
        # Half the spacing of float32 at 1, four components; between rows a chord in place of
        # the arc, (0.6 s * 0.04 rad/s)^2 / 8.
        assert rotation.angle_between(np.array(q_ib), states.q_ib[0]) < 1e-4
        shown = browser.find_element('css selector', '.chart .keys').text.replace('−', '-')
        angles = [float(x) for x in re.findall(r'(-?\d+\.\d+)', shown)]
        orbit = states.orbit.lvlh(t_s)
        truth = rotation.roll_pitch_yaw(
            rotation.multiply(rotation.conjugate(orbit), states.q_ib[0])
        )
        z_l = rotation.rotate(states.q_lb[0], [0.0, 0.0, 1.0])
        nadir = np.arccos(abs(z_l[2]))
        np.testing.assert_allclose(angles, np.degrees([*truth, nadir]), atol=0.06)


def test_play_and_scrub(page, browser):
    """Play moves body, clock and cursor on; keys and clicks seek; the console is silent."""
    opened(browser, page)
    clock = browser.find_element('class name', 'clock')
    before = browser.execute_script('return satdyn.stage.scene.row.q_ib')
    browser.find_element('class name', 'play').click()
    pages.wait(browser, f'satdyn.stage.scene.row.q_ib[0] !== {before[0]}')
    browser.find_element('class name', 'play').click()
    assert browser.find_element('class name', 'play').get_attribute('aria-label') == 'play'
    browser.execute_script(
        "const slider = document.querySelector('.timeline input'); slider.value = 500000;"
        "slider.dispatchEvent(new Event('input'))"
    )
    assert float(clock.text.split()[0]) == pytest.approx(5000.0 / 60.0, abs=0.01)
    key = (
        "document.body.dispatchEvent(new KeyboardEvent('keydown', {key: '%s', bubbles: true}));"
        'return [satdyn.timeline.time, satdyn.timeline.isPlaying]'
    )
    assert browser.execute_script(key % 'ArrowRight')[0] > 5000.0
    assert browser.execute_script(key % ' ')[1] is True
    assert browser.execute_script(key % ' ')[1] is False
    chart = browser.find_element('css selector', '.chart .u-over')
    chart.click()
    assert browser.execute_script('return satdyn.timeline.time') == pytest.approx(5000, abs=50)
    marks = browser.find_elements('css selector', '.marks i')
    assert [mark.get_attribute('class') for mark in marks] == ['driven', 'restart']
    assert pages.errors(browser) == []


def test_what_happens_at_one_instant_has_one_mark(folder):
    """The table lists the first of the events one by one, and how many there are."""
    path = bag(folder / 'resets', 10, {'publish': {'rate': 1.0}}, [Reset(5)] * 1000)
    assert playable(history(path, TABLE_ROWS))['marks']['events'] == [
        {'t_s': 5.0, 'kind': 'restart'}
    ]
    report(path, folder / 'resets.html')
    text = (folder / 'resets.html').read_text()
    assert text.count('reset: true') == 200
    assert '<td>800 more</td>' in text


def test_limits_of_rotors_are_marked_and_listed(folder, browser):
    """
    By hand: 2 N m are cut to 1 N m at 10 s, which bring 0.5 kg m^2 from 10 to 20 rad/s in 5 s.

    That is recorded at the first tick after it.  The charts have it at their upper edge.
    """
    wheel = {'mode': 'motor', 'axis': [0.0, 1.0, 0.0], 'inertia': 0.5, 'speed': 10.0}
    path = bag(
        folder / 'limited',
        100,
        {
            'publish': {'rate': 1.0, 'topics': ['attitude']},
            'body': {'inertia': [1e6, 1e6, 1e6]},
            'rotor': {**wheel, 'max_torque': 1.0, 'max_speed': 20.0},
        },
        [motor_command(k, {'rotor': 2.0}) for k in (10, 11, 90)],
    )
    report(path, folder / 'limited.html')
    text = (folder / 'limited.html').read_text()
    assert '<td>10</td><td>rotor meets its max_torque, 3 times until 90 s</td>' in text
    (met_s,) = re.findall(r'<td>(\d+)</td><td>rotor meets its max_speed', text)
    assert met_s in ('15', '16')
    opened(browser, folder / 'limited.html')
    marks = browser.find_elements('css selector', '.marks i.limited')
    assert len(marks) == len(playable(history(path, TABLE_ROWS))['marks']['limited']) > 2
    assert pages.errors(browser) == []


def test_pixels_are_sharp_where_they_are_slow(page, browser):
    """Drawn in software, each pixel of the picture is one of the screen, and edges are smooth."""
    pages.resize(browser, 1280, 720)
    opened(browser, page)
    browser.find_element('class name', 'play').click()
    pages.wait(browser, 'satdyn.stage.scene.frames.length > 5')
    width, box, is_smooth = browser.execute_script(
        'const { canvas, width, renderer } = satdyn.stage.scene;'
        'return [canvas.width, width, renderer.getContext().getContextAttributes().antialias]'
    )
    assert width == int(box)
    assert is_smooth


@pytest.mark.parametrize('apart_s', [3750, pytest.param(1250, marks=pytest.mark.long)])
@pytest.mark.parametrize('size', [(1280, 720), (390, 844)])
@pytest.mark.parametrize('view', ['orbit', 'body', 'space'])
def test_labels_lie_neither_on_one_another_nor_on_the_body(page, browser, size, view, apart_s):
    """On a screen and on a phone, in every view and all along the run."""
    pages.resize(browser, *size)
    opened(browser, page)
    browser.find_element('css selector', f'[data-view={view}]').click()
    for t_s in range(0, 10000, apart_s):
        drawn = 'satdyn.stage.scene.frames.length'
        count = browser.execute_script(f'const n = {drawn}; satdyn.timeline.seek({t_s}); return n')
        pages.wait(browser, f'{drawn} !== {count}')
        assert len(pages.wait_for_labels(browser)) >= 5
    width = browser.execute_script('return document.documentElement.scrollWidth')
    assert width == size[0]


def test_controls_have_names(page, browser):
    """Every control of the page says to a screen reader what it is."""
    opened(browser, page)
    controls = browser.find_elements('css selector', 'button, input, select')
    assert len(controls) >= 10
    assert all(control.accessible_name for control in controls)


def test_follows_the_colours_of_the_system(page, browser):
    """Dark and light differ, and a change while the page is open is taken."""
    pages.resize(browser, 1280, 720, 'dark')
    opened(browser, page)
    solid = 'satdyn.stage.scene.solid.children[0].material[0].color.getHexString()'
    page_colour = 'getComputedStyle(document.body).backgroundColor'
    dark = [browser.execute_script(f'return {colour}') for colour in (solid, page_colour)]
    pages.resize(browser, 1280, 720, 'light')
    for colour, before in zip((solid, page_colour), dark, strict=True):
        pages.wait(browser, f'{colour} !== "{before}"')


def test_what_is_denser_than_the_pixels_is_a_band(folder, browser):
    """Hundreds of turns are a band with a mean, a part of them lines; |omega| is there."""
    path = bag(
        folder / 'tumbling',
        20000,
        {
            'publish': {'rate': 1.0, 'topics': ['attitude']},
            'body': {'inertia': [100.0, 200.0, 250.0]},
            'initial': {'frame': 'inertial', 'angular_velocity': [0.06, 0.06, 0.06]},
        },
    )
    report(path, folder / 'tumbling.html')
    pages.resize(browser, 1280, 720)
    opened(browser, folder / 'tumbling.html')
    rates = 'satdyn.charts.charts[1].plot.data'
    seen = f'{rates}.slice(1, 4).map((line) => line.filter((y) => y !== null).length)'
    assert browser.execute_script(f'return {seen}') == [0, 0, 0]
    run = history(path, TABLE_ROWS)
    speed = np.degrees(np.linalg.norm(run.states.omega_bi_b, axis=-1))
    # After the times four lines, the edges of four bands, four means.
    means = np.array(browser.execute_script(f'return {rates}[12]'), float)
    assert np.all((speed.min() <= means) & (means <= speed.max()))
    edges = np.array(browser.execute_script(f'return {rates}.slice(5, 7)'), float)
    x = np.degrees(run.states.omega_bi_b[:, 0])
    # float32
    assert np.all((edges[0] <= x + 1e-6) & (x - 1e-6 <= edges[1]))
    assert (edges[0].min(), edges[1].max()) == pytest.approx((x.min(), x.max()), rel=1e-6)
    browser.execute_script("satdyn.charts.charts[1].plot.setScale('x', {min: 5000, max: 6000})")
    # A row in two.
    pages.wait(browser, f'{seen}.every((count) => count > 450)')


def test_the_angles_are_a_choice(page, browser):
    """In place of roll, pitch and yaw the chart has the angle of the least axis and its parts."""
    opened(browser, page)
    chart = '.chart:first-child'
    choice = browser.find_element('css selector', f'{chart} select')
    assert 'roll' in browser.find_element('css selector', f'{chart} .keys').text
    pages.choose(choice, 'axis to nadir')
    pages.wait(
        browser, f"document.querySelector('{chart} .keys').textContent.includes('along track')"
    )
    shown = browser.find_element('css selector', f'{chart} .keys').text.replace('−', '-')
    angles = [float(x) for x in re.findall(r'(-?\d+\.\d+)', shown)]
    # The default scenario: its third axis leans as LVLH is turned by 5 deg about x, 10 about y.
    lean = np.sin(np.radians(10.0)) * np.cos(np.radians(5.0))
    normal = np.sin(np.radians(5.0))
    truth = np.degrees([np.arcsin(np.hypot(lean, normal)), np.arcsin(lean), np.arcsin(normal)])
    np.testing.assert_allclose(angles, truth, atol=0.06)


@pytest.mark.long
def test_fast_body_is_a_band(folder, browser):
    """Where a row spans more than a quarter turn there are bands, and a window to choose."""
    path = bag(
        folder / 'fast',
        20000,
        {
            'publish': {'rate': 10.0, 'topics': ['attitude']},
            'initial': {'angular_velocity': [0.0, 0.3, 2.0]},
        },
    )
    report(path, folder / 'fast.html')
    opened(browser, folder / 'fast.html')
    assert 'a band from minimum to maximum' in (folder / 'fast.html').read_text()
    notice = browser.find_element('class name', 'notice').text
    ((begin_s, end_s),) = re.findall(r'--begin (\d+) --end (\d+)', notice)
    lines = 'satdyn.charts.charts[0].plot.data'
    assert browser.execute_script(f'return {lines}[1].every((y) => y === null)')
    most = browser.execute_script(f'return Math.max(...{lines}[6])')
    run = history(path, TABLE_ROWS)
    assert most == pytest.approx(np.degrees(run.most['attitude'][:, 0].max()), rel=1e-6)

    report(path, folder / 'window.html', float(begin_s), float(end_s))
    opened(browser, folder / 'window.html')
    assert not browser.find_element('class name', 'notice').is_displayed()
    assert browser.execute_script('return satdyn.rows.time(0)') >= float(begin_s)
    part = f'{{min: {begin_s}, max: {float(begin_s) + 10.0}}}'
    browser.execute_script(f"satdyn.charts.charts[0].plot.setScale('x', {part})")
    pages.wait(browser, f'{lines}[1].some((y) => y !== null)')


@pytest.mark.long
def test_without_webgl(page):
    """A browser that has no WebGL says so and shows the charts."""
    browser = pages.start('--disable-gpu', '--disable-3d-apis')
    try:
        browser.get(page.as_uri())
        assert 'no WebGL' in browser.find_element('class name', 'notice').text
        browser.execute_script('satdyn.timeline.seek(5000)')
        assert browser.find_element('css selector', '.chart .u-over').is_displayed()
        assert '.' in browser.find_element('css selector', '.chart output').text
    finally:
        browser.quit()


def test_the_page_knows_how_the_earth_is_turned_and_where_the_sun_is(page, browser):
    """From UTC alone, as ERFA has both."""
    pytest.importorskip('erfa')
    opened(browser, page)
    unix_s = np.array([0, 946728000, 1234567890, 1782000000, 2147000000])
    turned, suns = browser.execute_script(
        'const earth = new Earth({ epoch_s: 0, period_s: 1, coast: { lines: [] } });'
        'const at = (what) => arguments[0].map((time) => earth[what](time));'
        "return [at('attitude'), at('sun')]",
        unix_s.tolist(),
    )
    stamps_ns = unix_s * 10**9
    to_itrs = environment.gcrs_to_itrs(stamps_ns)
    for axis in np.eye(3):
        axis_e = environment.turned(to_itrs, rotation.rotate(np.array(turned), axis))
        # Nutation, of 9 arcsec, is left out.
        np.testing.assert_allclose(axis_e, np.broadcast_to(axis, (5, 3)), atol=np.radians(0.003))
    sun_e = environment.turned(to_itrs, environment.sun_position(stamps_ns))
    sun_e /= np.linalg.norm(sun_e, axis=-1, keepdims=True)
    apart = np.degrees(np.linalg.norm(sun_e - suns, axis=-1))
    # What the Almanac says of its formulas.
    assert apart.max() < 0.01


@pytest.fixture(scope='module')
def earth_bag(folder):
    """Return a bag of a revolution and a half, with the position, the field and the Sun."""
    given = {
        'publish': {'rate': 0.1, 'topics': ['attitude', 'geodetic']},
        'environment': {'magnetic_field': 'dipole', 'sun': 'ephemeris'},
        'orbit': {'altitude': 500e3, 'inclination': 1.7},
        'time': {'epoch': '2026-03-20T06:00:00Z'},
    }
    return bag(folder / 'earth', 8500, given)


def test_the_earth_is_shown_at_its_time(earth_bag, browser, folder):
    """The page says UTC, the position and where it is dark; labels keep off its map."""
    run = history(earth_bag)
    report(earth_bag, folder / 'earth.html')
    pages.resize(browser, 1280, 720)
    opened(browser, folder / 'earth.html')
    said = []
    dark = int(np.argmin(run.shown['sunlight'][:, 0]))
    for size, row in (((1280, 720), 100), ((390, 844), dark)):
        pages.resize(browser, *size)
        time_s = run.t_s[row]
        drawn = 'satdyn.stage.scene.frames.length'
        count = browser.execute_script(
            f'const n = {drawn}; satdyn.timeline.seek({time_s}); return n'
        )
        pages.wait(browser, f'{drawn} !== {count}')
        utc = str(np.datetime64('2026-03-20T06:00:00') + int(time_s)).replace('T', ' ')
        pages.wait(browser, f"document.querySelector('.ground time').textContent === '{utc} UTC'")
        latitude, longitude, height_m = run.shown['geodetic'][row]
        position = browser.find_element('class name', 'position').text
        north, east, height_km = re.findall(r'[\d.]+', position)
        assert float(north) == pytest.approx(abs(latitude), abs=0.006)
        assert float(east) == pytest.approx(abs(longitude), abs=0.006)
        assert float(height_km) == pytest.approx(height_m / 1000.0, abs=0.06)
        assert ('S' in position, 'W' in position) == (latitude < 0.0, longitude < 0.0)
        said.append(pages.wait_for_labels(browser))
        width = browser.execute_script('return document.documentElement.scrollWidth')
        assert width == size[0]
    assert 'Sun' in said[0]
    assert 'Sun, behind the Earth' in said[1]
    assert pages.errors(browser) == []

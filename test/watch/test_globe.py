"""All satellites on one globe: where they are, which are not drawn and why, and the way to one."""

import asyncio
import json
from urllib.parse import urlsplit

import aiohttp
import browser as pages
import numpy as np
import pytest
from ros.live import EPOCH_NS, LiveNode, Participant, stamp_ns
from scipy.integrate import quad

from satdyn_ros import environment

MU, RADIUS_M = 3.986004418e14, 6_378_137.0
# Circles of four and two Earth radii, and a body that does not fly.
CIRCLES = {
    '/high': {'semi_major_axis': 4.0 * RADIUS_M, 'inclination': 0.7, 'raan': 2.0},
    '/low': {'semi_major_axis': 2.0 * RADIUS_M, 'inclination': 1.4, 'true_anomaly': 1.0},
}
NODES = {
    namespace: {f'orbit.{name}': value for name, value in elements.items()}
    | {'orbit.type': 'circular', 'publish.topics': ['odometry'], 'publish.rate': 1.0}
    | {'time.factor': 100.0}
    for namespace, elements in CIRCLES.items()
} | {'/still': {'orbit.type': 'fixed', 'orbit.gradient': 0.0, 'initial.frame': 'inertial'}}

pytestmark = pytest.mark.usefixtures('ros')


@pytest.fixture(scope='module')
def url(watch, tmp_path_factory):
    """Return the URL of the page of the three."""
    directory = tmp_path_factory.mktemp('fleet')
    nodes = [LiveNode(directory, values, namespace=name) for name, values in NODES.items()]
    yield watch()
    for node in nodes:
        node.end()


@pytest.fixture
def participant(url):
    participant = Participant('/low')
    yield participant
    participant.close()


def frame(url, is_it):
    """Return the satellites of a frame by their names, of the first frame that is the one."""

    async def hear():
        here = f'http://127.0.0.1:{urlsplit(url).port}'
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f'{here}/socket', max_msg_size=0) as socket,
        ):
            is_chosen = False
            while True:
                message = json.loads((await socket.receive(timeout=60)).data)
                if message['type'] == 'status' and not is_chosen and len(message['nodes']) == 4:
                    assert message['nodes'] == [
                        'all',
                        '/high/satdyn',
                        '/low/satdyn',
                        '/still/satdyn',
                    ]
                    await socket.send_str('{"id": 1, "do": "choose", "node": "all"}')
                    is_chosen = True
                if message['type'] == 'globe':
                    satellites = {each['name']: each for each in message['satellites']}
                    if is_it(satellites):
                        return satellites

    return asyncio.run(asyncio.wait_for(hear(), 300.0))


def are_drawn(satellites):
    return sum('r_i' in each for each in satellites.values()) == len(CIRCLES)


def on_circle(namespace, t_s):
    """Return r_i [m] and v_i [m/s] at a time from tick 0, by the formulas of a circle."""
    of = {'true_anomaly': 0.0, 'raan': 0.0} | CIRCLES[namespace]
    a, i, raan = of['semi_major_axis'], of['inclination'], of['raan']
    n = np.sqrt(MU / a**3)
    u = of['true_anomaly'] + n * t_s
    node = np.array([np.cos(raan), np.sin(raan), 0.0])
    ahead = np.array([-np.sin(raan) * np.cos(i), np.cos(raan) * np.cos(i), np.sin(i)])
    r_i = a * (np.cos(u) * node + np.sin(u) * ahead)
    return r_i, n * a * (np.cos(u) * ahead - np.sin(u) * node)


def test_each_is_where_its_circle_has_it(url):
    """At the time in a frame, position and velocity are those of the formulas; they go on."""
    first = frame(url, are_drawn)
    later = frame(
        url,
        lambda now: are_drawn(now) and now['/low/satdyn']['utc_s'] > first['/low/satdyn']['utc_s'],
    )
    for satellites in (first, later):
        for namespace in CIRCLES:
            satellite = satellites[f'{namespace}/satdyn']
            r_i, v_i = on_circle(namespace, satellite['utc_s'] - EPOCH_NS / 1e9)
            # A Unix time in double precision is good to 0.2 us.
            np.testing.assert_allclose(satellite['r_i'], r_i, rtol=0.0, atol=0.01)
            np.testing.assert_allclose(satellite['v_i'], v_i, rtol=0.0, atol=1e-5)
            assert (satellite['is_paused'], satellite['note']) == (False, '')


def test_what_does_not_fly_is_listed_and_not_drawn(url):
    """The body at a fixed position is not on the globe; the list says why."""
    still = frame(url, lambda now: are_drawn(now) and 'orbit' in now['/still/satdyn']['note'])
    assert 'r_i' not in still['/still/satdyn']
    assert still['/still/satdyn']['note'] == 'not drawn: it has no orbit about the Earth'


def test_a_paused_one_is_where_its_topic_says(url, participant):
    """While it is paused its position is that of its last odometry; nobody is asked anything."""
    messages = participant.listen('odometry')
    participant.hear(messages, 1)
    # At 1 Hz a tick is a second.
    tick = int(participant.switch('pause', True)[1].removeprefix('paused after tick '))
    last_ns = EPOCH_NS + tick * 10**9
    participant.wait_until(lambda: stamp_ns(messages[-1]) == last_ns)
    low = frame(
        url,
        lambda now: (
            now['/low/satdyn']['is_paused'] and now['/low/satdyn'].get('utc_s') == last_ns / 1e9
        ),
    )['/low/satdyn']
    position = messages[-1].pose.pose.position
    np.testing.assert_allclose(
        low['r_i'], [position.x, position.y, position.z], rtol=0.0, atol=0.01
    )
    assert participant.switch('pause', False)[0]


@pytest.mark.long
def test_of_two_nodes_of_one_name_neither_is_drawn(url, tmp_path):
    """The list says that there are two; once one has left, the other is on its circle again."""
    twin = LiveNode(tmp_path, NODES['/low'] | {'orbit.true_anomaly': 3.0}, namespace='/low')
    low = frame(url, lambda now: '2 nodes' in now['/low/satdyn']['note'])['/low/satdyn']
    assert 'r_i' not in low
    twin.end()
    low = frame(url, are_drawn)['/low/satdyn']
    r_i, _ = on_circle('/low', low['utc_s'] - EPOCH_NS / 1e9)
    np.testing.assert_allclose(low['r_i'], r_i, rtol=0.0, atol=0.01)


@pytest.fixture
def page(url, browser):
    """Return the browser with the globe, and both on it."""
    browser.get(url)
    pages.wait(browser, 'window.satdyn && document.getElementById("nodes").options.length === 4')
    pages.choose(browser.find_element('id', 'nodes'), 'all')
    pages.wait(browser, 'satdyn.fleet.globe && satdyn.fleet.globe.satellites.size === 2')
    return browser


def entries(page):
    return page.find_elements('css selector', '#satellites button')


@pytest.mark.long
def test_the_page_lists_all_and_shows_the_one_that_is_clicked(page):
    """A click in the list, and one on a dot, leads to that satellite."""
    assert [entry.text.split('\n')[0] for entry in entries(page)] == [
        '/high/satdyn',
        '/low/satdyn',
        '/still/satdyn',
    ]
    assert not page.find_element('id', 'one').is_displayed()
    pages.wait(page, lambda: 'altitude 6378 km' in entries(page)[1].text)
    pages.wait(page, lambda: 'no orbit about the Earth' in entries(page)[2].text)
    answer = page.execute_script("return connection.ask({do: 'pause'})")
    assert (answer['success'], 'choose the one to ask' in answer['text']) == (False, True)
    # By the keyboard: a dot moves on.
    page.find_element('css selector', '.dot[aria-label="/low/satdyn"]').send_keys('\n')
    pages.wait(page, "satdyn.live.node === '/low/satdyn' && satdyn.rows.length > 5")
    assert page.find_element('id', 'one').is_displayed()
    assert not page.find_element('id', 'all').is_displayed()
    pages.choose(page.find_element('id', 'nodes'), 'all')
    pages.wait(page, lambda: page.find_element('id', 'all').is_displayed())
    entries(page)[0].click()
    pages.wait(page, "satdyn.live.node === '/high/satdyn' && satdyn.rows.length > 5")
    assert pages.errors(page) == []


@pytest.mark.long
def test_dots_and_lines_are_where_the_satellites_are(page):
    """
    A line goes all around on the circle; a dot lies on it, where the camera sees it.

    North is up in the picture: x of inertial axes is its x, y its -z and z its y.
    """
    for namespace in CIRCLES:
        seen = page.execute_script(
            """const { globe } = satdyn.fleet;
            globe._draw();
            const { at, orbit, dot } = globe.satellites.get(arguments[0]);
            const { projectionMatrix, matrixWorldInverse } = globe.camera;
            const box = (element) => element.getBoundingClientRect().toJSON();
            return { at: at.toArray(), line: Array.from(orbit.segments.array), dot: box(dot),
              picture: box(globe.canvas), projection: projectionMatrix.elements,
              view: matrixWorldInverse.elements };""",
            f'{namespace}/satdyn',
        )
        x, y, z = seen['at']
        position = np.array([x, -z, y])
        line = np.reshape(seen['line'], (-1, 3))
        axis = np.cross(*on_circle(namespace, 0.0))
        axis /= np.linalg.norm(axis)
        radius = CIRCLES[namespace]['semi_major_axis'] / RADIUS_M
        assert np.linalg.norm(position) == pytest.approx(radius, rel=1e-9)
        assert position @ axis == pytest.approx(0.0, abs=1e-9)
        # As single-precision numbers.
        np.testing.assert_allclose(np.linalg.norm(line, axis=1), radius, rtol=1e-6)
        np.testing.assert_allclose(line @ axis, 0.0, atol=1e-6)
        np.testing.assert_allclose([line[0], line[-1]], [position, position], atol=1e-5)
        projection, view = (np.reshape(seen[name], (4, 4)).T for name in ('projection', 'view'))
        right, up, _, depth = projection @ view @ [x, y, z, 1.0]
        picture, dot = seen['picture'], seen['dot']
        expected = [
            picture['left'] + (1.0 + right / depth) / 2.0 * picture['width'],
            picture['top'] + (1.0 - up / depth) / 2.0 * picture['height'],
        ]
        middle = [dot['left'] + dot['width'] / 2.0, dot['top'] + dot['height'] / 2.0]
        np.testing.assert_allclose(middle, expected, atol=0.1)
    assert pages.errors(page) == []


@pytest.mark.long
def test_tracks_on_the_ground_are_where_the_satellites_were_above(page):
    """A revolution back, at each of its times turned by ERFA."""
    pytest.importorskip('erfa')
    for namespace in CIRCLES:
        utc_s, track = page.execute_script(
            """const { globe, utc } = satdyn.fleet;
            const path = new Path(181, 1);
            globe._track(path, new Ellipse(...arguments[0], arguments[1]), utc);
            return [utc, Array.from(path.segments.array)];""",
            [values.tolist() for values in on_circle(namespace, 0.0)],
            MU,
        )
        a = CIRCLES[namespace]['semi_major_axis']
        before_s = -np.arange(180, 0, -1) / 180.0 * 2.0 * np.pi * np.sqrt(a**3 / MU)
        r_i = np.array([on_circle(namespace, t_s)[0] for t_s in before_s])
        stamps_ns = np.rint((utc_s + before_s) * 1e9).astype(np.int64)
        below = environment.turned(environment.gcrs_to_itrs(stamps_ns), r_i) / a
        found = np.reshape(track, (-1, 6))[:, :3] / 1.002
        # Nutation, of 9 arcsec, is left out.
        np.testing.assert_allclose(found, below, rtol=0.0, atol=6e-5)


@pytest.mark.long
def test_the_time_along_an_ellipse(page):
    """Forth and back from the pericentre, by the integral of r^2 / h over the true anomaly."""
    for e, angle in ((0.0, 1.0), (0.4, -2.0), (0.7, -5.5)):
        p = 1.0 - e * e
        right, _ = quad(lambda f, e=e, p=p: p**1.5 / (1.0 + e * np.cos(f)) ** 2, 0.0, angle)
        given = [1.0 - e, 0.0, 0.0], [0.0, np.sqrt((1.0 + e) / (1.0 - e)), 0.0]
        found = page.execute_script(
            'return new Ellipse(...arguments[0], 1).after(arguments[1])', given, angle
        )
        assert found == pytest.approx(right, abs=1e-8)


@pytest.mark.long
def test_the_line_of_an_ellipse(page):
    """From a position with its velocity follow the pericentre and the apocentre of the ellipse."""
    a, e, f = 3.0, 0.4, 2.0
    # The conic in its own axes, mu = 1: Montenbruck and Gill, Satellite Orbits, section 2.2.
    p = a * (1.0 - e * e)
    r = p / (1.0 + e * np.cos(f)) * np.array([np.cos(f), np.sin(f), 0.0])
    v = np.array([-np.sin(f), e + np.cos(f), 0.0]) / np.sqrt(p)
    ahead = 'new Ellipse(arguments[0], arguments[1], 1)'
    given = r.tolist(), v.tolist()
    found = page.execute_script(
        f'const of = {ahead}; return [of.ahead(-arguments[2]), of.ahead(Math.PI - arguments[2]), '
        'of.ahead(0), [of.furthest]]',
        *given,
        f,
    )
    np.testing.assert_allclose(found[0], [a * (1.0 - e), 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found[1], [-a * (1.0 + e), 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found[2], r, atol=1e-12)
    assert found[3] == [pytest.approx(a * (1.0 + e))]

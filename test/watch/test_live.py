"""The live page of a running node, in a browser, beside a participant that hears the topics."""

import signal

import browser as pages
import numpy as np
import pytest
from ros.live import EPOCH_NS, LiveNode, Participant, stamp_ns

from satdyn_ros.kernel import rotation
from satdyn_ros.run.scenario import Scenario

VALUES = {
    'publish.rate': 50.0,
    'publish.topics': ['attitude', 'imu', 'rotor', 'geodetic'],
    'initial.angular_velocity': [0.0, 0.1, 0.05],
    'rotor.names': ['wheel', 'ring', 'bias'],
    'rotor.wheel.mode': 'free',
    'rotor.wheel.inertia': 1.0,
    'rotor.wheel.speed': 12.0,
    'rotor.ring.mode': 'free',
    'rotor.ring.inertia': 2.0,
    'rotor.ring.speed': -7.0,
    'rotor.bias.mode': 'constant_momentum',
    'rotor.bias.momentum': 3.0,
}
NAMESPACE = '/watched'


@pytest.fixture(scope='module', autouse=True)
def _ros(ros):
    # A node is not to spend the patience of a test on its compiler.
    Scenario(VALUES).motion().at(0.0)


@pytest.fixture(scope='module')
def nodes(tmp_path_factory):
    """Return a list of the nodes that were started, the one that lives last."""
    directory = tmp_path_factory.mktemp('live')

    class Nodes(list):
        def begin(self, values=VALUES):
            self.append(LiveNode(directory, values, namespace=NAMESPACE))

    nodes = Nodes()
    nodes.begin()
    yield nodes
    nodes[-1].end()


@pytest.fixture(scope='module')
def participant(nodes):
    participant = Participant(NAMESPACE)
    yield participant
    participant.close()


@pytest.fixture(scope='module')
def page(nodes, watch, browser):
    """Return the browser with the page open and rows in it."""
    browser.get(watch('--node', f'{NAMESPACE}/satdyn'))
    pages.wait(browser, 'window.satdyn && satdyn.rows.length > 5')
    return browser


def text(browser, name):
    return browser.find_element('id', name).text


def press(browser, name, state):
    """Press a button and wait until the page says the state."""
    pages.wait(browser, lambda: browser.find_element('id', name).is_enabled())
    browser.find_element('id', name).click()
    pages.wait(browser, lambda: text(browser, 'state') == state)


def paused(page, participant, topic):
    """Pause; return the row that the page ends with, and the messages up to its tick."""
    messages = participant.listen(topic)
    participant.hear(messages, 1)
    press(page, 'pause', 'paused')

    def is_last(row):
        # What came since the last test may still be waiting to be heard.
        participant.spin(0.2)
        return row and abs(row['t_s'][0] - (stamp_ns(messages[-1]) - EPOCH_NS) / 1e9) < 1e-6

    shown = 'return satdyn.stage.scene.row'
    pages.wait(page, lambda: is_last(page.execute_script(shown)))
    return page.execute_script(shown), messages


def test_body_turns_as_the_node_says(page, participant):
    """Attitude, rate and rotor in the page are those of the topic at the same stamp."""
    row, messages = paused(page, participant, 'imu')
    q, omega = messages[-1].orientation, messages[-1].angular_velocity
    np.testing.assert_array_equal(row['q_ib'], np.array([q.x, q.y, q.z, q.w], np.float32))
    rate = np.array([omega.x, omega.y, omega.z], np.float32)
    np.testing.assert_array_equal(row['omega_bi_b'], rate)
    assert row['rotor_speed'][:2] == pytest.approx([12.0, -7.0], abs=0.2)
    # A rotor of constant momentum has no speed: nan, which the driver gives as None.
    assert row['rotor_speed'][2:] in ([None], [pytest.approx(np.nan, nan_ok=True)])
    press(page, 'step', 'paused')
    pages.wait(page, f'Math.abs(satdyn.stage.scene.row.t_s[0] - {row["t_s"][0]} - 0.02) < 1e-6')
    participant.hear(messages, 1)
    press(page, 'pause', 'running')


def test_the_position_is_that_of_the_topic(page, participant):
    """While the page is paused it has the position of the last message, and its time in UTC."""
    row, messages = paused(page, participant, 'geodetic')
    last = messages[-1]
    position = np.array([last.latitude, last.longitude, last.altitude], np.float32)
    np.testing.assert_array_equal(np.array(row['geodetic'], np.float32), position)
    utc = str(np.datetime64(last.header.stamp.sec, 's')).replace('T', ' ')
    pages.wait(page, f"document.querySelector('.ground time').textContent === '{utc} UTC'")
    pages.wait(page, lambda: text(page, 'clock').endswith(f'{utc} UTC'))
    press(page, 'pause', 'running')


def labels(browser):
    return len(browser.execute_script(pages.OVERLAPS)['texts'])


def test_reloaded_while_paused(page):
    """The page shows body, clock and labels of the state that is held, as before."""
    press(page, 'pause', 'paused')
    seen = 'return [satdyn.stage.scene.row, document.getElementById("clock").textContent]'

    def reloads_as_it_was():
        # The last rows, and the clock that follows them, may come after the answer to the pause.
        before = page.execute_script(seen)
        page.refresh()
        pages.wait(page, 'window.satdyn && satdyn.rows.length > 5 && satdyn.stage.scene.row')
        pages.wait(page, lambda: text(page, 'clock'))
        return page.execute_script(seen) == before

    pages.wait(page, reloads_as_it_was)
    pages.wait(page, lambda: labels(page) >= 5)
    press(page, 'pause', 'running')


@pytest.mark.long
def test_nothing_is_drawn_that_is_not_known(page, watch, browser):
    """A page whose server came after the pause says so, and shows no body; a step shows it."""
    press(page, 'pause', 'paused')
    first = page.current_url
    page.get(watch('--node', f'{NAMESPACE}/satdyn'))
    pages.wait(page, lambda: 'paused since before this page' in text(page, 'stage'))
    pages.wait(page, 'satdyn.live.description')
    assert not page.execute_script('return satdyn.stage.scene.world.visible')
    assert (labels(page), text(page, 'clock')) == (0, '')
    press(page, 'step', 'paused')
    pages.wait(page, 'satdyn.rows.length === 1 && satdyn.stage.scene.world.visible')
    pages.wait(page, lambda: labels(page) >= 5)
    press(page, 'pause', 'running')
    page.get(first)
    pages.wait(page, 'window.satdyn && satdyn.rows.length > 5')


def test_rows_that_come_at_once_are_shown_once(page):
    """A page that cannot draw as often as rows come shows the newest, once a frame."""
    came, shown, frames = page.execute_async_script(
        """const [done] = arguments;
        const { rows, stage } = satdyn;
        const show = stage.show.bind(stage);
        let [shown, frames] = [0, 0];
        stage.show = (...row) => { shown += 1; show(...row); };
        let frame = 0;
        const each = () => { frames += 1; frame = requestAnimationFrame(each); };
        each();
        const before = rows.length;
        const until = performance.now() + 3000; // the page is busy for so long
        while (performance.now() < until);
        const look = () => {
          if (rows.length < before + 40) return setTimeout(look, 10);
          stage.show = show;
          cancelAnimationFrame(frame);
          return done([rows.length - before, shown, frames]);
        };
        look();"""
    )
    assert came >= 40
    assert shown <= frames


@pytest.mark.long
def test_older_diagnostics_do_not_take_a_state_back(page):
    """From the answer on the page says the new state, though diagnostics come once a second."""
    pages.wait(page, lambda: text(page, 'state') == 'running')
    page.execute_script(
        """window.states = ['running'];
        new MutationObserver(() => {
          const state = document.getElementById('state').textContent;
          if (state !== states[states.length - 1]) states.push(state);
        }).observe(document.getElementById('state'), { childList: true });"""
    )
    for _ in range(3):
        press(page, 'pause', 'paused')
        pages.wait(page, lambda: 'paused after tick' in text(page, 'diagnostics'))
        press(page, 'pause', 'running')
        pages.wait(page, lambda: 'paused after tick' not in text(page, 'diagnostics'))
    states = page.execute_script('return states')
    assert states == ['running'] + 3 * ['paused', 'running']


def test_request_by_the_form(page, participant):
    """What is typed arrives; a refusal shows the node's own sentence, and nothing changes."""
    messages = participant.listen('imu')
    press(page, 'begin', 'running')
    field = page.find_element('name', 'initial.angular_velocity')
    field.clear()
    field.send_keys('0.1 0.2')
    page.find_element('id', 'send').click()
    pages.wait(page, lambda: text(page, 'refusal'))
    rates = [x / (180.0 / np.pi) for x in (0.1, 0.2)]
    refusal = participant.request({'initial.angular_velocity': rates})[1]
    assert text(page, 'refusal') == refusal.replace('\n', ' ')
    field.clear()
    # In degrees: 0.25 rad/s.
    field.send_keys('0, 0, 14.3239449')
    frame = page.find_element('name', 'initial.frame')
    pages.choose(frame, 'inertial')
    # On a busy machine the page may say that the node did not answer in time: once more.
    page.execute_script('window.dialog = document.getElementById("start")')
    pages.wait(page, '!dialog.open || document.getElementById("send").click()')
    participant.wait_until(
        lambda: messages and messages[-1].angular_velocity.z > 0.2, 'the requested rate'
    )
    pages.wait(page, 'satdyn.stage.scene.row.omega_bi_b[2] > 0.2')
    assert participant.get('initial.frame') == 'inertial'
    pages.wait(page, "satdyn.live.values['initial.frame'] === 'inertial'")


def test_form_is_in_degrees(page):
    """Angles come first, rates are in deg/s, the quaternion is last; exact values stay exact."""
    press(page, 'begin', 'running')
    fields = page.execute_script(
        "return [...document.querySelectorAll('#start label')].map((label) => label.textContent)"
    )
    assert [name.strip() for name in fields[:3]] == ['roll [deg]', 'pitch [deg]', 'yaw [deg]']
    assert 'initial.angular_velocity [deg/s]' in fields
    assert fields[-1].startswith('initial.attitude')
    page.find_element('id', 'yaw').clear()
    page.find_element('id', 'yaw').send_keys('40')
    shown = page.find_element('name', 'initial.attitude').get_attribute('value').split(', ')
    assert all(len(x.partition('.')[2]) <= 6 for x in shown)
    sent = np.array(page.execute_script("return form._value('initial.attitude')"))
    assert np.linalg.norm(sent) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose([float(x) for x in shown], sent, atol=5.1e-7)
    assert np.degrees(rotation.roll_pitch_yaw(sent))[2] == pytest.approx(40.0)
    rate = page.execute_script("return form._value('initial.angular_velocity')")
    assert rate == page.execute_script("return satdyn.live.values['initial.angular_velocity']")
    assert 'rotor.wheel.speed [rpm]' in fields
    wheel = page.find_element('name', 'rotor.wheel.speed')
    wheel.clear()
    wheel.send_keys('60')
    assert wheel.get_attribute('title') == '6.28319 rad/s'
    speed = page.execute_script("return form._value('rotor.wheel.speed')")
    assert speed == pytest.approx(2.0 * np.pi)
    page.find_element('id', 'cancel').click()


def test_a_text_with_its_unit_in_the_form(page, participant):
    """Another unit than the one that the form has is the node's to read."""
    press(page, 'begin', 'running')
    for name, typed in (
        ('initial.angular_velocity', '[0, 0, 600] arcmin/s'),
        ('rotor.ring.speed', '1.5 rev/s'),
    ):
        field = page.find_element('name', name)
        field.clear()
        field.send_keys(typed)
    page.execute_script('window.dialog = document.getElementById("start")')
    pages.wait(page, '!dialog.open || document.getElementById("send").click()')
    rate = list(participant.get('initial.angular_velocity'))
    assert rate == pytest.approx([0.0, 0.0, np.radians(10.0)])
    assert participant.get('rotor.ring.speed') == pytest.approx(3.0 * np.pi)


def test_record(page, participant):
    """The button begins a bag and closes it again; the page says which."""
    page.find_element('id', 'record').click()
    pages.wait(page, lambda: page.find_element('id', 'recording').is_displayed())
    pages.wait(page, lambda: text(page, 'record') == 'Stop recording')
    page.find_element('id', 'record').click()
    pages.wait(page, lambda: text(page, 'answer').startswith('closed'))
    pages.wait(page, lambda: not page.find_element('id', 'recording').is_displayed())


def test_diagnostics_and_no_errors(page):
    """The parts of the diagnostics are there, and the console is silent."""
    pages.wait(page, lambda: 'factor reached' in text(page, 'diagnostics'))
    shown = text(page, 'diagnostics').lower()
    assert all(part in shown for part in ('propagation', 'pacing', 'recorder', 'inputs'))
    assert 'relative drift of' in shown
    # Folded: its text is not seen.
    assert 'lateness of the ticks' in shown
    assert 'largest lateness' not in shown
    page.find_element('css selector', '#diagnostics summary').click()
    pages.wait(page, lambda: 'largest lateness' in text(page, 'diagnostics'))
    heard = text(page, 'diagnostics')
    # It stays so with the next diagnostics.
    pages.wait(page, lambda: text(page, 'diagnostics') != heard)
    assert 'largest lateness' in text(page, 'diagnostics')
    assert pages.errors(page) == []


def test_two_nodes_of_one_name(page, nodes, tmp_path):
    """The page says so, shows one alone and asks neither, until one has ended."""
    other = {'time.epoch_ns': EPOCH_NS + 1000, 'initial.angular_velocity': [0.0, 0.0, 0.7]}
    twin = LiveNode(tmp_path, VALUES | other, namespace=NAMESPACE)
    pages.wait(page, lambda: f'2 nodes are named {NAMESPACE}/satdyn' in text(page, 'stage'))
    for name in ('pause', 'step', 'reset', 'record', 'begin'):
        assert not page.find_element('id', name).is_enabled()
    answer = page.execute_script("return connection.ask({do: 'pause'})")
    assert (answer['success'], '2 nodes are named' in answer['text']) == (False, True)
    pages.wait(page, 'satdyn.rows.length > 30')
    rates = "(_, i) => satdyn.rows.get('omega_bi_b', i)"
    rates = page.execute_script(f'return Array.from({{length: satdyn.rows.length}}, {rates})')
    are_fast = {rate[2] > 0.5 for rate in rates}
    assert len(are_fast) == 1
    twin.end()
    pages.wait(page, lambda: page.find_element('id', 'pause').is_enabled())
    pages.wait(page, lambda: not page.find_element('class name', 'notice').is_displayed())
    pages.wait(page, 'satdyn.rows.length > 5 && satdyn.stage.scene.row.omega_bi_b[2] < 0.5')


def test_another_satellite_is_chosen(page, tmp_path):
    """Of two satellites the page shows the one that is chosen, with nothing of the other."""
    assert not page.find_element('id', 'nodes').is_displayed()
    values = {'publish.rate': 50.0, 'initial.angular_velocity': [0.0, 0.0, 0.7]}
    other = LiveNode(tmp_path, values, namespace='/other')
    try:
        choice = page.find_element('id', 'nodes')
        pages.wait(page, choice.is_displayed)
        # Typed keys would choose too, but the browser joins those of two names typed soon after
        # each other.
        pages.choose(choice, '/other/satdyn')
        pages.wait(page, "satdyn.live.node === '/other/satdyn' && satdyn.rows.length > 5")
        assert page.execute_script('return satdyn.rows.get("omega_bi_b", 0)')[2] > 0.69
        assert page.execute_script('return satdyn.stage.scene.wheels.length') == 0
        press(page, 'pause', 'paused')
        pages.choose(choice, f'{NAMESPACE}/satdyn')
        pages.wait(page, f"satdyn.live.node === '{NAMESPACE}/satdyn' && satdyn.rows.length > 5")
        pages.wait(page, lambda: text(page, 'state') == 'running')
        assert page.execute_script('return satdyn.stage.scene.wheels.length') == 3
    finally:
        other.end()
    pages.wait(page, lambda: not choice.is_displayed())


@pytest.mark.long
def test_goes_on_when_the_node_is_killed_and_comes_back(page, nodes):
    """After a SIGKILL the page says so, and continues with the next node of this name."""
    nodes[-1].end(signal.SIGKILL)
    pages.wait(page, lambda: text(page, 'state') == 'not there')
    nodes.begin(
        {
            'publish.rate': 50.0,
            'publish.topics': ['attitude'],
            'initial.angular_velocity': [0.0, 0.0, 0.3],
            'time.epoch_ns': 10**18,
        }
    )
    pages.wait(page, lambda: text(page, 'state') == 'running')
    pages.wait(page, lambda: 'angular_velocity not published' in text(page, 'stage'))
    participant = Participant(NAMESPACE)
    try:
        assert participant.set({'publish.topics': ['attitude', 'angular_velocity']})[0][0]
    finally:
        participant.close()
    pages.wait(page, 'satdyn.rows.length > 5 && satdyn.stage.scene.row.omega_bi_b[2] > 0.29')
    assert page.execute_script('return satdyn.rows.time(0)') < 60.0
    assert pages.errors(page) == []


@pytest.mark.long
def test_page_comes_back_when_the_server_does_not(page):
    """The page outlives its server and says that it has gone."""
    page.execute_script('arguments[0]; connection.socket.close()', None)
    pages.wait(page, 'connection.isOpen')
    pages.wait(page, lambda: text(page, 'state') == 'running')

"""The report opened as a user opens it: in a browser, without network."""

import re
import shutil

import pytest

from satdyn_ros.bag.simulate import simulate
from satdyn_ros.report.html import report
from satdyn_ros.run.events import Request
from satdyn_ros.run.scenario import Scenario

pytest.importorskip('plotly')

EVENTS = [Request(300000, {'initial.angular_velocity': [0.0, 0.0005, 0.0]})]
FLAGS = (
    '--headless=new',
    '--no-sandbox',
    '--disable-gpu',
    '--enable-unsafe-swiftshader',
    '--window-size=1400,1000',
    '--no-first-run',
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
    '--disable-quic',
)


@pytest.fixture(scope='module')
def page(tmp_path_factory):
    """Return the report of a bag of a million messages."""
    directory = tmp_path_factory.mktemp('report')
    scenario = Scenario.from_dict(
        {
            'publish': {'rate': 50.0, 'topics': ['attitude', 'imu']},
            'time': {'epoch_ns': 10**18},
        }
    )
    for _ in simulate(scenario, 10000, directory / 'bag', EVENTS):
        pass
    report(directory / 'bag', directory / 'report.html')
    return directory / 'report.html'


def test_page_needs_nothing_else(page):
    """A bag of a million messages gives less than 15 MB that loads nothing from anywhere."""
    text = page.read_text()
    assert page.stat().st_size < 15e6
    assert '500000 ticks at 50 Hz' in text
    assert not re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="(?!data:)', text)
    assert 'jacobi' in text
    assert 'no closed form' in text
    assert 'initial.angular_velocity' in text


@pytest.fixture(scope='module')
def browser():
    """Return a headless Chromium with a driver."""
    webdriver = pytest.importorskip('selenium.webdriver')
    chromium, driver = shutil.which('chromium'), shutil.which('chromedriver')
    if not (chromium and driver):
        pytest.skip("Debian's chromium and chromium-driver are not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in FLAGS:
        options.add_argument(flag)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    browser = webdriver.Chrome(options, webdriver.ChromeService(driver))
    yield browser
    browser.quit()


BODY = "return Array.from(document.getElementById('scene').data[0].x)"
CURSOR = "return document.getElementById('plots').layout.shapes[0].x0"


def test_play_and_scrub(page, browser):
    """Play moves the body and the cursor on; the scrubber moves both; the console is silent."""
    from selenium.webdriver.support.ui import WebDriverWait

    wait = WebDriverWait(browser, 60)
    browser.get(page.as_uri())
    wait.until(lambda b: b.execute_script('return document.getElementById("time").textContent'))
    before = browser.execute_script(BODY)
    play = browser.find_element('id', 'play')
    play.click()
    wait.until(lambda b: b.execute_script(BODY) != before)
    wait.until(lambda b: b.execute_script(CURSOR) > 0.0)
    play.click()
    assert play.text == 'Play'
    browser.execute_script(
        "const scrub = document.getElementById('scrub'); scrub.value = 2000;"
        "scrub.dispatchEvent(new Event('input'))"
    )
    assert browser.execute_script(CURSOR) == pytest.approx(5000.0, abs=5.0)
    assert browser.find_element('id', 'time').text.startswith('5000.')
    errors = [entry for entry in browser.get_log('browser') if entry['level'] == 'SEVERE']
    assert errors == []

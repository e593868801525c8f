"""A headless Chromium for tests of pages, with WebGL drawn in software."""

import shutil

import pytest

FLAGS = (
    '--headless=new',
    '--no-sandbox',
    '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader',
    # Otherwise what is not WebGL is drawn by the same software, at three times the cost.
    '--disable-gpu-compositing',
    '--window-size=1280,720',
    '--hide-scrollbars',
    '--no-first-run',
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
    '--disable-quic',
)


def start(*more_flags):
    """Return a browser with a driver; skip the test where Debian's packages are not installed."""
    webdriver = pytest.importorskip('selenium.webdriver')
    chromium, driver = shutil.which('chromium'), shutil.which('chromedriver')
    if not (chromium and driver):
        pytest.skip("Debian's chromium and chromium-driver are not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in (*FLAGS, *more_flags):
        options.add_argument(flag)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    # On a busy machine a page that draws lets a script wait; the driver gives up after 120 s.
    options.timeouts = {'script': 100_000}
    return webdriver.Chrome(options, webdriver.ChromeService(driver))


def leave(browser):
    """Leave the page, which would be drawn on, and what was set for it and said of it."""
    browser.get('about:blank')
    browser.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})
    browser.execute_cdp_cmd('Emulation.setEmulatedMedia', {'media': '', 'features': []})
    errors(browser)


def wait(browser, condition, timeout_s=180):
    """Wait until condition(), a function or a text of JavaScript, is true; return its value."""
    from selenium.webdriver.support.ui import WebDriverWait

    def met(_):
        return (
            condition() if callable(condition) else browser.execute_script(f'return {condition}')
        )

    return WebDriverWait(browser, timeout_s, poll_frequency=0.1).until(met)


def choose(element, text):
    """Choose the option of a select that has this text."""
    from selenium.webdriver.support.ui import Select

    Select(element).select_by_visible_text(text)


def resize(browser, width, height, colours='dark'):
    """Show the page in a window of this size [px], with the system's colours 'dark' or 'light'."""
    browser.execute_cdp_cmd(
        'Emulation.setDeviceMetricsOverride',
        {'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': width < 500},
    )
    browser.execute_cdp_cmd(
        'Emulation.setEmulatedMedia',
        {'features': [{'name': 'prefers-color-scheme', 'value': colours}]},
    )


def errors(browser):
    """Return what the console says is wrong."""
    return [entry for entry in browser.get_log('browser') if entry['level'] == 'SEVERE']


# Labels that are seen, those that lie on one another or on the map, and those through which a line
# of sight (one of a few over each) meets the body.
OVERLAPS = """
const boxes = [...document.querySelectorAll('.label')]
  .filter((label) => label.style.visibility === 'visible')
  .map((label) => ({ text: label.textContent, ...label.getBoundingClientRect().toJSON() }));
const map = document.querySelector('.ground').getBoundingClientRect().toJSON();
const overlaps = [];
boxes.forEach((a, i) => [...boxes.slice(i + 1), { text: 'map', ...map }].forEach((b) => {
  if (a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
    overlaps.push([a.text, b.text]);
}));
const { scene } = satdyn.stage;
const picture = scene.canvas.getBoundingClientRect();
const meetsBody = (x, y) => {
  const [right, down] = [(x - picture.left) / picture.width, (y - picture.top) / picture.height];
  const far = new THREE.Vector3(2 * right - 1, 1 - 2 * down, 0.9999);
  return scene._isBehindBody(far.unproject(scene.camera));
};
const isOnBody = ({ left, top, width, height }) => [0, 0.25, 0.5, 0.75, 1].some((i) => (
  [0, 0.5, 1].some((j) => meetsBody(left + i * width, top + j * height))));
const texts = (those) => those.map(({ text }) => text);
return { texts: texts(boxes), overlaps, on_body: texts(boxes.filter(isOnBody)) };
"""


def wait_for_labels(browser):
    """Wait until labels lie on nothing that they are to keep off; return their texts."""

    # The frame in which they are placed anew may come after the one with the new row or size.
    def free():
        found = browser.execute_script(OVERLAPS)
        return not found['overlaps'] and not found['on_body'] and found['texts']

    return set(wait(browser, free))

"""The site as a reader sees it: built, and opened in a browser."""

import subprocess
import sys
from pathlib import Path

import browser as pages
import pytest

pytestmark = pytest.mark.long
pytest.importorskip('furo')

DOCS = Path(__file__).parents[1] / 'docs'
# Without the pages of the API, which have no tables and take minutes.
WITHOUT_API = (
    '-D',
    'extensions=myst_parser,sphinx.ext.autodoc,sphinx.ext.mathjax',
    '-D',
    'exclude_patterns=_static,reference/api/*',
)
TOO_WIDE = """
return [...document.querySelectorAll('table')]
  .filter((table) => table.getBoundingClientRect().width > table.parentElement.clientWidth + 1)
  .map((table) => table.innerText.slice(0, 80));
"""


@pytest.fixture(scope='module')
def site(tmp_path_factory):
    """Return the folder of the pages."""
    built = tmp_path_factory.mktemp('site')
    command = [sys.executable, '-m', 'sphinx', '-q', '-b', 'html', *WITHOUT_API, DOCS, built]
    subprocess.run(command, check=True, capture_output=True)
    return built


def test_no_table_is_wider_than_its_page(site, browser):
    """In a window of 1280 pixels each table is seen whole."""
    pages.resize(browser, 1280, 800, 'light')
    seen = 0
    for page in sorted(site.rglob('*.html')):
        browser.get(page.as_uri())
        assert browser.execute_script(TOO_WIDE) == [], page.name
        seen += len(browser.find_elements('css selector', 'table'))
    assert seen > 20


def test_each_parameter_has_a_link_of_its_own(site, browser):
    """The link beside a key leads to its entry."""
    page = site / 'reference/parameters.html'
    browser.get(page.as_uri())
    links = browser.execute_script(
        "return [...document.querySelectorAll('h4 > a.headerlink')].map((link) => link.href)"
    )
    assert len(links) == len(set(links)) > 100
    browser.get(f'{page.as_uri()}#orbit-altitude')
    shown = browser.find_element('css selector', ':target h4')
    assert shown.text.startswith('orbit.altitude')
    assert browser.execute_script('return scrollY') > 0

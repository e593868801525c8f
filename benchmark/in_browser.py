"""
A headless Chromium that draws in software.

`python benchmark/in_browser.py URL` opens a page.
"""

import shutil
import signal
import sys
import time

from selenium import webdriver
from selenium.common.exceptions import WebDriverException

FLAGS = (
    'headless=new',
    'no-sandbox',
    'use-angle=swiftshader',
    'enable-unsafe-swiftshader',
    'window-size=1280,720',
)


def is_there() -> bool:
    """Return whether Debian's chromium and its driver are installed."""
    return bool(shutil.which('chromium') and shutil.which('chromedriver'))


def chromium() -> webdriver.Chrome:
    """Return a browser with a driver."""
    binary = shutil.which('chromium')
    assert binary is not None
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for flag in FLAGS:
        options.add_argument(f'--{flag}')
    return webdriver.Chrome(options, webdriver.ChromeService(shutil.which('chromedriver')))


def main(url: str) -> None:
    """Show a page, whose server may still be starting, until Ctrl-C."""
    with chromium() as browser:
        while True:
            try:
                browser.get(url)
                print('shown', flush=True)
                signal.pause()
            except WebDriverException:
                time.sleep(0.2)
            except KeyboardInterrupt:
                return


if __name__ == '__main__':
    main(sys.argv[1])

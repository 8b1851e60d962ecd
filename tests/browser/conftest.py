"""Fixtures for a browser without a window; tests are skipped if Chromium is not installed."""

import shutil

import pytest
from pages import WIDTHS, show
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

#: Switches for a browser without a window, without background requests, and without a sandbox. A sandbox
#: needs rights that containers do not have.
_SWITCHES = [
    *("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    "--enable-unsafe-swiftshader",  # draws solids where there is no graphics card
]


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    """Start Chromium with an empty profile, and log the messages and requests of pages."""
    program, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("needs the programs chromium and chromedriver")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for switch in (*_SWITCHES, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(switch)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    running = webdriver.Chrome(options=options, service=Service(executable_path=driver))
    yield running
    running.quit()


@pytest.fixture
def browser(chromium):
    """Return a function that sets the width of the page in pixels and returns the browser."""

    def of_width(width):
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        return chromium

    return of_width


@pytest.fixture(params=WIDTHS)
def width(request):
    """Return the width of a page in pixels, for a desktop screen and for a telephone."""
    return request.param


@pytest.fixture
def result(wall):
    """Return the result of the wall of the test module."""
    return wall[0]


@pytest.fixture
def page(browser, wall, width):
    """Open the page of the wall of the test module, and return the browser."""
    return show(browser, wall[1], width)

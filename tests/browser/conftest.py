"""A browser without a window, where there is one."""

import shutil

import pytest
from pages import WIDTHS, show
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

#: No window, no sandbox (which needs rights that containers lack), nothing that calls home.
_SWITCHES = [
    *("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    "--enable-unsafe-swiftshader",  # draws solids where there is no graphics card
]


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    """Chromium, with a new and empty profile, that logs what a page says and asks for."""
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
    """The browser, called with the width of its page in pixels."""

    def of_width(width):
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        return chromium

    return of_width


@pytest.fixture(params=WIDTHS)
def width(request):
    """Of a desk, and of a telephone."""
    return request.param


@pytest.fixture
def result(wall):
    """That of the module's wall."""
    return wall[0]


@pytest.fixture
def page(browser, wall, width):
    """The page of the module's wall, opened."""
    return show(browser, wall[1], width)

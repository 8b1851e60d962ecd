"""The layout of the pages of `compare` and `report` in a browser, on a desktop screen and a telephone."""

import itertools

import pytest
from comparisons import made_up
from loads.overhang import OVERHANG, axles
from pages import show, sticking_out
from scenes import block_on_floor, type_command
from selenium.webdriver.support.wait import WebDriverWait

import masonry_opt as mo
from masonry_opt.studies.compare.page import charts, page

#: Script that returns left, top, right and bottom of each element that a selector finds, in pixels.
_BOXES = """return [...document.querySelectorAll(arguments[0])].map(element => {
  const box = element.getBoundingClientRect();
  return [box.left, box.top + scrollY, box.right, box.bottom + scrollY];
});"""


@pytest.fixture(scope="module")
def comparison_page(tmp_path_factory):
    """Return the file of the page of a comparison without charts."""
    path = tmp_path_factory.mktemp("compare") / "report.html"
    with pytest.MonkeyPatch.context() as patched:
        type_command(patched, "compare", f"--out={'a_long_path/' * 20}")
        path.write_text(page(made_up(), []), "utf-8")
    return path


@pytest.fixture(scope="module")
def charts_page(tmp_path_factory):
    path = tmp_path_factory.mktemp("charts") / "report.html"
    comparison = made_up()
    path.write_text(page(comparison, charts(comparison.summary)), "utf-8")
    return path


def overflow(browser):
    """Return the number of pixels by which the page is wider than the window."""
    return browser.execute_script(
        "const {scrollWidth, clientWidth} = document.documentElement;return scrollWidth - clientWidth"
    )


def test_the_comparison(browser, comparison_page, width):
    """The page and its first table need no sideways scrolling, and λ is on the first screen."""
    chromium = browser(width)
    chromium.get(comparison_page.as_uri())
    assert overflow(chromium) <= 0
    values = chromium.execute_script(
        "return [...document.querySelectorAll('#answers td')].map(cell => cell.innerText)"
    )
    assert values[1:3] == ["0.25000", "0.15000, by hand"]
    left, top, right, bottom = chromium.execute_script(_BOXES, "#answers td")[1]
    assert 0 <= left < right <= width
    assert 0 <= top < bottom <= 900
    boxes = chromium.execute_script(_BOXES, "#answers td")
    assert max(right for _, _, right, _ in boxes) <= width
    first, definitions = (chromium.execute_script(_BOXES, part)[0] for part in ("#answers", "dl"))
    assert first[3] < definitions[1]


def test_no_table_moves_sideways_on_a_telephone(browser, comparison_page):
    """On a telephone, every cell fits and has a label, and empty cells are hidden.

    The headings still sort the table.
    """
    chromium = browser(400)
    chromium.get(comparison_page.as_uri())
    wider = (
        "return [...document.querySelectorAll('.table')].map(box => [box.scrollWidth - box.clientWidth,"
        "box.getBoundingClientRect().right])"
    )
    tables = chromium.execute_script(wider)
    assert len(tables) == 5
    assert [(more, right) for more, right in tables if more > 0 or right > 400] == []
    labelled = (
        "return [...document.querySelectorAll('#runs tbody tr:first-child td')].filter("
        "cell => getComputedStyle(cell).display !== 'none').map(cell => [cell.dataset.label, cell.innerText,"
        "getComputedStyle(cell, '::before').content])"
    )
    cells = chromium.execute_script(labelled)
    assert [label for label, *_ in cells[:2]] == ["scene", "method · model · solver"]
    assert all(text and content == f'"{label}"' for label, text, content in cells)
    first = "return document.querySelector('#runs tbody td:nth-child(2)').innerText"
    before = chromium.execute_script(first)
    heading = chromium.find_element("css selector", "#runs th:nth-child(2)")
    for _ in range(2):  # sorts upwards, then downwards
        heading.click()
    assert chromium.execute_script(first) != before


@pytest.mark.slow
def test_charts_are_drawn_whole(browser, charts_page, width):
    """Each chart is as wide as the page, contains its legend, and has tick labels that do not overlap."""
    chromium = show(browser, charts_page, width)
    missing = "return document.querySelectorAll('.chart:not(:has(.role-axis-label text))').length"
    WebDriverWait(chromium, 30).until(lambda page: page.execute_script(missing) == 0)
    assert overflow(chromium) <= 0
    plots = chromium.execute_script(_BOXES, "figure .chart svg")
    assert len(plots) == len(chromium.find_elements("css selector", "figure")) == 2
    for at, (left, top, right, bottom) in enumerate(plots, 1):
        assert bottom - top > 100
        assert width / 2 < right - left <= width
        entries = chromium.execute_script(_BOXES, f"#chart_{at} .role-legend-label text")
        assert len(entries) > 0
        assert all(box[2] <= right + 1 and box[3] <= bottom + 1 for box in entries)
        labels = f"#chart_{at} [aria-label^='X-axis'] .role-axis-label text:not([opacity='0'])"
        ticks = sorted(chromium.execute_script(_BOXES, labels))
        assert len(ticks) > 1
        assert all(one[2] < other[0] for one, other in itertools.pairwise(ticks))
    assert [line for line in chromium.get_log("browser") if line["level"] == "SEVERE"] == []


@pytest.mark.slow
def test_nothing_of_a_report_moves_sideways(browser, tmp_path, width):
    mo.report(mo.solve(block_on_floor(), "static"), tmp_path / "report.html")
    chromium = browser(width)
    chromium.get((tmp_path / "report.html").as_uri())
    assert sticking_out(chromium) == []
    assert all(image.get_property("naturalWidth") for image in chromium.find_elements("css selector", "img"))


@pytest.fixture
def on_paper(browser):
    """Return a function that lays a page out for print, on A4 in portrait or landscape format."""
    chromium = browser(1280)

    def laid(path, across=False):
        chromium.get(path.as_uri())
        size = {"width": 1017 if across else 688, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
        chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        return chromium

    yield laid
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.slow
def test_pages_print_whole(on_paper, comparison_page, tmp_path):
    """In print, no table is cut off or scrolls, and no control is visible."""
    mo.report(mo.solve(block_on_floor(), "static"), tmp_path / "report.html")
    scene, _ = OVERHANG, mo.settle(OVERHANG, "support -0.5", (0, -1)).save(tmp_path / "settle.html")
    mo.crossing(scene, axles(3.0), method="static").save(tmp_path / "crossing.html")
    for path in (comparison_page, *sorted(tmp_path.glob("*.html"))):
        printed = on_paper(path, across=path == comparison_page)
        assert sticking_out(printed) == [], path
        rolled = (
            "return [...document.querySelectorAll('.table')].filter(box =>"
            "box.scrollHeight > box.clientHeight + 1).length"
        )
        assert printed.execute_script(rolled) == 0
        assert printed.execute_script(_BOXES, "input") in ([], [[0, 0, 0, 0]])


@pytest.mark.slow
def test_a_picture_stands_for_what_turns_on_paper(on_paper, tmp_path):
    mo.solve(mo.extrude(block_on_floor(), 1.0), "static").save(tmp_path / "space.html")
    printed = on_paper(tmp_path / "space.html")
    assert sticking_out(printed) == []
    assert printed.execute_script("return document.querySelectorAll('.solids canvas').length") == 1
    shown = "return [...document.querySelectorAll(arguments[0])].filter(one => one.offsetHeight).length"
    hidden = (".solids canvas", ".controls", ".keys", ".joint")
    assert [printed.execute_script(shown, part) for part in hidden] == [0] * len(hidden)
    assert printed.execute_script(shown, ".solids img") == 1

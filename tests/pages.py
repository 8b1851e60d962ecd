"""Functions that open result pages in a browser, read them, and move their sliders."""

import json
import re

WIDTHS = (1280, 400)


def written(result, tmp_path_factory, **drawn):
    path = tmp_path_factory.mktemp("page") / "page.html"
    result.save(path, **drawn)
    return result, path


def show(browser, path, width):
    """Return the browser with the page open in a window of the given width."""
    chromium = browser(width)
    for log in ("browser", "performance"):
        chromium.get_log(log)
    chromium.get(path.as_uri())
    return chromium


def found(page, selector):
    return page.find_element("css selector", selector)


def sticking_out(page):
    """Return the elements that extend beyond the window or that need more than its width."""
    return page.execute_script(
        "const width = document.documentElement.clientWidth;"
        "return [...document.querySelectorAll('html, body, body *:not(svg *)')].filter((element) => {"
        "  const {left, right} = element.getBoundingClientRect();"
        "  const needs = element.scrollWidth > Math.max(width, element.clientWidth);"
        "  return left < 0 || right > width + 0.5 || needs;"
        "}).map((element) => element.outerHTML.slice(0, 80))"
    )


def cell(page, name):
    """Return a number from the panel of the selected joint."""
    return float(found(page, f'[data-of="{name}"]').text.replace("−", "-"))


def move_to(page, value):
    """Move the slider as a key or the pointer does."""
    page.execute_script(
        "const slider = document.getElementById('moved'); slider.value = arguments[0];"
        "slider.dispatchEvent(new Event('input', {bubbles: true}))",
        value,
    )


def quiet(page):
    """Return True if the browser logged nothing except rendering messages, and requested only local content.

    Local content is the file and data that the file contains.
    """
    events = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    sent = [event["params"] for event in events if event["method"] == "Network.requestWillBeSent"]
    asked = [event["request"]["url"] for event in sent]
    assert asked
    said = [entry for entry in page.get_log("browser") if entry["source"] != "rendering"]
    return said == [] and all(re.match("file:|data:", url) for url in asked)

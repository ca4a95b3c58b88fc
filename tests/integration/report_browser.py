#!/usr/bin/env python3
"""Opens a report in headless Chromium and checks that it really works there.

  report_browser.py PAGE [--screenshot FILE.png] [--width N] [--dark] [--figures N]
  report_browser.py --from-tests TEST_PROGRAM [...]     lets the unit tests write the page first

Exit 0: fine; 1: a check failed; 77: no Chromium here (skipped).
"""

import argparse
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from chromium import Browser, find_chromium  # noqa: E402

SKIPPED = 77


def check(browser, page, figures):
    """Returns a list of complaints."""
    complaints = []
    browser.open(page)
    if not browser.wait_for("document.documentElement?.dataset.ready === 'yes'", 90):
        return ["the page was not drawn within 90 s"] + browser.problems
    boxes = browser.evaluate("document.querySelectorAll('.chart').length")
    drawn = browser.evaluate(
        "[...document.querySelectorAll('.chart.js-plotly-plot')].filter(p => p.querySelector('.main-svg') "
        "&& p.querySelector('.main-svg').getBoundingClientRect().width > 200).length")
    if boxes == 0 or drawn != boxes:
        complaints.append(f"{drawn} of {boxes} figures are drawn")
    if figures is not None and boxes != figures:
        complaints.append(f"{boxes} figures, expected {figures}")
    empty = browser.evaluate(
        "[...document.querySelectorAll('.chart.js-plotly-plot')].filter(p => !p.data.length).map(p => p.dataset.figure)")
    if empty:
        complaints.append(f"figures without data: {empty}")
    lobes = browser.evaluate("document.querySelectorAll('[data-figure=lobe]').length")
    canvases = browser.evaluate("document.querySelectorAll('[data-figure=lobe] canvas').length")
    webgl = browser.evaluate("Boolean(document.createElement('canvas').getContext('webgl'))")
    if webgl and canvases < lobes:
        complaints.append(f"{canvases} WebGL canvases for {lobes} lobes")
    wide = browser.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    if wide > 0:
        complaints.append(f"the page is {wide} px wider than the window")
    # Every choice must redraw without an error.
    pressed = browser.evaluate(
        "(() => { let n = 0; for (const g of document.querySelectorAll('.chooser')) {"
        " const b = [...g.querySelectorAll('button')]; for (const x of [...b.slice(1), b[0]]) { x.click(); n++; } } return n; })()")
    print(f"{boxes} figures drawn, {pressed} choices tried, WebGL {'on' if webgl else 'off'}")
    outside = [url for url in browser.requests if not url.startswith(("file:", "data:", "blob:", "about:"))]
    if outside:
        complaints.append(f"the page asked the network for {outside}")
    broken = browser.evaluate("document.querySelectorAll('.chart .notice').length")
    if broken:
        complaints.append(f"{broken} figures show an error")
    return complaints + browser.problems


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", nargs="?")
    parser.add_argument("--from-tests", metavar="PROGRAM")
    parser.add_argument("--screenshot", metavar="PNG")
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--dark", action="store_true")
    parser.add_argument("--figures", type=int)
    arguments = parser.parse_args()
    program = find_chromium()
    if not program:
        print("SKIPPED: no chromium here (package chromium), so the report was not tried in a browser")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        page = arguments.page
        if arguments.from_tests:
            page = os.path.join(folder, "report.html")
            subprocess.run([arguments.from_tests, "--gtest_filter=*writes_a_page_for_the_browser*"],
                           env={**os.environ, "UMOV_REPORT_PAGE": page}, check=True, stdout=subprocess.DEVNULL)
        if not page or not os.path.exists(page):
            print(f"no page {page}")
            return 1
        with Browser(program) as browser:
            browser.size(arguments.width, 900)
            browser.prefer("dark" if arguments.dark else "light")
            complaints = check(browser, page, arguments.figures)
            if arguments.screenshot:
                browser.screenshot(arguments.screenshot)
    for complaint in complaints:
        print("FAILED:", complaint)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())

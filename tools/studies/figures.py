#!/usr/bin/python3
"""Draws the figures of a study as SVG files.

  figures.py FIGURES.json -o FOLDER [--prefix TEXT] [--width PX] [--height PX]

FIGURES.json is {"figures": [{"name", "data", "layout"}, ...]}: data and layout as plotly.js takes
them. Every figure becomes FOLDER/PREFIXNAME.svg, drawn by plotly.js (Debian's python3-plotly) in a
headless Chromium; nothing is loaded from the network. A layout's own `width` and `height` count; what
it leaves out is set to a light, legible page figure. A figure is refused where an axis has no title,
as a number without its quantity and unit tells nothing.

Also a module: render(figures, folder) -> list of the files written.
"""

import argparse
import base64
import json
import os
import pathlib
import re
import sys
import tempfile
import urllib.parse

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/integration"))
from chromium import Browser, find_chromium  # noqa: E402

PLOTLY = pathlib.Path(os.environ.get("UMOV_PLOTLY_JS", "/usr/share/python3-plotly/plotly.js"))
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")

TEXT, SOFT, LINE, ZERO, PAPER = "#1c222b", "#5a6472", "#e3e7ec", "#aab3bf", "#ffffff"
COLORWAY = ["#1f5fbf", "#d4331d", "#16883a", "#74296f", "#c86a06", "#0b79b8", "#3d4f63", "#9a7a00"]
FONT = "'DejaVu Sans', 'Liberation Sans', Arial, sans-serif"
MARGIN = {"l": 76, "r": 24, "t": 56, "b": 64}


class FigureError(ValueError):
    """A figure that cannot be drawn or should not be shown; the message names it."""


def axes_of(figure):
    """Names of the cartesian axes that the figure's traces use ("xaxis", "yaxis2", ...)."""
    used = set()
    for trace in figure["data"]:
        if trace.get("type") in ("pie", "table", "surface", "scatter3d", "scatterpolar", "indicator"):
            continue
        for letter in "xy":
            number = trace.get(letter + "axis", letter)[1:]
            used.add(f"{letter}axis{number}")
    return sorted(used)


def title_text(axis):
    title = axis.get("title", "")
    return title.get("text", "") if isinstance(title, dict) else title


def check(figures):
    """Raises FigureError for what is missing or unreadable."""
    seen = set()
    for figure in figures:
        name = figure.get("name", "")
        if not NAME.fullmatch(name):
            raise FigureError(f"figure name {name!r}: use letters, digits, - and _")
        if name in seen:
            raise FigureError(f"figure {name}: the name stands twice")
        seen.add(name)
        if not figure.get("data"):
            raise FigureError(f"figure {name}: no data")
        layout = figure.get("layout", {})
        for axis in axes_of(figure):
            settings = layout.get(axis, {})
            shared = "matches" in settings and settings.get("showticklabels") is False
            if not title_text(settings) and settings.get("visible", True) and not shared:
                raise FigureError(f"figure {name}: {axis} has no title (quantity and unit)")


def merged(defaults, own):
    """`own` over `defaults`, dictionaries merged."""
    out = dict(defaults)
    for key, value in own.items():
        both = isinstance(value, dict) and isinstance(out.get(key), dict)
        out[key] = merged(out[key], value) if both else value
    return out


def styled(figure, width, height):
    """The layout with what makes a figure legible where it says nothing itself."""
    axis = {"gridcolor": LINE, "zerolinecolor": ZERO, "linecolor": ZERO, "ticks": "outside", "tickcolor": ZERO,
            "showline": True, "mirror": True, "automargin": True, "exponentformat": "power",
            "title": {"standoff": 10, "font": {"size": 16}}, "tickfont": {"size": 14}}
    layout = dict(figure.get("layout", {}))
    for name in [key for key in layout if re.fullmatch(r"[xy]axis\d*", key)] + axes_of(figure):
        own = dict(layout.get(name, {}))
        if isinstance(own.get("title"), str):
            own["title"] = {"text": own["title"]}
        layout[name] = merged(axis, own)
    if isinstance(layout.get("title"), str):
        layout["title"] = {"text": layout["title"]}
    defaults = {"width": width, "height": height, "paper_bgcolor": PAPER, "plot_bgcolor": PAPER,
                "font": {"family": FONT, "size": 15, "color": TEXT}, "colorway": COLORWAY, "margin": MARGIN,
                "title": {"font": {"size": 17}, "x": 0.02, "xanchor": "left"},
                "legend": {"font": {"size": 14}, "bgcolor": "rgba(255,255,255,.85)", "bordercolor": LINE, "borderwidth": 1}}
    return merged(defaults, layout)


def svg_of(answer):
    """The picture inside a data URL."""
    head, _, body = answer.partition(",")
    return base64.b64decode(body) if head.endswith(";base64") else urllib.parse.unquote(body).encode()


def render(figures, folder, prefix="", width=860, height=540):
    """Writes folder/PREFIXNAME.svg for each figure; returns the paths. Raises FigureError, or
    FileNotFoundError where Chromium or plotly.js is missing."""
    check(figures)
    program = find_chromium()
    if program is None:
        raise FileNotFoundError("no Chromium: install the package chromium")
    if not PLOTLY.is_file():
        raise FileNotFoundError(f"no {PLOTLY}: install the package python3-plotly")
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    with tempfile.TemporaryDirectory(prefix="umov-figures-") as name:
        page = pathlib.Path(name) / "page.html"
        page.write_text('<!doctype html><meta charset="utf-8"><body>'
                        f'<script src="{PLOTLY.resolve().as_uri()}"></script>', encoding="utf-8")
        with Browser(program) as browser:
            browser.open(page)
            if not browser.wait_for("window.Plotly", 60):
                raise FigureError("plotly.js did not load")
            for figure in figures:
                layout = styled(figure, width, height)
                spec = json.dumps({"data": figure["data"], "layout": layout})
                try:
                    answer = browser.evaluate(
                        f"(async () => {{ const f = {spec}; return Plotly.toImage(f, {{format: 'svg', "
                        f"width: {layout['width']}, height: {layout['height']}}}); }})()")
                except RuntimeError as error:
                    raise FigureError(f"figure {figure['name']}: {error}") from error
                path = folder / f"{prefix}{figure['name']}.svg"
                path.write_bytes(svg_of(answer))
                written.append(path)
    return written


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("figures", help="JSON file")
    parser.add_argument("-o", "--output", required=True, help="folder for the SVG files")
    parser.add_argument("--prefix", default="", help="put before every file name")
    parser.add_argument("--width", type=int, default=860)
    parser.add_argument("--height", type=int, default=540)
    options = parser.parse_args()
    try:
        figures = json.loads(pathlib.Path(options.figures).read_text(encoding="utf-8"))["figures"]
        for path in render(figures, options.output, options.prefix, options.width, options.height):
            print(path)
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        sys.exit(f"figures.py: {options.figures}: {error}")


if __name__ == "__main__":
    main()

"""The list of studies, and their figures as SVG files."""

import json
import pathlib
import subprocess
import sys
import unittest

from chromium import find_chromium
from umov_case import SOURCE, UmovCase

sys.path.insert(0, str(SOURCE / "tools/studies"))
import figures  # noqa: E402


def figure(name="curve", **layout):
    axes = {"xaxis": {"title": {"text": "θ / °"}}, "yaxis": {"title": "BRDF / sr<sup>−1</sup>", "type": "log"}}
    return {"name": name, "data": [{"x": [0, 30, 60], "y": [0.1, 10, 0.01], "name": "532 nm"}], "layout": {**axes, **layout}}


class Studies(UmovCase):
    def test_studies_are_listed_and_unknown_ones_refused(self):
        self.assertIn("reflectometer", self.must("study").stdout)
        names = [entry["study"] for entry in json.loads(self.must("study", "--json").stdout)]
        self.assertIn("reflectometer", names)
        self.refused("study", "reflectomter", "-o", "out", says=["reflectomter", "reflectometer"])
        self.refused("study", "reflectometer", says=["-o"])

    def test_the_catalogue_page_tells_of_every_effect(self):
        self.must("study", "effects", "-o", "page", "--quiet", timeout=300)
        page = (self.folder / "page/effects.md").read_text()
        listed = [line.split("  [")[0] for line in self.must("diagnose", "--effects").stdout.splitlines()
                  if line and not line.startswith(" ")]
        self.assertGreater(len(listed), 30)
        for name in listed:
            self.assertIn(f"\n## {name}\n", page)

    def test_a_folder_with_other_files_is_left_alone(self):
        (self.folder / "mine").mkdir()
        self.write("mine/thesis.tex", "x")
        self.refused("study", "reflectometer", "-o", "mine", says=["mine", "no study wrote"])
        self.assertEqual([p.name for p in (self.folder / "mine").iterdir()], ["thesis.tex"])

    def test_figures_without_quantity_and_unit_are_refused(self):
        with self.assertRaisesRegex(figures.FigureError, "curve: yaxis has no title"):
            figures.check([figure(yaxis={})])
        second = figure()
        second["data"].append({"x": [1], "y": [1], "xaxis": "x2", "yaxis": "y"})
        with self.assertRaisesRegex(figures.FigureError, "xaxis2"):
            figures.check([second])
        with self.assertRaisesRegex(figures.FigureError, "twice"):
            figures.check([figure(), figure()])
        with self.assertRaisesRegex(figures.FigureError, "letters"):
            figures.check([figure("../curve")])
        figures.check([figure()])

    @unittest.skipUnless(find_chromium() and figures.PLOTLY.is_file(), "no Chromium or no plotly.js")
    def test_a_figure_becomes_a_legible_svg(self):
        self.write("figures.json", json.dumps({"figures": [figure(title="Red gloss"), figure("second")]}))
        done = subprocess.run(["/usr/bin/python3", SOURCE / "tools/studies/figures.py", "figures.json", "-o", "out",
                               "--prefix", "demo-"], cwd=self.folder, text=True, capture_output=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        files = sorted(pathlib.Path(line).name for line in done.stdout.splitlines())
        self.assertEqual(files, ["demo-curve.svg", "demo-second.svg"])
        svg = (self.folder / "out/demo-curve.svg").read_text()
        self.assertTrue(svg.startswith("<svg"))
        for text in ("BRDF / sr", "θ / °", "Red gloss", "rgb(255, 255, 255)"):
            self.assertIn(text, svg)
        self.assertNotIn("http://localhost", svg)


if __name__ == "__main__":
    unittest.main()

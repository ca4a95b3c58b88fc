"""umov study real-data on the shipped part of the PTFE data: in-plane fits foretell real rows out of the plane."""

import json
import os
import subprocess
import unittest

import umov_case
from umov_case import UmovCase


class RealDataStudy(UmovCase):
    def study(self, *arguments, data=umov_case.SOURCE / "tests/data"):
        return subprocess.run([umov_case.UMOV, "study", "real-data", *arguments], cwd=self.folder, text=True,
                              capture_output=True, timeout=120, check=False, env={**os.environ, "UMOV_DATA": str(data)})

    def numbers(self, folder, *arguments):
        done = self.study("-o", folder, "--json", "--quiet", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("skipped", done.stderr)
        return json.loads(done.stdout)

    def test_a_sheen_over_a_body_foretells_ptfe_better_than_a_lambertian_and_its_own_in_plane_rows(self):
        models = ("--models", "lambertian,li-torrance+single-scatter")
        found = self.numbers("one", *models, "--threads", "1")
        ptfe = found["samples"]["sintered PTFE"]
        by_name = {row["name"]: row for row in ptfe["attempts"]}
        self.assertGreater(ptfe["out_of_plane_points"], 2000)
        good, plain = by_name["li-torrance+single-scatter"], by_name["lambertian"]
        interpolations = [row for row in ptfe["attempts"] if row["kind"] == "interpolation"]
        self.assertEqual(len(interpolations), 3)
        self.assertLess(good["out_of_plane"]["median"], 0.015)
        self.assertGreater(plain["out_of_plane"]["median"], 0.03)
        for row in interpolations:
            self.assertLess(good["out_of_plane"]["median"], row["out_of_plane"]["median"])
            self.assertLess(row["out_of_plane"]["median"], 0.03)
        self.assertLess(good["linear_rms"], 0.75 * plain["linear_rms"])
        self.assertTrue(all(target["met"] for target in found["targets"]))
        self.assertEqual(self.numbers("two", *models, "--threads", "2"), found)
        page = (self.folder / "one/real-data.md").read_text()
        self.assertIn("Skipped", page)
        self.assertIn("li-torrance+single-scatter", page)

    def test_says_what_it_lacks(self):
        nowhere = self.study("-o", "none", data=self.folder)
        self.assertEqual(nowhere.returncode, 1)
        self.assertIn("UMOV_DATA", nowhere.stderr)
        wrong = self.study("-o", "wrong", "--models", "plaster")
        self.assertEqual(wrong.returncode, 1)
        self.assertIn("plaster", wrong.stderr)
        self.refused("study", "reflectometer", "-o", "other", "--models", "nef", says=["takes no models"])


if __name__ == "__main__":
    unittest.main()

"""umov simulate surface: a scene file in, a hemisphere with its errors out."""

import json
import math
import unittest

import h5py

from umov_case import SOURCE, UmovCase

PAINT = """wavelengths_nm = [500, 700]
period_um = 100
[ground]
kind = "lambertian"
albedo = [0.2, 0.6]
"""
SOIL = """[[particles]]
kind = "soil"
albedo = 0.5
diameter_um = 20
coverage = 0.3
"""


class SimulateSurface(UmovCase):
    def scene(self, text):
        path = self.folder / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return path

    def test_a_bare_paint_has_its_albedo_in_the_file_and_on_the_terminal(self):
        said = json.loads(self.must("simulate", "surface", self.scene(PAINT), "--theta-i", 40, "--samples", 1e5, "-o", "paint.h5",
                                    "--directions", "strip", "--strip", 45, "--json", "--quiet").stdout)
        for band, albedo in zip(said["bands"], (0.2, 0.6)):
            self.assertAlmostEqual(band["dhr"], albedo, places=9)
            self.assertEqual(band["lost"], 0)
        with h5py.File(self.folder / "paint.h5") as file:
            f = file["points/brdf_per_sr"][:]
            u = file["points/brdf_u"][:]
            wavelength = file["points/wavelength_nm"][:]
            theta = file["points/theta_r_deg"][:]
            self.assertEqual(set(file["points/phi_r_deg"][:]), {0.0})
            self.assertEqual(file["mueller/mueller"].shape[1], 16)
        self.assertLess(min(theta), -80)
        self.assertGreater(max(theta), 80)
        z = [(x - (0.2 if w == 500 else 0.6) / math.pi) / e for x, e, w in zip(f, u, wavelength)]
        self.assertGreater(len(z), 80)
        self.assertLess(sum(v * v for v in z) / len(z), 2.0)

    def test_the_result_depends_on_the_seed_and_on_nothing_else(self):
        scene = self.scene(PAINT + SOIL)

        def dhr(*options):
            text = self.must("simulate", "surface", scene, "--samples", 40000, "--json", "--quiet", *options).stdout
            return json.loads(text)["bands"]

        self.assertEqual(dhr("--threads", 1), dhr("--threads", 3))
        self.assertNotEqual(dhr("--seed", 1), dhr("--seed", 2))

    def test_the_example_runs_and_its_hemisphere_can_be_exported(self):
        self.must("simulate", "surface", SOURCE / "examples/surfaces/wet-dirt.toml", "--theta-i", 20, "--relative-error", 2,
                  "-o", "wet.h5", "--quiet")
        self.must("export", "wet.h5", "-o", "wet.csv")

    def test_refuses_what_cannot_be(self):
        crowded = self.scene(PAINT + SOIL.replace("0.3", "0.9"))
        self.refused("simulate", "surface", crowded, says=("find no more room",))
        self.refused("simulate", "surface", self.scene(PAINT), "--theta-i", 90, says=("90",))
        self.refused("simulate", "surface", self.scene(PAINT + "gloss = 1\n"), says=("scene.toml:6", "gloss"))


if __name__ == "__main__":
    unittest.main()

"""Intensity distributions and luminance maps in the formats of other programs."""

import json
import re
import unittest

import h5py

from chambers import small_chamber
from umov_case import UmovCase

SCENE = small_chamber(rays=2e5)

ABSOLUTE_FEET = "IESNA:LM-63-2002\r\n[LUMINAIRE] quadrant\r\nTILT=NONE\r\n1 -1 2 3 3 1 1 .5 1 0\r\n1 1 10\r\n0 45 90\r\n0 45 90\r\n5 4 1\r\n5 3 1\r\n5 2 1\r\n"


class LightFormats(UmovCase):
    def export(self, source, form, output):
        return json.loads(self.must("export", source, "--format", form, "-o", output, "--json").stdout)

    def sim(self, scene=SCENE):
        self.write("scene.toml", scene)
        self.must("simulate", "chamber", "scene.toml", "-o", "sim.h5", "--quiet")

    @staticmethod
    def ies_numbers(path):
        return [float(word) for word in re.split(r"TILT=NONE\s+", path.read_text())[1].split()]

    def test_a_distribution_goes_round_both_formats(self):
        self.sim()
        with h5py.File(self.folder / "sim.h5") as file:
            intensity = file["lid/intensity_cd"][:]
            # Numbers, not text.
            self.assertAlmostEqual(float(file["lid"].attrs["source_lm"]), 2)
            self.assertEqual(file["lid"].attrs["source_lm"].dtype.kind, "f")
            self.assertEqual(float(file["map"].attrs["pixel_mm"]), 2)
            self.assertEqual(file.attrs["pixel_mm"].dtype.kind, "f")
            self.assertEqual(float(file.attrs["seed"]), 1)
            out_lm = float(file["lid"].attrs["out_lm"])
            self.assertTrue(0 < float(file["lid"].attrs["absorbed_fraction"]) < 1)
        said = self.export("sim.h5", "ldt", "lamp.ldt")
        self.assertEqual(said["format"], "ldt")
        self.assertIn("4 planes of 37 angles", said["holds"])
        self.export("lamp.ldt", "ies", "lamp.ies")
        numbers = self.ies_numbers(self.folder / "lamp.ies")
        self.assertEqual(numbers[1], 2)
        table = numbers[13 + 37 + 5:]
        for c in range(4):
            for g in range(37):
                self.assertAlmostEqual(table[37 * c + g], intensity[c, g], delta=1e-5)
        flux = float(re.search(r"([\d.]+) lm of 2 lm", said["holds"])[1])
        self.assertAlmostEqual(flux / out_lm, 1, delta=0.02)
        # Once more through both: the same texts.
        self.export("lamp.ies", "ldt", "again.ldt")
        self.export("again.ldt", "ies", "again.ies")
        self.assertEqual((self.folder / "again.ies").read_bytes(), (self.folder / "lamp.ies").read_bytes())

    def test_absolute_photometry_in_feet_is_told_of_in_eulumdat(self):
        (self.folder / "a.ies").write_bytes(ABSOLUTE_FEET.encode())
        said = self.export("a.ies", "ldt", "a.ldt")
        self.assertIn("absolute", said["notes"][0])
        lines = (self.folder / "a.ldt").read_text().splitlines()
        self.assertEqual(lines[3], "8")  # planes, of three in the file
        self.assertEqual([float(lines[15]), float(lines[16])], [304.8, 152.4])
        self.assertEqual(float(lines[42 + 8 + 3]), 10)  # cd/klm at C0, γ 0: twice 5 cd of 1000 lm

    def test_a_map_comes_back_from_csv_and_exr(self):
        self.sim()
        for form, name in (("map-csv", "map.csv"), ("exr", "map.exr"), ("png", "map.png")):
            said = self.export("sim.h5", form, name)
            self.assertIn("20 × 12 pixels", said["holds"])
        rows = [[float(v) for v in line.split(",")] for line in (self.folder / "map.csv").read_text().splitlines()[2:]]
        with h5py.File(self.folder / "sim.h5") as file:
            values, errors = file["map/luminance_cd_m2"][:], file["map/luminance_se"][:]
        self.assertEqual(len(rows), 240)
        for x, y, value, error in rows:
            place = (int(y // 2), int(x // 2))
            self.assertEqual((value, error), (values[place], errors[place]))

    def test_what_a_source_does_not_have_is_refused(self):
        self.sim(SCENE.split("[goniophotometer]")[0])
        self.refused("export", "sim.h5", "--format", "ies", "-o", "x.ies", says=("no intensity distribution", "goniophotometer"))
        self.refused("export", "sim.h5", "-o", "x.ies", says=("--format", "ldt"))
        self.refused("export", "sim.h5", "--format", "merl", "-o", "x", says=("merl is for BRDFs",))
        (self.folder / "a.ies").write_bytes(ABSOLUTE_FEET.encode())
        self.refused("export", "a.ies", "--format", "exr", "-o", "x.exr", says=("no luminance map",))
        self.refused("import", "a.ies", "-o", "x.h5", says=("intensity distribution", "umov export"))
        (self.folder / "bad.ies").write_bytes(ABSOLUTE_FEET.replace("5 3 1", "5 1e300 1").encode())
        self.refused("export", "bad.ies", "--format", "ldt", "-o", "x.ldt", says=("bad.ies:9", "candela"))


if __name__ == "__main__":
    unittest.main()

"""Cases with withheld effects: what is written, what is sealed, what can be asked for later."""

import hashlib
import json
import unittest

from umov_case import UmovCase

MENU = ("reverse", "serpentine", "flip", "pm45", "shutter", "nd", "iris", "oop", "white_tile", "repeat",
        "long_pass", "no_sample")

PLAN = """
sample = "coupon"
wavelengths_nm = [532, 633]
theta_i_deg = [30, 60]
theta_r_deg = { from = -60, to = 60, step = 20 }
states = [["P", "P"], ["S", "open"]]
order = "serpentine"
[[block]]
menu = "flip"
[[block]]
menu = "white_tile"
"""


class BlindCases(UmovCase):
    def make(self, *arguments):
        done = self.must("blind", "make", "cases", "--truth", "sealed", "--json", *arguments)
        return json.loads(done.stdout)

    def truth(self):
        return json.loads((self.folder / "sealed/truth.json").read_text())

    def test_scans_lie_in_one_folder_and_their_sealed_truth_in_another(self):
        said = self.make("--cases", 4, "--seed", 3)
        names = sorted(p.relative_to(self.folder / "cases").as_posix()
                       for p in (self.folder / "cases").rglob("*") if p.is_file())
        self.assertEqual(names, ["README.md", "SEAL"] + [f"case_000{i}/scan.csv" for i in range(1, 5)])
        digest = hashlib.sha256((self.folder / "sealed/truth.json").read_bytes()).hexdigest()
        self.assertEqual(said["sha256"], digest)
        self.assertIn(digest, (self.folder / "cases/SEAL").read_text())
        self.must("blind", "check", "cases", "--truth", "sealed")
        for case in self.truth()["cases"]:
            text = (self.folder / "cases" / case["case"] / "scan.csv").read_text()
            rows = [line for line in text.splitlines() if not line.startswith("#")]
            self.assertEqual(len(rows) - 1, case["records"])
        with (self.folder / "sealed/truth.json").open("a") as file:
            file.write(" ")
        self.refused("blind", "check", "cases", "--truth", "sealed", says=["sealed with"])

    def test_the_same_seed_gives_the_same_bytes_on_any_number_of_threads(self):
        self.must("blind", "make", "a", "--truth", "ta", "--cases", 3, "--seed", 8, "--threads", 1)
        self.must("blind", "make", "b", "--truth", "tb", "--cases", 3, "--seed", 8, "--threads", 2)
        self.must("blind", "make", "c", "--truth", "tc", "--cases", 3, "--seed", 9, "--threads", 2)
        for name in ("SEAL", "case_0001/scan.csv", "case_0002/scan.csv", "case_0003/scan.csv"):
            self.assertEqual((self.folder / "a" / name).read_bytes(), (self.folder / "b" / name).read_bytes())
            self.assertNotEqual((self.folder / "a" / name).read_bytes(), (self.folder / "c" / name).read_bytes())

    def test_scans_are_canonical_scan_csv(self):
        self.make("--cases", 1, "--seed", 4, "--class", "none")
        self.must("import", "cases/case_0001/scan.csv", "-o", "scan.h5")
        self.must("export", "scan.h5", "-o", "again.csv")
        before = (self.folder / "cases/case_0001/scan.csv").read_text().splitlines()
        after = (self.folder / "again.csv").read_text().splitlines()
        rows = [line for line in before if not line.startswith("#")]
        self.assertEqual(rows, [line for line in after if not line.startswith("#")])

    def test_every_scan_of_the_menu_can_be_taken_afterwards(self):
        self.make("--cases", 1, "--seed", 6, "--effect", "backlash", "--style", "one-way")
        own = (self.folder / "cases/case_0001/scan.csv").read_text().splitlines()
        end_s = float(own[-1].split(",")[1])
        for menu in MENU:
            self.must("blind", "scan", "sealed", "case_0001", "--menu", menu, "-o", f"{menu}.csv")
            lines = (self.folder / f"{menu}.csv").read_text().splitlines()
            blocks = [line for line in lines if line.startswith("# block: ")]
            self.assertEqual(len(blocks), 1)
            self.assertTrue(blocks[0].startswith(f"# block: {menu} 0-"), blocks[0])
            self.assertEqual("# role: white" in lines, menu == "white_tile")
            first = next(line for line in lines if line[0].isdigit())
            self.assertGreater(float(first.split(",")[1]), end_s)
        flip = (self.folder / "flip.csv").read_text()
        self.assertIn("sample_azimuth_deg=180", flip)
        self.must("blind", "scan", "sealed", "case_0001", "--menu", "flip", "-o", "flip2.csv")
        self.assertEqual(flip, (self.folder / "flip2.csv").read_text())

    def test_a_plan_of_ones_own_can_be_scanned_too(self):
        self.make("--cases", 1, "--seed", 6, "--class", "single")
        (self.folder / "next.toml").write_text(PLAN)
        self.must("blind", "scan", "sealed", "case_0001", "--plan", "next.toml", "-o", "next.csv")
        lines = (self.folder / "next.csv").read_text().splitlines()
        blocks = [line.split()[2] for line in lines if line.startswith("# block: ")]
        self.assertEqual(blocks, ["main", "flip"])
        self.assertIn("# role: white", (self.folder / "next-white.csv").read_text())
        directions = {line.split(",")[8] for line in lines if line[0].isdigit()}
        self.assertEqual(directions, {"1", "-1"})

    def test_effects_are_listed_with_their_parameters(self):
        effects = {e["effect"]: e for e in json.loads(self.must("blind", "effects", "--json").stdout)}
        self.assertEqual(sum(e["in_catalogue"] for e in effects.values()), 35)
        self.assertGreaterEqual(sum(not e["in_catalogue"] for e in effects.values()), 10)
        self.assertEqual(effects["dark_offset"]["parameters"], ["offset_v", "y_fraction"])

    def test_what_cannot_be_done_is_refused(self):
        make = ("blind", "make", "cases", "--truth", "sealed", "--cases", 1)
        self.refused(*make, "--class", "easy", says=["easy", "single"])
        self.refused(*make, "--effect", "ghosts", says=["ghosts", "backlash"])
        self.refused(*make, "--style", "zigzag", says=["zigzag", "serpentine"])
        self.refused(*make, "--rho-min", 9, "--rho-max", 3, says=["--rho-min"])
        self.refused("blind", "make", "cases", "--truth", "cases/sealed", "--cases", 1, says=["cases/sealed"])
        self.make("--cases", 1, "--class", "none")
        self.refused(*make, says=["cases"])
        self.refused("blind", "scan", "sealed", "case_0009", "--menu", "flip", "-o", "x.csv", says=["case_0009"])
        self.refused("blind", "scan", "sealed", "case_0001", "--menu", "x-ray", "-o", "x.csv", says=["x-ray", "flip"])
        self.refused("blind", "scan", "sealed", "case_0001", "-o", "x.csv", says=["--menu"])
        self.refused("blind", "scan", "nowhere", "case_0001", "--menu", "flip", "-o", "x.csv", says=["truth.json"])
        self.refused("blind", "check", "sealed", "--truth", "sealed", says=["SEAL"])


class EmulatorEffects(UmovCase):
    def test_the_emulator_takes_each_kind_of_effect_as_a_setting(self):
        (self.folder / "plan.toml").write_text("""
sample = "red-gloss"
wavelengths_nm = [532]
theta_i_deg = [30]
theta_r_deg = [-30, 10, 30]
states = [["P", "open"]]
""")

        def signals(*settings):
            options = [word for setting in settings for word in ("--plant-set", setting)]
            (self.folder / "scan.h5").unlink(missing_ok=True)
            self.must("scan", "plan.toml", "-o", "scan.h5", "--quiet", *options)
            self.must("export", "scan.h5", "-o", "scan.csv", "--force", "--quiet")
            lines = (self.folder / "scan.csv").read_text().splitlines()
            return [float(line.split(",")[10]) for line in lines if line[0].isdigit()]

        plain = signals()
        dusty = signals("dust.optical_depth_633=0.1")
        retro = signals("marks.retro_peak_per_sr=0.5")
        ghost = signals("ghost.share=0.1", "ghost.angle_deg=20")
        self.assertLess(dusty[2], plain[2])
        self.assertGreater(retro[0], 1.5 * plain[0])
        self.assertAlmostEqual(retro[2] / plain[2], 1.0, places=3)
        self.assertGreater(ghost[1], 1.5 * plain[1])


if __name__ == "__main__":
    unittest.main()

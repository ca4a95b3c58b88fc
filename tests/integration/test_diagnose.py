"""umov diagnose on scans that another program made, and on what no diagnosis can be made of."""

import json
import math
import unittest

from umov_case import SOURCE, UmovCase

SCANS = SOURCE / "tests/data/foreign_scans"


class Diagnose(UmovCase):
    def diagnosis(self, *arguments):
        self.must("diagnose", *arguments, "--json", "answer.json", "--quiet", timeout=300)
        return json.loads((self.folder / "answer.json").read_text())

    def test_nothing_is_needed_where_nothing_is_wrong(self):
        answer = self.diagnosis(SCANS / "scan_03.csv")
        self.assertEqual(answer["verdict"], "none_needed")
        self.assertEqual(answer["causes"], [])
        self.assertEqual(answer["data"]["records"], 3645)
        self.assertEqual(len(answer["data"]["sha256"]), 64)
        for key in ("gap", "where", "ambiguity_sets", "unexplained", "next_scan", "base", "program"):
            self.assertIn(key, answer)

    def test_a_leaning_sample_is_named_with_its_angle(self):
        answer = self.diagnosis(SCANS / "scan_05.csv")
        self.assertEqual(answer["verdict"], "explained")
        cause = answer["causes"][0]
        self.assertEqual(cause["effect"], "sample_tilt_in_plane")
        self.assertGreater(cause["probability"], 0.5)
        tilt = cause["parameters"]["tilt_deg"]
        self.assertLess(tilt["lo"], 0.0358)
        self.assertGreater(tilt["hi"], 0.0358)
        gap = answer["gap"]
        self.assertGreater(gap["before"]["g2"], 3 * gap["after"]["g2"])
        self.assertGreater(gap["closed_fraction"]["value"], 0.7)
        for size in (gap["before"], gap["after"], gap["floor"]):
            self.assertLess(size["lo"], size["g2"])
            self.assertGreater(size["hi"], size["g2"])
        for size in (gap["before"], gap["after"]):
            self.assertLessEqual(size["percent_lo"], size["percent"])
            self.assertGreaterEqual(size["percent_hi"], size["percent"])
        self.assertGreater(gap["before"]["lo"], gap["after"]["hi"])

    def test_what_looks_alike_in_plane_is_one_set_and_the_scan_that_tells_is_prescribed(self):
        answer = self.diagnosis(SCANS / "scan_01.csv", "--next", "next.toml")
        self.assertIn(["polarizer_leakage", "polarizer_rotation"], answer["ambiguity_sets"])
        families = [c.get("family") for c in answer["causes"] if c["effect"] == "sample_model"]
        self.assertEqual(families, ["microfacet+microfacet"])
        best = answer["next_scan"][0]
        self.assertEqual(best["menu"], "pm45")
        self.assertGreater(best["expected_separation"], 5)
        # The plan is one that the program takes.
        plan = (self.folder / "next.toml").read_text()
        self.assertIn('menu = "pm45"', plan)
        (self.folder / "small.toml").write_text(
            plan.replace("step = 4", "step = 40").replace("coupon", "red-gloss"))
        self.must("scan", "small.toml", "-o", "further.h5", timeout=300)

    def test_a_cause_without_a_name_is_told_by_what_it_varies_with(self):
        # A wedge in the polariser: the beam walks as it turns. No effect of the catalogue does that.
        self.must("blind", "make", "cases", "--truth", "sealed", "--cases", "1", "--effect", "polarizer_wedge",
                  "--style", "one-way", "--rho-min", "25", "--rho-max", "30", "--seed", "3", timeout=120)
        answer = self.diagnosis("cases/case_0001/scan.csv")
        self.assertIn(answer["verdict"], ("unexplained", "explained_in_part"))
        self.assertEqual([c["effect"] for c in answer["causes"] if c["effect"] != "sample_model"], [])
        varies = answer["unexplained"]["varies"]
        self.assertEqual((varies["effect"], varies["with"]), ("incidence_zero", "polarizer_deg"))
        self.assertLess(varies["p_global"], 1e-6)

    def test_the_answer_does_not_depend_on_threads(self):
        one = self.diagnosis(SCANS / "scan_03.csv", "--threads", "1")
        two = self.diagnosis(SCANS / "scan_03.csv", "--threads", "2")
        for answer in (one, two):
            del answer["program"]["command"]
        self.assertEqual(one, two)

    def altered(self, change, keep=None):
        """scan_05 with its columns changed, as altered.csv."""
        lines = (SCANS / "scan_05.csv").read_text().splitlines()
        head = [line for line in lines if line.startswith("#") and not line.startswith("# block")]
        names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
        rows = [dict(zip(names, row)) for row in rows]
        rows = list(filter(keep, rows)) if callable(keep) else rows[:keep]
        for index, row in enumerate(rows):
            row["index"] = str(index)
            change(row)
        body = [",".join(names)] + [",".join(row[name] for name in names) for row in rows]
        (self.folder / "altered.csv").write_text("\n".join(head + body) + "\n")
        return "altered.csv"

    def test_says_what_one_wavelength_cannot_tell(self):
        one = self.altered(lambda row: None, lambda row: row["wavelength_nm"] == "532")
        answer = self.diagnosis(one, "--quick")
        self.assertTrue(any("one wavelength only" in note for note in answer["data"]["notes"]))
        self.assertTrue(answer["program"]["quick"])
        for cause in answer["causes"]:
            self.assertNotIn(cause["effect"], ("wavelength_error", "laser_crosstalk"))

    def test_refuses_what_no_diagnosis_can_be_made_of(self):
        def turned(row):
            row["theta_r_deg"] = str(-float(row["theta_r_deg"]))

        def noise(row):
            # As like positive as negative, whatever the geometry.
            size = 1e-5 * math.sin(1 + 7.3 * int(row["index"]) ** 1.5)
            row.update(x_v=f"{size:.6g}", y_v=f"{-size:.6g}")

        cases = [
            ("too few", lambda row: None, 100),
            ("saturated", lambda row: row.update(saturated="1"), None),
            ("the same in all", lambda row: row.update(x_v="0.01", monitor_v="2.5"), None),
            ("wrong sign", turned, None),
            ("the same in all", lambda row: row.update(x_v="0.01"), None),
            ("is zero in all", lambda row: row.update(x_v="0", y_v="0"), None),
            ("noise about zero", noise, None),
            ("without light", lambda row: row.update(shutter="closed"), None),
            ("not a finite number", lambda row: row.update(x_v="nan"), None),
        ]
        for says, change, keep in cases:
            with self.subTest(says):
                self.refused("diagnose", self.altered(change, keep), says=[says])
        middle = self.altered(turned, lambda row: 20 < float(row["theta_i_deg"]) < 50)
        self.refused("diagnose", middle, says=["wrong sign"])
        text = (SCANS / "scan_05.csv").read_text()
        self.write("other.csv", text.replace("# sample: coupon", "# sample: token"))
        self.refused("diagnose", SCANS / "scan_05.csv", "other.csv", says=["different samples", "coupon", "token"])
        self.write("lame.csv", text.replace("theta_r_deg", "theta_x_deg", 1))
        self.refused("diagnose", "lame.csv", says=["theta_x_deg", "theta_r_deg"])
        self.refused("diagnose", SCANS / "scan_05.csv", "--without", "gremlins",
                     says=["gremlins", "backlash"])


if __name__ == "__main__":
    unittest.main()

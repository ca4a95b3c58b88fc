"""umov diagnose with what is known beforehand (calibration, tolerances, a fit) and with follow-up scans."""

import json
import unittest

from umov_case import SOURCE, UmovCase

SCANS = SOURCE / "tests/data/foreign_scans"

SAMPLE = """
name = "plain-facets"
title = "Gaussian facets over a diffuse base"
kind = "facets"
wavelengths_nm = [532, 633, 814]
n = 1.52
weight = 1.0
slope = 0.14
rho_d1 = [0.05, 0.08, 0.11]
"""

PLAN = """
sample = "plain facets"
wavelengths_nm = [532, 633]
theta_i_deg = [30, 50]
theta_r_deg = { from = -70, to = 70, step = 5, near = { within_deg = 5, step = 1 } }
states = [["P", "P"], ["P", "S"], ["S", "P"], ["S", "S"]]
dwell_ms = 20
"""

WHITE = """
sample = "lambertian 99"
role = "white"
wavelengths_nm = [532, 633]
theta_i_deg = [0]
theta_r_deg = { from = -75, to = 75, step = 15 }
states = [["P", "P"], ["P", "S"], ["P", "open"], ["S", "S"], ["S", "P"]]
dwell_ms = 20
reference_dhr = { 532 = 0.99, 633 = 0.99 }
reference_dhr_u = 0.002
"""


def bench(noise, **settings):
    """A TOML of an otherwise ideal bench whose lasers flicker by `noise`."""
    lines = ['preset = "ideal"']
    for nm in (532, 633):
        lines += [f"[laser.{nm}]", f"jitter = {noise}"]
    for table, values in settings.items():
        lines += [f"[{table.replace('__', '.')}]", *(f"{key} = {value}" for key, value in values.items())]
    return "\n".join(lines) + "\n"


class DiagnoseKnown(UmovCase):
    def setUp(self):
        super().setUp()
        for name, text in (("sample.toml", SAMPLE), ("plan.toml", PLAN), ("white.toml", WHITE)):
            self.write(name, text)

    def measure(self, name, *options):
        self.must("scan", "plan.toml", "--sample", "sample.toml", "-o", name, "--quiet", *options)

    def calibrate(self, name, *options, mirror=False):
        self.must("scan", "white.toml", "--sample", "lambertian-99", "-o", "white.h5", "--quiet", "--force", *options)
        scans = ["white.h5"]
        if mirror:
            germanium = (SOURCE / "examples/campaign/germanium.toml").read_text()
            self.write("ge.toml", germanium.replace("[532, 633, 814]", "[532, 633]"))
            self.must("scan", "ge.toml", "--sample", "germanium", "-o", "ge.h5", "--quiet", *options)
            scans.append("ge.h5")
        self.must("calibrate", *scans, "-o", name, "--quiet")

    def diagnosis(self, *arguments):
        self.must("diagnose", *arguments, "--quick", "--json", "answer.json", "--quiet", timeout=300)
        return json.loads((self.folder / "answer.json").read_text())

    @staticmethod
    def named(answer):
        return [cause["effect"] for cause in answer["causes"]]

    def test_what_the_calibration_knows_is_no_cause_and_what_came_after_it_is(self):
        self.write("leaky.toml", bench(0.02, polarizer={"extinction": 4e-3}, axis__polarizer={"zero_deg": 0.6}))
        leaky = ["--plant", "leaky.toml"]
        self.calibrate("white-only.h5", *leaky)
        self.calibrate("cal.h5", *leaky, mirror=True)
        self.measure("scan.h5", *leaky)
        unaware = self.diagnosis("scan.h5", "--calibration", "white-only.h5")
        self.assertIn("polarizer_leakage", self.named(unaware))
        # Cells of one channel say which, in letters, and numbers are numbers.
        confined = [cell["also"] for cell in unaware["where"] if "polarizer" in cell["also"]]
        self.assertIn({"polarizer": "P", "analyzer": "S", "component": "x"},
                      [{k: v for k, v in also.items() if k != "wavelength_nm"} for also in confined])
        for cell in unaware["where"]:
            self.assertIn(cell["also"].get("wavelength_nm"), (None, 532, 633))
        aware = self.diagnosis("scan.h5", "--calibration", "cal.h5")
        self.assertNotIn("polarizer_leakage", self.named(aware))
        self.assertLess(aware["gap"]["before"]["g2"], 0.2 * unaware["gap"]["before"]["g2"])
        self.assertEqual(aware["known"], {"calibration": "cal.h5"})
        self.assertIn("polarizer_leakage extinction 0.004", " ".join(aware["data"]["notes"]))
        # More than was declared is said to be so.
        self.write("declared.toml", "[polarizer_leakage]\nextinction = 0.001\n")
        declared = self.diagnosis("scan.h5", "--calibration", "white-only.h5", "--tolerances", "declared.toml")
        self.assertEqual([c["within_tolerance"] for c in declared["causes"] if c["effect"] == "polarizer_leakage"],
                         [False])
        # Somebody leans on the detector arm after the calibration: that is found.
        self.write("leant.toml", bench(0.02, polarizer={"extinction": 4e-3}, axis__polarizer={"zero_deg": 0.6},
                                       axis__detector={"zero_deg": 0.3}))
        self.measure("leant.h5", "--plant", "leant.toml")
        answer = self.diagnosis("leant.h5", "--calibration", "cal.h5")
        named = set(self.named(answer)) | {name for group in answer["ambiguity_sets"] for name in group}
        self.assertIn("detector_zero", named)
        self.assertNotIn("polarizer_leakage", named)
        # A scan without gain constants needs a calibration, and one with its wavelengths.
        self.refused("diagnose", "scan.h5", says=["gain_constant_532", "--calibration"])
        self.refused("diagnose", "scan.h5", "--calibration", "plan.toml", says=["plan.toml"])

    def test_a_zero_error_is_ambiguous_until_the_flipped_scan_was_taken(self):
        self.write("bench.toml", bench(0.05, axis__incidence={"zero_deg": 0.1}))
        instrument = ["--sample", "sample.toml", "--plant", "bench.toml"]
        self.calibrate("cal.h5", "--plant", "bench.toml")
        self.measure("scan.h5", "--plant", "bench.toml")
        # What describes an instrument is of no use where none is to measure.
        for option, value in (("--sample", "sample.toml"), ("--plant", "bench.toml"), ("--preset", "realistic"),
                              ("--plant-set", "axis.detector.zero_deg=1")):
            done = self.refused("diagnose", "scan.h5", "--calibration", "cal.h5", option, value, code=2)
            self.assertIn("--follow-up", done.stderr)
        # The scan is of the instrument itself: another one may not take the follow-up.
        follow_up = ["scan.h5", "--calibration", "cal.h5", "--follow-up", "emulator"]
        done = self.refused("diagnose", *follow_up, *instrument, "--seed", 99, "--keep", "other", "--quiet")
        self.assertIn("the first scan on", done.stderr)
        answer = self.diagnosis(*follow_up, *instrument)
        first = answer["follow_ups"][0]
        self.assertEqual(first["menu"], "flip")
        self.assertTrue(any("incidence_zero" in group and "sample_tilt_in_plane" in group
                            for group in first["before"]["ambiguity_sets"]), first)
        self.assertEqual(first["after"]["ambiguity_sets"], [])
        self.assertEqual(self.named(answer), ["incidence_zero"])
        zero = answer["causes"][0]["parameters"]["zero_deg"]
        self.assertLess(zero["lo"], 0.1)
        self.assertGreater(zero["hi"], 0.1)
        for name in ("scan.next-1.h5", "scan.next-1.toml"):
            self.assertTrue((self.folder / name).exists())
        # What was measured is used again, and both files by themselves say the same.
        again = self.diagnosis(*follow_up, *instrument)
        self.assertEqual(again["causes"], answer["causes"])
        together = self.diagnosis("scan.h5", "scan.next-1.h5", "--calibration", "cal.h5")
        self.assertEqual(together["causes"], answer["causes"])
        # A real instrument (here one on a socket) has nobody to turn the sample: it is said what to do.
        _, device = self.emulator(*instrument)
        said = self.umov("diagnose", "scan.h5", "--calibration", "cal.h5", "--follow-up", device, "--keep", "tcp")
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("needs a hand at the instrument", said.stdout)
        self.assertIn("Turn the sample to 180 deg", said.stdout)

    def test_tolerances_are_priors_and_say_what_is_within_them(self):
        shipped = SOURCE / "examples/tolerances/bench.toml"
        cause = self.diagnosis(SCANS / "scan_05.csv", "--tolerances", shipped)["causes"][0]
        self.assertEqual((cause["effect"], cause["within_tolerance"]), ("sample_tilt_in_plane", True))
        cases = [
            ("[gremlins]\nsize = 1\n", ["t.toml:2", "gremlins", "backlash"]),
            ("[backlash]\n\nzero_deg = 1\n", ["t.toml:3", "zero_deg", "gap_deg"]),
            ("[backlash]\ngap_deg = -1\n", ["t.toml:2", "no positive number", "half_width"]),
            ("[dust]\ng = 0.1\n", ["t.toml:2", "only shapes", "optical_depth_633"]),
            ("backlash = 1\n", ["t.toml:1", "no table"]),
            ("", ["t.toml", "no tolerance"]),
        ]
        for text, says in cases:
            with self.subTest(text):
                self.write("t.toml", text)
                self.refused("diagnose", SCANS / "scan_05.csv", "--tolerances", "t.toml", says=says)

    def test_no_output_replaces_what_is_read_or_another_output(self):
        scan = SCANS / "scan_05.csv"
        self.write("t.toml", "keep = 1\n")
        taken = ["t.toml", "already"]
        self.refused("diagnose", scan, "--tolerances", "t.toml", "--json", "t.toml", says=taken)
        self.refused("diagnose", scan, "--fit", "t.toml", "--report", "t.toml", says=taken)
        self.refused("diagnose", scan, "--json", "one", "--next", "one", says=["one", "already"])
        self.assertEqual((self.folder / "t.toml").read_text(), "keep = 1\n")
        self.assertFalse((self.folder / "one").exists())

    def test_a_fit_is_the_simulation_and_held_it_shows_its_own_gap(self):
        self.write("bench.toml", bench(0.05))
        self.calibrate("cal.h5", "--plant", "bench.toml")
        self.measure("scan.h5", "--plant", "bench.toml")
        self.must("reduce", "scan.h5", "--calibration", "cal.h5", "-o", "brdf.h5", "--quiet")
        self.must("invert", "brdf.h5", "--model", "microfacet+nef", "-o", "fit.json", "--quiet")
        known = ["scan.h5", "--calibration", "cal.h5", "--fit", "fit.json"]
        held = self.diagnosis(*known, "--hold")
        self.assertEqual(held["verdict"], "none_needed")
        fit = json.loads((self.folder / "fit.json").read_text())
        slope = held["base"]["parameters"]["0.slope_rms"]
        self.assertAlmostEqual(slope["value"], fit["parameters"]["0.slope_rms"]["value"], places=12)
        self.assertEqual(slope["lo"], slope["hi"])
        # A simulation that is off in its index is off in the scan: held, it shows, and free, it mends.
        wrong = json.loads((self.folder / "fit.json").read_text())
        wrong["parameters"]["0.slope_rms"].update(value=0.17, lo=0.169, hi=0.171)
        self.write("wrong.json", json.dumps(wrong))
        off = self.diagnosis("scan.h5", "--calibration", "cal.h5", "--fit", "wrong.json", "--hold")
        self.assertGreater(off["gap"]["before"]["g2"], held["gap"]["before"]["g2"] + 1)
        self.assertNotEqual(off["verdict"], "none_needed")
        mended = self.diagnosis("scan.h5", "--calibration", "cal.h5", "--fit", "wrong.json")
        self.assertEqual(mended["verdict"], "none_needed")
        self.assertEqual(mended["base"]["model"], "microfacet+nef")
        self.refused("diagnose", "scan.h5", "--hold", says=["--fit"])


if __name__ == "__main__":
    unittest.main()

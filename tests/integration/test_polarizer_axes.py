"""Axes and extinction of polariser and analyser from a germanium wafer on the emulated, imperfect instrument."""

import json
import unittest

import h5py
import numpy as np

from umov_case import SOURCE, UmovCase

WHITE = """
sample = "lambertian 99"
role = "white"
wavelengths_nm = [532, 633, 814]
theta_i_deg = [0]
theta_r_deg = { from = -75, to = 75, step = 15 }
states = [["P", "P"], ["P", "S"], ["P", "open"], ["S", "S"], ["S", "P"]]
dwell_ms = 20
reference_dhr = { 532 = 0.99, 633 = 0.99, 814 = 0.99 }
reference_dhr_u = 0.002
"""

LINEAR = """
sample = "red gloss"
role = "sample"
wavelengths_nm = [532]
theta_i_deg = [55]
theta_r_deg = { from = 35, to = 75, step = 4 }
states = [["P", "P"], ["P", "S"], ["S", "P"], ["S", "S"], ["P", "open"], [45, 45], [45, -45],
          ["P", 45], ["S", 45], [45, "P"], [-45, "S"], [-45, 45]]
dwell_ms = 20
"""

LEAKY = {"polarizer.extinction": 1e-4, "analyzer.extinction": 1e-4, "axis.polarizer.zero_deg": 0.3,
         "axis.analyzer.zero_deg": -0.25}


def settings(values):
    return [word for name, value in values.items() for word in ("--plant-set", f"{name}={value}")]


class PolarizerAxes(UmovCase):
    def scan(self, plan, sample, output, *more):
        self.must("scan", plan, "--sample", sample, "-o", output, "--quiet", *more)

    def test_wafer_on_a_realistic_bench_gives_axes_and_extinction(self):
        realistic = ["--preset", "realistic", "--seed", 11, *settings(LEAKY)]
        self.scan(SOURCE / "examples/campaign/germanium.toml", "germanium", "ge.h5", *realistic)
        self.scan(self.write("white.toml", WHITE), "lambertian-99", "white.h5", *realistic)
        done = self.must("calibrate", "white.h5", "ge.h5", "-o", "cal.h5", "--json")
        found = json.loads(done.stdout)["polarization"]
        self.assertEqual(len(found["wavelengths"]), 3)
        for wave in found["wavelengths"]:
            for key, truth in (("polarizer_axis_deg", 0.3), ("analyzer_axis_deg", -0.25)):
                self.assertAlmostEqual(wave[key]["value"], truth, delta=0.05)
                self.assertLess(abs(wave[key]["value"] - truth), 3.5 * wave[key]["u"])
                self.assertLess(wave[key]["u"], 0.05)
            for key in ("polarizer_extinction", "analyzer_extinction"):
                self.assertAlmostEqual(wave[key]["value"], 1e-4, delta=1e-5)
                self.assertLess(abs(wave[key]["value"] - 1e-4), 5 * wave[key]["u"])
            self.assertAlmostEqual(wave["detector_bias"]["value"], -0.004, delta=0.004)
        # The calibration file carries it to the reduction, which names what it took into account.
        self.scan(self.write("linear.toml", LINEAR), "red-gloss", "sample.h5", *realistic)
        report = json.loads(self.must("reduce", "sample.h5", "--calibration", "cal.h5", "-o", "brdf.h5",
                                      "--json").stdout)
        self.assertIn("polarizer axis 532 nm", report["factors"])
        self.assertEqual(report["mueller"]["complete"], 11)
        self.assertEqual(report["mueller"]["undetermined"], [])

    def test_reduction_refers_to_ideal_elements(self):
        leaky = settings({**LEAKY, "polarizer.extinction": 1e-3, "analyzer.extinction": 2e-3,
                          "detector.polarization_bias": 0.01, "monitor.polarization_bias": 0.015})
        white = self.write("white.toml", WHITE.replace("[532, 633, 814]", "[532]"))
        germanium = (SOURCE / "examples/campaign/germanium.toml").read_text()
        germanium = self.write("ge.toml", germanium.replace("[532, 633, 814]", "[532]"))
        linear = self.write("linear.toml", LINEAR)
        tables = {}
        for name, bench in (("true", leaky), ("perfect", [])):
            self.scan(white, "lambertian-99", f"white-{name}.h5", "--seed", 3, *bench)
            self.scan(linear, "red-gloss", f"sample-{name}.h5", "--seed", 4, *bench)
        self.scan(germanium, "germanium", "ge.h5", "--seed", 5, *leaky)
        for label, name, scans in (("perfect", "perfect", ["white-perfect.h5"]),
                                   ("corrected", "true", ["white-true.h5", "ge.h5"]),
                                   ("plain", "true", ["white-true.h5"])):
            self.must("calibrate", *scans, "-o", "cal.h5", "--quiet")
            self.must("reduce", f"sample-{name}.h5", "--calibration", "cal.h5", "-o", "brdf.h5", "--quiet")
            with h5py.File(self.folder / "brdf.h5") as file:
                tables[label] = file["mueller/mueller"][:]
                z = file["mueller/realisable_z"][:]
            self.assertGreater(z.min(), -5)
        m00 = tables["perfect"][:, :1]
        error = {label: np.abs((tables[label] - tables["perfect"]) / m00).max()
                 for label in ("plain", "corrected")}
        self.assertGreater(error["plain"], 0.01)
        self.assertLess(error["corrected"], 0.1 * error["plain"])

    def test_a_mirror_scan_without_crossed_states_is_refused_by_name(self):
        plan = self.write("ge.toml", """
sample = "germanium"
role = "mirror"
wavelengths_nm = [532]
theta_i_deg = [25, 50, 65, 75]
theta_r_deg = "mirror"
states = [["P", "P"], ["S", "S"], ["P", "S"]]
optical_density = 3
dwell_ms = 20
""")
        self.scan(plan, "germanium", "ge.h5", "--seed", 1)
        white = self.write("white.toml", WHITE.replace("[532, 633, 814]", "[532]"))
        self.scan(white, "lambertian-99", "white.h5", "--seed", 3)
        self.refused("calibrate", "white.h5", "ge.h5", "-o", "cal.h5", says=["S/P", "analyser on both sides"])


if __name__ == "__main__":
    unittest.main()

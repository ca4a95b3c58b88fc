"""The whole way once: scan, calibrate, reduce, invert, report; and the files other software reads."""

import json
import math
import re
import unittest

from umov_case import UmovCase

WHITE = """
sample = "white-99"
role = "white"
wavelengths_nm = [532, 633, 814]
theta_i_deg = [0]
theta_r_deg = { from = -80, to = 80, step = 4 }
states = [["P", "open"], ["S", "open"]]
dwell_ms = 50
reference_dhr = { 532 = 0.99, 633 = 0.99, 814 = 0.99 }
"""

PAINT = """
sample = "red-gloss"
wavelengths_nm = [532, 633, 814]
theta_i_deg = [30, 60]
theta_r_deg = { from = -76, to = 76, step = 4, near = { within_deg = 6, step = 1 } }
states = [["P", "P"], ["P", "S"], ["P", "open"], ["S", "S"], ["S", "P"], ["S", "open"]]
dwell_ms = 50
"""


class OneWayToAModel(UmovCase):
    def test_a_red_gloss_paint_is_found_again(self):
        import h5py

        self.write("white.toml", WHITE.replace('"white-99"', '"lambertian-99"'))
        self.write("paint.toml", PAINT)
        self.must("scan", "white.toml", "-o", "white.h5", "--seed", 1)
        self.must("scan", "paint.toml", "-o", "scan.h5", "--seed", 2)
        self.must("calibrate", "white.h5", "-o", "cal.h5")
        self.must("reduce", "scan.h5", "--calibration", "cal.h5", "-o", "brdf.h5")
        self.must("invert", "brdf.h5", "--model", "li-torrance", "-o", "fit.json")
        self.must("report", "scan.h5", "cal.h5", "brdf.h5", "fit.json", "-o", "report.html")

        truth = json.loads(self.must("emulator", "--describe", "red-gloss", "--json").stdout)["parameters"]
        fit = json.loads((self.folder / "fit.json").read_text())
        self.assertEqual(fit["model"], "li-torrance")
        self.assertEqual(fit["wavelengths_nm"], [532, 633, 814])
        for i in (1, 2):
            subsurface = fit["parameters"]["k_uds"][i]
            self.assertLess(subsurface["lo"], subsurface["value"])
            self.assertLess(subsurface["value"], subsurface["hi"])
            reflectance = next(d for d in fit["dhr"] if (d["wavelength_nm"], d["theta_i_deg"]) == ((532, 633, 814)[i], 0))
            self.assertAlmostEqual(reflectance["value"] / self.true_dhr(truth, i), 1.0, delta=0.01)
            # First-surface and subsurface uniform light are hard to tell apart; their sum is not.
            total = subsurface["value"] + fit["parameters"]["k_udf"][i]["value"]
            expected = truth["k_uds"]["value"][i] + truth["k_udf"]["value"][i]
            self.assertAlmostEqual(total / expected, 1.0, delta=0.02)

        with h5py.File(self.folder / "scan.h5") as scan:
            columns = set(scan["records"])
            self.assertLessEqual({"index", "time_s", "theta_i_deg", "theta_r_deg", "phi_r_deg", "wavelength_nm",
                                  "polarizer_deg", "analyzer_deg", "direction", "gain", "x_v", "y_v", "x_se_v",
                                  "y_se_v", "monitor_v", "saturated", "shutter"}, columns)
            self.assertLessEqual({"format", "program", "command", "created", "device", "firmware_hash", "role"},
                                 set(scan.attrs))
        with h5py.File(self.folder / "brdf.h5") as brdf:
            points = {name: brdf["points"][name][()] for name in brdf["points"]}
            self.assertEqual(len({len(column) for column in points.values()}), 1)
            self.assertTrue((points["brdf_u"] > 0).all())
            dolp = {name: brdf["dolp"][name][()] for name in brdf["dolp"]}
        mirror = [(d, u) for t, r, w, d, u in zip(dolp["theta_i_deg"], dolp["theta_r_deg"], dolp["wavelength_nm"],
                                                 dolp["dolp"], dolp["dolp_u"]) if (t, r, w) == (30, 30, 532)]
        self.assertEqual(len(mirror), 1)
        self.assertGreater(mirror[0][0], 0.9)
        self.assertTrue(0 < mirror[0][1] < 0.05 and math.isfinite(mirror[0][1]))

        page = (self.folder / "report.html").read_text()
        embedded = re.search(r'<script type="application/json" id="umov-data">(.*?)</script>', page, re.S).group(1)
        samples = json.loads(embedded)["samples"]
        self.assertEqual([sample["name"] for sample in samples], ["red-gloss"])
        self.assertEqual(samples[0]["fit"]["model"], "li-torrance")

    def true_dhr(self, truth, wavelength_index):
        settings = []
        for name in ("n", "kappa", "sigma_um", "tau_um", "k_dd", "k_udf", "k_uds", "k_fs"):
            settings += ["--set", f"{name}={truth[name]['value'][wavelength_index]}"]
        done = self.must("model", "dhr", "li-torrance", *settings, "--wavelength-nm", (532, 633, 814)[wavelength_index],
                         "--theta-i", 0, "--json")
        return json.loads(done.stdout)["dhr"]

    def test_csv_export_and_import_give_the_same_scan(self):
        self.write("paint.toml", PAINT.replace("step = 4", "step = 38"))
        self.must("scan", "paint.toml", "-o", "scan.h5")
        self.must("export", "scan.h5", "--format", "csv", "-o", "one.csv")
        self.must("import", "one.csv", "-o", "again.h5")
        self.must("export", "again.h5", "--format", "csv", "-o", "two.csv")
        self.assertEqual((self.folder / "one.csv").read_bytes(), (self.folder / "two.csv").read_bytes())


if __name__ == "__main__":
    unittest.main()

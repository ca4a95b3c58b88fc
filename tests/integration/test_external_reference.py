"""A chopper that turns by itself: scans detected against its photo-interrupter, and what is said without it."""

import csv
import json
import unittest

from umov_case import UmovCase

PLAN = """sample = "white 99"
reference_source = "external"
wavelengths_nm = [633]
theta_i_deg = [30]
theta_r_deg = { from = -60, to = 60, step = 20 }
states = [["P", "P"]]
dwell_ms = 100
gain = 10
"""
CHOPPER = ("--plant-set", "chopper.frequency_hz=437", "--plant-set", "chopper.wander=1e-5")
BENCH = ("--sample", "white-99")


class ExternalReference(UmovCase):
    def rows(self, name, plan, *extra):
        self.write(f"{name}.toml", plan)
        self.must("scan", f"{name}.toml", "-o", f"{name}.h5", *BENCH, *extra)
        self.must("export", f"{name}.h5", "-o", f"{name}.csv")
        lines = [line for line in (self.folder / f"{name}.csv").read_text().splitlines() if not line.startswith("#")]
        return list(csv.DictReader(lines))

    def test_a_scan_gives_the_reflectance_that_internal_detection_gives(self):
        chopped = self.rows("chopped", PLAN, *CHOPPER)
        internal = self.rows("internal", PLAN.replace('"external"', '"internal"'))
        self.assertEqual(len(chopped), 7)
        for a, b in zip(chopped, internal):
            x, y, m = (float(a[key]) for key in ("x_v", "y_v", "monitor_v"))
            self.assertAlmostEqual(x / m / (float(b["x_v"]) / float(b["monitor_v"])), 1, delta=2e-3)
            self.assertLess(abs(y), 2e-3 * x)

    def test_without_a_chopper_a_scan_is_refused_by_what_comes_in(self):
        self.write("plan.toml", PLAN)
        self.refused("scan", "plan.toml", "-o", "a.h5", *BENCH, says=["no edges come in at its reference input", "umov device info"])
        self.refused("scan", "plan.toml", "-o", "b.h5", *BENCH, "--plant-set", "chopper.frequency_hz=30000",
                     says=["slower than 10 Hz, faster than 20 kHz"])
        self.refused("scan", "plan.toml", "-o", "c.h5", *BENCH, "--plant-set", "chopper.frequency_hz=437",
                     "--plant-set", "chopper.jitter_deg=60", says=["do not come at a steady period"])

    def test_a_chopper_that_stops_is_a_named_fault(self):
        self.write("plan.toml", PLAN.replace("dwell_ms = 100", "dwell_ms = 60000"))
        done = self.umov("scan", "plan.toml", "-o", "scan.h5", *BENCH, *CHOPPER, "--plant-set", "chopper.stops_s=200")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("[reference_lost]", done.stderr)
        self.assertIn("external reference went away", done.stderr)

    def test_a_plan_says_where_it_contradicts_itself(self):
        self.write("plan.toml", PLAN + "reference_hz = 437\n")
        self.refused("scan", "plan.toml", "-o", "a.h5", says=["plan.toml", ":9", "reference_hz"])

    def test_the_input_is_shown_and_the_source_is_a_setting(self):
        _, device = self.emulator(*BENCH, "--plant-set", "chopper.frequency_hz=437")
        on = ("--device", device)
        self.assertIn("reference input locked at 437.000 Hz", self.must("device", "info", *on).stdout)
        self.must("device", "config", "set", "lockin", "reference_source=external", "harmonic=2", *on)
        lockin = json.loads(self.must("device", "config", "get", "lockin", "--json", *on).stdout)
        self.assertEqual((lockin["reference_source"], lockin["harmonic"]), ("external", 2))
        self.refused("device", "config", "set", "lockin", "reference_source=outside", *on, says=["'outside'", "reference_source=internal"])


if __name__ == "__main__":
    unittest.main()

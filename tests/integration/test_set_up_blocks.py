"""Blocks that need a hand at the instrument: on the emulator, asked for, made beforehand, interrupted."""

import csv
import subprocess
import time
import unittest

import umov_case
from umov_case import UmovCase

PLAN = """
sample = "black gloss"
wavelengths_nm = [532, 633]
theta_i_deg = [30]
theta_r_deg = { from = -60, to = 60, step = 5 }
states = [["P", "P"], ["P", "S"]]
dwell_ms = 20
"""
FLIP = '[[block]]\nmenu = "flip"\ntheta_r_deg = { from = -60, to = 60, step = 1 }\n'
OTHERS = """
[[block]]
menu = "iris"
[[block]]
menu = "oop"
[[block]]
menu = "no_sample"
[[block]]
menu = "white_tile"
reference_dhr = { 532 = 0.99, 633 = 0.99 }
"""


class SetUpBlocks(UmovCase):
    def rows(self, file):
        self.must("export", file, "--format", "csv", "-o", "out.csv", "--force")
        with open(self.folder / "out.csv", encoding="utf-8") as stream:
            lines = stream.readlines()
        head = [line.strip() for line in lines if line.startswith("#")]
        return head, list(csv.DictReader(line for line in lines if not line.startswith("#")))

    def with_input(self, text, *arguments):
        """Runs umov with somebody who types."""
        return subprocess.run([umov_case.UMOV, *map(str, arguments)], cwd=self.folder, text=True, input=text,
                              capture_output=True, timeout=120, check=False)

    def test_every_block_runs_on_the_emulator_and_is_marked_as_agreed(self):
        self.write("plan.toml", PLAN + FLIP + OTHERS)
        self.must("scan", "plan.toml", "-o", "scan.h5")
        head, rows = self.rows("scan.h5")
        blocks = [line.split()[2:] for line in head if line.startswith("# block:")]
        self.assertEqual([block[0] for block in blocks], ["main", "flip", "iris", "oop", "no_sample"])
        self.assertEqual([block[2:] for block in blocks],
                         [[], ["sample_azimuth_deg=180"], ["iris_fraction=0.5"], [], ["sample_removed=1"]])
        ends = [block[1].split("-") for block in blocks]
        self.assertEqual(ends[0][0], "0")
        self.assertEqual([int(a) for a, _ in ends[1:]], [int(b) + 1 for _, b in ends[:-1]])
        self.assertEqual(int(ends[-1][1]), len(rows) - 1)
        self.assertIn("# reference: scan-white.h5", head)
        white, _ = self.rows("scan-white.h5")
        self.assertIn("# role: white", white)
        self.assertIn("# reference_dhr_532: 0.99", white)
        reduced = self.must("reduce", "scan.h5", "-o", "brdf.h5").stdout
        self.assertIn("scan-white.h5", reduced)

    def test_kill_9_in_a_changed_block_then_resume_measures_the_rest_in_that_change(self):
        self.write("plan.toml", PLAN + FLIP + OTHERS)
        leaning = ("--plant-set", "mount.tilt_in_plane_deg=1")
        self.must("scan", "plan.toml", "-o", "whole.h5", *leaning)
        _, whole = self.rows("whole.h5")
        scan = self.start("scan", "plan.toml", "-o", "scan.h5", *leaning)
        self.wait_for_record(scan, 150)  # the flip begins at row 100
        scan.kill()
        scan.wait()
        self.must("scan", "plan.toml", "-o", "scan.h5", "--resume", *leaning)
        _, rows = self.rows("scan.h5")
        self.assertEqual([int(row["index"]) for row in rows], list(range(len(whole))))
        for row, other in zip(rows, whole):
            ratio, expected = (float(r["x_v"]) / float(r["monitor_v"]) for r in (row, other))
            self.assertAlmostEqual(ratio, expected, delta=0.02 * abs(expected) + 1e-5, msg=row["index"])
        self.assertTrue((self.folder / "scan-white.h5").exists())
        self.refused("scan", "plan.toml", "-o", "scan.h5", "--resume", *leaning, says=["complete"])

    def wait_for_record(self, process, count):
        """Until the journal holds so many records, judged by its size."""
        journal = self.folder / "scan.h5.journal"
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline:
            self.assertIsNone(process.poll(), "the scan ended before it could be disturbed")
            if journal.exists() and journal.stat().st_size > 2000 + 120 * count:
                return
            time.sleep(0.002)
        self.fail("no journal grows")

    def test_without_anybody_there_nothing_is_begun(self):
        _, device = self.emulator("--sample", "black-gloss")
        self.write("plan.toml", PLAN + FLIP)
        self.refused("scan", "plan.toml", "-o", "scan.h5", "--device", device,
                     says=["flip", "sample_azimuth_deg=180", "--block flip --arrange made"])
        self.assertEqual(list(self.folder.glob("scan*")), [])
        self.refused("scan", "plan.toml", "-o", "scan.h5", "--arrange", "refuse", says=["flip"])
        self.write("tile.toml", PLAN + '[[block]]\nmenu = "white_tile"\n')
        self.refused("scan", "tile.toml", "-o", "tile.h5", "--device", device, says=["white_tile"])
        self.assertEqual(list(self.folder.glob("tile*.h5*")), [])

    def test_someone_who_is_asked_changes_the_set_up_and_undoes_it(self):
        _, device = self.emulator("--sample", "black-gloss")
        self.write("plan.toml", PLAN + FLIP + '[[block]]\nmenu = "repeat"\n')
        asked = ("scan", "plan.toml", "-o", "scan.h5", "--device", device, "--arrange", "ask")
        done = self.with_input("\n", *asked)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("Turn the sample to 180 deg", done.stderr)
        self.assertIn("Turn the sample back to 0 deg", done.stderr)
        self.assertIn("nobody answered", done.stderr)
        done = self.with_input("\n", *asked, "--resume")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("as usual", done.stderr)
        _, rows = self.rows("scan.h5")
        self.assertEqual([int(row["index"]) for row in rows], list(range(len(rows))))

    def test_a_change_made_beforehand_is_measured_as_a_scan_of_its_own(self):
        _, device = self.emulator("--sample", "black-gloss")
        self.write("plan.toml", PLAN + FLIP + OTHERS)
        here = ("scan", "plan.toml", "--device", device, "--arrange", "made")
        self.refused(*here, "-o", "all.h5", says=["more than one set-up", "--block"])
        self.must(*here, "--block", "main", "-o", "main.h5")
        self.must(*here, "--block", "flip", "-o", "flip.h5")
        self.must(*here, "--block", "white_tile", "-o", "tile.h5")
        head, rows = self.rows("flip.h5")
        self.assertIn(f"# block: flip 0-{len(rows) - 1} sample_azimuth_deg=180", head)
        self.assertIn("# role: white", self.rows("tile.h5")[0])
        self.refused(*here, "--block", "flup", "-o", "x.h5", says=["flup", "main, flip"])


if __name__ == "__main__":
    unittest.main()

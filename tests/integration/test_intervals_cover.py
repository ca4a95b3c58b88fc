"""95 % intervals hold the truth, on a few emulated benches (the study has a hundred)."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools" / "studies"))
import coverage  # noqa: E402


class IntervalsCover(unittest.TestCase):
    def test_noise_alone(self):
        paint = coverage.PAINT % ("[30, 60]", 8, 2)
        seeds = 12
        covered, errors, chi2 = coverage.run(seeds, paint, ("detector.shot_noise_v=4e-6",))
        share = sum(covered.values()) / (seeds * len(covered))
        # 12 seeds of 59 intervals, correlated within a seed: an honest 95 % falls outside once in some thousand runs,
        # and the seeds are fixed.
        self.assertGreater(share, 0.86, covered)
        self.assertLess(share, 0.999, covered)
        for i in range(3):
            self.assertLess(max(abs(e) for e in errors["dhr", i]), 0.01)
        self.assertTrue(all(0.85 < ratio < 1.15 for ratio in chi2), chi2)


if __name__ == "__main__":
    unittest.main()

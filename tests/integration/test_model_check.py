"""umov model check: what it says of models that keep the laws of light and of one that doesn't."""

import json
import unittest

from umov_case import UmovCase


class ModelCheck(UmovCase):
    def check(self, *arguments):
        return json.loads(self.must("model", "check", *arguments, "--json").stdout)

    def test_names_the_amount_by_which_unshadowed_facets_make_light(self):
        found = self.check("microfacet:shadowing=none", "--set", "slope_rms=0.3", "--lossless", "--theta-i", "0,85",
                           "--draws", 1000)
        self.assertGreater(found["greatest_reflectance"], 1.5)
        self.assertEqual(found["parameters"]["kappa"], 100.0)
        self.assertEqual([row["theta_i_deg"] for row in found["energy"]], [0, 85])
        self.assertLess(found["reciprocity"]["violation"], 1e-9)
        text = self.must("model", "check", "microfacet:shadowing=none", "--set", "slope_rms=0.3", "--lossless",
                         "--draws", 0).stdout
        self.assertIn("energy: violated", text)

    def test_drawn_and_integrated_reflectance_agree(self):
        found = self.check("microfacet+nef", "--theta-i", "0,60", "--draws", 20000)
        for drawn, integrated in zip(found["sampling"], found["energy"]):
            self.assertLess(abs(drawn["mean"] - integrated["total"]), 4 * drawn["standard_error"])

    def test_finds_ward_not_reciprocal(self):
        found = self.check("ward", "--set", "alpha_x=0.1", "--set", "alpha_y=0.4", "--draws", 0)
        self.assertGreater(found["reciprocity"]["violation"], 0.1)
        self.assertEqual(found["sampling"], [])

    def test_repeats_itself_for_a_seed(self):
        def weights(seed):
            found = self.check("ggx", "--theta-i", "30", "--draws", 500, "--seed", seed)
            return found["sampling"][0]["mean"]

        self.assertEqual(weights(3), weights(3))
        self.assertNotEqual(weights(3), weights(4))

    def test_refuses_what_it_cannot_check(self):
        self.refused("model", "check", "nef", "--lossless", says=["lossless"])
        self.refused("model", "check", "tabulated", says=["table"])
        self.refused("model", "check", "ggx", "--theta-i", "95", says=["95"])
        self.refused("model", "check", "ggx", "--wavelength-nm", "5", says=["wavelength"])


if __name__ == "__main__":
    unittest.main()

"""BRDF text of other programs, from the command line."""

import json
import unittest

from umov_case import UmovCase

SATIN = ["--model", "microfacet+lambertian", "--set", "0.slope_rms=0.1", "--set", "1.rho=0.3"]

# Made for this test in the form of the Cornell files: the mirror direction, back, and across.
PAINT = """# A laboratory
# Green paint
# num wls
2
450 550
0.698132 0 0.698132 3.141593 0.30 0.50
0.698132 0 0.698132 0.000000 0.03 0.20
0.698132 0 0.349066 -1.570796 0.04 0.21
"""


class ExchangeText(UmovCase):
    def text(self, name):
        return (self.folder / name).read_text()

    def test_a_measured_paint_goes_through_astm_unchanged(self):
        import h5py
        (self.folder / "green.brdf").write_text(PAINT)
        self.must("import", "green.brdf", "-o", "green.h5")
        self.must("export", "green.h5", "--format", "astm", "-o", "green.astm")
        self.must("import", "green.astm", "-o", "again.h5")
        with h5py.File(self.folder / "green.h5") as one, h5py.File(self.folder / "again.h5") as two:
            self.assertEqual(list(one["points/theta_r_deg"]), [40, 40, -40, -40, 20, 20])
            self.assertEqual(list(one["points/phi_r_deg"]), [0, 0, 0, 0, 90, 90])
            self.assertTrue(all(one["points/brdf_u"][:] > 0))
            for column in ("theta_i_deg", "theta_r_deg", "phi_r_deg", "wavelength_nm", "brdf_per_sr", "brdf_u", "used"):
                self.assertEqual(list(one["points"][column]), list(two["points"][column]), column)

    def test_a_klems_matrix_keeps_the_reflectance_of_a_model(self):
        self.must("export", *SATIN, "--format", "window", "-o", "satin.xml")
        self.assertIn("weighted with cos theta_i cos theta_r", self.text("satin.xml"))
        matrix = json.loads(self.must("model", "dhr", "tabulated", "--set", "file=satin.xml", "--theta-i", 30, "--json").stdout)
        model = json.loads(self.must("model", "dhr", *SATIN[1:], "--wavelength-nm", 632.8, "--theta-i", 30, "--json").stdout)
        self.assertAlmostEqual(matrix["dhr"], model["dhr"], delta=1e-3)

    def test_patches_of_several_wavelengths_are_compared_with_their_mean(self):
        out = json.loads(self.must("export", *SATIN, "--format", "window", "--wavelength-nm", 500, "--wavelength-nm", 600,
                                   "--json", "-o", "two.xml").stdout)
        self.assertLess(out["difference"]["p95"], 0.005)
        self.assertNotIn("pointwise", out)

    def test_scatmech_parameters_are_the_same_model(self):
        self.must("export", *SATIN, "--format", "scatmech", "--wavelength-nm", 550, "-o", "satin.txt")
        self.assertIn("Two_Source_BRDF_Model", self.text("satin.txt"))
        where = ["--wavelength-nm", 550, "--theta-i", 40, "--theta-r", 50, "--phi-r", 10, "--json"]
        back = json.loads(self.must("model", "eval", "tabulated", "--set", "file=satin.txt", *where).stdout)
        model = json.loads(self.must("model", "eval", *SATIN[1:], *where).stdout)
        for a, b in zip(back["mueller"], model["mueller"]):
            self.assertAlmostEqual(a, b, delta=1e-14)

    def test_an_import_says_what_a_table_of_a_model_has_lost(self):
        (self.folder / "m.txt").write_text("Microroughness_BRDF_Model\nlambda = 0.6328\nsubstrate = (4,0.1)\n"
                                           "psd = Gaussian_PSD_Function\npsd.sigma = 0.005\n")
        done = self.must("import", "m.txt", "-o", "m.h5")
        self.assertIn("mirror direction (reflectance 0.", done.stdout)
        self.assertIn("SCATMECH's defaults then: ", done.stdout)
        self.assertIn("psd.length = 5", done.stdout)
        line = next(line for line in done.stdout.splitlines() if "umov model eval" in line)
        command = line[line.index("umov model eval"):].split()[1:]
        self.assertIn("sigma_um=0.005", command)
        values = json.loads(self.must(*command, "--json").stdout)["mueller"]
        file = json.loads(self.must("model", "eval", "tabulated", "--set", "file=m.txt", "--wavelength-nm", 632.8,
                                    "--theta-i", 30, "--theta-r", 30, "--json").stdout)["mueller"]
        for a, b in zip(values, file):
            self.assertAlmostEqual(a, b, delta=1e-14)
        out = json.loads(self.must("import", "m.txt", "--force", "-o", "m.h5", "--json").stdout)
        self.assertEqual(len(out["notes"]), 2)
        self.assertIn(out["model"], line)
        (self.folder / "nm.txt").write_text("Facet_BRDF_Model\nlambda = 632.8\n")
        self.refused("import", "nm.txt", "-o", "x.h5", says=["nm.txt:2:lambda", "not nm"])

    def test_a_mirror_part_is_said_to_be_where_it_is(self):
        mirror = ["--model", "rayleigh-rice", "--set", "sigma_um=0.005"]
        window = self.must("export", *mirror, "--format", "window", "-o", "m.xml").stdout
        self.assertNotIn("not in the table", window)
        self.assertNotIn("not in the table", self.text("m.xml"))
        self.assertIn("mirror patches left out", window)
        out = json.loads(self.must("export", *mirror, "--format", "window", "--force", "-o", "m.xml", "--json").stdout)
        self.assertEqual(out["difference"]["of"], "patch means")
        self.assertLess(out["difference"]["median"], 0.0005)
        self.assertLess(out["difference"]["p95"], 0.005)
        self.assertEqual(out["pointwise"]["without"], "mirror patches")
        self.assertGreater(out["pointwise"]["p95"], 0.1)
        self.assertLess(out["dhr"]["largest_difference"], 0.0005)
        self.assertGreater(min(out["dhr"]["file"]), 0.03)
        self.assertNotIn("not in the table", self.must("export", *mirror, "--format", "scatmech", "-o", "m.txt").stdout)
        self.assertNotIn("not in the table", self.text("m.txt"))
        self.assertIn("not in the table", self.must("export", *mirror, "--format", "zemax", "-o", "m.bsdf").stdout)

    def test_text_that_lost_its_last_bytes_is_refused(self):
        self.must("export", *SATIN, "--format", "table-csv", "-o", "t.csv")
        self.must("export", *SATIN, "--format", "planes-csv", "-o", "p.csv")
        self.must("export", *SATIN, "--format", "scatmech", "-o", "m.txt")
        (self.folder / "green.brdf").write_text(PAINT)
        self.must("import", "green.brdf", "-o", "green.h5")
        self.must("export", "green.h5", "--format", "astm", "-o", "g.astm")
        for name in ("t.csv", "p.csv", "m.txt", "green.brdf", "g.astm"):
            for cut in (1, 2, 3):
                with self.subTest(f"{name} less {cut}"):
                    (self.folder / f"cut-{name}").write_bytes((self.folder / name).read_bytes()[:-cut])
                    self.refused("import", f"cut-{name}", "-o", "x.h5", says=[f"cut-{name}", "cut off"])

    def test_noise_without_a_stated_uncertainty_can_be_fitted(self):
        rows = [f"{i},{r},{0.2 if r < 60 else 0}" for i in (10, 40) for r in range(-75, 80, 5)]
        rows[0] = "10,-75,-0.001"
        (self.folder / "g.astm").write_text("ASTM E2387\nWAVELENGTH 633 nm\nANGLE_UNITS DEGREES\n"
                                            "VARS theta_i,theta_s,BRDF\n" + "\n".join(rows) + "\n")
        self.must("import", "g.astm", "-o", "g.h5")
        self.must("invert", "g.h5", "--model", "lambertian", "-o", "fit.json")

    def test_csv_tables_come_back_line_by_line(self):
        for name in ("table-csv", "planes-csv"):
            with self.subTest(name):
                self.must("export", *SATIN, "--format", name, "-o", f"one.{name}")
                self.must("export", f"one.{name}", "--format", name, "-o", f"two.{name}")
                rows = [[line for line in self.text(file).splitlines() if not line.startswith("#")]
                        for file in (f"one.{name}", f"two.{name}")]
                self.assertEqual(rows[0], rows[1])
                self.assertGreater(len(rows[0]), 100)

    def test_a_damaged_file_is_refused_with_its_line(self):
        (self.folder / "green.brdf").write_text(PAINT.replace("0.20", "nan"))
        done = self.umov("import", "green.brdf", "-o", "green.h5")
        self.assertEqual(done.returncode, 1)
        self.assertIn("green.brdf:7:brdf", done.stderr)
        self.assertFalse((self.folder / "green.h5").exists())


if __name__ == "__main__":
    unittest.main()

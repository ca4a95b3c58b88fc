"""BRDF tables from and to the formats of other programs, from the command line."""

import json
import struct
import unittest

from umov_case import SOURCE, UmovCase

SATIN = ["--model", "microfacet+lambertian", "--set", "0.slope_rms=0.1", "--set", "1.rho=0.3"]


class TableFormats(UmovCase):
    def data(self, name):
        return (self.folder / name).read_bytes()

    def test_a_merl_file_goes_through_a_table_unchanged(self):
        self.must("export", *SATIN, "--format", "merl", "-o", "satin.binary")
        self.assertEqual(struct.unpack("<3i", self.data("satin.binary")[:12]), (90, 90, 180))
        done = self.must("import", "satin.binary", "-o", "satin.h5")
        self.assertIn("table.h5", done.stdout)
        self.must("export", "satin.h5", "--format", "merl", "-o", "again.binary")
        self.assertEqual(self.data("again.binary"), self.data("satin.binary"))

    def test_an_rgl_tensor_goes_through_a_table_unchanged(self):
        self.must("export", *SATIN, "--format", "rgl", "--wavelength-nm", 532, "--wavelength-nm", 633,
                  "-o", "satin.bsdf")
        self.must("import", "satin.bsdf", "-o", "satin.h5")
        self.must("export", "satin.h5", "--format", "rgl", "-o", "again.bsdf")
        self.assertEqual(self.data("again.bsdf"), self.data("satin.bsdf"))

    def test_every_table_says_how_far_it_is_off_its_source(self):
        for name, most in (("merl", 0.01), ("rgl", 0.01), ("zemax", 0.02), ("table", 0.02)):
            with self.subTest(name):
                out = json.loads(self.must("export", *SATIN, "--format", name, "--json", "-o",
                                           f"satin.{name}").stdout)
                self.assertEqual(out["format"], name)
                self.assertLess(out["difference"]["median"], out["difference"]["p95"])
                self.assertLess(out["difference"]["p95"], most)

    def test_reflectances_of_file_and_source_stand_beside_each_other(self):
        out = json.loads(self.must("export", *SATIN, "--format", "zemax", "--json", "-o", "satin.bsdf").stdout)["dhr"]
        self.assertEqual(out["theta_i_deg"], [10, 45, 70])
        for theta_i, value in zip(out["theta_i_deg"], out["source"]):
            model = json.loads(self.must("model", "dhr", *SATIN[1:], "--wavelength-nm", 632.8, "--theta-i", theta_i,
                                         "--json").stdout)
            self.assertAlmostEqual(value, model["dhr"], places=6)
        self.assertLess(out["largest_difference"], 0.01)
        done = self.must("export", *SATIN, "--format", "rgl", "-o", "satin.rgl")
        self.assertIn("DHR at 10, 45, 70 deg: 0.", done.stdout)

    def test_a_table_of_one_program_becomes_that_of_another(self):
        self.must("export", *SATIN, "--format", "zemax", "-o", "satin.bsdf")
        out = json.loads(self.must("export", "satin.bsdf", "--format", "rgl", "--json", "-o",
                                   "rgl.bsdf").stdout)
        self.assertLess(out["difference"]["median"], 0.01)

    def test_a_table_file_opens_with_plain_h5py(self):
        import h5py
        self.must("export", *SATIN, "--format", "table", "-o", "satin.h5")
        with h5py.File(self.folder / "satin.h5") as file:
            self.assertEqual(file.attrs["format"], "umov table h5")
            shape = tuple(len(file["axes"][name]) for name in
                          ("wavelength_um", "theta_i_deg", "theta_r_deg", "phi_r_deg"))
            self.assertEqual(file["values"].shape, shape + (16,))
            header = dict(zip(file["header/key"].asstr(), file["header/value"].asstr()))
        self.assertIn("not multiplied by cos theta", header["quantity"])
        self.assertIn("specular", header["azimuth"])
        self.assertIn("632.8 nm", header["wavelength"])

    def test_the_model_tabulated_reads_a_table_back(self):
        self.must("export", "--model", "lambertian", "--set", "rho=0.5", "--format", "zemax", "-o", "grey.bsdf")
        out = json.loads(self.must("model", "dhr", "tabulated", "--set", "file=grey.bsdf",
                                   "--theta-i", "30", "--json").stdout)
        self.assertAlmostEqual(out["dhr"], 0.5, places=3)

    def test_what_cannot_be_done_is_refused_with_a_way_out(self):
        self.must("export", *SATIN, "--format", "zemax", "-o", "satin.bsdf")
        self.refused("export", "--format", "merl", "-o", "x", says=["nothing to export", "--model"])
        self.refused("export", "satin.bsdf", *SATIN, "-o", "x", says=["at once"])
        self.refused("export", "satin.bsdf", "-o", "x", says=["--format", "table, merl, rgl, zemax, window, table-csv"])
        self.refused("export", *SATIN, "-o", "x", says=["--format", "scatmech"])
        self.refused("export", "satin.bsdf", "--format", "csv", "-o", "x", says=["--format csv", "table-csv"])
        self.refused("export", *SATIN, "--format", "zemax", "--wavelength-nm", 500, "--wavelength-nm", 600,
                     "-o", "x", says=["one wavelength", "500, 600"])
        self.refused("export", *SATIN, "--format", "merl", "--wavelength-nm", 5, "-o", "x", says=["5 nm"])
        self.refused("export", *SATIN, "--format", "astm", "-o", "x", says=["astm"])
        self.refused("export", "satin.bsdf", "--format", "merl", "-o", "satin.bsdf", says=["the output is the input"])
        self.refused("import", "satin.bsdf", "--as", "points", "-o", "x.h5", says=["zemax", "points"])
        self.must("import", "satin.bsdf", "-o", "table.h5")
        self.refused("import", "table.h5", "-o", "y.h5", says=["table.h5 already"])
        lines = (self.folder / "satin.bsdf").read_text().splitlines()
        (self.folder / "cut.bsdf").write_text("\n".join(lines[:-40]) + "\n")
        self.refused("import", "cut.bsdf", "-o", "z.h5", says=[f"cut.bsdf:{len(lines) - 40}:", "ends where"])
        (self.folder / "short.bsdf").write_text("\n".join(lines[:40]) + "\n")
        self.refused("import", "short.bsdf", "-o", "z.h5", says=["short.bsdf:", "more than the file has room for"])
        self.assertFalse((self.folder / "z.h5").exists())

    def test_measured_points_do_not_become_a_table(self):
        source = "ptfe.h5"
        self.must("import", SOURCE / "tests/data/nist_ptfe/ptfe_532_633.csv", "-o", source)
        self.refused("export", source, "--format", "merl", "-o", "x", says=["measured points", "umov invert"])
        self.must("export", source, "--format", "astm", "-o", "ptfe.astm")

    def test_help_lists_the_formats_with_their_directions(self):
        exported = self.must("export", "--help").stdout
        imported = self.must("import", "--help").stdout
        for name in ("merl", "rgl", "zemax", "window", "astm", "scatmech"):
            self.assertIn(name, exported)
            self.assertIn(name, imported)


if __name__ == "__main__":
    unittest.main()

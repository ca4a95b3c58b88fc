"""umov simulate chamber: a scene file in; map, distribution and their files out."""

import json
import os
import re
import shutil
import subprocess
import unittest

import h5py

from chambers import small_chamber
from umov_case import SOURCE, UMOV, UmovCase

EXAMPLE = SOURCE / "examples/chambers/mixing-chamber.toml"
SMALL = small_chamber(rays=1e5) + "[glare]\n"


class SimulateChamber(UmovCase):
    def scene(self, text):
        path = self.folder / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return path

    def test_every_file_says_the_same(self):
        said = json.loads(self.must("simulate", "chamber", self.scene(SMALL), "-o", "sim.h5", "--exr", "map.exr", "--png", "map.png",
                                    "--ies", "c.ies", "--ldt", "c.ldt", "--json", "--quiet").stdout)
        self.assertAlmostEqual(said["lid"]["source_lm"], 2)
        self.assertGreater(said["lid"]["efficiency"], 0.5)
        self.assertGreater(said["lid"]["absorbed_fraction"], 0.01)
        self.assertEqual(said["map"]["paths_given_up"], 0)
        self.assertIn("map", said["ugr"])
        with h5py.File(self.folder / "sim.h5") as file:
            luminance = file["map/luminance_cd_m2"][:]
            self.assertEqual(luminance.shape, (12, 20))
            self.assertAlmostEqual(luminance.mean(), said["map"]["mean_cd_m2"], places=6)
            self.assertTrue((file["map/luminance_se"][:] >= 0).all())
            intensity = file["lid/intensity_cd"][:]
            self.assertEqual(intensity.shape, (4, 37))
        self.assertEqual((self.folder / "map.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual((self.folder / "map.exr").read_bytes()[:4], b"\x76\x2f\x31\x01")
        numbers = re.split(r"TILT=NONE\s+", (self.folder / "c.ies").read_text())[1].split()
        self.assertAlmostEqual(float(numbers[13 + 37 + 5]), intensity[0, 0], places=4)
        cd_per_klm = float((self.folder / "c.ldt").read_text().splitlines()[42 + 4 + 37])
        self.assertAlmostEqual(cd_per_klm * 2 / 1000, intensity[0, 0], places=4)

    @unittest.skipUnless(shutil.which("mpirun"), "mpirun is not installed")
    def test_any_number_of_ranks_and_threads_gives_the_same_bits(self):
        scene = self.scene(SMALL)
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")

        def run(*launcher, threads, output):
            command = [*launcher, UMOV, "simulate", "chamber", scene, "-o", output, "--threads", threads, "--json", "--quiet"]
            done = subprocess.run([str(word) for word in command], cwd=self.folder, timeout=120, env=environment, capture_output=True, text=True,
                                  check=True)
            with h5py.File(self.folder / output) as file:
                columns = {}
                file.visititems(lambda name, node: columns.update({name: node[:].tobytes()}) if getattr(node, "dtype", None) == float else None)
            return json.loads(done.stdout), columns

        alone = run(threads=1, output="alone.h5")
        self.assertIn("map/luminance_cd_m2", alone[1])
        self.assertIn("lid/intensity_se", alone[1])
        for ranks, threads in ((1, 2), (2, 1), (4, 1), (4, 2)):
            team = run("mpirun", "--oversubscribe", "--bind-to", "none", "-n", ranks, threads=threads, output=f"team{ranks}{threads}.h5")
            self.assertEqual(team, alone, f"{ranks} ranks of {threads} threads")

    def test_colours_are_kept_band_by_band(self):
        (self.folder / "led.csv").write_text("wavelength_nm,power\n380,0\n450,3\n500,1\n600,2\n780,0\n", encoding="utf-8")
        text = SMALL.replace("rho = 0.9", "rho = [0.2, 0.5, 0.9, 0.9]") + "[bands]\nwavelength_nm = [430, 500, 570, 640]\n"
        scene = self.scene(text.replace("flux_lm = 2", 'flux_lm = 2\nspectrum = { file = "led.csv", column = "power" }'))
        said = json.loads(self.must("simulate", "chamber", scene, "-o", "sim.h5", "--json", "--quiet").stdout)
        with h5py.File(self.folder / "sim.h5") as file:
            radiance = file["map/radiance"][:]
            self.assertEqual(radiance.shape, (4, 12, 20))
            self.assertEqual([round(um, 9) for um in file["map/wavelength_um"][:]], [0.43, 0.5, 0.57, 0.64])
            # The walls take blue out of the light, at every bounce again; the LED, in view too, has more of it than of red.
            luminance = file["map/luminance_cd_m2"][:]
            walls = (luminance > 0) & (luminance < 0.2 * luminance.max())
            self.assertGreater(walls.sum(), 20)
            self.assertLess(radiance[0][walls].mean(), 0.5 * radiance[3][walls].mean())
            self.assertGreater(radiance[0].max(), radiance[3].max())
            self.assertEqual(file["lid/spectrum_out"].shape, (4,))
        self.assertAlmostEqual(said["map"]["bands"][2]["mean_radiance"], radiance[2].mean(), places=9)
        self.must("simulate", "chamber", scene, "--compare", "sim.h5", "--quiet")  # read again, checksum and all

    def test_a_map_is_like_itself_and_less_like_another(self):
        scene = self.scene(SMALL)
        self.must("simulate", "chamber", scene, "-o", "a.h5", "--quiet")

        def like(*options):
            return json.loads(self.must("simulate", "chamber", scene, "--compare", "a.h5", "--json", "--quiet", *options).stdout)["likeness"]

        self.assertAlmostEqual(like("--threads", 1)["ncc"], 1)
        self.assertLess(like("--seed", 2)["ncc"], 1)

    def test_the_example_runs(self):
        said = json.loads(self.must("simulate", "chamber", EXAMPLE, "--rays-per-pixel", 4, "--rays", 20000, "--json", "--quiet").stdout)
        self.assertGreater(said["region"]["mean_cd_m2"], 100)
        self.assertAlmostEqual(said["lid"]["source_lm"], 3.84)

    def test_refuses_what_cannot_be(self):
        self.refused("simulate", "chamber", self.scene(SMALL.replace("rho = 0.9", "rho = 1.9")), says=("scene.toml:4", "1.9"))
        self.refused("simulate", "chamber", self.scene(SMALL.replace("flux_lm = 2", "flux_lm = -2")), says=("scene.toml:8", "-2"))
        no_gonio = SMALL.replace("[goniophotometer]\nrays = 100000\nplanes = 4\n", "")
        self.refused("simulate", "chamber", self.scene(SMALL), "--advise", "-o", "sim.h5", says=("--advise writes no files",))
        self.refused("simulate", "chamber", self.scene(SMALL), "--advise", "--rays", 1e6, says=("counts its rays itself",))
        self.refused("simulate", "chamber", self.scene(no_gonio), "--ies", "x.ies", says=("x.ies", "goniophotometer"))


if __name__ == "__main__":
    unittest.main()

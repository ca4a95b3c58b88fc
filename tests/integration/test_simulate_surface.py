"""umov simulate surface: a scene file in, a hemisphere with its errors out."""

import json
import math
import os
import shutil
import signal
import subprocess
import time
import unittest

import h5py

from umov_case import SOURCE, UMOV, UmovCase

PAINT = """[surface]
wavelengths_um = [0.5, 0.7]
period_um = 200
[substrate]
model = "lambertian"
rho = [0.2, 0.6]
"""
SOIL = """[[particles]]
material = "dry_soil"
radius_um = 10
coverage = 0.3
"""


class SimulateSurface(UmovCase):
    def scene(self, text):
        path = self.folder / "scene.toml"
        path.write_text(text, encoding="utf-8")
        return path

    def test_a_bare_paint_has_its_albedo_in_the_file_and_on_the_terminal(self):
        said = json.loads(self.must("simulate", "surface", self.scene(PAINT), "--theta-i", 40, "--samples", 1e5, "-o", "paint.h5",
                                    "--directions", "strip", "--strip", 45, "--json", "--quiet").stdout)
        for band, albedo in zip(said["bands"], (0.2, 0.6)):
            self.assertAlmostEqual(band["dhr"], albedo, places=9)
            self.assertEqual(band["lost"], 0)
        with h5py.File(self.folder / "paint.h5") as file:
            f = file["points/brdf_per_sr"][:]
            u = file["points/brdf_u"][:]
            wavelength = file["points/wavelength_nm"][:]
            theta = file["points/theta_r_deg"][:]
            self.assertEqual(set(file["points/phi_r_deg"][:]), {0.0})
            self.assertEqual(file["mueller/mueller"].shape[1], 16)
        self.assertLess(min(theta), -80)
        self.assertGreater(max(theta), 80)
        z = [(x - (0.2 if w == 500 else 0.6) / math.pi) / e for x, e, w in zip(f, u, wavelength)]
        self.assertGreater(len(z), 80)
        self.assertLess(sum(v * v for v in z) / len(z), 2.0)

    def test_the_result_depends_on_the_seed_and_on_nothing_else(self):
        scene = self.scene(PAINT + SOIL)

        def dhr(*options):
            text = self.must("simulate", "surface", scene, "--samples", 40000, "--json", "--quiet", *options).stdout
            return json.loads(text)["bands"]

        self.assertEqual(dhr("--threads", 1), dhr("--threads", 3))
        self.assertNotEqual(dhr(), dhr("--lay-samples", 0))
        self.assertNotEqual(dhr("--seed", 1), dhr("--seed", 2))

    def test_the_example_runs_and_its_hemisphere_can_be_exported(self):
        self.must("simulate", "surface", SOURCE / "examples/surfaces/wet-dirt.toml", "--theta-i", "20,60", "--relative-error", 2,
                  "-o", "wet.h5", "--quiet")
        self.must("export", "wet.h5", "-o", "wet.csv")
        with h5py.File(self.folder / "wet.h5") as file:
            for group, theta in (("hemisphere", 20), ("hemisphere_2", 60)):
                f = file[group + "/mueller"][:]
                solid = file[group + "/solid_angle_sr"][:]
                cosine = [math.cos(math.radians(t)) for t in file[group + "/theta_r_deg"][:]]
                self.assertEqual(file[group].attrs["theta_i_deg"], theta)
                self.assertEqual(f.shape, (len(solid), 11, 16))
                dhr = sum(x * s * c for x, s, c in zip(f[:, 0, 0], solid, cosine))
                self.assertAlmostEqual(dhr / file[group].attrs["dhr"][0], 1, delta=0.01)

    def test_an_interrupted_run_is_kept_and_goes_on_to_the_same_bits(self):
        scene = self.scene(PAINT + SOIL)
        command = ["simulate", "surface", scene, "--theta-i", 30, "-o", "sim.h5", "--quiet", "--json"]
        running = subprocess.Popen([UMOV, *map(str, command), "--samples", "1e9"], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(3.0)
        running.send_signal(signal.SIGINT)
        said, complaint = running.communicate(timeout=60)
        self.assertEqual(running.returncode, 130, complaint)
        self.assertIn("--resume", complaint)
        first = json.loads(said)
        self.assertTrue((self.folder / "sim.h5.state").exists())
        with h5py.File(self.folder / "sim.h5") as file:
            self.assertEqual(file["hemisphere"].attrs["samples"], first["samples"])
        more = first["samples"] + 100000
        resumed = json.loads(self.must(*command, "--samples", more, "--resume").stdout)
        self.assertFalse((self.folder / "sim.h5.state").exists())
        command[command.index("sim.h5")] = "whole.h5"
        whole = json.loads(self.must(*command, "--samples", more).stdout)
        self.assertEqual(resumed["bands"], whole["bands"])
        self.assertEqual(resumed["rays"], whole["rays"])

    def test_an_interrupted_mixture_goes_on_to_the_same_file(self):
        scene = self.scene(PAINT + SOIL)

        def command(output):
            return ["simulate", "surface", scene, "--mixture", "--coverage-factors", "0.5,1", "--theta-i", "0,60", "--samples", 1e6,
                    "-o", output, "--quiet"]

        start = time.monotonic()
        self.must(*command("whole.json"))
        a_while = 0.4 * (time.monotonic() - start)
        running = subprocess.Popen([UMOV, *map(str, command("parts.json"))], cwd=self.folder, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        time.sleep(a_while)
        stops = 0
        while running.poll() is None:
            running.send_signal(signal.SIGINT)
            _, complaint = running.communicate(timeout=60)
            if running.returncode == 0:
                break
            self.assertEqual(running.returncode, 130, complaint)
            self.assertIn("--resume", complaint)
            self.assertTrue((self.folder / "parts.json.state").exists())
            stops += 1
            running = subprocess.Popen([UMOV, *map(str, command("parts.json")), "--resume"], cwd=self.folder, stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE, text=True)
            time.sleep(a_while)
        self.assertGreater(stops, 0)
        self.assertFalse((self.folder / "parts.json.state").exists())
        whole, parts = (json.loads((self.folder / name).read_text(encoding="utf-8")) for name in ("whole.json", "parts.json"))
        self.assertEqual(whole["angles"], parts["angles"])

    def test_a_run_stops_by_its_cells(self):
        scene = self.scene(PAINT + SOIL)

        def errors(output, *options):
            said = json.loads(self.must("simulate", "surface", scene, "--rings", 6, "--strip", 0, "-o", output, "--json", "--quiet",
                                        *options).stdout)
            self.assertGreaterEqual(said["lays"], 64)
            with h5py.File(self.folder / output) as file:
                f = file["hemisphere/mueller"][:, :, 0]
                u = file["hemisphere/mueller_se"][:, :, 0]
                self.assertEqual(file["hemisphere"].attrs["lays"], said["lays"])
            return said["samples"], (u / f).max(axis=1)

        samples, relative = errors("median.h5", "--cell-error", 1.5, "--lay-samples", 500)
        self.assertGreaterEqual((relative < 0.015).mean(), 0.5)
        more, relative = errors("most.h5", "--cell-error", 1.5, "--cell-percentile", 90, "--lay-samples", 500)
        self.assertGreaterEqual((relative < 0.015).mean(), 0.9)
        self.assertGreater(more, samples)
        one, relative = errors("one.h5", "--cell-error", 1.5, "--cell", "1,0", "--lay-samples", 500)
        self.assertLess(relative[0], 0.015)
        self.assertLess(one, more)
        self.refused("simulate", "surface", scene, "--cell-percentile", 90, says=("--cell-error",))
        self.refused("simulate", "surface", scene, "--cell-error", 1, "--cell", "95,0", says=("95",))
        self.refused("simulate", "surface", self.scene(PAINT + "[stop]\ncell_deg = [30, 0]\n"), says=("scene.toml:8", "cell_relative_error"))

    def test_a_run_does_not_go_on_with_another_spectrum(self):
        spectrum = self.folder / "paint.csv"
        spectrum.write_text("wavelength_um,rho\n0.4,0.2\n0.8,0.6\n", encoding="utf-8")
        scene = self.scene(PAINT.replace("rho = [0.2, 0.6]", 'rho = { file = "paint.csv", column = "rho" }') + SOIL)
        command = ["simulate", "surface", scene, "-o", "sim.h5", "--quiet"]
        running = subprocess.Popen([UMOV, *map(str, command), "--samples", "1e9"], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(2.0)
        running.send_signal(signal.SIGINT)
        _, complaint = running.communicate(timeout=60)
        self.assertEqual(running.returncode, 130, complaint)
        spectrum.write_text("wavelength_um,rho\n0.4,0.3\n0.8,0.6\n", encoding="utf-8")
        refused = self.umov(*command, "--samples", "2e9", "--resume")
        self.assertIn("another scene", refused.stderr)

    @unittest.skipUnless(shutil.which("mpirun"), "mpirun is not installed")
    def test_four_ranks_give_the_bits_of_one(self):
        scene = self.scene(PAINT + SOIL)
        command = ["simulate", "surface", str(scene), "--samples", "1e5", "--theta-i", "10,50", "--json", "--quiet"]
        alone = json.loads(self.must(*command).stdout)
        environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
        team = subprocess.run(["mpirun", "--oversubscribe", "--bind-to", "none", "-n", "4", str(UMOV), *command], cwd=self.folder, timeout=120,
                              env=environment, capture_output=True, text=True, check=True)
        self.assertEqual(json.loads(team.stdout), alone)

    def test_a_mixture_is_compared_with_the_simulation(self):
        self.must("simulate", "surface", self.scene(PAINT + SOIL), "--mixture", "--coverage-factors", "0.5,1", "--theta-i", "0,60",
                  "--samples", 40000, "-o", "mixture.json", "--quiet")
        found = json.loads((self.folder / "mixture.json").read_text(encoding="utf-8"))
        self.assertEqual([a["theta_i_deg"] for a in found["angles"]], [0, 60])
        above = found["angles"][0]["points"]
        self.assertAlmostEqual(above[1]["area_fraction"], above[1]["coverage"], delta=0.01)
        for angle in found["angles"]:
            self.assertEqual(angle["law"]["points"], 2)
            for point in angle["points"]:
                f = point["area_fraction"]
                self.assertAlmostEqual(point["bands"][1]["dhr_linear"], f * 0.3355 + (1 - f) * 0.6, delta=1e-6)
                self.assertGreater(point["effective_fraction_u"], 0)
                self.assertEqual(point["lays"], 16)

    def test_what_mixing_leaves_out_of_a_dirty_paint_is_named(self):
        scene = self.scene(PAINT.replace("period_um = 200", "period_um = 600") + SOIL)
        self.must("simulate", "surface", scene, "--theta-i", 50, "--samples", 2e5, "--seed", 5, "--rings", 18, "--directions", "cells",
                  "-o", "dirty.h5", "--quiet")
        answer = json.loads(self.must("diagnose", "dirty.h5", "--surface", scene, "--json", "answer.json", "--quiet").stdout or
                            (self.folder / "answer.json").read_text(encoding="utf-8"))
        named = {cause["effect"]: next(iter(cause["parameters"].values())) for cause in answer["causes"]}
        for effect in ("particle_shadowing", "multiple_scattering"):
            self.assertAlmostEqual(named.pop(effect)["value"], 1, delta=0.3)
        # Simulated templates have noise of their own: what else is named is nothing within its interval.
        for effect, size in named.items():
            self.assertLess(size["lo"], 0, effect)
            self.assertGreater(size["hi"], 0, effect)

    def test_a_dirty_sample_lies_under_the_emulated_instrument(self):
        text = PAINT + SOIL.replace("0.3", "0.5")
        self.must("simulate", "surface", self.scene(text), "--theta-i", "0,30,60", "--samples", 4e5, "--rings", 9, "--strip", 60,
                  "--strip-half-width", 5, "--directions", "strip", "-o", "dirty.h5", "--table", "dirty.csv", "--quiet")
        (self.folder / "plan.toml").write_text('sample = "dirt"\nwavelengths_nm = [633]\ntheta_i_deg = [30]\n'
                                               'theta_r_deg = [-60, -45, 0, 45, 60]\nstates = [["open", "open"]]\ndwell_ms = 20\n')
        self.must("scan", "plan.toml", "--sample", "dirty.csv", "-o", "scan.h5", "--quiet")
        with h5py.File(self.folder / "scan.h5") as file:
            signal = file["records/x_v"][:] / file["records/monitor_v"][:]
            theta = file["records/theta_r_deg"][:]
        by_angle = {t: x / math.cos(math.radians(t)) for t, x in zip(theta, signal)}
        # Dirt is brighter towards the light, as it is in the simulation.
        with h5py.File(self.folder / "dirty.h5") as file:
            here = {t: f for t, f, i, w in zip(*(file["points/" + name][:] for name in
                    ("theta_r_deg", "brdf_per_sr", "theta_i_deg", "wavelength_nm"))) if i == 30 and w == 700}
        near = lambda angle: sum(f for t, f in here.items() if abs(t - angle) < 8) / sum(abs(t - angle) < 8 for t in here)
        self.assertGreater(near(-60), 1.2 * near(60))
        self.assertAlmostEqual(by_angle[-60] / by_angle[60], near(-60) / near(60), delta=0.2)

    def test_hemispheres_are_drawn_one_picture_an_angle(self):
        self.must("simulate", "surface", self.scene(PAINT), "--theta-i", "0,60", "--samples", 1e5, "--exr", "paint.exr", "--png", "paint.png",
                  "--png-nm", 700, "--png-element", "m10", "--quiet")
        self.assertEqual((self.folder / "paint.exr").read_bytes()[:4], b"\x76\x2f\x31\x01")
        for angle in (0, 60):
            self.assertEqual((self.folder / f"paint-{angle}deg.png").read_bytes()[:4], b"\x89PNG")

    def test_a_warm_paint_shines_by_itself(self):
        text = PAINT.replace("[0.5, 0.7]", "[3.0, 5.0]") + "[emission]\ntemperature_k = 300\nsky_temperature_k = 300\n"
        said = json.loads(self.must("simulate", "surface", self.scene(text), "--samples", 1e5, "--json", "--quiet").stdout)
        for band, albedo in zip(said["bands"], (0.2, 0.6)):
            w = band["wavelength_nm"] * 1e-3
            black = 1.191042972e8 / w**5 / math.expm1(14387.76877 / (w * 300))
            self.assertAlmostEqual(band["emissivity"], 1 - albedo, places=9)
            self.assertAlmostEqual(band["radiance"]["total"] / black, 1, places=6)

    def test_refuses_what_cannot_be(self):
        crowded = self.scene(PAINT + SOIL.replace("0.3", "0.9"))
        self.refused("simulate", "surface", crowded, says=("find no more room",))
        self.refused("simulate", "surface", self.scene(PAINT), "--theta-i", 90, says=("90",))
        self.refused("simulate", "surface", self.scene(PAINT), "--png", "p.png", "--png-nm", 600, says=("600", "--png-nm"))
        self.refused("simulate", "surface", self.scene(PAINT + SOIL), "--mixture", "--exr", "m.exr", says=("--exr",))
        # Before anything is simulated.
        self.refused("simulate", "surface", self.scene(PAINT), "--theta-i", "60,20", "--table", "t.csv", "--samples", 1e12,
                     says=("must rise", "ascending"))
        self.refused("diagnose", "--effects", "--surface", self.scene(PAINT), says=("no list",))
        self.refused("simulate", "surface", self.scene(PAINT + "gloss = 1\n"), says=("scene.toml:7", "gloss"))


if __name__ == "__main__":
    unittest.main()
